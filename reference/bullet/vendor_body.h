// A spring network as Bullet's own soft body: its nodes and links. For the two bodies of this folder
// alone, which include the vendor's headers.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/spring_network.h"

class btSoftBody;
struct btSoftBodyWorldInfo;

namespace palpate::reference::bullet {

/// One node a point, one link a spring with its rest length, both in their order; no collisions, no gravity.
/// It needs `world` as long as it lives. Throws: ContractError unless there is one mass a point.
std::unique_ptr<btSoftBody> build_soft_body(std::span<const Vec3> points, const SpringNetwork& net,
                                            std::span<const double> mass_kg, btSoftBodyWorldInfo& world);

/// Velocities of the nodes, in m/s. Throws: ContractError unless there is one a node.
void set_velocities(std::span<const Vec3> velocity_m_s, btSoftBody& soft);

/// Positions of the nodes, in m.
std::vector<Vec3> read_positions(const btSoftBody& soft);

}  // namespace palpate::reference::bullet
