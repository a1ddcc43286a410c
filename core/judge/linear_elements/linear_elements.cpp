#include "core/judge/linear_elements/linear_elements.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/judge/linear_elements/elastic_blocks.h"
#include "core/judge/linear_elements/stiffness_spectrum.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

constexpr int kFields = 15;
constexpr double kSolve = 1e-6;
constexpr std::size_t kMostSteps = 4000;
constexpr double kMostCondition = 1e12;  // beyond, rounding hides the least eigenvalue

using Strains = Eigen::Matrix<double, 6, kFields>;  // xx, yy, zz, 2 yz, 2 xz, 2 xy of each field
using Moduli = Eigen::Matrix<double, 6, 6>;
using Gram = Eigen::Matrix<double, kFields, kFields>;
using Tensor = Eigen::Matrix3d;

/// Strains of the 15 fields: strain(x) = x at[0] + y at[1] + z at[2].
struct QuadraticFields {
  std::array<Strains, 3> at;
  Moduli moduli;
  double lambda = 0.0;
  double mu = 0.0;

  Strains strain(const Vec3& p) const { return p.x * at[0] + p.y * at[1] + p.z * at[2]; }

  /// Integral of strain : C : strain over a body with these second moments.
  Gram energies(const Tensor& moments) const {
    Gram sum = Gram::Zero();
    for (int d = 0; d < 3; ++d) {
      for (int e = 0; e < 3; ++e) {
        sum += moments(d, e) * at[static_cast<std::size_t>(d)].transpose() * moduli *
               at[static_cast<std::size_t>(e)];
      }
    }
    return sum;
  }
};

/// The place of strain (a, b) among the six.
int place_of(int a, int b) {
  return a == b ? a : 6 - a - b;
}

/// The quadratic displacements e_k x_i x_j, and of them those without body force: (lambda + mu) grad(div u) +
/// mu div(grad u) = 0 is three equations for 18 coefficients.
QuadraticFields build_fields(double poisson_ratio) {
  QuadraticFields fields;
  fields.mu = 0.5 / (1.0 + poisson_ratio);
  fields.lambda = poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  fields.moduli.setZero();
  fields.moduli.topLeftCorner<3, 3>().setConstant(fields.lambda);
  for (int i = 0; i < 3; ++i) {
    fields.moduli(i, i) += 2.0 * fields.mu;
    fields.moduli(i + 3, i + 3) = fields.mu;
  }
  constexpr int kAll = 18;
  std::array<Eigen::Matrix<double, 6, kAll>, 3> strain;
  for (auto& s : strain) s.setZero();
  Eigen::Matrix<double, 3, kAll> force = Eigen::Matrix<double, 3, kAll>::Zero();
  int column = 0;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j, ++column) {
        strain[static_cast<std::size_t>(j)](place_of(k, i), column) += 1.0;  // d(x_i x_j) / dx_i = x_j
        strain[static_cast<std::size_t>(i)](place_of(k, j), column) += 1.0;
        if (k == i) force(j, column) += fields.lambda + fields.mu;
        if (k == j) force(i, column) += fields.lambda + fields.mu;
        if (i == j) force(k, column) += 2.0 * fields.mu;
      }
    }
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(force, Eigen::ComputeFullV);
  const Eigen::MatrixXd free = svd.matrixV().rightCols(kFields);
  for (std::size_t d = 0; d < 3; ++d) fields.at[d] = strain[d] * free;
  return fields;
}

/// The mesh without unused vertices, scaled by a power of two to a size near 1 and moved to its centroid.
struct Body {
  TetMesh mesh;
  std::vector<TetGradients> shapes;
  double volume = 0.0;
  Tensor moments = Tensor::Zero();      ///< integral of x x^T about the centroid
  Tensor within_tets = Tensor::Zero();  ///< sum over the tets of the same about each one's own centroid
};

Eigen::Vector3d vector_of(const Vec3& p) {
  return {p.x, p.y, p.z};
}

Vec3 centroid_of(const TetMesh& mesh, const Tet& t) {
  return 0.25 * (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]] + mesh.points[t[3]]);
}

TetMesh near_unit_size(const TetMesh& mesh) {
  std::vector<Index> number(mesh.points.size(), kNoIndex);
  TetMesh scaled{{}, mesh.tets};
  double largest = 0.0;
  for (Tet& tet : scaled.tets) {
    for (Index& v : tet) {
      if (number[v] == kNoIndex) {
        number[v] = static_cast<Index>(scaled.points.size());
        scaled.points.push_back(mesh.points[v]);
        const Vec3& p = mesh.points[v];
        largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
      }
      v = number[v];
    }
  }
  const auto shrink = [&](double size) {
    const int exponent = size > 0.0 ? std::ilogb(size) : 0;
    for (Vec3& p : scaled.points) {
      p = {std::scalbn(p.x, -exponent), std::scalbn(p.y, -exponent), std::scalbn(p.z, -exponent)};
    }
  };
  shrink(largest);
  const Vec3 origin = scaled.points.front();
  double extent = 0.0;
  for (Vec3& p : scaled.points) {
    p = p - origin;
    extent = std::max({extent, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  shrink(extent);
  return scaled;
}

Vec3 centroid_of(const TetMesh& mesh) {
  Vec3 sum;
  double volume = 0.0;
  for (const Tet& tet : mesh.tets) {
    const double part = tet_gradients(mesh, tet).volume;
    volume += part;
    sum = sum + part * centroid_of(mesh, tet);
  }
  return (1.0 / volume) * sum;
}

/// Nothing if a tet has no positive volume in double precision.
std::optional<Body> build_body(const TetMesh& mesh) {
  Body body;
  body.mesh = near_unit_size(mesh);
  const Vec3 centroid = centroid_of(body.mesh);
  for (Vec3& p : body.mesh.points) p = p - centroid;
  for (const Tet& tet : body.mesh.tets) {
    body.shapes.push_back(tet_gradients(body.mesh, tet));
    const TetGradients& shape = body.shapes.back();
    if (!(shape.volume > 0.0) || !std::isfinite(shape.volume * length_sq(shape.gradient[0])))
      return std::nullopt;
    body.volume += shape.volume;
    const Eigen::Vector3d center = vector_of(centroid_of(body.mesh, tet));
    for (const Index v : tet) {
      const Eigen::Vector3d arm = vector_of(body.mesh.points[v]) - center;
      body.within_tets += shape.volume / 20.0 * arm * arm.transpose();  // exact for quadratics
    }
    body.moments += shape.volume * center * center.transpose();
  }
  body.moments += body.within_tets;
  return body;
}

/// Forces of the fields' tractions: integral of sigma(u) : grad phi, which for a linear stress is that of its
/// mean.
FieldBlock build_loads(const Body& body, const QuadraticFields& fields) {
  FieldBlock loads(body.mesh.points.size(), kFields);
  for (std::size_t t = 0; t < body.mesh.tets.size(); ++t) {
    const Tet& tet = body.mesh.tets[t];
    const TetGradients& shape = body.shapes[t];
    const Strains stress = shape.volume * fields.moduli * fields.strain(centroid_of(body.mesh, tet));
    for (std::size_t i = 0; i < 4; ++i) {
      const std::array<double, 3> g{shape.gradient[i].x, shape.gradient[i].y, shape.gradient[i].z};
      for (int a = 0; a < 3; ++a) {
        double* row = loads.row(3 * std::size_t{tet[i]} + static_cast<std::size_t>(a));
        for (int b = 0; b < 3; ++b) {
          const int place = place_of(a, b);
          for (int j = 0; j < kFields; ++j) row[j] += g[static_cast<std::size_t>(b)] * stress(place, j);
        }
      }
    }
  }
  return loads;
}

Strains strain_of(const FieldBlock& field, const Tet& tet, const TetGradients& shape) {
  Strains strain = Strains::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const std::array<double, 3> g{shape.gradient[i].x, shape.gradient[i].y, shape.gradient[i].z};
    for (int a = 0; a < 3; ++a) {
      const double* row = field.row(3 * std::size_t{tet[i]} + static_cast<std::size_t>(a));
      for (int b = 0; b < 3; ++b) {
        const int place = place_of(a, b);
        for (int j = 0; j < kFields; ++j) strain(place, j) += g[static_cast<std::size_t>(b)] * row[j];
      }
    }
  }
  return strain;
}

/// Fills in the errors: within each tet the strain of the truth is its mean and a linear rest, which no
/// constant strain has a part in; so the error's energy is the sum of the rest's and of the means'
/// differences, nothing of it negative.
void measure_errors(const Body& body, const QuadraticFields& fields, const FieldBlock& answer,
                    LinearElementFigures& figures) {
  Gram error = fields.energies(body.within_tets);
  for (std::size_t t = 0; t < body.mesh.tets.size(); ++t) {
    const Tet& tet = body.mesh.tets[t];
    const Strains off = fields.strain(centroid_of(body.mesh, tet)) - strain_of(answer, tet, body.shapes[t]);
    error += body.shapes[t].volume * off.transpose() * (fields.moduli * off);
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Rows> shares(error, fields.energies(body.moments),
                                                              Eigen::EigenvaluesOnly);
  figures.p1_error = std::sqrt(std::max(0.0, shares.eigenvalues().mean()));
  figures.p1_error_worst = std::sqrt(std::max(0.0, shares.eigenvalues().maxCoeff()));
}

/// Lumped masses: a quarter of each tet's to each of its vertices.
std::vector<Block> lumped_masses(const Body& body) {
  std::vector<Block> masses(body.mesh.points.size(), Block{});
  for (std::size_t t = 0; t < body.mesh.tets.size(); ++t) {
    for (const Index v : body.mesh.tets[t]) {
      for (const std::size_t i : {0U, 4U, 8U}) masses[v][i] += 0.25 * body.shapes[t].volume;
    }
  }
  return masses;
}

/// Fills in conditions, greatest eigenvalues and step; returns whether that could be done.
bool measure_spectrum(const Body& body, const BlockRows& stiffness, std::span<const Block> inverse_diagonal,
                      const FieldBlock& answer, LinearElementFigures& figures) {
  const auto condition = [&](std::span<const Block> blocks, double& value, double& greatest) {
    greatest = greatest_eigenvalue(stiffness, blocks);
    const auto least =
        least_elastic_eigenvalue(stiffness, inverse_diagonal, blocks, body.mesh.points, answer);
    if (!least || !(greatest <= kMostCondition * *least)) return false;
    value = greatest / *least;
    return true;
  };
  const std::vector<Block> unit(stiffness.size(), Block{1, 0, 0, 0, 1, 0, 0, 0, 1});
  const std::vector<Block> diagonal = diagonal_blocks(stiffness);
  if (!condition(unit, figures.stiffness_condition, figures.max_stiffness_eigenvalue) ||
      !condition(diagonal, figures.scaled_condition, figures.max_scaled_eigenvalue))
    return false;
  const double size = std::cbrt(body.volume / static_cast<double>(body.mesh.tets.size()));
  figures.max_stiffness_eigenvalue /= size;
  figures.explicit_step = 2.0 / std::sqrt(greatest_eigenvalue(stiffness, lumped_masses(body))) / size;
  return std::isfinite(figures.explicit_step);
}

/// Why the mesh is no single sound body; empty if it is.
std::string reason_against(const TetMesh& mesh) {
  if (mesh.tets.empty()) return "no tetrahedra";
  std::size_t bad = 0;
  for (const Tet& t : mesh.tets) {
    require(has_valid_indices(t, mesh.points.size()), "measure_linear_elements: a tet with invalid indices");
    const auto& p = mesh.points;
    if (!measure_tet(p[t[0]], p[t[1]], p[t[2]], p[t[3]]).is_positive) ++bad;
  }
  if (bad > 0) return std::to_string(bad) + (bad == 1 ? " tet is" : " tets are") + " not positive";
  const std::uint64_t parts = count_elements(mesh).components;
  return parts > 1 ? "the body is in " + std::to_string(parts) + " parts" : "";
}

}  // namespace

LinearElementFigures measure_linear_elements(const TetMesh& mesh, double poisson_ratio) {
  require(poisson_ratio > -1.0 && poisson_ratio < 0.5, "measure_linear_elements: a bad Poisson's ratio");
  LinearElementFigures figures;
  figures.reason = reason_against(mesh);
  if (!figures.reason.empty()) return figures;
  figures.reason = "a tet of almost no volume, or too few tets: rounding hides the answer";
  const std::optional<Body> body = build_body(mesh);
  if (!body) return figures;
  const QuadraticFields fields = build_fields(poisson_ratio);
  const BlockRows stiffness = build_stiffness(body->mesh, fields.lambda, fields.mu);
  const std::vector<Block> inverse_diagonal = invert_blocks(diagonal_blocks(stiffness));
  if (inverse_diagonal.empty()) return figures;
  FieldBlock answer(body->mesh.points.size(), kFields);
  if (!solve_fields(stiffness, inverse_diagonal, build_loads(*body, fields), answer, kSolve, kMostSteps))
    return figures;
  LinearElementFigures found;
  measure_errors(*body, fields, answer, found);
  if (!measure_spectrum(*body, stiffness, inverse_diagonal, answer, found)) return figures;
  return found;
}

}  // namespace palpate::judge
