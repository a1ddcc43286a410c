// A dynamic scene on its mesh as what goes through the door: a motion problem, or a whole moving body.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/scene.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {

/// Options of springs.* and smoothed.* that say how a static answer is solved or measured: no part of a
/// model.
inline constexpr std::array kStaticOptions{"load_steps", "max_iterations", "tolerance",
                                           "solver",     "cost",           "step_cost"};

/// What moves a placed scene: what holds it, each load by itself with its times, Rayleigh's damping,
/// duration, samples, and the vertices nearest to its probes. Masses, damping and steps of the scene's own
/// are not in it. Throws: InputError as resolve_problem does.
reference::MotionProblem build_motion_problem(const Scene& placed, const TetMesh& mesh);

/// What has no use in a motion, a line each: a load that begins after its end, a solver of steps that iterate
/// nothing, a safety of a given step, damping of springs that the model does not have. Throws: InputError for
/// a step longer than the motion, or a probe that is outside of the body by more than its longest edge.
std::vector<std::string> check_moving_scene(const Scene& placed, const TetMesh& mesh);

/// The same with the scene's model and how it is stepped. What a preset stands for is written out. Throws:
/// InputError also for a scene without a model, with one that does not move, or with options of a static
/// analysis.
reference::MovingBody build_moving_body(const Scene& placed, const TetMesh& mesh, const Registry& registry);

}  // namespace palpate::experiments
