// A body under a finger: made of a mesh, its springs and a choice of model, pressed, pulled, let go and
// stepped; the same in a program and in a page.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/stability/stability.h"
#include "live/body/pad_stepper.h"

namespace palpate::live {

/// What a body is, whatever model it gets.
///
/// Shape:  mesh in metres, tets positive. springs are those of the material itself: other volume models get
///         them times spring_material's modulus over the material's, in which every method is linear. Empty
///         springs: smoothed models alone.
struct BodySetup {
  TetMesh mesh;
  BoundaryProblem holding;  ///< material, supports and held faces; its loads are not there
  SpringNetwork springs;
  double damping_stiffness_s = 0.0;  ///< Rayleigh's shares
  double damping_mass_per_s = 0.0;
};

/// Which model moves it, and how.
struct ModelChoice {
  bool is_smoothed = false;             ///< smoothed elements; else springs
  dynamics::SpringModelOptions spring;  ///< of springs; `strain` of both
  dynamics::BlendOptions blend;         ///< of smoothed elements
  dynamics::IntegratorKind integrator = dynamics::IntegratorKind::kSymplecticEuler;
};

/// The body as it stands.
struct LiveReport {
  double time_s = 0.0;
  double kinetic_j = 0.0;
  double elastic_j = 0.0;
  double load_j = 0.0;  ///< of supports and pad
  Vec3 pad_force_n;     ///< of the pad on the body
  double largest_m = 0.0;
  std::size_t inverted = 0;  ///< tets that are not positive
  bool is_broken = false;    ///< a displacement is not finite or beyond twice the body's longest side
  Index vertex = kNoIndex;   ///< broken: the first that is not finite, else the farthest; inverted: of the
                             ///< first inverted tet the vertex that moved farthest
};

/// A body under a finger.
class LiveBody {
 public:
  /// Throws: InputError for a material, a model or an option that does not fit; as validate(MotionModel).
  LiveBody(const BodySetup& setup, const ModelChoice& choice);

  /// Puts an elastic pad on the skin around a vertex, in the place of the one before; it does not move yet.
  /// Throws: InputError for a vertex that is not of the skin, a radius or a stiffness that is not above zero.
  void press(Index vertex, double radius_m, double stiffness_pa_per_m);
  /// The same pad slides: it now holds the skin around another vertex, moved as far as it was. What both
  /// places have in common feels nothing of it. Throws: as press; without a pad, too.
  void slide(Index vertex, double radius_m, double stiffness_pa_per_m);
  /// Where the pad is to go, from where it was put: it moves there at `speed_m_s` of simulated time.
  void aim(const Vec3& by_m, double speed_m_s);
  /// Takes the pad away.
  void release();

  /// Takes up to `steps` steps, or none once it is broken. Returns: whether it is whole.
  /// Throws: InputError for a step that is not a finite number above zero.
  bool step(double step_s, std::uint64_t steps);

  /// Back to rest, whole, without a pad.
  void reset();

  const FacePatch& pad() const { return pad_; }
  const Vec3& pad_by_m() const { return by_m_; }
  const dynamics::MotionState& state() { return stepper_->state(); }
  /// Linear time: an evaluation of all energies.
  LiveReport report();
  const StepperChoice& stepper() const { return stepper_choice_; }
  const dynamics::MotionModel& model() const { return model_; }
  const std::vector<Triangle>& skin() const { return skin_; }

  /// The longest stable step at rest, predicted, with a pad of that stiffness on all of the skin: it then
  /// holds for a pad anywhere on it. 0 for no pad. Infinite for implicit integrators.
  dynamics::StableStep predict_step(double pad_pa_per_m) const;

 private:
  void put_pad(Index vertex, double radius_m, double stiffness_pa_per_m);

  std::vector<Triangle> skin_;
  dynamics::MotionModel model_;  ///< its second group of loads is the pad's
  ModelChoice choice_;
  StepperChoice stepper_choice_;
  std::unique_ptr<PadStepper> stepper_;
  FacePatch pad_;
  Vec3 by_m_;
  Vec3 aim_m_;
  double speed_m_s_ = 0.0;
  double escape_m_ = 0.0;
  bool is_broken_ = false;
};

}  // namespace palpate::live
