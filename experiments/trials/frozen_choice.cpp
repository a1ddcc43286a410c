#include "experiments/trials/frozen_choice.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/text/figure_text.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {

using nlohmann::json;

std::vector<Index> find_still(std::span<const Vec3> displacement_m, double most_m) {
  std::vector<Index> still;
  for (std::size_t v = 0; v < displacement_m.size(); ++v) {
    if (length(displacement_m[v]) <= most_m) still.push_back(static_cast<Index>(v));
  }
  return still;
}

std::size_t count_still_tets(const TetMesh& mesh, const std::vector<Index>& still) {
  std::vector<bool> is_still(mesh.points.size(), false);
  for (const Index v : still) is_still[v] = true;
  return static_cast<std::size_t>(std::count_if(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
    return std::all_of(tet.begin(), tet.end(), [&](Index v) { return is_still[v]; });
  }));
}

double rms_displacement(std::span<const Vec3> displacement_m) {
  double squares = 0.0;
  for (const Vec3& u : displacement_m) squares += length_sq(u);
  return displacement_m.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(displacement_m.size()));
}

std::string why_not_frozen(const FrozenTry& tried, std::size_t of_tets, double most_error) {
  if (static_cast<double>(tried.tets) < kLeastFrozen * static_cast<double>(of_tets))
    return "only " + std::to_string(tried.tets) + " of " + std::to_string(of_tets) + " tetrahedra are still";
  if (!tried.error || !tried.motion_error) return "its motion did not end";
  const double error = *tried.error + *tried.motion_error;
  if (!(error <= most_error)) return "error up to " + percent_text(error) + " of " + percent_text(most_error);
  if (!(tried.cost_s < tried.cost_before_s))
    return "takes " + time_text(tried.cost_s) + ", the whole model " + time_text(tried.cost_before_s);
  return "";
}

json describe_frozen(const std::vector<Index>& still, std::size_t of_vertices,
                     std::optional<double> most_force_n) {
  return {{"schema", "palpate/frozen/1"},
          {"of_vertices", of_vertices},
          {"most_force_n", reference::or_null(most_force_n)},
          {"vertices", still}};
}

std::string why_it_wakes(const std::filesystem::path& frozen_file, const json& report) {
  const json frozen = reference::read_json_file(frozen_file);
  const json most = frozen.is_object() ? frozen.value("most_force_n", json()) : json();
  if (!most.is_number())
    throw InputError(frozen_file.string() + ": most_force_n", 0,
                     "the force that the held part was verified with", most.dump());
  const json acts = report.value("frozen_force_most_n", json());
  if (acts.is_number() && acts.get<double>() <= most.get<double>() * (1.0 + 1e-9)) return "";
  const std::string now = acts.is_number() ? short_number(acts.get<double>()) + " N" : "no finite force";
  return "what acts on the part that is held at rest came to " + now + ", verified up to " +
         short_number(most.get<double>()) + " N";
}

}  // namespace palpate::experiments
