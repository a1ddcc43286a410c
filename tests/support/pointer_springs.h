// The engine as the thesis describes it (section 4.2.1): objects of vertices and springs that point to each
// other. What ours is measured against; it lives in tests, since nothing else should use it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/dynamics/motion/motion_model.h"

namespace palpate::testing_support {

template <typename Real>
struct PointerVector {
  Real x = 0;
  Real y = 0;
  Real z = 0;
};

/// The thesis's CVertex3D, with all that it keeps in a vertex, whether a step needs it or not.
template <typename Real>
struct PointerVertex {
  PointerVector<Real> position;
  PointerVector<Real> normal;
  std::vector<PointerVertex*> neighbours;
  std::vector<Real> spring_lengths;
  std::vector<int> spring_numbers;
  PointerVector<Real> velocity;
  PointerVector<Real> force;
  Real influence_volume = 0;
  Real mass = 1;
  Real drag = 0;
};

/// The thesis's CSpring3D; its ends are objects.
template <typename Real>
struct PointerSpring {
  int number = 0;
  PointerVertex<Real>* first = nullptr;
  PointerVertex<Real>* second = nullptr;
  Real stiffness = 0;
  Real rest_length = 0;
  Real damping = 0;
  Real alpha = 0;  ///< angles of the rest shape
  Real beta = 0;
};

/// How objects lie in memory: as they are made one after another, or at random.
enum class ObjectOrder { kAsMade, kShuffled };

/// The thesis's CMesh3D: arrays of pointers to objects that each have storage of their own. Springs with
/// axial damping, environment damping, symplectic Euler; no loads.
template <typename Real>
class PointerBody {
 public:
  /// Requires: a model of springs with axial damping alone, without loads.
  PointerBody(const dynamics::MotionModel& model, ObjectOrder order, std::uint64_t seed = 1);

  void set_state(const dynamics::MotionState& state);
  dynamics::MotionState state() const;
  void step(double step_s, std::uint64_t steps);

 private:
  void add_spring_forces();
  void update(Real h);

  std::vector<Vec3> rest_;
  std::vector<std::unique_ptr<PointerVertex<Real>>> vertices_;
  std::vector<std::unique_ptr<PointerSpring<Real>>> springs_;
  double time_s_ = 0.0;
};

extern template class PointerBody<float>;
extern template class PointerBody<double>;

}  // namespace palpate::testing_support
