#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "reference/finite_spheres/quadrature.h"
#include "reference/finite_spheres/sphere_system.h"

namespace palpate::reference {

using dynamics::kIdentity;
using dynamics::Mat3;

namespace {

/// A point of a boundary face.
struct FaceSample {
  std::size_t tet = 0;
  std::array<double, 4> at{};  ///< barycentric in the tet
  double area_m2 = 0.0;        ///< the point's share of the face's area
  Vec3 normal;
  double height_m = 0.0;  ///< of the tet over the face
};

/// Faces with their tets and points.
class FaceSampler {
 public:
  FaceSampler(const TetMesh& mesh, std::vector<FacePoint> rule)
      : mesh_(mesh), rule_(std::move(rule)), faces_(build_faces(mesh)) {}

  /// Calls use(sample) at each point of a face.
  template <typename Use>
  void visit(const Triangle& face, Use&& use) const {
    FaceSample sample;
    sample.tet = tet_of(face);
    const Vec3& a = mesh_.points[face[0]];
    const Vec3 area = 0.5 * cross(mesh_.points[face[1]] - a, mesh_.points[face[2]] - a);
    const double size = length(area);
    sample.normal = (1.0 / size) * area;
    sample.height_m = 3.0 * tet_volume(mesh_, sample.tet) / size;
    const Tet& tet = mesh_.tets[sample.tet];
    std::array<std::size_t, 3> corner{};
    for (std::size_t i = 0; i < 3; ++i)
      corner[i] = static_cast<std::size_t>(std::find(tet.begin(), tet.end(), face[i]) - tet.begin());
    for (const FacePoint& point : rule_) {
      sample.at = {};
      for (std::size_t i = 0; i < 3; ++i) sample.at[corner[i]] = point.at[i];
      sample.area_m2 = point.weight * size;
      use(sample);
    }
  }

  std::size_t tet_of(const Triangle& face) const {
    Triangle sorted = face;
    std::sort(sorted.begin(), sorted.end());
    const auto found =
        std::lower_bound(faces_.begin(), faces_.end(), sorted,
                         [](const Face& each, const Triangle& wanted) { return each.vertices < wanted; });
    require(found != faces_.end() && found->vertices == sorted, "a face of the mesh");
    return found->tets[0];
  }

 private:
  const TetMesh& mesh_;
  std::vector<FacePoint> rule_;
  std::vector<Face> faces_;
};

/// The blocks between the functions of one tet, summed up before they go to the matrix.
class TetBlocks {
 public:
  TetBlocks(const SphereField& field, std::size_t tet) {
    const std::size_t per = functions_per_sphere(field.functions);
    std::vector<Index> spheres;
    collect_moving(field, tet, spheres);
    for (const Index sphere : spheres) {
      for (std::size_t n = 0; n < per; ++n) numbers_.push_back(static_cast<Index>(per * sphere + n));
    }
    blocks_.resize(numbers_.size() * numbers_.size());
  }

  /// The places of a point's functions in this group.
  std::vector<std::size_t> places(const FunctionValues& here) const {
    std::vector<std::size_t> out;
    std::size_t at = 0;
    for (const Index number : here.numbers) {
      while (numbers_[at] < number) ++at;
      out.push_back(at);
    }
    return out;
  }

  Mat3& at(std::size_t row, std::size_t column) { return blocks_[row * numbers_.size() + column]; }

  void add_to(dynamics::BlockMatrix& matrix) const {
    for (std::size_t a = 0; a < numbers_.size(); ++a) {
      for (std::size_t b = 0; b < numbers_.size(); ++b)
        dynamics::add_block(matrix, numbers_[a], numbers_[b], blocks_[a * numbers_.size() + b]);
    }
  }

 private:
  std::vector<Index> numbers_;
  std::vector<Mat3> blocks_;
};

/// P: the identity on the held axes.
Mat3 projector(const std::array<bool, 3>& axes) {
  Mat3 p;
  for (std::size_t i = 0; i < 3; ++i) p(i, i) = axes[i] ? 1.0 : 0.0;
  return p;
}

/// T: sigma n = T u for the displacement phi u with the gradient g of phi,
///   T = lambda n g^T + mu (g n^T + (g . n) I).
Mat3 traction_of(const Material& material, const Vec3& normal, const Vec3& g) {
  return material.lambda_pa() * dynamics::outer(normal, g) +
         material.mu_pa() * (dynamics::outer(g, normal) + dot(g, normal) * kIdentity);
}

/// sigma n of a displacement gradient.
Vec3 traction_of(const Material& material, const Vec3& normal, const Mat3& gradient) {
  return (material.lambda_pa() * dynamics::trace(gradient)) * normal +
         material.mu_pa() * ((gradient + transpose(gradient)) * normal);
}

double penalty(const Material& material, double nitsche, double height_m) {
  return nitsche * (material.lambda_pa() + 2.0 * material.mu_pa()) / height_m;
}

/// What all sums over the boundary share.
struct Boundary {
  const SphereField& field;
  const BoundaryProblem& problem;
  FaceSampler sampler;
  QuadraticField held_field;
  double nitsche = 0.0;

  Boundary(const SphereField& of, const BoundaryProblem& asked, const IntegrationOptions& integration,
           double factor)
      : field(of),
        problem(asked),
        sampler(*of.mesh, integration.face_rule()),
        held_field(*of.mesh, asked.held_field_m),
        nitsche(factor) {}

  FunctionValues functions_at(const FaceSample& sample) const {
    FunctionValues here;
    evaluate_moving(field, sample.tet, point_in_tet(*field.mesh, sample.tet, sample.at), here);
    return here;
  }
};

void add_support(const Boundary& boundary, const ElasticSupport& support, SphereSystem& system) {
  for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
    TetBlocks blocks(boundary.field, boundary.sampler.tet_of(support.patch.faces[f]));
    boundary.sampler.visit(support.patch.faces[f], [&](const FaceSample& sample) {
      const FunctionValues here = boundary.functions_at(sample);
      const std::vector<std::size_t> places = blocks.places(here);
      const double stiffness = support.stiffness_pa_per_m * support.patch.weight[f] * sample.area_m2;
      for (std::size_t a = 0; a < places.size(); ++a) {
        Vec3& pull = system.moved_n[here.numbers[a]];
        pull = pull + (stiffness * here.values[a]) * support.by_m;
        for (std::size_t b = 0; b < places.size(); ++b)
          blocks.at(places[a], places[b]) += (stiffness * here.values[a] * here.values[b]) * kIdentity;
      }
    });
    blocks.add_to(system.matrix);
  }
}

void add_held(const Boundary& boundary, const HeldFaces& held, SphereSystem& system) {
  const Material& material = boundary.problem.material;
  const Mat3 axes = projector(held.axes);
  for (const Triangle& face : held.faces) {
    TetBlocks blocks(boundary.field, boundary.sampler.tet_of(face));
    boundary.sampler.visit(face, [&](const FaceSample& sample) {
      const FunctionValues here = boundary.functions_at(sample);
      const std::vector<std::size_t> places = blocks.places(here);
      const double area = sample.area_m2;
      const double beta = penalty(material, boundary.nitsche, sample.height_m);
      const Vec3 by = axes * (held.by_m + boundary.held_field.at(sample.tet, sample.at));
      std::vector<Mat3> tractions;  // P T_b
      tractions.reserve(places.size());
      for (const Vec3& gradient : here.gradients)
        tractions.push_back(dynamics::multiply(axes, traction_of(material, sample.normal, gradient)));
      for (std::size_t a = 0; a < places.size(); ++a) {
        Vec3& pull = system.moved_n[here.numbers[a]];
        pull = pull + area * ((beta * here.values[a]) * by - transpose(tractions[a]) * by);
        for (std::size_t b = 0; b < places.size(); ++b) {
          blocks.at(places[a], places[b]) +=
              area * ((beta * here.values[a] * here.values[b]) * axes + (-here.values[a]) * tractions[b] +
                      (-here.values[b]) * transpose(tractions[a]));
        }
      }
    });
    blocks.add_to(system.matrix);
  }
}

void add_traction(const Boundary& boundary, const Traction& traction, SphereSystem& system) {
  for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
    boundary.sampler.visit(traction.patch.faces[f], [&](const FaceSample& sample) {
      const FunctionValues here = boundary.functions_at(sample);
      const Vec3 force = (traction.patch.weight[f] * sample.area_m2) *
                         (traction.traction_pa - traction.pressure_pa * sample.normal);
      for (std::size_t a = 0; a < here.numbers.size(); ++a) {
        Vec3& sum = system.dead_n[here.numbers[a]];
        sum = sum + here.values[a] * force;
      }
    });
  }
}

void add_nodal_forces(const Boundary& boundary, SphereSystem& system) {
  if (boundary.problem.nodal_forces.empty()) return;
  const TetMesh& mesh = *boundary.field.mesh;
  const VertexStars stars = build_vertex_stars(mesh);
  FunctionValues here;
  for (const NodalForce& force : boundary.problem.nodal_forces) {
    evaluate_moving(boundary.field, stars.of(force.vertex).front(), mesh.points[force.vertex], here);
    for (std::size_t a = 0; a < here.numbers.size(); ++a) {
      Vec3& sum = system.dead_n[here.numbers[a]];
      sum = sum + here.values[a] * force.force_n;
    }
  }
}

void measure_supports(const Boundary& boundary, std::span<const Vec3> coefficients,
                      BoundaryFigures& figures) {
  for (const ElasticSupport& support : boundary.problem.supports) {
    Vec3 force;
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      boundary.sampler.visit(support.patch.faces[f], [&](const FaceSample& sample) {
        const Vec3 u = sum_values(boundary.functions_at(sample), coefficients);
        const double stiffness = support.stiffness_pa_per_m * support.patch.weight[f] * sample.area_m2;
        figures.quadratic_j += 0.5 * stiffness * length_sq(u);
        figures.supports_j += 0.5 * stiffness * length_sq(u - support.by_m);
        force = force + stiffness * (support.by_m - u);
      });
    }
    figures.supports_n.push_back(force);
  }
}

void measure_held(const Boundary& boundary, std::span<const Vec3> coefficients, BoundaryFigures& figures) {
  const Material& material = boundary.problem.material;
  for (const HeldFaces& held : boundary.problem.held) {
    const Mat3 axes = projector(held.axes);
    for (const Triangle& face : held.faces) {
      boundary.sampler.visit(face, [&](const FaceSample& sample) {
        const FunctionValues here = boundary.functions_at(sample);
        const Vec3 u = axes * sum_values(here, coefficients);
        const Vec3 pull = traction_of(material, sample.normal, sum_gradients(here, coefficients));
        const double beta = penalty(material, boundary.nitsche, sample.height_m);
        figures.quadratic_j += sample.area_m2 * (0.5 * beta * length_sq(u) - dot(u, pull));
        const Vec3 by = axes * (held.by_m + boundary.held_field.at(sample.tet, sample.at));
        figures.held_error_m = std::max(figures.held_error_m, length(u - by));
      });
    }
  }
}

}  // namespace

void add_boundary(const SphereField& field, const BoundaryProblem& problem,
                  const IntegrationOptions& integration, double nitsche, SphereSystem& system) {
  const Boundary boundary(field, problem, integration, nitsche);
  for (const ElasticSupport& support : problem.supports) add_support(boundary, support, system);
  for (const HeldFaces& held : problem.held) add_held(boundary, held, system);
  for (const Traction& traction : problem.tractions) add_traction(boundary, traction, system);
  add_nodal_forces(boundary, system);
}

BoundaryFigures measure_boundary(const SphereField& field, const BoundaryProblem& problem,
                                 const IntegrationOptions& integration, double nitsche,
                                 std::span<const Vec3> coefficients) {
  const Boundary boundary(field, problem, integration, nitsche);
  BoundaryFigures figures;
  measure_supports(boundary, coefficients, figures);
  measure_held(boundary, coefficients, figures);
  return figures;
}

}  // namespace palpate::reference
