// What the tests of contestants share: one is started as the runner starts it, on a mesh and a problem.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/registry.h"
#include "tests/support/scratch_folder.h"

namespace palpate::test {

/// Starts contestants, each in a scratch folder of its own that lives as long as this.
class ContestantStarter {
 public:
  experiments::ContestantAnswer run(const std::string& method, const TetMesh& mesh,
                                    const nlohmann::json& problem,
                                    const nlohmann::json& options = nlohmann::json::object());
  const experiments::Registry& registry() const { return registry_; }

 private:
  experiments::Registry registry_ = experiments::load_registry();
  ScratchFolder scratch_;
  int asked_ = 0;
};

}  // namespace palpate::test
