// Faces and edges of a skin that no tetrahedra inside make up for.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// What of a mesh's skin, the faces that no two tets share, is so bad that no inside makes up for it; null
/// where nothing is.
///
///   faces   on which no tet has a mean ratio above `best_mean_ratio`: that of the best tet on a triangle of
///           area A and squared edges l^2 is (12 A / (sqrt(3) sum of l^2))^(2/3), with its apex over the
///           middle
///   edges   at which two faces meet inside at less than `least_angle_deg`: some tet there has no greater
///   angle
///
/// Each as "count" and, the worst first, up to ten of them by their vertices (from 1, as in the file) and
/// place.
nlohmann::json describe_poor_skin(const TetMesh& mesh, const std::vector<Triangle>& skin);

/// The same in words.
std::string poor_skin_text(const nlohmann::json& skin);

}  // namespace palpate::experiments
