#include "reference/bullet/soft_body.h"

#include <BulletSoftBody/btSoftBody.h>

#include "reference/bullet/vendor_body.h"

namespace palpate::reference {

struct BulletBody::Body {
  btSoftBodyWorldInfo world;
  std::unique_ptr<btSoftBody> soft;
};

BulletBody::BulletBody(std::span<const Vec3> points, const SpringNetwork& net,
                       std::span<const double> mass_kg, const BulletOptions& options)
    : body_(std::make_unique<Body>()) {
  body_->soft = bullet::build_soft_body(points, net, mass_kg, body_->world);
  btSoftBody& soft = *body_->soft;
  soft.m_materials[0]->m_kLST = static_cast<btScalar>(options.stiffness);
  soft.updateLinkConstants();
  for (int k = 0; k < soft.m_links.size(); ++k)
    soft.m_links[k].m_c1 = soft.m_links[k].m_rl * soft.m_links[k].m_rl;
  soft.m_cfg.piterations = options.iterations;
  soft.m_cfg.viterations = 0;
  soft.m_cfg.diterations = 0;
  soft.m_cfg.citerations = 0;
  soft.m_cfg.kDP = static_cast<btScalar>(options.damping);
}

BulletBody::~BulletBody() = default;
BulletBody::BulletBody(BulletBody&&) noexcept = default;
BulletBody& BulletBody::operator=(BulletBody&&) noexcept = default;

void BulletBody::set_velocities(std::span<const Vec3> velocity_m_s) {
  bullet::set_velocities(velocity_m_s, *body_->soft);
}

std::vector<Vec3> BulletBody::positions() const {
  return bullet::read_positions(*body_->soft);
}

void BulletBody::step(double step_s) {
  btSoftBody& soft = *body_->soft;
  soft.predictMotion(static_cast<btScalar>(step_s));
  soft.solveConstraints();
  soft.integrateMotion();
}

void BulletBody::sweep_links() {
  btSoftBody& soft = *body_->soft;
  for (int k = 0; k < soft.m_cfg.piterations; ++k) btSoftBody::PSolve_Links(&soft, 1, 0);
}

}  // namespace palpate::reference
