#include "core/springs/identification/isotropy_system.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/mesh/space_order.h"
#include "core/mesh/topology.h"
#include "core/springs/network/network.h"

namespace palpate::springs {
namespace {

constexpr std::size_t kRows = kIsotropyRows + kPatchRows;
constexpr std::size_t kPadding = 4;        // of a block's columns, in floats
constexpr std::size_t kLargestBlock = 64;  // springs at a vertex; beyond, rows take less memory than a block

// A third of the outward area vectors of the boundary faces at each vertex.
std::vector<Vec3> vertex_areas(const TetMesh& mesh) {
  std::vector<Vec3> area(mesh.points.size());
  for (const auto& [a, b, c] : build_boundary(mesh)) {
    const Vec3 third = (1.0 / 6.0) * cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
    for (const Index vertex : {a, b, c}) area[vertex] = area[vertex] + third;
  }
  return area;
}

// Spring ends around each vertex; the springs of a vertex in increasing order.
void add_ends(const TetMesh& mesh, const SpringNetwork& network, IsotropySystem& system) {
  const std::size_t places = system.vertex.size();
  std::vector<std::size_t> place(places);
  for (std::size_t i = 0; i < places; ++i) place[system.vertex[i]] = i;
  system.offsets.assign(places + 1, 0);
  for (const Edge& ends : network.springs)
    for (const Index vertex : ends) ++system.offsets[place[vertex] + 1];
  std::partial_sum(system.offsets.begin(), system.offsets.end(), system.offsets.begin());
  system.spring.resize(system.offsets.back());
  system.direction.resize(system.offsets.back());
  std::vector<std::size_t> next(system.offsets.begin(), system.offsets.end() - 1);
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    const Vec3 d = mesh.points[b] - mesh.points[a];
    const Vec3 unit = (1.0 / length(d)) * d;
    const std::size_t at_a = next[place[a]]++;
    const std::size_t at_b = next[place[b]]++;
    system.spring[at_a] = static_cast<Index>(s);
    system.direction[at_a] = unit;
    system.spring[at_b] = static_cast<Index>(s);
    system.direction[at_b] = -1.0 * unit;
  }
}

// The right-hand side, and the weight of the patch rows at each vertex.
void add_targets(const TetMesh& mesh, const SpringNetwork& network, double young_modulus_pa,
                 const IsotropyOptions& options, IsotropySystem& system) {
  const std::vector<double> volume = build_influence_volumes(mesh);
  const std::vector<Vec3> area = options.patch ? vertex_areas(mesh) : std::vector<Vec3>(volume.size());
  const auto means = isotropy_means();
  system.patch_factor.assign(system.spring.size(), 0.0);
  system.target.resize(system.vertex.size() * system.rows_a_vertex);
  for (std::size_t i = 0; i < system.vertex.size(); ++i) {
    double* row = system.target.data() + i * system.rows_a_vertex;
    const double moment = 12.0 * young_modulus_pa * volume[system.vertex[i]];
    for (std::size_t r = 0; r < kIsotropyRows; ++r) row[r] = moment * means[r];
    if (!options.patch || system.offsets[i] == system.offsets[i + 1]) {
      std::fill(row + kIsotropyRows, row + system.rows_a_vertex, 0.0);
      continue;
    }
    double lengths = 0.0;
    for (std::size_t end = system.offsets[i]; end < system.offsets[i + 1]; ++end)
      lengths += network.rest_length_m[system.spring[end]];
    const double weight =
        options.patch_length * lengths / static_cast<double>(system.offsets[i + 1] - system.offsets[i]);
    for (std::size_t end = system.offsets[i]; end < system.offsets[i + 1]; ++end)
      system.patch_factor[end] = weight / network.rest_length_m[system.spring[end]];
    const auto patch = patch_target(area[system.vertex[i]]);
    for (std::size_t r = 0; r < kPatchRows; ++r)
      row[kIsotropyRows + r] = -weight * young_modulus_pa / 2.5 * patch[r];
  }
}

// Inner product of two springs' rows at a vertex.
double inner_product(const IsotropySystem& system, std::size_t end, std::size_t other) {
  const double cosine = dot(system.direction[end], system.direction[other]);
  return cosine * cosine * cosine * (cosine + system.patch_factor[end] * system.patch_factor[other]);
}

std::size_t padded(std::size_t springs) {
  return (springs + kPadding - 1) / kPadding * kPadding;
}

void add_blocks(IsotropySystem& system) {
  const std::size_t places = system.vertex.size();
  system.block_offsets.assign(places + 1, 0);
  for (std::size_t i = 0; i < places; ++i) {
    const std::size_t count = system.offsets[i + 1] - system.offsets[i];
    system.block_offsets[i + 1] =
        system.block_offsets[i] + (count <= kLargestBlock ? count * padded(count) : 0);
  }
  system.blocks.assign(system.block_offsets.back(), 0.0F);
  for (std::size_t i = 0; i < places; ++i) {
    const std::size_t first = system.offsets[i];
    const std::size_t count = system.offsets[i + 1] - first;
    if (count > kLargestBlock) continue;
    float* block = system.blocks.data() + system.block_offsets[i];
    const std::size_t stride = padded(count);
    for (std::size_t column = 0; column < count; ++column)
      for (std::size_t row = 0; row <= column; ++row) {
        const auto value = static_cast<float>(inner_product(system, first + row, first + column));
        block[column * stride + row] = value;
        block[row * stride + column] = value;
      }
  }
}

// All rows of one spring end.
std::array<double, kRows> coefficients(const IsotropySystem& system, std::size_t end) {
  std::array<double, kRows> rows;
  const auto isotropy = isotropy_coefficients(system.direction[end]);
  std::copy(isotropy.begin(), isotropy.end(), rows.begin());
  const auto patch = patch_coefficients(system.direction[end]);
  for (std::size_t r = 0; r < kPatchRows; ++r) rows[kIsotropyRows + r] = system.patch_factor[end] * patch[r];
  return rows;
}

// The rows at one place applied to x, and added back to y: y += A_i^T A_i x.
template <typename Scalar>
void add_rows_action(const IsotropySystem& system, std::size_t place, std::span<const Scalar> x,
                     std::span<Scalar> y) {
  std::array<double, kRows> moments{};
  for (std::size_t end = system.offsets[place]; end < system.offsets[place + 1]; ++end) {
    const auto rows = coefficients(system, end);
    const auto value = static_cast<double>(x[system.spring[end]]);
    for (std::size_t r = 0; r < kRows; ++r) moments[r] += rows[r] * value;
  }
  for (std::size_t end = system.offsets[place]; end < system.offsets[place + 1]; ++end) {
    const auto rows = coefficients(system, end);
    double sum = 0.0;
    for (std::size_t r = 0; r < kRows; ++r) sum += rows[r] * moments[r];
    y[system.spring[end]] += static_cast<Scalar>(sum);
  }
}

// The inner products of the rows at one place, computed on the way, in double precision: y += B_i x. Faster
// than by the rows where springs are few.
void add_products_action(const IsotropySystem& system, std::size_t place, std::span<const double> x,
                         std::span<double> y) {
  const std::size_t first = system.offsets[place];
  const std::size_t count = system.offsets[place + 1] - first;
  std::array<double, kLargestBlock> ex;
  std::array<double, kLargestBlock> ey;
  std::array<double, kLargestBlock> ez;
  std::array<double, kLargestBlock> sum;
  const double* factor = system.patch_factor.data() + first;
  for (std::size_t i = 0; i < count; ++i) {
    ex[i] = system.direction[first + i].x;
    ey[i] = system.direction[first + i].y;
    ez[i] = system.direction[first + i].z;
    sum[i] = 0.0;
  }
  for (std::size_t j = 0; j < count; ++j) {
    const Vec3 e{ex[j], ey[j], ez[j]};
    const double value = x[system.spring[first + j]];
    const double factor_j = factor[j];
    for (std::size_t i = 0; i < count; ++i) {
      const double cosine = ex[i] * e.x + ey[i] * e.y + ez[i] * e.z;
      sum[i] += cosine * cosine * cosine * (cosine + factor[i] * factor_j) * value;
    }
  }
  for (std::size_t i = 0; i < count; ++i) y[system.spring[first + i]] += sum[i];
}

// The stored block at one place: y += B_i x.
void add_block_action(const IsotropySystem& system, std::size_t place, std::span<const float> x,
                      std::span<float> y) {
  const std::size_t first = system.offsets[place];
  const std::size_t count = system.offsets[place + 1] - first;
  const std::size_t stride = padded(count);
  std::array<float, kLargestBlock> sum{};
  const float* column = system.blocks.data() + system.block_offsets[place];
  for (std::size_t i = 0; i < count; ++i, column += stride) {
    const float value = x[system.spring[first + i]];
    for (std::size_t r = 0; r < stride; ++r) sum[r] += column[r] * value;
  }
  for (std::size_t i = 0; i < count; ++i) y[system.spring[first + i]] += sum[i];
}

}  // namespace

IsotropySystem build_isotropy_system(const TetMesh& mesh, const SpringNetwork& network,
                                     double young_modulus_pa, const IsotropyOptions& options) {
  require(young_modulus_pa > 0.0 && std::isfinite(young_modulus_pa),
          "isotropy rows: Young's modulus is positive and finite");
  require(options.patch_length >= 0.0 && std::isfinite(options.patch_length),
          "isotropy rows: the patch rows' weight is finite and not negative");
  require(network.rest_length_m.size() == network.springs.size(),
          "isotropy rows: each spring has a rest length");
  for (std::size_t s = 0; s < network.springs.size(); ++s)
    require(network.springs[s][0] < network.springs[s][1] && network.springs[s][1] < mesh.points.size() &&
                network.rest_length_m[s] > 0.0,
            "isotropy rows: the springs are those of the mesh, with positive rest lengths");
  IsotropySystem system;
  system.springs = network.springs.size();
  system.rows_a_vertex = options.patch ? kRows : kIsotropyRows;
  system.vertex = order_in_space(mesh.points);
  add_ends(mesh, network, system);
  add_targets(mesh, network, young_modulus_pa, options, system);
  add_blocks(system);
  return system;
}

void apply_isotropy_rows(const IsotropySystem& system, std::span<const double> w, std::span<double> y) {
  for (std::size_t i = 0; i < system.vertex.size(); ++i) {
    double* moments = y.data() + i * system.rows_a_vertex;
    std::fill(moments, moments + system.rows_a_vertex, 0.0);
    for (std::size_t end = system.offsets[i]; end < system.offsets[i + 1]; ++end) {
      const auto rows = coefficients(system, end);
      for (std::size_t r = 0; r < system.rows_a_vertex; ++r) moments[r] += rows[r] * w[system.spring[end]];
    }
  }
}

void apply_isotropy_rows_transposed(const IsotropySystem& system, std::span<const double> y,
                                    std::span<double> w) {
  std::fill(w.begin(), w.end(), 0.0);
  for (std::size_t i = 0; i < system.vertex.size(); ++i) {
    const double* moments = y.data() + i * system.rows_a_vertex;
    for (std::size_t end = system.offsets[i]; end < system.offsets[i + 1]; ++end) {
      const auto rows = coefficients(system, end);
      double sum = 0.0;
      for (std::size_t r = 0; r < system.rows_a_vertex; ++r) sum += rows[r] * moments[r];
      w[system.spring[end]] += sum;
    }
  }
}

NormalEquations isotropy_normal_equations(const IsotropySystem& system) {
  NormalEquations equations;
  equations.diagonal.assign(system.springs, 0.0);
  for (std::size_t end = 0; end < system.spring.size(); ++end)
    equations.diagonal[system.spring[end]] += inner_product(system, end, end);
  equations.linear.resize(system.springs);
  apply_isotropy_rows_transposed(system, system.target, equations.linear);
  equations.apply = [&system](std::span<const double> x, std::span<double> y) {
    std::fill(y.begin(), y.end(), 0.0);
    for (std::size_t i = 0; i < system.vertex.size(); ++i) {
      if (system.offsets[i + 1] - system.offsets[i] <= kLargestBlock)
        add_products_action(system, i, x, y);
      else
        add_rows_action(system, i, x, y);
    }
  };
  equations.apply_single = [&system](std::span<const float> x, std::span<float> y) {
    std::fill(y.begin(), y.end(), 0.0F);
    for (std::size_t i = 0; i < system.vertex.size(); ++i) {
      if (system.offsets[i + 1] - system.offsets[i] <= kLargestBlock)
        add_block_action(system, i, x, y);
      else
        add_rows_action(system, i, x, y);
    }
  };
  return equations;
}

}  // namespace palpate::springs
