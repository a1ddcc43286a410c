// A spring network as a soft body of the Bullet physics library: what a step of it costs.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/spring_network.h"

namespace palpate::reference {

struct BulletOptions {
  int iterations = 1;      ///< sweeps over all links a step
  double stiffness = 1.0;  ///< the share of a link's elongation that a sweep corrects, in (0, 1]
  double damping = 0.0;    ///< the share of its velocity that a node loses a step, in [0, 1]
};

/// One node a point, one link a spring with the spring's rest length. Not equal to a spring in N/m: a link is
/// a constraint of position that each sweep corrects by a share, one link after another, so that stiffness
/// depends on the step and on the number of sweeps. Single precision, one thread, no gravity, no collisions.
class BulletBody {
 public:
  /// Requires: one mass > 0 a point.
  BulletBody(std::span<const Vec3> points, const SpringNetwork& net, std::span<const double> mass_kg,
             const BulletOptions& options);
  ~BulletBody();
  BulletBody(BulletBody&&) noexcept;
  BulletBody& operator=(BulletBody&&) noexcept;

  void set_velocities(std::span<const Vec3> velocity_m_s);
  std::vector<Vec3> positions() const;

  /// Prediction, sweeps over the links, and velocities from the positions, as Bullet's world does them.
  void step(double step_s);

  /// The sweeps of a step alone.
  void sweep_links();

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

}  // namespace palpate::reference
