#include "core/dynamics/loads.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/jacobi_eigen.h"
#include "core/mesh/geometry.h"
#include "core/mesh/refinement.h"

namespace palpate::dynamics {
namespace {

constexpr std::array<Vec3, 3> kAxes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

/// Area vector of a face: half the cross product, outward for a boundary face.
Vec3 area_vector(const TetMesh& mesh, const Triangle& face) {
  const Vec3& a = mesh.points[face[0]];
  return 0.5 * cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a);
}

void check_face(const TetMesh& mesh, const Triangle& face, const char* where) {
  for (const Index v : face) {
    if (v >= mesh.points.size())
      throw InputError(where, 0, "vertices below " + std::to_string(mesh.points.size()), std::to_string(v));
  }
}

void check_patch(const TetMesh& mesh, const FacePatch& patch, const char* where) {
  if (patch.weight.size() != patch.faces.size())
    throw InputError(where, 0, "one weight a face", std::to_string(patch.weight.size()) + " weights");
  for (const Triangle& face : patch.faces) check_face(mesh, face, where);
  for (const double weight : patch.weight) {
    if (!(weight > 0.0 && weight <= 1.0))
      throw InputError(where, 0, "weights in (0, 1]", std::to_string(weight));
  }
}

void hold(const TetMesh& mesh, const HeldFaces& held, const std::vector<Vec3>& field, Loads& loads) {
  for (const Triangle& face : held.faces) {
    check_face(mesh, face, "held");
    for (const Index v : face) {
      const Vec3 told = field.empty() ? held.by_m : held.by_m + field[v];
      const std::array<double, 3> by{told.x, told.y, told.z};
      const std::array<double*, 3> place{&loads.held_by_m[v].x, &loads.held_by_m[v].y, &loads.held_by_m[v].z};
      for (std::size_t i = 0; i < 3; ++i) {
        if (!held.axes[i]) continue;
        const auto bit = static_cast<std::uint8_t>(1U << i);
        if ((loads.held[v] & bit) != 0 && *place[i] != by[i])
          throw InputError("held", 0, "one displacement for vertex " + std::to_string(v),
                           std::to_string(*place[i]) + " m and " + std::to_string(by[i]) + " m");
        loads.held[v] |= bit;
        *place[i] = by[i];
      }
    }
  }
}

void add_tractions(const TetMesh& mesh, const Traction& traction, std::vector<Vec3>& force) {
  check_patch(mesh, traction.patch, "tractions");
  for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
    const Triangle& face = traction.patch.faces[f];
    const Vec3 area = area_vector(mesh, face);
    const double share = traction.patch.weight[f] / 3.0;
    const Vec3 part = share * (length(area) * traction.traction_pa - traction.pressure_pa * area);
    for (const Index v : face) force[v] = force[v] + part;
  }
}

void add_gravity(const TetMesh& mesh, const BoundaryProblem& problem, std::vector<Vec3>& force) {
  const Vec3 weight = problem.material.density_kg_m3 * problem.gravity_m_s2;
  if (length_sq(weight) == 0.0) return;
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) force[v] = force[v] + (0.25 * volume) * weight;
  }
}

void check_field(const std::vector<Vec3>& field, std::size_t nodes, const char* where) {
  if (!field.empty() && field.size() != nodes)
    throw InputError(where, 0, "a value a vertex and an edge midpoint (" + std::to_string(nodes) + ")",
                     std::to_string(field.size()));
}

/// Adds the integral of a quadratic body force times each linear shape function: in a tet of volume V, b_i
/// times the quadratic function of vertex j is 0 for i = j and -V / 60 else, of an edge V / 15 if i is one of
/// its ends and V / 30 else.
void add_body_force_field(const TetMesh& mesh, const EdgeNumbers& edges, const std::vector<Vec3>& field,
                          std::vector<Vec3>& force) {
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    const auto add = [&](std::size_t i, double share, const Vec3& value) {
      force[t[i]] = force[t[i]] + (share * volume) * value;
    };
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        if (i != j) add(i, -1.0 / 60.0, field[t[j]]);
      }
      for (const auto& [a, b] : kTetEdges) {
        const bool is_end = i == static_cast<std::size_t>(a) || i == static_cast<std::size_t>(b);
        const Index edge = edges.of(t[static_cast<std::size_t>(a)], t[static_cast<std::size_t>(b)]);
        add(i, is_end ? 1.0 / 15.0 : 1.0 / 30.0, field[mesh.points.size() + edge]);
      }
    }
  }
}

/// What varies in space.
void add_fields(const TetMesh& mesh, const BoundaryProblem& problem, std::vector<Vec3>& force) {
  if (problem.body_force_n_m3.empty() && problem.held_field_m.empty()) return;
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const std::size_t nodes = mesh.points.size() + edges.edges.size();
  check_field(problem.body_force_n_m3, nodes, "body_force_n_m3");
  check_field(problem.held_field_m, nodes, "held_field_m");
  if (!problem.body_force_n_m3.empty()) add_body_force_field(mesh, edges, problem.body_force_n_m3, force);
}

/// The six rigid motions of a connected part: translations, and rotations about its center over its radius.
struct RigidFrame {
  Vec3 center;
  double radius = 1.0;

  std::array<Vec3, 6> motions_at(const Vec3& point) const {
    const Vec3 arm = (1.0 / radius) * (point - center);
    return {kAxes[0], kAxes[1], kAxes[2], cross(kAxes[0], arm), cross(kAxes[1], arm), cross(kAxes[2], arm)};
  }
};

/// How strongly the six motions are resisted: by what is held and by what is supported, each to its own
/// scale.
struct Resistance {
  std::array<double, 36> held{};
  std::array<double, 36> supported{};
};

void add_product(std::array<double, 36>& sum, const std::array<Vec3, 6>& a, const std::array<Vec3, 6>& b,
                 double scale) {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) sum[6 * i + j] += scale * dot(a[i], b[j]);
  }
}

double trace_of(const std::array<double, 36>& a) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 6; ++i) sum += a[7 * i];
  return sum;
}

std::string vector_text(const Vec3& v) {
  std::array<char, 96> text{};
  // Adding zero turns the -0 that rounding leaves into 0.
  const auto round = [](double x) { return std::round(1000.0 * x) / 1000.0 + 0.0; };
  std::snprintf(text.data(), text.size(), "(%.3f, %.3f, %.3f)", round(v.x), round(v.y), round(v.z));
  return text.data();
}

/// The motion of the least resistance in words; empty if all are resisted.
std::string free_motion(const Resistance& resistance, const RigidFrame& frame) {
  std::array<double, 36> sum{};
  for (const auto* part : {&resistance.held, &resistance.supported}) {
    const double scale = trace_of(*part);
    if (!(scale > 0.0)) continue;
    for (std::size_t k = 0; k < 36; ++k) sum[k] += (*part)[k] / scale;
  }
  const SymmetricEigen<6> eigen = decompose_symmetric<6>(sum);
  const auto least = static_cast<std::size_t>(std::min_element(eigen.values.begin(), eigen.values.end()) -
                                              eigen.values.begin());
  constexpr double kFree = 1e-10;  // of the trace, which is 1 or 2: an angle of 1e-5 of the part's size
  if (eigen.values[least] > kFree) return {};
  const Vec3 shift{eigen.vectors[least], eigen.vectors[6 + least], eigen.vectors[12 + least]};
  const Vec3 turn{eigen.vectors[18 + least], eigen.vectors[24 + least], eigen.vectors[30 + least]};
  if (length(turn) < 1e-6) return "a translation along " + vector_text((1.0 / length(shift)) * shift);
  const Vec3 point = frame.center + (frame.radius / length_sq(turn)) * cross(turn, shift);
  return "a rotation about the axis " + vector_text((1.0 / length(turn)) * turn) + " through " +
         vector_text(point) + " m";
}

/// The connected part of each vertex, named by its smallest vertex.
std::vector<Index> find_parts(const TetMesh& mesh) {
  std::vector<Index> parent(mesh.points.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Tet& tet : mesh.tets) {
    for (std::size_t k = 1; k < 4; ++k) {
      const Index a = root(tet[0]);
      const Index b = root(tet[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (Index v = 0; v < parent.size(); ++v) parent[v] = root(v);
  return parent;
}

}  // namespace

Loads build_loads(const TetMesh& mesh, const BoundaryProblem& problem) {
  const std::size_t n = mesh.points.size();
  Loads loads{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  add_gravity(mesh, problem, loads.force_n);
  add_fields(mesh, problem, loads.force_n);
  for (const Traction& traction : problem.tractions) add_tractions(mesh, traction, loads.force_n);
  for (const NodalForce& nodal : problem.nodal_forces) {
    if (nodal.vertex >= n)
      throw InputError("nodal_forces", 0, "vertices below " + std::to_string(n),
                       std::to_string(nodal.vertex));
    loads.force_n[nodal.vertex] = loads.force_n[nodal.vertex] + nodal.force_n;
  }
  for (const HeldFaces& held : problem.held) hold(mesh, held, problem.held_field_m, loads);
  for (const ElasticSupport& support : problem.supports) {
    check_patch(mesh, support.patch, "supports");
    if (!(support.stiffness_pa_per_m >= 0.0))
      throw InputError("supports", 0, "a stiffness >= 0", std::to_string(support.stiffness_pa_per_m));
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      const double area = length(area_vector(mesh, support.patch.faces[f]));
      loads.supports.push_back({support.patch.faces[f],
                                support.stiffness_pa_per_m * support.patch.weight[f] * area / 12.0,
                                support.by_m});
    }
  }
  return loads;
}

void require_no_rigid_motion(const TetMesh& mesh, const Loads& loads) {
  const std::vector<Index> part = find_parts(mesh);
  std::vector<Vec3> center(mesh.points.size());
  std::vector<double> radius_sq(mesh.points.size());
  std::vector<double> count(mesh.points.size());
  for (std::size_t v = 0; v < part.size(); ++v) {
    center[part[v]] = center[part[v]] + mesh.points[v];
    count[part[v]] += 1.0;
  }
  for (std::size_t v = 0; v < part.size(); ++v) {
    const Vec3 arm = mesh.points[v] - (1.0 / count[part[v]]) * center[part[v]];
    radius_sq[part[v]] = std::max(radius_sq[part[v]], length_sq(arm));
  }
  std::vector<RigidFrame> frames(part.size());
  std::vector<Resistance> resistance(part.size());
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (part[v] == v) frames[v] = {(1.0 / count[v]) * center[v], std::sqrt(radius_sq[v])};
  }
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (loads.held[v] == 0) continue;
    const std::array<Vec3, 6> motions = frames[part[v]].motions_at(mesh.points[v]);
    for (std::size_t i = 0; i < 3; ++i) {
      if ((loads.held[v] & (1U << i)) == 0) continue;
      std::array<Vec3, 6> along{};
      for (std::size_t k = 0; k < 6; ++k) along[k] = dot(motions[k], kAxes[i]) * kAxes[i];
      add_product(resistance[part[v]].held, along, along, 1.0);
    }
  }
  for (const SupportFace& support : loads.supports) {
    const Index p = part[support.face[0]];
    for (const Index a : support.face) {
      for (const Index b : support.face)
        add_product(resistance[p].supported, frames[p].motions_at(mesh.points[a]),
                    frames[p].motions_at(mesh.points[b]), support.coefficient_n_per_m * (a == b ? 2.0 : 1.0));
    }
  }
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (part[v] != v || count[v] < 2.0) continue;
    const std::string motion = free_motion(resistance[v], frames[v]);
    if (!motion.empty())
      throw InputError("clamps and supports", 0,
                       "the part of the mesh with vertex " + std::to_string(v) + " to be held",
                       motion + " left free");
  }
}

double load_energy(const Loads& loads, std::span<const Vec3> displacement, double scale) {
  double energy = 0.0;
  for (std::size_t v = 0; v < displacement.size(); ++v)
    energy -= scale * dot(loads.force_n[v], displacement[v]);
  for (const SupportFace& support : loads.supports) {
    Vec3 sum;
    double squares = 0.0;
    for (const Index v : support.face) {
      const Vec3 off = displacement[v] - scale * support.by_m;
      sum = sum + off;
      squares += length_sq(off);
    }
    energy += 0.5 * support.coefficient_n_per_m * (squares + length_sq(sum));
  }
  return energy;
}

void add_load_forces(const Loads& loads, std::span<const Vec3> displacement, double scale,
                     std::span<Vec3> force) {
  for (std::size_t v = 0; v < displacement.size(); ++v) force[v] = force[v] + scale * loads.force_n[v];
  for (const SupportFace& support : loads.supports) {
    std::array<Vec3, 3> off;
    Vec3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      off[k] = displacement[support.face[k]] - scale * support.by_m;
      sum = sum + off[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3& f = force[support.face[k]];
      f = f - support.coefficient_n_per_m * (off[k] + sum);
    }
  }
}

void add_support_tangent(const Loads& loads, BlockMatrix& matrix) {
  for (const SupportFace& support : loads.supports) {
    for (const Index a : support.face) {
      for (const Index b : support.face)
        add_block(matrix, a, b, (support.coefficient_n_per_m * (a == b ? 2.0 : 1.0)) * kIdentity);
    }
  }
}

}  // namespace palpate::dynamics
