// Continua, stepped explicitly: strain energies with their damping, loads and symplectic Euler, as fast as it
// goes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/spring_engine/plain_engine.h"

namespace palpate::dynamics {

/// What of a model the tet engine cannot take: "springs", "a volume force", "no strain energy" or "a domain
/// of too many vertices". Empty: it takes all of it.
std::string find_more_than_tets(const MotionModel& model);

/// Steps a body of strain terms (linear tets, smoothed elements over faces, edges or nodes) in single or
/// double precision:
///
///   v' = v + h / m (-sum of V_s P_s g_sv - gamma v + f),  u' = u + h v'
///
/// P is stress and damping_stress of the term's law (core/dynamics/elasticity/elastic_law.h), f the loads:
/// dead ones, elastic supports and pads, each with its profile (core/dynamics/spring_engine/plain_loads.h).
/// Held components follow their profiles, as Integrator has them. The arithmetic is fixed by the layout alone
/// (core/dynamics/tet_engine/domain_layout.h): one thread and two give the same bits, with AVX2 and without.
///
/// Options, reports and observers are those of the plain engine; no step has a spring without length.
///
/// Precision: what is stored is the displacement, so a small one keeps its digits. Gradients are rounded to
/// 1e-7 (single precision) of |u| over an edge.
///
/// Source: K. Miller, G. Joldes, D. Lance, A. Wittek, Commun. Numer. Meth. Engng 23 (2007), doi
/// 10.1002/cnm.887: explicit total Lagrangian steps with gradients of the rest shape made beforehand.
template <typename Real>
class TetEngine {
 public:
  /// Throws: as validate(MotionModel); InputError for a model with more than it takes (find_more_than_tets).
  TetEngine(const MotionModel& model, const PlainOptions& options);
  ~TetEngine();
  TetEngine(TetEngine&&) noexcept;
  TetEngine& operator=(TetEngine&&) noexcept;

  /// Shape: as MotionState of the model. Held components are put where their profiles have them.
  void set_state(const MotionState& state);
  MotionState state() const;

  /// Takes `steps` steps of length `step_s` > 0.
  PlainReport step(double step_s, std::uint64_t steps, const PlainObserver& observer = {});

  /// The force of each group of loads on the body, in N, at the start of the last step
  /// (MotionForces::group_forces); zero before the first.
  const std::vector<Vec3>& group_forces() const;

  /// Puts an elastic pad on faces of the body between two steps, at rest, in the place of the one before; no
  /// faces: takes it away. move_pad says how far it is moved; SupportFace::by_m is not read. It acts like the
  /// supports of a group of loads, but for a last place of rounding.
  void set_pad(std::span<const SupportFace> faces);
  void move_pad(const Vec3& by_m);
  /// The pad's force on the body at the start of the last step, in N; zero without one.
  Vec3 pad_force() const;

  /// Whether domains are computed with AVX2.
  bool uses_avx2() const;

  /// What one step reads and writes at the least: domains, vertices before and after, masses and loads; the
  /// sums of forces, copies for blocks and what a write fetches first are not counted.
  std::size_t bytes_per_step() const;

  /// Domains of all terms.
  std::size_t domains() const;
  /// Vertices of other blocks that blocks see, in sum.
  std::size_t halo_vertices() const;

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

extern template class TetEngine<float>;
extern template class TetEngine<double>;

}  // namespace palpate::dynamics
