// A model that moves, as one file that another simulator can read (palpate/model/1, docs/model_file.md).
#pragma once

#include <nlohmann/json.hpp>

#include "core/dynamics/motion/motion_model.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Mesh, masses, springs, smoothed energies, volume force and damping as JSON, in SI units; numbers read back
/// to the same bits. Loads are not in it. Shape: docs/model_file.md.
nlohmann::json model_to_json(const TetMesh& mesh, const dynamics::MotionModel& model);

}  // namespace palpate::reference
