#include "reference/bullet/soft_body.h"

#include <BulletSoftBody/btSoftBody.h>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

btVector3 narrow(const Vec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

}  // namespace

struct BulletBody::Body {
  btSoftBodyWorldInfo world;
  std::unique_ptr<btSoftBody> soft;
};

BulletBody::BulletBody(std::span<const Vec3> points, const SpringNetwork& net,
                       std::span<const double> mass_kg, const BulletOptions& options)
    : body_(std::make_unique<Body>()) {
  require(points.size() == mass_kg.size(), "one mass a point");
  btAlignedObjectArray<btVector3> at;
  btAlignedObjectArray<btScalar> mass;
  at.reserve(static_cast<int>(points.size()));
  mass.reserve(static_cast<int>(points.size()));
  for (std::size_t v = 0; v < points.size(); ++v) {
    at.push_back(narrow(points[v]));
    mass.push_back(static_cast<btScalar>(mass_kg[v]));
  }
  body_->world.m_gravity.setZero();
  body_->world.air_density = 0;
  body_->soft = std::make_unique<btSoftBody>(&body_->world, at.size(), &at[0], &mass[0]);
  btSoftBody& soft = *body_->soft;
  soft.m_materials[0]->m_kLST = static_cast<btScalar>(options.stiffness);
  soft.m_links.reserve(static_cast<int>(net.springs.size()));
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    soft.appendLink(static_cast<int>(net.springs[s][0]), static_cast<int>(net.springs[s][1]),
                    soft.m_materials[0]);
    soft.m_links[soft.m_links.size() - 1].m_rl = static_cast<btScalar>(net.rest_length_m[s]);
  }
  soft.updateLinkConstants();
  for (int k = 0; k < soft.m_links.size(); ++k)
    soft.m_links[k].m_c1 = soft.m_links[k].m_rl * soft.m_links[k].m_rl;
  soft.m_cfg.piterations = options.iterations;
  soft.m_cfg.viterations = 0;
  soft.m_cfg.diterations = 0;
  soft.m_cfg.citerations = 0;
  soft.m_cfg.collisions = 0;
  soft.m_cfg.kDP = static_cast<btScalar>(options.damping);
}

BulletBody::~BulletBody() = default;
BulletBody::BulletBody(BulletBody&&) noexcept = default;
BulletBody& BulletBody::operator=(BulletBody&&) noexcept = default;

void BulletBody::set_velocities(std::span<const Vec3> velocity_m_s) {
  btSoftBody& soft = *body_->soft;
  require(velocity_m_s.size() == static_cast<std::size_t>(soft.m_nodes.size()), "one velocity a point");
  for (int k = 0; k < soft.m_nodes.size(); ++k)
    soft.m_nodes[k].m_v = narrow(velocity_m_s[static_cast<std::size_t>(k)]);
}

std::vector<Vec3> BulletBody::positions() const {
  const btSoftBody& soft = *body_->soft;
  std::vector<Vec3> out(static_cast<std::size_t>(soft.m_nodes.size()));
  for (int k = 0; k < soft.m_nodes.size(); ++k) {
    const btVector3& x = soft.m_nodes[k].m_x;
    out[static_cast<std::size_t>(k)] = {x.x(), x.y(), x.z()};
  }
  return out;
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
