// The cases of a training request: problems and the fields that they should give, on one mesh.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/springs/training/training.h"

namespace palpate::reference {

/// The cases of one set.
struct TrainingSplit {
  std::string name;
  springs::TrainingSet set;
  std::vector<double> linear_elements;  ///< relative L2 error of the linear elements' field, one a case
};

/// Reads one of the request's "splits": {"name": "train", "cases": [{"name": "low/weight", "problem":
/// "problem.json", "quadratic": "p2.csv", "linear": "p1.csv"}]}, displacements as read_displacement reads
/// them. Throws: InputError for a file that does not fit the mesh.
TrainingSplit read_training_split(const nlohmann::json& split, const TetMesh& mesh);

}  // namespace palpate::reference
