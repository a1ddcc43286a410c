#include "reference/simplifier_support/remesh_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/sizing/stop_rule.h"
#include "reference/simplifier_support/size_search.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr double kWorthANote = 0.005;

simplify::StopRule read_count_stop(const json& stop) {
  const auto fail = [&](const std::string& found) {
    throw InputError("stop", 0, "tets (a whole number, 1 or more) or ratio (from 0 up to, not including, 1)",
                     found);
  };
  if (!stop.is_object() || stop.size() != 1) fail(stop.dump());
  simplify::StopRule rule;
  const std::string& kind = stop.begin().key();
  const json& value = stop.begin().value();
  if (kind == "tets" && value.is_number_unsigned() && value.get<std::uint64_t>() > 0) {
    rule.tets = value.get<std::uint64_t>();
  } else if (kind == "ratio" && value.is_number() && value.get<double>() >= 0.0 &&
             value.get<double>() < 1.0) {
    rule.ratio = value.get<double>();
  } else {
    fail(kind + ": " + value.dump());
  }
  return rule;
}

/// Edge of the regular tet of the mean volume that the target leaves.
double first_size(const TetMesh& mesh, std::uint64_t target) {
  constexpr double kEdgeCubedPerVolume = 8.485281374238571;  // 6 sqrt(2)
  return std::cbrt(kEdgeCubedPerVolume * total_volume(mesh) / static_cast<double>(target));
}

std::string percent_text(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g%%", 100.0 * share);
  return text.data();
}

std::string count_note(const FoundSize& found, bool searched, double mismatch, const std::string& size_name) {
  std::array<char, 32> size{};
  std::snprintf(size.data(), size.size(), "%.6g", found.size);
  std::string note = size_name + " " + size.data();
  note += searched ? ", searched for outside the timed part in " + std::to_string(found.tries) + " tries"
                   : ", handed back from an earlier repeat's search";
  if (std::fabs(mismatch) > kWorthANote) {
    note += "; " + percent_text(std::fabs(mismatch)) + (mismatch > 0.0 ? " more" : " fewer") +
            " tetrahedra than asked for" + (searched ? ", the nearest found" : "");
  }
  return note;
}

double tuned_size(const Request& request, const std::string& name) {
  const auto size = request.tuned.find(name);
  if (request.tuned.size() != 1 || size == request.tuned.end() || !(size->get<double>() > 0.0)) {
    throw InputError("tuned", 0, "a positive " + name + " alone", request.tuned.dump());
  }
  return size->get<double>();
}

}  // namespace

std::uint64_t read_tet_target(const json& stop, std::uint64_t tets_in) {
  const simplify::StopRule rule = read_count_stop(stop);
  return std::clamp<std::uint64_t>(simplify::target_tet_count(rule, tets_in), 1, tets_in);
}

Response run_remesher(const Request& request, const Remesher& remesher) {
  read_count_stop(request.stop);
  MeditFile file = read_medit(request.input);
  const TetMesh& mesh = file.mesh;
  const std::uint64_t target = read_tet_target(request.stop, mesh.tets.size());
  const double limit_s = 60.0 + remesher.time_limit_per_tet_s * static_cast<double>(mesh.tets.size());
  const auto run_once = [&](double size) {
    return run_isolated([&] { return remesher.remesh(mesh, target, size); }, limit_s);
  };
  const bool searched = request.tuned.empty();
  FoundSize found;
  if (searched) {
    found = search_size(run_once, remesher.first_factor * first_size(mesh, target), target);
  } else {
    found = {tuned_size(request, remesher.size_name), {}, 1};
    found.result = run_once(found.size);
  }
  const TetMesh& out = found.result.mesh;
  write_medit(request.output, out);
  const double mismatch = count_mismatch(out.tets.size(), target);
  Response response;
  response.kernel_s = found.result.kernel_s;
  response.tuned = {{remesher.size_name, found.size}};
  response.notes = std::move(file.notes);
  response.notes.push_back(count_note(found, searched, mismatch, remesher.size_name));
  response.report = {{"method", request.method},
                     {"vertices_in", mesh.points.size()},
                     {"vertices_out", out.points.size()},
                     {"tets_in", mesh.tets.size()},
                     {"tets_out", out.tets.size()},
                     {"target_tets", target},
                     {"count_mismatch_relative", mismatch},
                     {"tries", found.tries},
                     {"stop", request.stop.begin().key()}};
  return response;
}

}  // namespace palpate::reference
