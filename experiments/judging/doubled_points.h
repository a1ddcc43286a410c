// Meshes whose tets do not know of each other: every one has its own copies of its corners.
#pragma once

#include <string>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// Why a mesh is no body: it has several tets, no two of them share a vertex, and points lie where others do,
/// as files of cells with copied corners have them. Says how many, and one pair, counted from 1. Empty
/// otherwise; bodies that touch are not looked at. Time: n log n.
std::string doubled_points_complaint(const TetMesh& mesh);

}  // namespace palpate::experiments
