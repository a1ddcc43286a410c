// A false alarm of g++ 12 inside Eigen, from what Spectra's Arnoldi method frees and allocates in a loop.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuse-after-free"
#endif

#include "core/dynamics/stability/slow_rates.h"

#include <Spectra/GenEigsSolver.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/rigid_motion.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kMostVerticesFactored = 4000;

void require_held(const MotionModel& model, const std::vector<std::uint8_t>& held) {
  if (model.tets.empty()) return;
  std::vector<std::uint8_t> resisted = held;
  for (const TimedLoads& group : model.loads) {
    for (const SupportFace& support : group.loads.supports) {
      if (!(support.coefficient_n_per_m > 0.0)) continue;
      for (const Index v : support.face) resisted[v] = 7;
    }
  }
  const TetMesh mesh{model.elastic.rest, model.tets};
  const std::vector<RigidMotion> free = find_free_motions(mesh, resisted);
  if (!free.empty())
    throw InputError("slowest decay", 0, "a body that is held", rigid_motion_text(free[0]) + " left free");
}

/// M, D and K of a body at rest, and solutions with K.
class RestingBody {
 public:
  RestingBody(const MotionModel& model, int threads) : model_(&model), threads_(threads) {
    held_ = MotionForces(model, 1).held_bits();
    require_held(model, held_);
    const std::vector<Vec3> still(model.elastic.rest.size());
    stiffness_ = build_motion_pattern(model);
    damping_ = stiffness_;
    add_motion_stiffness(model, still, TangentKind::kExact, stiffness_);
    add_changing_damping(model, still, damping_);
    add_constant_damping(model, damping_);
    LinearOptions options;
    options.method =
        rows() <= kMostVerticesFactored ? LinearMethod::kDirect : LinearMethod::kConjugateGradients;
    options.tolerance = 1e-11;
    options.threads = threads;
    solver_.emplace(options);
    if (solver_->prepare(stiffness_, held_) != LinearStatus::kSolved) refuse();
    prepare_volume_force(still);
  }

  std::size_t rows() const { return model_->elastic.rest.size(); }
  std::size_t solves() const { return solves_; }

  /// x = -K^-1 (D a + scale M b).
  void solve(std::span<const Vec3> a, double scale, std::span<const Vec3> b, std::vector<Vec3>& x) {
    std::vector<Vec3> right(rows());
    multiply(damping_, a, right, threads_);
    for (std::size_t v = 0; v < rows(); ++v) right[v] = -1.0 * right[v] - (scale * model_->mass_kg[v]) * b[v];
    clear_held(held_, right);
    solve_stiffness(right, x);
    if (!volume_gradient_.empty())
      add_scaled(x, -dot_of(volume_gradient_, x) / (1.0 + dot_of(volume_gradient_, volume_answer_)),
                 volume_answer_);
  }

  /// The frequency of the slowest undamped motion, roughly: a scale for velocities.
  double guess_frequency() {
    SplitMix64 random(1);
    std::vector<Vec3> x(rows());
    for (Vec3& each : x) each = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    clear_held(held_, x);
    const std::vector<Vec3> none(rows());
    double square = 0.0;
    for (int k = 0; k < 4; ++k) {
      const std::vector<Vec3> before = x;
      solve(none, -1.0, before, x);
      square = norm_of(before) / norm_of(x);
      for (Vec3& each : x) each = square / norm_of(before) * each;
    }
    return std::sqrt(square);
  }

  const std::vector<std::uint8_t>& held() const { return held_; }

 private:
  [[noreturn]] static void refuse() {
    throw InputError("slowest decay", 0, "a body that is stiff in all directions", "one that is not");
  }

  void solve_stiffness(std::span<const Vec3> right, std::vector<Vec3>& x) {
    x.resize(rows());
    ++solves_;
    if (solver_->solve(right, x).status != LinearStatus::kSolved) refuse();
  }

  void prepare_volume_force(const std::vector<Vec3>& still) {
    const auto& force = model_->elastic.volume_force;
    if (!force) return;
    VolumeForceTangent tangent = differentiate_volume_force(*force, model_->elastic.rest, still);
    clear_held(held_, tangent.direction);
    clear_held(held_, tangent.volume_gradient);
    for (Vec3& each : tangent.direction) each = -force->stiffness_n_per_m3 * each;
    solve_stiffness(tangent.direction, volume_answer_);
    volume_gradient_ = std::move(tangent.volume_gradient);
  }

  const MotionModel* model_;
  int threads_;
  std::vector<std::uint8_t> held_;
  BlockMatrix stiffness_;
  BlockMatrix damping_;
  std::optional<LinearSolver> solver_;
  std::vector<Vec3> volume_gradient_;
  std::vector<Vec3> volume_answer_;  ///< K^-1 (-k d)
  std::size_t solves_ = 0;
};

/// (x, s w) -> the state whose rate of change it is: (-K^-1 (D x + s M w), x / s).
class InverseProduct {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name

  InverseProduct(RestingBody& body, double scale) : body_(&body), scale_(scale) {}

  Eigen::Index rows() const { return static_cast<Eigen::Index>(6 * body_->rows()); }
  Eigen::Index cols() const { return rows(); }

  void perform_op(const double* in, double* out) const {
    const std::size_t n = body_->rows();
    std::vector<Vec3> x(n);
    std::vector<Vec3> w(n);
    std::vector<Vec3> answer(n);
    for (std::size_t v = 0; v < n; ++v) {
      x[v] = {in[3 * v], in[3 * v + 1], in[3 * v + 2]};
      const double* rate = in + 3 * (n + v);
      w[v] = {rate[0], rate[1], rate[2]};
    }
    body_->solve(x, scale_, w, answer);
    for (std::size_t v = 0; v < n; ++v) {
      out[3 * v] = answer[v].x;
      out[3 * v + 1] = answer[v].y;
      out[3 * v + 2] = answer[v].z;
      double* rate = out + 3 * (n + v);
      for (std::size_t i = 0; i < 3; ++i) rate[i] = in[3 * v + i] / scale_;
    }
  }

 private:
  RestingBody* body_;
  double scale_;
};

/// Where Arnoldi's method starts: anything that no mode is orthogonal to, zero where the body is held.
std::vector<double> build_start(const RestingBody& body) {
  SplitMix64 random(2);
  std::vector<Vec3> field(2 * body.rows());
  for (Vec3& each : field) each = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  clear_held(body.held(), std::span(field).first(body.rows()));
  clear_held(body.held(), std::span(field).last(body.rows()));
  std::vector<double> start;
  start.reserve(3 * field.size());
  for (const Vec3& each : field) start.insert(start.end(), {each.x, each.y, each.z});
  return start;
}

}  // namespace

double SlowRates::slowest_decay_s() const {
  double slowest = std::numeric_limits<double>::infinity();
  for (const std::complex<double>& each : lambda_per_s) slowest = std::min(slowest, -each.real());
  return slowest > 0.0 ? 1.0 / slowest : std::numeric_limits<double>::infinity();
}

SlowRates find_slow_rates(const MotionModel& model, std::size_t count, int threads) {
  RestingBody body(model, threads);
  std::size_t free = 0;
  for (const std::uint8_t bits : body.held()) {
    for (unsigned axis = 0; axis < 3; ++axis) free += ((bits >> axis) & 1U) == 0 ? 1 : 0;
  }
  if (free == 0) throw InputError("slowest decay", 0, "a body that can move", "one that is held everywhere");
  const auto wanted = static_cast<Eigen::Index>(std::min(count, free));
  const Eigen::Index vectors = std::min<Eigen::Index>(4 * wanted + 12, static_cast<Eigen::Index>(2 * free));
  constexpr Eigen::Index kRestarts = 60;
  constexpr double kTolerance = 1e-7;
  InverseProduct product(body, body.guess_frequency());
  Spectra::GenEigsSolver<InverseProduct> solver(product, wanted, vectors);
  const std::vector<double> start = build_start(body);
  solver.init(start.data());
  solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kTolerance);
  SlowRates out;
  out.solves = body.solves();
  out.converged = solver.info() == Spectra::CompInfo::Successful;
  const auto values = solver.eigenvalues();
  for (Eigen::Index k = 0; k < values.size(); ++k) out.lambda_per_s.push_back(1.0 / values[k]);
  std::sort(out.lambda_per_s.begin(), out.lambda_per_s.end(), [](const auto& a, const auto& b) {
    return std::abs(a) != std::abs(b) ? std::abs(a) < std::abs(b) : a.imag() < b.imag();
  });
  return out;
}

}  // namespace palpate::dynamics
