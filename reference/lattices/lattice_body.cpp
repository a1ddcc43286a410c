#include "reference/lattices/lattice_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

using dynamics::StrainOperator;
using nlohmann::json;
using springs::Lattice;
using springs::LatticeKind;

constexpr double kSpringRatio = 0.25;

/// Puts a domain's vertices in increasing order, each with its gradient.
void add_domain_of(std::vector<std::pair<Index, Vec3>> entries, double volume_m3, StrainOperator& op) {
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (op.offsets.empty()) op.offsets.push_back(0);
  for (const auto& [vertex, gradient] : entries) {
    op.vertices.push_back(vertex);
    op.gradients.push_back(gradient);
  }
  op.offsets.push_back(static_cast<Index>(op.vertices.size()));
  op.volume_m3.push_back(volume_m3);
}

/// 1/2 lambda V (tr H)^2 of each domain.
dynamics::StrainTerm dilatation_term(StrainOperator op, double lambda_pa) {
  return {std::move(op), {lambda_pa, 0.0}, dynamics::StrainLaw::kLinear};
}

/// 1/2 k (d . (u_c - mean u))^2 as lambda V / 2 (tr H)^2: H = (u_c - mean u) (x) 2 d / h, V = k h^2 / (4
/// lambda).
StrainOperator half_axis_operator(const std::vector<springs::HalfAxis>& half_axes, double spacing_m,
                                  double lambda_pa) {
  StrainOperator op;
  for (const springs::HalfAxis& axis : half_axes) {
    const Vec3 along = (2.0 / spacing_m) * axis.direction;
    std::vector<std::pair<Index, Vec3>> entries{{axis.centre, along}};
    for (const Index corner : axis.corners) entries.emplace_back(corner, -0.25 * along);
    add_domain_of(std::move(entries), axis.stiffness_n_per_m * spacing_m * spacing_m / (4.0 * lambda_pa), op);
  }
  return op;
}

StrainOperator cell_operator(const Lattice& lattice) {
  const std::array<Vec3, 8> gradients = mean_cell_gradients(lattice);
  StrainOperator op;
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    std::vector<std::pair<Index, Vec3>> entries;
    for (std::size_t c = 0; c < 8; ++c) entries.emplace_back(lattice.corners[cell][c], gradients[c]);
    add_domain_of(std::move(entries), lattice.share[cell] * lattice.cell_volume_m3(), op);
  }
  return op;
}

}  // namespace

LatticeRequest take_lattice_request(const std::string& prefix, const std::string& method, json& left) {
  if (!method.starts_with(prefix))
    throw InputError("method", 0, prefix + "hexahedral or " + prefix + "bcc", method);
  LatticeRequest request;
  springs::LatticeOptions& lattice = request.lattice;
  lattice.kind = springs::kLatticeKindNames.parse(method.substr(prefix.size()));
  lattice.boundary = springs::kLatticeBoundaryNames.parse(
      take_option<std::string>(left, "boundary", &json::is_string, "keep, remove or weight",
                               springs::kLatticeBoundaryNames.of(lattice.boundary)));
  if (left.contains("fraction")) lattice.fraction = take_number(left, "fraction", 0.0, 1.0, 0.0);
  lattice.spacing_m = take_number(left, "spacing_m", 0.0, 1e6, 0.0);
  lattice.vertices = static_cast<std::size_t>(take_whole(left, "nodes", 0, 100'000'000, 0));
  lattice.turn_deg = take_number(left, "turn_deg", -180.0, 180.0, 0.0);
  if (left.contains("volume")) request.has_volume_energy = take_choice(left, "volume", {"none", "cell"}) == 1;
  request.held_stiffness = take_number(left, "held_stiffness", 1.0, 1e8, request.held_stiffness);
  if (lattice.kind == LatticeKind::kHexahedral) {
    request.mix.body_share = take_number(left, "body_share", 0.0, 0.9, request.mix.body_share);
  } else {
    request.mix.face_share = take_number(left, "face_share", 0.0, 0.9, request.mix.face_share);
  }
  return request;
}

LatticeBody build_lattice_body(const TetMesh& mesh, const BoundaryProblem& problem,
                               const LatticeRequest& request) {
  if (problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: springs of a lattice are linear here", "large");
  const Material& material = problem.material;
  if (request.has_volume_energy && material.poisson_ratio < kSpringRatio)
    throw InputError("volume", 0, "none for a Poisson's ratio below 0.25: lambda - mu is negative", "cell");
  LatticeBody body;
  body.lattice = build_lattice(mesh, request.lattice);
  const Lattice& lattice = body.lattice;
  const Material of_springs = spring_material(
      material, request.has_volume_energy ? dynamics::VolumeModel::kTet : dynamics::VolumeModel::kNone);
  springs::LatticeSprings made = build_lattice_springs(lattice, of_springs.young_modulus_pa, request.mix);
  body.half_axes = made.half_axes.size();
  body.elastic.rest = lattice.nodes;
  body.elastic.springs = std::move(made.network);
  body.elastic.springs_are_linear = true;
  const double unit_pa = of_springs.young_modulus_pa;
  if (!made.half_axes.empty())
    body.elastic.strain_terms.push_back(
        dilatation_term(half_axis_operator(made.half_axes, lattice.frame.spacing_m, unit_pa), unit_pa));
  if (request.has_volume_energy && material.poisson_ratio > kSpringRatio)
    body.elastic.strain_terms.push_back(
        dilatation_term(cell_operator(lattice), material.lambda_pa() - material.mu_pa()));
  body.vertices = build_embedding(lattice, mesh.points);
  body.held_pa_per_m = request.held_stiffness * material.young_modulus_pa / lattice.frame.spacing_m;
  return body;
}

dynamics::BlockMatrix build_lattice_pattern(const LatticeBody& body) {
  const Lattice& lattice = body.lattice;
  std::vector<Index> cell_offsets{0};
  std::vector<Index> cell_nodes;
  for (std::size_t cell = 0; cell < lattice.cells(); ++cell) {
    cell_nodes.insert(cell_nodes.end(), lattice.corners[cell].begin(), lattice.corners[cell].end());
    if (!lattice.centres.empty()) cell_nodes.push_back(lattice.centres[cell]);
    cell_offsets.push_back(static_cast<Index>(cell_nodes.size()));
  }
  std::vector<Index> spring_offsets{0};
  std::vector<Index> spring_ends;
  for (const Edge& spring : body.elastic.springs.springs) {
    spring_ends.insert(spring_ends.end(), spring.begin(), spring.end());
    spring_offsets.push_back(static_cast<Index>(spring_ends.size()));
  }
  const std::array<dynamics::VertexGroups, 2> groups{dynamics::VertexGroups{cell_offsets, cell_nodes},
                                                     dynamics::VertexGroups{spring_offsets, spring_ends}};
  return dynamics::build_block_matrix(lattice.nodes.size(), groups);
}

void report_lattice(const LatticeBody& body, json& report) {
  const Lattice& lattice = body.lattice;
  report["nodes"] = lattice.nodes.size();
  report["springs"] = body.elastic.springs.springs.size();
  report["half_axes"] = body.half_axes;
  report["cells"] = lattice.cells();
  report["cut_cells"] = lattice.cut_cells();
  report["loose_cells"] = lattice.loose_cells;
  report["spacing_m"] = lattice.frame.spacing_m;
  report["volume_ratio"] = lattice.volume_ratio();
  report["outside_vertices"] = body.vertices.outside;
  report["outside_farthest_spacings"] = body.vertices.farthest_cells;
}

std::string material_note(const Material& material, const LatticeRequest& request) {
  if (request.has_volume_energy || material.poisson_ratio == kSpringRatio) return {};
  return "springs alone have Poisson's ratio 1/4, whatever the material's is: volume: cell adds what is "
         "missing";
}

}  // namespace palpate::reference
