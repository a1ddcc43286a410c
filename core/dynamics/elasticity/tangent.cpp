#include "core/dynamics/elasticity/tangent.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

/// Offsets 0, n, 2 n, ... of groups of n.
std::vector<Index> even_offsets(std::size_t groups, std::size_t size) {
  std::vector<Index> offsets(groups + 1);
  for (std::size_t g = 0; g <= groups; ++g) offsets[g] = static_cast<Index>(g * size);
  return offsets;
}

Mat3 spring_block(const ElasticModel& model, std::span<const Vec3> u, std::size_t s, TangentKind kind) {
  const auto [a, b] = model.springs.springs[s];
  const Vec3 rest_edge = model.rest[b] - model.rest[a];
  const Vec3 change = u[b] - u[a];
  const double stiffness = model.springs.stiffness_n_per_m[s];
  const Vec3 edge = model.springs_are_linear ? rest_edge : rest_edge + change;
  const double size = length(edge);
  if (!(size > 0.0)) return {};
  const Vec3 n = (1.0 / size) * edge;
  const Mat3 along = outer(n, n);
  if (model.springs_are_linear) return stiffness * along;
  double turning = spring_elongation(rest_edge, change, model.springs.rest_length_m[s]) / size;
  if (kind == TangentKind::kProjected) turning = std::max(turning, 0.0);
  return stiffness * (along + turning * (kIdentity - along));
}

/// D_b: (dP/dF) contracted with g_b, entry [j][3 i + k].
using Contracted = std::array<std::array<double, 9>, 3>;

Contracted contract_with(const Tangent9& c, const Vec3& g) {
  Contracted out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double* row = &c[9 * (3 * i + j) + 3 * k];
        out[j][3 * i + k] = row[0] * g.x + row[1] * g.y + row[2] * g.z;
      }
    }
  }
  return out;
}

/// Adds the blocks of one domain, on the diagonal and above it: for each pair a <= b of its vertices (they
/// rise), V g_a . D_b.
void add_domain(const StrainOperator& op, std::size_t s, const Tangent9& c, BlockMatrix& matrix,
                std::vector<Contracted>& scratch) {
  const std::span<const Index> vertices = op.vertices_of(s);
  const std::span<const Vec3> gradients = op.gradients_of(s);
  scratch.resize(vertices.size());
  for (std::size_t b = 0; b < vertices.size(); ++b)
    scratch[b] = contract_with(c, op.volume_m3[s] * gradients[b]);
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    const Vec3& g = gradients[a];
    std::size_t place = matrix.offsets[vertices[a]];
    for (std::size_t b = a; b < vertices.size(); ++b) {
      while (matrix.columns[place] != vertices[b]) ++place;
      const Contracted& d = scratch[b];
      std::array<double, 9>& block = matrix.blocks[place].m;
      for (std::size_t ik = 0; ik < 9; ++ik)  // nine at once: no entry waits for another
        block[ik] += g.x * d[0][ik] + g.y * d[1][ik] + g.z * d[2][ik];
    }
  }
}

}  // namespace

BlockMatrix build_tangent_pattern(const ElasticModel& model, std::span<const Triangle> faces) {
  const std::vector<Index> spring_offsets = even_offsets(model.springs.springs.size(), 2);
  std::vector<Index> spring_ends;
  spring_ends.reserve(2 * model.springs.springs.size());
  for (const Edge& spring : model.springs.springs)
    spring_ends.insert(spring_ends.end(), spring.begin(), spring.end());
  const std::vector<Index> face_offsets = even_offsets(faces.size(), 3);
  std::vector<Index> face_corners;
  for (const Triangle& face : faces) face_corners.insert(face_corners.end(), face.begin(), face.end());
  std::vector<VertexGroups> groups{{spring_offsets, spring_ends}, {face_offsets, face_corners}};
  for (const StrainTerm& term : model.strain_terms) groups.push_back({term.op.offsets, term.op.vertices});
  return build_block_matrix(model.rest.size(), groups);
}

void add_tangent(const ElasticModel& model, std::span<const Vec3> displacement, TangentKind kind,
                 BlockMatrix& matrix,
                 const std::function<Tangent9(const StrainTerm& term, const Mat3& h)>& more) {
  require(matrix.rows() == model.rest.size() && displacement.size() == model.rest.size(), "one row a vertex");
  for (std::size_t s = 0; s < model.springs.springs.size(); ++s) {
    const Mat3 block = spring_block(model, displacement, s, kind);
    const auto [a, b] = model.springs.springs[s];
    add_block(matrix, a, a, block);
    add_block(matrix, b, b, block);
    add_block(matrix, a, b, (-1.0) * block);
    add_block(matrix, b, a, (-1.0) * block);
  }
  for (const StrainTerm& term : model.strain_terms) {
    if (term.law == StrainLaw::kLinear) {
      const Tangent9 exact = tangent(term.law, term.moduli, {});
      const Tangent9 c = kind == TangentKind::kExact ? exact : project_to_semidefinite(exact);
      add_domain_tangents(
          term.op, [&c](std::size_t) { return c; }, matrix);
      continue;
    }
    const auto at = [&](std::size_t s) {
      const Mat3 h = displacement_gradient(term.op, s, displacement);
      Tangent9 c = tangent(term.law, term.moduli, h);
      if (kind == TangentKind::kProjected) c = project_to_semidefinite(c);
      if (!more) return c;
      const Tangent9 extra = more(term, h);
      for (std::size_t k = 0; k < c.size(); ++k) c[k] += extra[k];
      return c;
    };
    add_domain_tangents(term.op, at, matrix);
  }
}

void add_domain_tangents(const StrainOperator& op, const std::function<Tangent9(std::size_t)>& tangent_of,
                         BlockMatrix& matrix) {
  std::vector<Contracted> scratch;
  for (std::size_t s = 0; s < op.domains(); ++s) add_domain(op, s, tangent_of(s), matrix, scratch);
  mirror_upper_half(matrix);
}

}  // namespace palpate::dynamics
