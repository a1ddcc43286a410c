#include "reference/lattices/embedded_loads.h"

#include <array>
#include <map>
#include <utility>

#include "core/base/component.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/triangle_rule.h"
#include "core/springs/lattice/cell_faces.h"
#include "core/springs/lattice/embedding.h"

namespace palpate::reference {
namespace {

/// Product by components.
Vec3 scale_axes(const Vec3& a, const Vec3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// A point of a face, with its share of the area, the face's area vector and the point's place between the
/// corners.
struct FacePlace {
  Vec3 at;
  double area_m2 = 0.0;
  Vec3 normal;  ///< outward, of length 1
  std::array<double, 3> corners{};
};

/// The places at which integrals over a face are summed up.
std::vector<FacePlace> places_on(const LatticeBody& body, const TetMesh& mesh, const Triangle& face) {
  const springs::LatticeFrame& frame = body.lattice.frame;
  std::array<Vec3, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) corners[i] = frame.to_cells(mesh.points[face[i]]);
  const auto doubled_area = [](const Vec3& a, const Vec3& b, const Vec3& c) { return cross(b - a, c - a); };
  const Vec3 whole = doubled_area(corners[0], corners[1], corners[2]);
  const Vec3 area =
      0.5 * cross(mesh.points[face[1]] - mesh.points[face[0]], mesh.points[face[2]] - mesh.points[face[0]]);
  std::vector<FacePlace> places;
  for (const std::array<Vec3, 3>& part : springs::split_at_cells(corners)) {
    const double share = dot(doubled_area(part[0], part[1], part[2]), whole) / length_sq(whole);
    for (const FacePoint& point : build_radon_rule()) {
      const Vec3 p = point.at[0] * part[0] + point.at[1] * part[1] + point.at[2] * part[2];
      FacePlace place{frame.to_body(p), share * point.weight * length(area), (1.0 / length(area)) * area, {}};
      for (std::size_t i = 0; i < 3; ++i)
        place.corners[i] =
            dot(doubled_area(p, corners[(i + 1) % 3], corners[(i + 2) % 3]), whole) / length_sq(whole);
      places.push_back(place);
    }
  }
  return places;
}

/// Points that are pulled to a place by springs along the axes, before they are put together.
struct PulledPoints {
  std::vector<Vec3> at;
  std::vector<Vec3> stiffness_n_per_m;
  std::vector<Vec3> by_m;

  void add(const Vec3& place, const Vec3& stiffness, const Vec3& by) {
    at.push_back(place);
    stiffness_n_per_m.push_back(stiffness);
    by_m.push_back(by);
  }
};

PulledPoints find_pulled_points(const LatticeBody& body, const TetMesh& mesh,
                                const BoundaryProblem& problem) {
  PulledPoints points;
  for (const ElasticSupport& support : problem.supports) {
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      for (const FacePlace& place : places_on(body, mesh, support.patch.faces[f])) {
        const double k = support.stiffness_pa_per_m * support.patch.weight[f] * place.area_m2;
        points.add(place.at, {k, k, k}, support.by_m);
      }
    }
  }
  for (const HeldFaces& held : problem.held) {
    const Vec3 axes{held.axes[0] ? 1.0 : 0.0, held.axes[1] ? 1.0 : 0.0, held.axes[2] ? 1.0 : 0.0};
    for (const Triangle& face : held.faces) {
      for (const FacePlace& place : places_on(body, mesh, face)) {
        Vec3 by = held.by_m;
        for (std::size_t i = 0; i < 3 && !problem.held_field_m.empty(); ++i)
          by = by + place.corners[i] * problem.held_field_m[face[i]];
        points.add(place.at, (body.held_pa_per_m * place.area_m2) * axes, by);
      }
    }
  }
  return points;
}

void add_supports(const LatticeBody& body, const PulledPoints& points, EmbeddedLoads& loads) {
  const springs::Embedding at = build_embedding(body.lattice, points.at);
  std::map<std::pair<Index, Index>, Vec3> entries;
  for (std::size_t p = 0; p < at.points(); ++p) {
    const Vec3& k = points.stiffness_n_per_m[p];
    const Vec3 pull = scale_axes(k, points.by_m[p]);
    loads.rest_energy_j += 0.5 * dot(pull, points.by_m[p]);
    for (Index a = at.offsets[p]; a < at.offsets[p + 1]; ++a) {
      Vec3& sum = loads.pull_n[at.nodes[a]];
      sum = sum + at.weights[a] * pull;
      for (Index b = at.offsets[p]; b < at.offsets[p + 1]; ++b) {
        Vec3& entry = entries[{at.nodes[a], at.nodes[b]}];
        entry = entry + (at.weights[a] * at.weights[b]) * k;
      }
    }
  }
  for (const auto& [nodes, stiffness] : entries) {
    if (loads.rows.empty() || loads.rows.back() != nodes.first) {
      loads.rows.push_back(nodes.first);
      loads.offsets.push_back(loads.offsets.back());
    }
    ++loads.offsets.back();
    loads.columns.push_back(nodes.second);
    loads.stiffness_n_per_m.push_back(stiffness);
  }
}

void add_tractions(const LatticeBody& body, const TetMesh& mesh, const BoundaryProblem& problem,
                   EmbeddedLoads& loads) {
  std::vector<Vec3> at;
  std::vector<Vec3> forces;
  for (const Traction& traction : problem.tractions) {
    for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
      for (const FacePlace& place : places_on(body, mesh, traction.patch.faces[f])) {
        at.push_back(place.at);
        forces.push_back((traction.patch.weight[f] * place.area_m2) *
                         (traction.traction_pa - traction.pressure_pa * place.normal));
      }
    }
  }
  carry_back(build_embedding(body.lattice, at), forces, loads.dead_n);
}

/// S u in row r.
Vec3 row_product(const EmbeddedLoads& loads, std::size_t r, std::span<const Vec3> u) {
  Vec3 sum;
  for (Index k = loads.offsets[r]; k < loads.offsets[r + 1]; ++k)
    sum = sum + scale_axes(loads.stiffness_n_per_m[k], u[loads.columns[k]]);
  return sum;
}

}  // namespace

EmbeddedLoads embed_loads(const LatticeBody& body, const TetMesh& mesh, const BoundaryProblem& problem) {
  static_cast<void>(dynamics::build_loads(mesh, problem));  // refuses what is wrong
  BoundaryProblem inside = problem;                         // what does not act on faces
  inside.held.clear();
  inside.supports.clear();
  inside.tractions.clear();
  inside.held_field_m.clear();
  EmbeddedLoads loads;
  loads.dead_n.resize(body.lattice.nodes.size());
  loads.pull_n.resize(body.lattice.nodes.size());
  carry_back(body.vertices, dynamics::build_loads(mesh, inside).force_n, loads.dead_n);
  add_tractions(body, mesh, problem, loads);
  add_supports(body, find_pulled_points(body, mesh, problem), loads);
  return loads;
}

void add_load_forces(const EmbeddedLoads& loads, std::span<const Vec3> u, double share,
                     std::span<Vec3> force) {
  dynamics::add_scaled(force, share, loads.dead_n);
  dynamics::add_scaled(force, share, loads.pull_n);
  for (std::size_t r = 0; r < loads.rows.size(); ++r) {
    Vec3& sum = force[loads.rows[r]];
    sum = sum - row_product(loads, r, u);
  }
}

double load_energy(const EmbeddedLoads& loads, std::span<const Vec3> u, double share) {
  double energy = share * share * loads.rest_energy_j -
                  share * (dynamics::dot_of(loads.dead_n, u) + dynamics::dot_of(loads.pull_n, u));
  for (std::size_t r = 0; r < loads.rows.size(); ++r)
    energy += 0.5 * dot(u[loads.rows[r]], row_product(loads, r, u));
  return energy;
}

void add_load_stiffness(const EmbeddedLoads& loads, dynamics::BlockMatrix& matrix) {
  for (std::size_t r = 0; r < loads.rows.size(); ++r) {
    for (Index k = loads.offsets[r]; k < loads.offsets[r + 1]; ++k) {
      dynamics::Mat3 block;
      for (std::size_t i = 0; i < 3; ++i) block(i, i) = component(loads.stiffness_n_per_m[k], i);
      dynamics::add_block(matrix, loads.rows[r], loads.columns[k], block);
    }
  }
}

Vec3 total_force(const EmbeddedLoads& loads, std::span<const Vec3> u, double share) {
  std::vector<Vec3> forces(u.size());
  add_load_forces(loads, u, share, forces);
  Vec3 sum;
  for (const Vec3& f : forces) sum = sum + f;
  return sum;
}

}  // namespace palpate::reference
