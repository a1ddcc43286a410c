#include "core/judge/linear_elements/elastic_blocks.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/mesh/tet_edges.h"

namespace palpate::judge {
namespace {

/// Rows and columns of the vertices of each edge, and the vertices themselves.
BlockRows build_pattern(const TetMesh& mesh, const TetEdges& edges) {
  const std::size_t n = mesh.points.size();
  BlockRows rows;
  rows.first.assign(n + 1, 1);  // the diagonal
  rows.first[0] = 0;
  for (const auto& [a, b] : edges.edges) {
    ++rows.first[a + 1];
    ++rows.first[b + 1];
  }
  for (std::size_t v = 0; v < n; ++v) rows.first[v + 1] += rows.first[v];
  rows.column.resize(rows.first[n]);
  rows.block.assign(rows.first[n], Block{});
  // Edges are sorted by (a, b): smaller neighbours come first and rise, then the diagonal, then larger ones.
  std::vector<std::size_t> next(rows.first.begin(), rows.first.end() - 1);
  for (const auto& [a, b] : edges.edges) rows.column[next[b]++] = a;
  for (std::size_t v = 0; v < n; ++v) rows.column[next[v]++] = static_cast<Index>(v);
  for (const auto& [a, b] : edges.edges) rows.column[next[a]++] = b;
  return rows;
}

Block& entry(BlockRows& rows, Index v, Index w) {
  const auto begin = rows.column.begin();
  const auto low = begin + static_cast<std::ptrdiff_t>(rows.first[v]);
  const auto high = begin + static_cast<std::ptrdiff_t>(rows.first[v + 1]);
  return rows.block[static_cast<std::size_t>(std::lower_bound(low, high, w) - begin)];
}

/// V (lambda g h^T + mu h g^T + mu (g . h) 1): what a displacement h at one vertex does at the other.
void add_pair(Block& block, const Vec3& g, const Vec3& h, double volume, double lambda, double mu) {
  const std::array<double, 3> gs{g.x, g.y, g.z};
  const std::array<double, 3> hs{h.x, h.y, h.z};
  const double both = volume * mu * dot(g, h);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      block[3 * i + j] += volume * (lambda * gs[i] * hs[j] + mu * hs[i] * gs[j]) + (i == j ? both : 0.0);
    }
  }
}

/// y += factor_j x for each field.
void add_scaled(std::span<const double> factor, const FieldBlock& x, FieldBlock& y) {
  for (std::size_t r = 0; r < x.rows(); ++r) {
    const double* p = x.row(r);
    double* q = y.row(r);
    for (std::size_t j = 0; j < x.width; ++j) q[j] += factor[j] * p[j];
  }
}

}  // namespace

TetGradients tet_gradients(const TetMesh& mesh, const Tet& tet) {
  const auto& p = mesh.points;
  const Vec3 a = p[tet[1]] - p[tet[0]];
  const Vec3 b = p[tet[2]] - p[tet[0]];
  const Vec3 c = p[tet[3]] - p[tet[0]];
  const double six_volumes = dot(cross(a, b), c);
  TetGradients result;
  result.volume = six_volumes / 6.0;
  result.gradient[1] = (1.0 / six_volumes) * cross(b, c);
  result.gradient[2] = (1.0 / six_volumes) * cross(c, a);
  result.gradient[3] = (1.0 / six_volumes) * cross(a, b);
  result.gradient[0] = -1.0 * (result.gradient[1] + result.gradient[2] + result.gradient[3]);
  return result;
}

BlockRows build_stiffness(const TetMesh& mesh, double lambda, double mu) {
  BlockRows rows = build_pattern(mesh, number_edges(mesh));
  for (const Tet& tet : mesh.tets) {
    const TetGradients shape = tet_gradients(mesh, tet);
    require(shape.volume > 0.0, "build_stiffness: a tet without positive volume");
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        add_pair(entry(rows, tet[i], tet[j]), shape.gradient[i], shape.gradient[j], shape.volume, lambda, mu);
      }
    }
  }
  return rows;
}

void multiply(const BlockRows& matrix, const FieldBlock& x, FieldBlock& y) {
  const std::size_t width = x.width;
  std::fill(y.values.begin(), y.values.end(), 0.0);
  for (std::size_t v = 0; v < matrix.size(); ++v) {
    for (std::size_t k = matrix.first[v]; k < matrix.first[v + 1]; ++k) {
      const Block& b = matrix.block[k];
      const std::size_t other = 3 * std::size_t{matrix.column[k]};
      const double* x0 = x.row(other);
      const double* x1 = x.row(other + 1);
      const double* x2 = x.row(other + 2);
      for (std::size_t a = 0; a < 3; ++a) {
        double* out = y.row(3 * v + a);
        for (std::size_t j = 0; j < width; ++j) {
          out[j] += b[3 * a] * x0[j] + b[3 * a + 1] * x1[j] + b[3 * a + 2] * x2[j];
        }
      }
    }
  }
}

void apply_blocks(std::span<const Block> blocks, const FieldBlock& x, FieldBlock& y) {
  const std::size_t width = x.width;
  for (std::size_t v = 0; v < blocks.size(); ++v) {
    for (std::size_t a = 0; a < 3; ++a) {
      double* out = y.row(3 * v + a);
      const double* x0 = x.row(3 * v);
      const double* x1 = x.row(3 * v + 1);
      const double* x2 = x.row(3 * v + 2);
      const Block& b = blocks[v];
      for (std::size_t j = 0; j < width; ++j) {
        out[j] = b[3 * a] * x0[j] + b[3 * a + 1] * x1[j] + b[3 * a + 2] * x2[j];
      }
    }
  }
}

std::vector<double> dots(const FieldBlock& x, const FieldBlock& y) {
  std::vector<double> sums(x.width, 0.0);
  for (std::size_t r = 0; r < x.rows(); ++r) {
    const double* p = x.row(r);
    const double* q = y.row(r);
    for (std::size_t j = 0; j < x.width; ++j) sums[j] += p[j] * q[j];
  }
  return sums;
}

std::vector<Block> diagonal_blocks(const BlockRows& matrix) {
  std::vector<Block> blocks(matrix.size());
  for (std::size_t v = 0; v < matrix.size(); ++v) {
    for (std::size_t k = matrix.first[v]; k < matrix.first[v + 1]; ++k) {
      if (matrix.column[k] == v) blocks[v] = matrix.block[k];
    }
  }
  return blocks;
}

std::vector<Block> invert_blocks(std::span<const Block> blocks) {
  std::vector<Block> inverses;
  inverses.reserve(blocks.size());
  for (const Block& m : blocks) {
    const Vec3 r0{m[0], m[1], m[2]};
    const Vec3 r1{m[3], m[4], m[5]};
    const Vec3 r2{m[6], m[7], m[8]};
    const Vec3 c0 = cross(r1, r2);
    const Vec3 c1 = cross(r2, r0);
    const Vec3 c2 = cross(r0, r1);
    const double determinant = dot(r0, c0);
    if (!(m[0] > 0.0) || !(c2.z > 0.0) || !(determinant > 0.0)) return {};
    const double f = 1.0 / determinant;
    inverses.push_back(
        {f * c0.x, f * c1.x, f * c2.x, f * c0.y, f * c1.y, f * c2.y, f * c0.z, f * c1.z, f * c2.z});
  }
  return inverses;
}

bool solve_fields(const BlockRows& matrix, std::span<const Block> inverse_diagonal, const FieldBlock& f,
                  FieldBlock& x, double tolerance, std::size_t most) {
  FieldBlock residual = f;
  FieldBlock scaled(matrix.size(), f.width);
  FieldBlock product(matrix.size(), f.width);
  apply_blocks(inverse_diagonal, f, scaled);
  std::vector<double> enough = dots(f, scaled);
  for (double& value : enough) value *= tolerance * tolerance;
  multiply(matrix, x, product);
  for (std::size_t i = 0; i < residual.values.size(); ++i) residual.values[i] -= product.values[i];
  apply_blocks(inverse_diagonal, residual, scaled);
  FieldBlock direction = scaled;
  std::vector<double> size = dots(residual, scaled);
  std::vector<double> factor(f.width);
  for (std::size_t step = 0; step <= most; ++step) {
    bool is_done = true;
    for (std::size_t j = 0; j < f.width; ++j) is_done = is_done && size[j] <= enough[j];
    if (is_done) return true;
    multiply(matrix, direction, product);
    const std::vector<double> energy = dots(direction, product);
    for (std::size_t j = 0; j < f.width; ++j) {
      factor[j] = size[j] > enough[j] && energy[j] > 0.0 ? size[j] / energy[j] : 0.0;
    }
    add_scaled(factor, direction, x);
    for (double& value : factor) value = -value;
    add_scaled(factor, product, residual);
    apply_blocks(inverse_diagonal, residual, scaled);
    const std::vector<double> next = dots(residual, scaled);
    for (std::size_t r = 0; r < direction.rows(); ++r) {
      double* d = direction.row(r);
      const double* z = scaled.row(r);
      for (std::size_t j = 0; j < f.width; ++j)
        d[j] = z[j] + (size[j] > 0.0 ? next[j] / size[j] : 0.0) * d[j];
    }
    size = next;
  }
  return false;
}

}  // namespace palpate::judge
