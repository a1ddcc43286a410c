#include "experiments/meshes/metre_mesh.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "experiments/judging/judge_record.h"
#include "experiments/meshes/mesh_fill.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

/// No organ is longer: a bigger box is most likely in millimetres.
constexpr double kLongestOrganM = 10.0;

}  // namespace

TetMesh read_mesh_in_metres(const std::string& path, double unit_m) {
  MeditFile file = read_mesh(path, ReadOrientation::kRestore);
  for (const std::string& note : file.notes) print_note(path + ": " + note);
  if (file.isolated_vertices > 0)
    print_note(path + ": vertices of the output are numbered without those left out");
  const Judgement judgement = judge_mesh(file.mesh);
  if (!judgement.violations.empty()) throw InputError(path, 0, "a valid mesh", judgement.violations.front());
  const BoundingBox box = bounding_box(file.mesh.points);
  require_body_size(unit_m * length(box.high - box.low));
  for (Vec3& point : file.mesh.points) point = unit_m * point;
  const double longest = longest_side(bounding_box(file.mesh.points));
  if (longest > kLongestOrganM) {
    print_note(path + ": the mesh is " + short_number(longest) +
               " m long; if its unit is the millimetre, say --unit-m 0.001");
  }
  return std::move(file.mesh);
}

}  // namespace palpate::experiments
