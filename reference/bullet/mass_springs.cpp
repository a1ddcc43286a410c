#include "reference/bullet/mass_springs.h"

#include <BulletSoftBody/btDeformableMassSpringForce.h>

#include "reference/bullet/vendor_body.h"

namespace palpate::reference {

struct BulletSprings::Body {
  btSoftBodyWorldInfo world;
  std::unique_ptr<btSoftBody> soft;
  btDeformableMassSpringForce springs;
  btAlignedObjectArray<btVector3> impulse;  ///< zero between steps

  explicit Body(const BulletSpringOptions& options)
      : springs(static_cast<btScalar>(options.stiffness_n_per_m),
                static_cast<btScalar>(options.damping_n_s_per_m), true) {}
};

BulletSprings::BulletSprings(std::span<const Vec3> points, const SpringNetwork& net,
                             std::span<const double> mass_kg, const BulletSpringOptions& options)
    : body_(std::make_unique<Body>(options)) {
  body_->soft = bullet::build_soft_body(points, net, mass_kg, body_->world);
  btSoftBody& soft = *body_->soft;
  for (int k = 0; k < soft.m_nodes.size(); ++k) soft.m_nodes[k].index = k;  // where its force stands
  body_->springs.addSoftBody(&soft);
  body_->impulse.resize(soft.m_nodes.size(), btVector3(0, 0, 0));
}

BulletSprings::~BulletSprings() = default;
BulletSprings::BulletSprings(BulletSprings&&) noexcept = default;
BulletSprings& BulletSprings::operator=(BulletSprings&&) noexcept = default;

void BulletSprings::set_velocities(std::span<const Vec3> velocity_m_s) {
  bullet::set_velocities(velocity_m_s, *body_->soft);
}

std::vector<Vec3> BulletSprings::positions() const {
  return bullet::read_positions(*body_->soft);
}

std::vector<Vec3> BulletSprings::forces() const {
  btAlignedObjectArray<btVector3>& sum = body_->impulse;
  body_->springs.addScaledForces(1, sum);
  std::vector<Vec3> out;
  out.reserve(static_cast<std::size_t>(sum.size()));
  for (int k = 0; k < sum.size(); ++k) {
    out.push_back({sum[k].x(), sum[k].y(), sum[k].z()});
    sum[k].setZero();
  }
  return out;
}

void BulletSprings::step(double step_s) {
  const auto dt = static_cast<btScalar>(step_s);
  btAlignedObjectArray<btVector3>& impulse = body_->impulse;
  body_->springs.addScaledForces(dt, impulse);
  btSoftBody& soft = *body_->soft;
  for (int k = 0; k < soft.m_nodes.size(); ++k) {
    btSoftBody::Node& node = soft.m_nodes[k];
    node.m_v += node.m_im * impulse[k];
    node.m_x += dt * node.m_v;
    node.m_q = node.m_x;  // the vendor's stiffness reads the one, its damping the other
    impulse[k].setZero();
  }
}

}  // namespace palpate::reference
