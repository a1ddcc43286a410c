#include "core/dynamics/elasticity/strain_operator.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/enum_names.h"
#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<StrainDomain, 4> kDomainNames{"domain", {"tet", "face", "edge", "node"}};

/// The domains that each tet gives a share of its volume to: `per_tet` of them a tet.
struct Membership {
  std::size_t domains = 0;
  std::size_t per_tet = 1;
  std::vector<Index> of_tet;
};

Membership join_faces(const TetMesh& mesh) {
  const std::vector<Face> faces = build_faces(mesh);
  Membership out{faces.size(), 4, std::vector<Index>(4 * mesh.tets.size())};
  std::vector<std::uint8_t> filled(mesh.tets.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (const Index t : faces[f].tets) {
      if (t != kNoIndex) out.of_tet[4 * std::size_t{t} + filled[t]++] = static_cast<Index>(f);
    }
  }
  return out;
}

Membership join_edges(const TetMesh& mesh) {
  const std::vector<Edge> edges = build_edges(mesh);
  Membership out{edges.size(), 6, {}};
  out.of_tet.reserve(6 * mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) {
      const Index a = tet[static_cast<std::size_t>(i)];
      const Index b = tet[static_cast<std::size_t>(j)];
      const Edge edge{std::min(a, b), std::max(a, b)};
      const auto place = std::lower_bound(edges.begin(), edges.end(), edge);
      out.of_tet.push_back(static_cast<Index>(place - edges.begin()));
    }
  }
  return out;
}

Membership join(const TetMesh& mesh, StrainDomain domain) {
  if (domain == StrainDomain::kFace) return join_faces(mesh);
  if (domain == StrainDomain::kEdge) return join_edges(mesh);
  const bool is_node = domain == StrainDomain::kNode;
  Membership out{
      is_node ? mesh.points.size() : mesh.tets.size(), is_node ? std::size_t{4} : std::size_t{1}, {}};
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (!is_node) out.of_tet.push_back(static_cast<Index>(t));
    if (is_node) out.of_tet.insert(out.of_tet.end(), mesh.tets[t].begin(), mesh.tets[t].end());
  }
  return out;
}

/// Volume of a tet, and its volume times the gradients of its shape functions: a third of the inward area
/// vector of the opposite face.
struct TetGradients {
  double volume = 0.0;
  std::array<Vec3, 4> scaled;
};

TetGradients measure(const TetMesh& mesh, std::size_t t) {
  const Tet& tet = mesh.tets[t];
  const auto point = [&](int local) { return mesh.points[tet[static_cast<std::size_t>(local)]]; };
  TetGradients out{signed_volume(point(0), point(1), point(2), point(3)), {}};
  if (!(out.volume > 0.0))
    throw InputError("tet " + std::to_string(t), 0, "a positive volume", std::to_string(out.volume));
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& face = kTetFaces[k];
    out.scaled[k] = (-1.0 / 6.0) * cross(point(face[1]) - point(face[0]), point(face[2]) - point(face[0]));
  }
  return out;
}

/// Tets of each domain, in increasing order.
std::vector<Index> group(const Membership& members, std::vector<Index>& offsets) {
  offsets.assign(members.domains + 1, 0);
  for (const Index s : members.of_tet) ++offsets[s + 1];
  for (std::size_t s = 0; s < members.domains; ++s) offsets[s + 1] += offsets[s];
  std::vector<Index> next(offsets.begin(), offsets.end() - 1);
  std::vector<Index> tets(members.of_tet.size());
  for (std::size_t k = 0; k < members.of_tet.size(); ++k)
    tets[next[members.of_tet[k]]++] = static_cast<Index>(k / members.per_tet);
  return tets;
}

}  // namespace

StrainDomain parse_strain_domain(std::string_view name) {
  return kDomainNames.parse(name);
}

const char* strain_domain_name(StrainDomain domain) {
  return kDomainNames.of(domain);
}

StrainOperator build_strain_operator(const TetMesh& mesh, StrainDomain domain) {
  const Membership members = join(mesh, domain);
  std::vector<TetGradients> gradients(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) gradients[t] = measure(mesh, t);
  std::vector<Index> tet_offsets;
  const std::vector<Index> tets = group(members, tet_offsets);
  const double share = 1.0 / static_cast<double>(members.per_tet);

  StrainOperator op;
  op.volume_m3.resize(members.domains);
  op.offsets.assign(1, 0);
  std::vector<Index> around;
  std::vector<Vec3> sum(mesh.points.size());
  for (std::size_t s = 0; s < members.domains; ++s) {
    around.clear();
    for (Index k = tet_offsets[s]; k < tet_offsets[s + 1]; ++k) {
      const Tet& tet = mesh.tets[tets[k]];
      const TetGradients& tet_gradients = gradients[tets[k]];
      op.volume_m3[s] += share * tet_gradients.volume;
      for (std::size_t local = 0; local < 4; ++local)
        sum[tet[local]] = sum[tet[local]] + share * tet_gradients.scaled[local];
      around.insert(around.end(), tet.begin(), tet.end());
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    for (const Index v : around) {
      op.vertices.push_back(v);
      op.gradients.push_back((1.0 / op.volume_m3[s]) * sum[v]);
      sum[v] = {};
    }
    op.offsets.push_back(static_cast<Index>(op.vertices.size()));
  }
  return op;
}

Mat3 displacement_gradient(const StrainOperator& op, std::size_t domain, std::span<const Vec3> displacement) {
  const std::span<const Index> vertices = op.vertices_of(domain);
  const std::span<const Vec3> gradients = op.gradients_of(domain);
  Mat3 h;
  for (std::size_t k = 0; k < vertices.size(); ++k) add_outer(h, displacement[vertices[k]], gradients[k]);
  return h;
}

}  // namespace palpate::dynamics
