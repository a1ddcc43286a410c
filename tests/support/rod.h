// A rod between smooth walls: it can move along x alone, so that all of it is known in closed form.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "reference/door/motion_problem.h"

namespace palpate::test {

/// [0, length] x [0, width]^2 of `cells` x 2 x 2 cells. All of the sides is held along y and z.
struct Rod {
  static constexpr double kLengthM = 0.1;
  static constexpr double kWidthM = 0.0125;
  static constexpr double kAreaM2 = kWidthM * kWidthM;

  TetMesh mesh;
  reference::MotionProblem problem;  ///< E = 10 kPa, nu = 0.25, 1000 kg/m^3; no loads; probe: x = length

  explicit Rod(int cells);

  std::vector<Triangle> left() const;
  std::vector<Triangle> right() const;
  void hold_left();                                                ///< along x too
  reference::MotionLoad empty_load() const;                        ///< of the same material
  reference::MotionLoad pad(double stiffness, double by_m) const;  ///< on the right end, along x
  reference::MotionLoad sine_force(double force_n_m3) const;       ///< force x sin(pi x / (2 length)) along x
  double modulus_pa() const;  ///< lambda + 2 mu: Young's modulus without sideways strain
  double wave_speed_m_s() const;
};

/// Six cells, damped and held at the left. A pad, three times as stiff as the rod, pushes the right end
/// within 0.3 s: at 1 s springs in series are at rest.
struct PushedRod : Rod {
  static constexpr double kByM = -1e-3;  ///< how far the pad is moved

  PushedRod();

  double stiffness_n_m3() const;               ///< of the rod alone, over its area
  double pad_force_n() const;                  ///< on the rod at the end
  double pad_force_n(double held_n_m3) const;  ///< the same where what holds the left end gives way
};

/// The numbers of one column of a history, one a row; none, and a failure of the test, where there is no such
/// column.
std::vector<double> column(const reference::MotionHistory& history, const std::string& name);

}  // namespace palpate::test
