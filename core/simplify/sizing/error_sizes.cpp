#include "core/simplify/sizing/error_sizes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::simplify {
namespace {

using Stress = std::array<double, 6>;  ///< xx, yy, zz, xy, xz, yz

/// Of a tet of edge length l in a mesh of good ones: 0.1 l^3 (a regular one has 0.118 l^3).
constexpr double kTetVolume = 0.1;
constexpr double kEasyShare = 0.1;  ///< of the volume: where errors are least
constexpr double kExponent = -0.2;  ///< of linear elements in three dimensions: -1 / (2 + 3)
constexpr int kFitSteps = 60;
constexpr double kMostRounds = 400.0;  ///< of spreading: twenty edges

struct TetPlaces {
  std::array<Vec3, 4> p;
  double volume;
};

TetPlaces places_of(const TetMesh& mesh, const Tet& t) {
  TetPlaces out{{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]}, 0.0};
  out.volume = signed_volume(out.p[0], out.p[1], out.p[2], out.p[3]);
  require(out.volume > 0.0, "sizes of errors: a tet without positive volume");
  return out;
}

/// Gradient of the linear shape function of corner i.
Vec3 shape_gradient(const TetPlaces& tet, std::size_t i) {
  const auto& face = kTetFaces[i];  // opposite to corner i, counter-clockwise from outside
  const Vec3 area = cross(tet.p[face[1]] - tet.p[face[0]], tet.p[face[2]] - tet.p[face[0]]);
  return (-1.0 / (6.0 * tet.volume)) * area;
}

Stress stress_of(const Tet& t, const TetPlaces& tet, double lambda, double mu,
                 std::span<const Vec3> displacement) {
  Stress strain{};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 g = shape_gradient(tet, i);
    const Vec3 u = displacement[t[i]];
    strain[0] += u.x * g.x;
    strain[1] += u.y * g.y;
    strain[2] += u.z * g.z;
    strain[3] += 0.5 * (u.x * g.y + u.y * g.x);
    strain[4] += 0.5 * (u.x * g.z + u.z * g.x);
    strain[5] += 0.5 * (u.y * g.z + u.z * g.y);
  }
  const double pressure = lambda * (strain[0] + strain[1] + strain[2]);
  Stress stress{};
  for (std::size_t k = 0; k < 6; ++k) stress[k] = 2.0 * mu * strain[k] + (k < 3 ? pressure : 0.0);
  return stress;
}

/// a : C^-1 b of two stresses.
double compliance_product(const Stress& a, const Stress& b, double lambda, double mu) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 6; ++k) sum += (k < 3 ? 1.0 : 2.0) * a[k] * b[k];
  const double trace = (a[0] + a[1] + a[2]) * (b[0] + b[1] + b[2]);
  return (sum - lambda / (3.0 * lambda + 2.0 * mu) * trace) / (2.0 * mu);
}

/// 1/2 of the integral over a tet of d : C^-1 d, d linear between its corners: V / 20 (sum of d_i : d_j over
/// all pairs, and of d_i : d_i once more).
double linear_energy(const std::array<Stress, 4>& d, double volume, double lambda, double mu) {
  Stress sum{};
  double own = 0.0;
  for (const Stress& corner : d) {
    own += compliance_product(corner, corner, lambda, mu);
    for (std::size_t k = 0; k < 6; ++k) sum[k] += corner[k];
  }
  return 0.5 * volume / 20.0 * (own + compliance_product(sum, sum, lambda, mu));
}

/// Rounds in which each vertex takes the mean of itself and its neighbours, by weight: n of them spread by
/// about the root of n mean edges.
void spread_values(const TetMesh& mesh, const std::vector<double>& weight, double spread,
                   std::vector<double>& value) {
  const std::vector<Edge> edges = build_edges(mesh);
  double sum = 0.0;
  for (const auto& [a, b] : edges) sum += length(mesh.points[b] - mesh.points[a]);
  const double mean = sum / static_cast<double>(std::max<std::size_t>(1, edges.size()));
  const double steps = mean > 0.0 ? spread / mean : 0.0;
  const int rounds = static_cast<int>(std::min(std::floor(steps * steps), kMostRounds));
  std::vector<double> top(value.size());
  std::vector<double> bottom(value.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t v = 0; v < value.size(); ++v) {
      top[v] = weight[v] * value[v];
      bottom[v] = weight[v];
    }
    for (const auto& [a, b] : edges) {
      top[a] += weight[b] * value[b];
      bottom[a] += weight[b];
      top[b] += weight[a] * value[a];
      bottom[b] += weight[a];
    }
    for (std::size_t v = 0; v < value.size(); ++v) {
      if (bottom[v] > 0.0) value[v] = top[v] / bottom[v];
    }
  }
}

}  // namespace

std::vector<double> estimate_tet_errors(const TetMesh& mesh, double lambda_pa, double mu_pa,
                                        std::span<const Vec3> displacement) {
  require(displacement.size() == mesh.points.size(), "estimate_tet_errors: one displacement a vertex");
  std::vector<Stress> of_tet(mesh.tets.size());
  std::vector<double> volume(mesh.tets.size());
  std::vector<Stress> recovered(mesh.points.size(), Stress{});
  std::vector<double> weight(mesh.points.size(), 0.0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetPlaces tet = places_of(mesh, mesh.tets[t]);
    volume[t] = tet.volume;
    of_tet[t] = stress_of(mesh.tets[t], tet, lambda_pa, mu_pa, displacement);
    for (const Index v : mesh.tets[t]) {
      weight[v] += tet.volume;
      for (std::size_t k = 0; k < 6; ++k) recovered[v][k] += tet.volume * of_tet[t][k];
    }
  }
  for (std::size_t v = 0; v < recovered.size(); ++v) {
    for (double& component : recovered[v]) component /= std::max(weight[v], 1e-300);
  }
  std::vector<double> errors(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::array<Stress, 4> difference{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 6; ++k) difference[i][k] = recovered[mesh.tets[t][i]][k] - of_tet[t][k];
    }
    errors[t] = std::max(0.0, linear_energy(difference, volume[t], lambda_pa, mu_pa));
  }
  return errors;
}

std::vector<double> sizes_of_errors(const TetMesh& mesh, std::span<const double> tet_errors,
                                    double least_size, double spread) {
  if (!(spread >= 0.0 && std::isfinite(spread)))
    throw InputError("spread", 0, "a finite length of at least 0", short_number(spread));
  if (!(least_size > 0.0 && least_size <= 1.0))
    throw InputError("least_size", 0, "a number above 0, at most 1", short_number(least_size));
  require(tet_errors.size() == mesh.tets.size(), "sizes_of_errors: one error a tet");
  std::vector<double> density(mesh.points.size(), 0.0);
  std::vector<double> weight(mesh.points.size(), 0.0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = places_of(mesh, mesh.tets[t]).volume;
    const double size = std::cbrt(volume);
    for (const Index v : mesh.tets[t]) {
      density[v] += tet_errors[t] / (size * size);
      weight[v] += volume;
    }
  }
  for (std::size_t v = 0; v < density.size(); ++v) {
    if (weight[v] > 0.0) density[v] /= weight[v];
  }
  spread_values(mesh, weight, spread, density);
  double whole = 0.0;
  std::vector<std::pair<double, double>> sorted;  // density, volume
  sorted.reserve(density.size());
  for (std::size_t v = 0; v < density.size(); ++v) {
    if (!(weight[v] > 0.0)) continue;
    whole += weight[v];
    sorted.emplace_back(density[v], weight[v]);
  }
  std::sort(sorted.begin(), sorted.end());
  double least = 0.0;
  double below = 0.0;
  for (const auto& [value, volume] : sorted) {
    below += volume;
    least = value;
    if (below >= kEasyShare * whole && least > 0.0) break;
  }
  std::vector<double> sizes(density.size(), 1.0);
  if (!(least > 0.0)) return sizes;
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    if (density[v] > least) sizes[v] = std::max(least_size, std::pow(density[v] / least, kExponent));
  }
  return sizes;
}

void limit_growth(const TetMesh& mesh, double growth, double far, std::vector<double>& sizes) {
  if (!(growth > 0.0 && std::isfinite(growth)))
    throw InputError("growth", 0, "a finite number above 0", short_number(growth));
  if (!(far > 0.0 && std::isfinite(far)))
    throw InputError("far", 0, "a finite length above 0", short_number(far));
  std::vector<std::vector<std::pair<Index, double>>> neighbours(mesh.points.size());
  for (const auto& [a, b] : build_edges(mesh)) {
    const double rise = growth * length(mesh.points[b] - mesh.points[a]) / far;
    neighbours[a].emplace_back(b, rise);
    neighbours[b].emplace_back(a, rise);
  }
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (Index v = 0; v < sizes.size(); ++v) open.emplace(sizes[v], v);
  while (!open.empty()) {
    const auto [size, v] = open.top();
    open.pop();
    if (size > sizes[v]) continue;
    for (const auto& [w, rise] : neighbours[v]) {
      if (!(size + rise < sizes[w])) continue;
      sizes[w] = size + rise;
      open.emplace(sizes[w], w);
    }
  }
}

double fit_sizes(const TetMesh& mesh, std::uint64_t tets, std::vector<double>& sizes) {
  if (tets == 0 || tets >= mesh.tets.size())
    throw InputError("tets", 0, "from 1 to " + std::to_string(mesh.tets.size()) + ", fewer than the mesh has",
                     std::to_string(tets));
  require(sizes.size() == mesh.points.size(), "fit_sizes: one size a vertex");
  for (const double size : sizes) {
    if (!(size > 0.0 && std::isfinite(size)))
      throw InputError("sizes", 0, "finite numbers above 0", short_number(size));
  }
  std::vector<double> volume;
  std::vector<double> edge;    // that the mesh has, of each tet
  std::vector<double> wanted;  // relative
  volume.reserve(mesh.tets.size());
  edge.reserve(mesh.tets.size());
  wanted.reserve(mesh.tets.size());
  std::vector<double> own(mesh.points.size(), 0.0);  // of each vertex: the mean edge of its tets, by volume
  std::vector<double> weight(mesh.points.size(), 0.0);
  for (const Tet& t : mesh.tets) {
    const double here = places_of(mesh, t).volume;
    volume.push_back(here);
    edge.push_back(std::cbrt(here / kTetVolume));
    double sum = 0.0;
    for (const Index v : t) {
      sum += sizes[v];
      own[v] += here * edge.back();
      weight[v] += here;
    }
    wanted.push_back(0.25 * sum);
  }
  const auto count_at = [&](double far) {
    double count = 0.0;
    for (std::size_t t = 0; t < volume.size(); ++t) {
      const double size = std::max(far * wanted[t], edge[t]);
      count += volume[t] / (kTetVolume * size * size * size);
    }
    return count;
  };
  double low = 0.0;
  double high =
      2.0 * *std::max_element(edge.begin(), edge.end()) / *std::min_element(wanted.begin(), wanted.end());
  const auto goal = static_cast<double>(tets);
  while (count_at(high) > goal) high *= 2.0;
  for (int step = 0; step < kFitSteps; ++step) {
    const double middle = 0.5 * (low + high);
    (count_at(middle) > goal ? low : high) = middle;
  }
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    if (weight[v] > 0.0) sizes[v] = std::max(sizes[v], own[v] / weight[v] / high);
  }
  return high;
}

}  // namespace palpate::simplify
