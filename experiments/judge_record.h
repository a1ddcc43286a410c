// What the judge says, as the flat JSON object that records and `palpate quality --json` hold.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/judge/judge.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// The judge's verdict on one mesh.
struct Judgement {
  judge::Validity validity;
  nlohmann::json figures;               ///< flat; see record.schema.json
  std::vector<std::string> violations;  ///< why the mesh is invalid, one line each
};

/// Judges a mesh by itself.
Judgement judge_mesh(const TetMesh& mesh);

/// Judges an output: by itself, by the input's ideal volume (keys that end in _input_ideal), and against the
/// input.
Judgement judge_output(const TetMesh& output, const TetMesh& input);

/// A finite number as itself, any other as null; adds "key: reason" to `reasons` for the latter.
nlohmann::json finite_or_null(double value, const std::string& key, nlohmann::json& reasons);

}  // namespace palpate::experiments
