// A spring network as Bullet's springs in N/m: what an explicit step of it costs.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/spring_network.h"

namespace palpate::reference {

/// One pair of constants holds for all springs of a body: the vendor's class has no more.
struct BulletSpringOptions {
  double stiffness_n_per_m = 1.0;
  double damping_n_s_per_m = 0.0;  ///< along the spring
};

/// One node a point, and Bullet's btDeformableMassSpringForce over one link a spring:
///
///   f_i = (k (|d| - L) + c (w . n)) n,   d = x_j - x_i,  w = v_j - v_i,  n = d / |d|;   f_j = -f_i
///
/// A step is symplectic Euler: the vendor's sweeps over the links for damping and for stiffness, then one
/// over the nodes for velocities and positions. The world, its trees of boxes, contacts and its implicit
/// solver for damping are left out. Single precision, one thread.
class BulletSprings {
 public:
  /// The network's own constants are not used. Requires: one mass > 0 a point.
  BulletSprings(std::span<const Vec3> points, const SpringNetwork& net, std::span<const double> mass_kg,
                const BulletSpringOptions& options);
  ~BulletSprings();
  BulletSprings(BulletSprings&&) noexcept;
  BulletSprings& operator=(BulletSprings&&) noexcept;

  void set_velocities(std::span<const Vec3> velocity_m_s);
  std::vector<Vec3> positions() const;

  /// The force on each node as it is now, in N.
  std::vector<Vec3> forces() const;

  void step(double step_s);

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

}  // namespace palpate::reference
