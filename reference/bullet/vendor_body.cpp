#include "reference/bullet/vendor_body.h"

#include <BulletSoftBody/btSoftBody.h>

#include "core/base/error.h"

namespace palpate::reference::bullet {
namespace {

/// The nearest vector of single precision.
btVector3 narrow(const Vec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

}  // namespace

std::unique_ptr<btSoftBody> build_soft_body(std::span<const Vec3> points, const SpringNetwork& net,
                                            std::span<const double> mass_kg, btSoftBodyWorldInfo& world) {
  require(points.size() == mass_kg.size(), "one mass a point");
  world.m_gravity.setZero();
  world.air_density = 0;
  btAlignedObjectArray<btVector3> at;
  btAlignedObjectArray<btScalar> mass;
  at.reserve(static_cast<int>(points.size()));
  mass.reserve(static_cast<int>(points.size()));
  for (std::size_t v = 0; v < points.size(); ++v) {
    at.push_back(narrow(points[v]));
    mass.push_back(static_cast<btScalar>(mass_kg[v]));
  }
  auto soft = std::make_unique<btSoftBody>(&world, at.size(), &at[0], &mass[0]);
  soft->m_links.reserve(static_cast<int>(net.springs.size()));
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    soft->appendLink(static_cast<int>(net.springs[s][0]), static_cast<int>(net.springs[s][1]),
                     soft->m_materials[0]);
    soft->m_links[soft->m_links.size() - 1].m_rl = static_cast<btScalar>(net.rest_length_m[s]);
  }
  soft->m_cfg.collisions = 0;
  return soft;
}

void set_velocities(std::span<const Vec3> velocity_m_s, btSoftBody& soft) {
  require(velocity_m_s.size() == static_cast<std::size_t>(soft.m_nodes.size()), "one velocity a point");
  for (int k = 0; k < soft.m_nodes.size(); ++k)
    soft.m_nodes[k].m_v = narrow(velocity_m_s[static_cast<std::size_t>(k)]);
}

std::vector<Vec3> read_positions(const btSoftBody& soft) {
  std::vector<Vec3> out(static_cast<std::size_t>(soft.m_nodes.size()));
  for (int k = 0; k < soft.m_nodes.size(); ++k) {
    const btVector3& x = soft.m_nodes[k].m_x;
    out[static_cast<std::size_t>(k)] = {x.x(), x.y(), x.z()};
  }
  return out;
}

}  // namespace palpate::reference::bullet
