#include "reference/engine/motion_progress.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// Least height of a tet: three volumes over its largest face.
double height_of(const TetMesh& mesh, const Tet& t) {
  const auto& p = mesh.points;
  double largest = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& a = p[t[(k + 1) % 4]];
    largest = std::max(largest, 0.5 * length(cross(p[t[(k + 2) % 4]] - a, p[t[(k + 3) % 4]] - a)));
  }
  return 3.0 * signed_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) / largest;
}

}  // namespace

FlatTet find_flattest_tet(const TetMesh& mesh, Index vertex) {
  FlatTet found;
  found.height_m = std::numeric_limits<double>::infinity();
  std::vector<double> heights;
  heights.reserve(mesh.tets.size());
  for (Index k = 0; k < mesh.tets.size(); ++k) {
    const Tet& t = mesh.tets[k];
    heights.push_back(height_of(mesh, t));
    if (std::find(t.begin(), t.end(), vertex) == t.end() || heights.back() >= found.height_m) continue;
    found.tet = k;
    found.height_m = heights.back();
  }
  require(found.tet != kNoIndex, "find_flattest_tet: a vertex without tets");
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  found.median_height_m = *middle;
  return found;
}

MotionProgress::MotionProgress(const std::filesystem::path& file, const MotionSetup& setup,
                               const TetMesh& mesh)
    : file_(file) {
  if (!file_.is_written()) return;
  json content = {{"time_step_s", setup.step_s},
                  {"stable_step_s", number_or_null(setup.stable.step_s)},
                  {"stable_by", setup.stable_by},
                  {"steps", setup.steps},
                  {"limiting", nullptr}};
  const Index vertex = setup.stable.limiting_vertex;
  if (vertex != kNoIndex) {
    const FlatTet flat = find_flattest_tet(mesh, vertex);
    const Vec3& place = mesh.points[vertex];
    content["limiting"] = {{"vertex", vertex},
                           {"place_m", {place.x, place.y, place.z}},
                           {"tet", flat.tet},
                           {"height_m", flat.height_m},
                           {"median_height_m", flat.median_height_m}};
  }
  file_.begin(std::move(content));
}

}  // namespace palpate::reference
