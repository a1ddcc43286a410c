#include "core/dynamics/reduced/compliance_table.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/linear_algebra/signed_index.h"
#include "core/dynamics/reduced/rigid_frame.h"
#include "core/dynamics/reduced/skin_space.h"
#include "core/mesh/rigid_motion.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

using Matrix = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kMostBytes = 4.0 * 1024.0 * 1024.0 * 1024.0;
constexpr Eigen::Index kBlock = 48;  ///< right sides that are solved at once

void check_options(const ComplianceOptions& options) {
  if (options.element_order != 1 && options.element_order != 2)
    throw InputError("elements", 0, "of order 1 or 2", std::to_string(options.element_order));
  if (options.refine < 0 || options.refine > 1)
    throw InputError("refine", 0, "0 or 1", std::to_string(options.refine));
  if (options.reaction_order < 1 || options.reaction_order > options.element_order)
    throw InputError("reactions", 0, "no higher order than the elements",
                     std::to_string(options.reaction_order));
  if (options.midpoints && options.element_order == 1 && options.refine == 0)
    throw InputError("midpoints", 0, "elements that have nodes there: p2, or refined ones", "p1");
}

void require_one_body(const TetMesh& mesh) {
  const std::vector<std::uint8_t> nothing(mesh.points.size(), 0);
  const std::size_t motions = find_free_motions(mesh, nothing).size();
  if (motions != 6) throw InputError("mesh", 0, "one connected body", std::to_string(motions / 6) + " parts");
}

/// The body that floats free, with what balances its loads.
class FreeBody {
 public:
  FreeBody(const TetMesh& mesh, const ElementSpace& space, double poisson_ratio, const RigidFrame& frame,
           const FactorMaker& make_factor, ComplianceSetup& setup) {
    const Stopwatch start;
    const ElementMatrices body = build_element_matrices(mesh, space, {1.0, poisson_ratio, 1.0});
    const std::size_t n = space.nodes();
    rigid_.resize(signed_index(3 * n), 6);
    weighted_.resize(signed_index(3 * n), 6);
    std::vector<Vec3> motion(n);
    std::vector<Vec3> product(n);
    for (std::size_t k = 0; k < 6; ++k) {
      for (std::size_t v = 0; v < n; ++v) motion[v] = frame.motion(k, space.points[v]);
      multiply_mass(body, motion, product);
      std::memcpy(rigid_.col(signed_index(k)).data(), motion.data(), n * sizeof(Vec3));
      std::memcpy(weighted_.col(signed_index(k)).data(), product.data(), n * sizeof(Vec3));
    }
    inverse_ = (rigid_.transpose() * weighted_).inverse();
    std::vector<std::uint8_t> held = pin_statically(mesh, frame);
    held.resize(n, 0);
    free_ = number_free(held);
    const LowerHalf lower = lower_half(body.stiffness, free_);
    setup.assembly_s += start.seconds();
    const Stopwatch factoring;
    factor_ = make_factor(lower);
    setup.factor_s += factoring.seconds();
    setup.unknowns = free_.count;
    setup.factor_entries = factor_->entries();
  }

  /// K^+ times loads, one a column: balanced, solved, freed of rigid motion.
  void solve(Matrix& loads) const {
    loads -= weighted_ * (inverse_ * (rigid_.transpose() * loads));
    Matrix inner(signed_index(free_.count), loads.cols());
    for (Eigen::Index c = 0; c < loads.cols(); ++c) {
      for (std::size_t i = 0; i < free_.number.size(); ++i) {
        if (free_.number[i] != kNoIndex) inner(free_.number[i], c) = loads(signed_index(i), c);
      }
    }
    factor_->solve({inner.data(), static_cast<std::size_t>(inner.size())});
    for (Eigen::Index c = 0; c < loads.cols(); ++c) {
      for (std::size_t i = 0; i < free_.number.size(); ++i)
        loads(signed_index(i), c) = free_.number[i] == kNoIndex ? 0.0 : inner(free_.number[i], c);
    }
    loads -= rigid_ * (inverse_ * (weighted_.transpose() * loads));
  }

 private:
  Matrix rigid_;
  Matrix weighted_;  ///< M R, for density 1
  Eigen::Matrix<double, 6, 6> inverse_;
  FreeNumbers free_;
  std::unique_ptr<SymmetricFactor> factor_;
};

/// The mass of the tractions' shape functions, to divide by; one number a node, for each of three components.
class TractionMass {
 public:
  explicit TractionMass(const std::vector<std::vector<NodeWeight>>& columns) {
    if (columns.empty()) return;
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (const NodeWeight& entry : columns[c])
        entries.emplace_back(static_cast<int>(entry.node), static_cast<int>(c), entry.weight);
    }
    Eigen::SparseMatrix<double> mass(signed_index(columns.size()), signed_index(columns.size()));
    mass.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(mass);
    require(factor_.info() == Eigen::Success, "the mass of the skin is positive definite");
    size_ = columns.size();
  }

  /// Each row of 3 n numbers times the inverse.
  void divide_rows(std::vector<double>& rows) const {
    if (size_ == 0) return;
    constexpr std::size_t kRows = 32;
    const std::size_t width = 3 * size_;
    const std::size_t height = rows.size() / width;
    for (std::size_t first = 0; first < height; first += kRows) {
      const std::size_t count = std::min(kRows, height - first);
      RowMatrix all(signed_index(size_), signed_index(3 * count));
      const auto row = [&](std::size_t r) {
        return Eigen::Map<RowMatrix>(rows.data() + (first + r) * width, signed_index(size_), 3);
      };
      for (std::size_t r = 0; r < count; ++r) all.middleCols(signed_index(3 * r), 3) = row(r);
      const RowMatrix solved = factor_.solve(all);
      for (std::size_t r = 0; r < count; ++r) row(r) = solved.middleCols(signed_index(3 * r), 3);
    }
  }

 private:
  std::size_t size_ = 0;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

void make_symmetric(std::vector<double>& square, std::size_t n) {
  Eigen::Map<RowMatrix> all(square.data(), signed_index(n), signed_index(n));
  const RowMatrix mean = 0.5 * (all + all.transpose());
  all = mean;
}

void transpose(std::vector<double>& square, std::size_t n) {
  Eigen::Map<RowMatrix> all(square.data(), signed_index(n), signed_index(n));
  const RowMatrix other = all.transpose();
  all = other;
}

/// Solves for all tractions; what comes out is B^T K^+ B and the rows of K^+ B at the mesh's vertices.
void solve_columns(const FreeBody& body, std::size_t nodes, const SkinCoupling& skin,
                   ComplianceTable& table) {
  const std::size_t columns = 3 * skin.coupling.size();
  table.skin.assign(columns * columns, 0.0);
  table.field.assign(3 * table.order.size() * columns, 0.0);
  for (std::size_t first = 0; first < columns; first += static_cast<std::size_t>(kBlock)) {
    const std::size_t last = std::min(columns, first + static_cast<std::size_t>(kBlock));
    Matrix block = Matrix::Zero(signed_index(3 * nodes), signed_index(last - first));
    for (std::size_t c = first; c < last; ++c) {
      for (const NodeWeight& entry : skin.coupling[c / 3])
        block(signed_index(3 * std::size_t{entry.node} + c % 3), signed_index(c - first)) = entry.weight;
    }
    body.solve(block);
    for (std::size_t k = 0; k < skin.coupling.size(); ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t c = first; c < last; ++c) {
          double sum = 0.0;
          for (const NodeWeight& entry : skin.coupling[k])
            sum +=
                entry.weight * block(signed_index(3 * std::size_t{entry.node} + i), signed_index(c - first));
          table.skin[(3 * k + i) * columns + c] = sum;
        }
      }
    }
    for (std::size_t row = 0; row < table.order.size(); ++row) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t c = first; c < last; ++c)
          table.field[(3 * row + i) * columns + c] =
              block(signed_index(3 * std::size_t{table.order[row]} + i), signed_index(c - first));
      }
    }
  }
}

void order_vertices(const TetMesh& mesh, ComplianceTable& table) {
  table.order = table.nodes.vertices;
  std::vector<std::uint8_t> on_skin(mesh.points.size(), 0);
  for (const Index v : table.order) on_skin[v] = 1;
  for (std::size_t v = 0; v < on_skin.size(); ++v) {
    if (on_skin[v] == 0) table.order.push_back(static_cast<Index>(v));
  }
  if (!table.options.midpoints) return;
  // The same numbers as nodes of quadratic elements, or as vertices of the refined mesh.
  const std::size_t nodes = mesh.points.size() + build_edges(mesh).size();
  for (std::size_t node = mesh.points.size(); node < nodes; ++node)
    table.order.push_back(static_cast<Index>(node));
}

}  // namespace

std::uint64_t hash_body(const TetMesh& mesh) {
  std::uint64_t hash = 1469598103934665603ULL;
  const auto add = [&](const void* data, std::size_t bytes) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ at[i]) * 1099511628211ULL;
  };
  add(mesh.points.data(), mesh.points.size() * sizeof(Vec3));
  add(mesh.tets.data(), mesh.tets.size() * sizeof(Tet));
  return hash;
}

ComplianceTable build_compliance_table(const TetMesh& mesh, const ComplianceOptions& options,
                                       const FactorMaker& make_factor, ComplianceSetup& setup) {
  const Stopwatch start;
  check_options(options);
  require_one_body(mesh);
  ComplianceTable table;
  table.options = options;
  table.body = hash_body(mesh);
  const ElementSpace coarse = build_element_space(mesh, options.reaction_order);
  const SkinPlaces skin = number_skin(mesh, coarse);
  table.nodes = skin.nodes;
  order_vertices(mesh, table);
  const std::size_t columns = 3 * table.nodes.size();
  const double bytes = 8.0 * static_cast<double>(columns) *
                       (static_cast<double>(columns) + 3.0 * static_cast<double>(table.order.size()));
  if (bytes > kMostBytes)
    throw InputError("mesh", 0, "a table of at most 4 GiB in double precision",
                     std::to_string(bytes / (kMostBytes / 4.0)) + " GiB");
  const TetMesh fine_mesh = options.refine == 1 ? refine_uniformly(mesh) : mesh;
  const ElementSpace fine = build_element_space(fine_mesh, options.element_order);
  const SkinCoupling coupling = couple_skin(mesh, coarse, fine_mesh, fine, skin);
  setup.assembly_s += start.seconds();
  const FreeBody body(fine_mesh, fine, options.poisson_ratio, build_rigid_frame(mesh), make_factor, setup);
  const Stopwatch solving;
  solve_columns(body, fine.nodes(), coupling, table);
  const TractionMass mass(coupling.mass);
  mass.divide_rows(table.field);
  mass.divide_rows(table.skin);
  transpose(table.skin, columns);
  mass.divide_rows(table.skin);
  make_symmetric(table.skin, columns);
  setup.solve_s += solving.seconds();
  return table;
}

ComplianceTable to_single(const ComplianceTable& table) {
  ComplianceTable out;
  out.options = table.options;
  out.body = table.body;
  out.nodes = table.nodes;
  out.order = table.order;
  out.skin_single.assign(table.skin.begin(), table.skin.end());
  out.field_single.assign(table.field.begin(), table.field.end());
  return out;
}

}  // namespace palpate::dynamics
