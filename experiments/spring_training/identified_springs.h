// Springs of a mesh by one of our methods, from the program that knows them (reference/springs).
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/identification/identify.h"

namespace palpate::experiments {

/// What is asked for.
struct SpringWish {
  springs::SpringMethod method = springs::SpringMethod::kIsotropyPatch;
  Material material;
  std::map<std::string, std::string>
      set;                 ///< options of the method, as springs::set_spring_option reads them
  bool calibrate = false;  ///< all springs times one factor, from their moduli on their own mesh
};

/// What came of it.
struct IdentifiedSprings {
  SpringNetwork network;
  springs::IdentifyReport report;
  double calibration_factor = 1.0;
  double kernel_s = 0.0;  ///< that the method and the calibration took
};

/// As requests have it.
nlohmann::json material_to_json(const Material& material);

/// Requires: a mesh in metres. Throws: InputError as springs::identify_springs does; UnavailableError if the
/// program is not there, or fails.
IdentifiedSprings obtain_springs(const TetMesh& mesh, const SpringWish& wish);

}  // namespace palpate::experiments
