#include "reference/lattices/embedded_loads.h"

#include <algorithm>
#include <cmath>

#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/triangle_rule.h"

namespace palpate::reference {
namespace {

using dynamics::component;
using dynamics::Mat3;

/// Points of faces, before they are looked up in the lattice.
class FacePoints {
 public:
  explicit FacePoints(const TetMesh& mesh) : mesh_(mesh), rule_(build_radon_rule()) {}

  /// Calls use(barycentric point, share of the area, area vector) at each point of a face, and keeps the
  /// place.
  template <typename Use>
  void visit(const Triangle& face, Use&& use) {
    const auto corner = [&](std::size_t i) -> const Vec3& { return mesh_.points[face[i]]; };
    const Vec3 area = 0.5 * cross(corner(1) - corner(0), corner(2) - corner(0));
    for (const FacePoint& point : rule_) {
      places_.push_back(point.at[0] * corner(0) + point.at[1] * corner(1) + point.at[2] * corner(2));
      use(point, area);
    }
  }

  const std::vector<Vec3>& places() const { return places_; }

 private:
  const TetMesh& mesh_;
  std::vector<FacePoint> rule_;
  std::vector<Vec3> places_;
};

void add_supports(const BoundaryProblem& problem, FacePoints& points, std::vector<PointSpring>& springs) {
  for (const ElasticSupport& support : problem.supports) {
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      points.visit(support.patch.faces[f], [&](const FacePoint& point, const Vec3& area) {
        const double k = support.stiffness_pa_per_m * support.patch.weight[f] * point.weight * length(area);
        springs.push_back({{k, k, k}, support.by_m, false});
      });
    }
  }
}

void add_held(const BoundaryProblem& problem, double held_pa_per_m, FacePoints& points,
              std::vector<PointSpring>& springs) {
  for (const HeldFaces& held : problem.held) {
    for (const Triangle& face : held.faces) {
      points.visit(face, [&](const FacePoint& point, const Vec3& area) {
        PointSpring spring{{}, held.by_m, true};
        for (std::size_t i = 0; i < 3; ++i) {
          if (held.axes[i]) spring.stiffness_n_per_m[i] = held_pa_per_m * point.weight * length(area);
        }
        if (!problem.held_field_m.empty()) {
          for (std::size_t i = 0; i < 3; ++i)
            spring.by_m = spring.by_m + point.at[i] * problem.held_field_m[face[i]];
        }
        springs.push_back(spring);
      });
    }
  }
}

std::vector<Vec3> traction_forces(const BoundaryProblem& problem, FacePoints& points) {
  std::vector<Vec3> forces;
  for (const Traction& traction : problem.tractions) {
    for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
      points.visit(traction.patch.faces[f], [&](const FacePoint& point, const Vec3& area) {
        forces.push_back((traction.patch.weight[f] * point.weight) *
                         (length(area) * traction.traction_pa - traction.pressure_pa * area));
      });
    }
  }
  return forces;
}

/// The force of a spring at its point.
Vec3 pull_of(const PointSpring& spring, const Vec3& u, double share) {
  Vec3 pull;
  for (std::size_t i = 0; i < 3; ++i)
    component(pull, i) = spring.stiffness_n_per_m[i] * (share * component(spring.by_m, i) - component(u, i));
  return pull;
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
  carry_back(body.vertices, dynamics::build_loads(mesh, inside).force_n, loads.dead_n);
  FacePoints loaded(mesh);
  const std::vector<Vec3> forces = traction_forces(problem, loaded);
  carry_back(build_embedding(body.lattice, loaded.places()), forces, loads.dead_n);
  FacePoints sprung(mesh);
  add_supports(problem, sprung, loads.springs);
  add_held(problem, body.held_pa_per_m, sprung, loads.springs);
  loads.at = build_embedding(body.lattice, sprung.places());
  return loads;
}

void add_load_forces(const EmbeddedLoads& loads, std::span<const Vec3> u, double share,
                     std::span<Vec3> force) {
  dynamics::add_scaled(force, share, loads.dead_n);
  std::vector<Vec3> pulls = interpolate(loads.at, u);
  for (std::size_t p = 0; p < pulls.size(); ++p) pulls[p] = pull_of(loads.springs[p], pulls[p], share);
  carry_back(loads.at, pulls, force);
}

double load_energy(const EmbeddedLoads& loads, std::span<const Vec3> u, double share) {
  double energy = -share * dynamics::dot_of(loads.dead_n, u);
  const std::vector<Vec3> there = interpolate(loads.at, u);
  for (std::size_t p = 0; p < there.size(); ++p) {
    const Vec3 off = share * loads.springs[p].by_m - there[p];
    energy += 0.5 * dot(pull_of(loads.springs[p], there[p], share), off);
  }
  return energy;
}

void add_load_stiffness(const EmbeddedLoads& loads, dynamics::BlockMatrix& matrix) {
  const springs::Embedding& at = loads.at;
  for (std::size_t p = 0; p < at.points(); ++p) {
    Mat3 stiffness;
    for (std::size_t i = 0; i < 3; ++i) stiffness(i, i) = loads.springs[p].stiffness_n_per_m[i];
    for (Index a = at.offsets[p]; a < at.offsets[p + 1]; ++a) {
      for (Index b = at.offsets[p]; b < at.offsets[p + 1]; ++b)
        dynamics::add_block(matrix, at.nodes[a], at.nodes[b], (at.weights[a] * at.weights[b]) * stiffness);
    }
  }
}

Vec3 total_force(const EmbeddedLoads& loads, std::span<const Vec3> u, double share) {
  Vec3 sum;
  for (const Vec3& f : loads.dead_n) sum = sum + share * f;
  const std::vector<Vec3> there = interpolate(loads.at, u);
  for (std::size_t p = 0; p < there.size(); ++p) sum = sum + pull_of(loads.springs[p], there[p], share);
  return sum;
}

double worst_held_error(const EmbeddedLoads& loads, std::span<const Vec3> u) {
  double worst = 0.0;
  const std::vector<Vec3> there = interpolate(loads.at, u);
  for (std::size_t p = 0; p < there.size(); ++p) {
    const PointSpring& spring = loads.springs[p];
    if (!spring.is_held) continue;
    Vec3 off = spring.by_m - there[p];
    for (std::size_t i = 0; i < 3; ++i) {
      if (spring.stiffness_n_per_m[i] == 0.0) component(off, i) = 0.0;
    }
    worst = std::max(worst, length(off));
  }
  return worst;
}

}  // namespace palpate::reference
