#include "live/body/live_body.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "live/body/pad.h"

namespace palpate::live {
namespace {

using dynamics::BuiltModel;
using dynamics::MotionModel;
using dynamics::MotionState;

/// The springs for a volume model: those of the material, times the modulus that is theirs there.
SpringNetwork scaled_springs(const BodySetup& setup, dynamics::VolumeModel volume) {
  if (setup.springs.springs.empty()) throw InputError("model", 0, "a body with springs", "none");
  const Material& material = setup.holding.material;
  const double factor = spring_material(material, volume).young_modulus_pa / material.young_modulus_pa;
  SpringNetwork net = setup.springs;
  for (double& stiffness : net.stiffness_n_per_m) stiffness *= factor;
  return net;
}

/// Springs of nothing else turn with the body whatever the strain: the plain engine takes those alone.
BuiltModel build_elastic(const BodySetup& setup, const ModelChoice& choice) {
  const Material& material = setup.holding.material;
  if (choice.is_smoothed) return build_blend_model(setup.mesh, material, choice.blend);
  return build_spring_model(setup.mesh, scaled_springs(setup, choice.spring.volume), material, choice.spring);
}

MotionModel build_model(const BodySetup& setup, const ModelChoice& choice) {
  MotionModel model;
  model.tets = setup.mesh.tets;
  model.elastic = build_elastic(setup, choice).model;
  model.mass_kg = dynamics::build_lumped_masses(setup.mesh, setup.holding.material.density_kg_m3);
  for (const double k : model.elastic.springs.stiffness_n_per_m) {
    if (setup.damping_stiffness_s > 0.0)
      model.spring_damping_n_s_per_m.push_back(setup.damping_stiffness_s * k);
  }
  if (!model.elastic.strain_terms.empty()) model.strain_damping_s = setup.damping_stiffness_s;
  for (const double m : model.mass_kg) {
    if (setup.damping_mass_per_s > 0.0)
      model.environment_damping_n_s_per_m.push_back(setup.damping_mass_per_s * m);
  }
  BoundaryProblem holding = setup.holding;
  holding.gravity_m_s2 = {};
  holding.tractions.clear();
  holding.nodal_forces.clear();
  model.loads.push_back({dynamics::build_loads(setup.mesh, holding), {}});
  model.loads.push_back({dynamics::build_loads(setup.mesh, {}), {}});
  validate(model);
  return model;
}

}  // namespace

LiveBody::LiveBody(const BodySetup& setup, const ModelChoice& choice)
    : skin_(build_boundary(setup.mesh)), model_(build_model(setup, choice)), choice_(choice) {
  escape_m_ = 2.0 * longest_side(bounding_box(setup.mesh.points));
  stepper_ = make_pad_stepper(model_, choice.integrator, escape_m_, stepper_choice_);
}

void LiveBody::press(Index vertex, double radius_m, double stiffness_pa_per_m) {
  put_pad(vertex, radius_m, stiffness_pa_per_m);
  by_m_ = aim_m_ = {};
}

void LiveBody::slide(Index vertex, double radius_m, double stiffness_pa_per_m) {
  if (pad_.faces.empty()) throw InputError("pad", 0, "a pad that is on the skin", "none");
  put_pad(vertex, radius_m, stiffness_pa_per_m);
  for (dynamics::SupportFace& face : model_.loads.back().loads.supports) face.by_m = by_m_;
  stepper_->move_pad(by_m_);
}

void LiveBody::put_pad(Index vertex, double radius_m, double stiffness_pa_per_m) {
  if (!(radius_m > 0.0) || !(stiffness_pa_per_m > 0.0) || !std::isfinite(radius_m + stiffness_pa_per_m))
    throw InputError("pad", 0, "a radius and a stiffness above zero", "something else");
  const std::vector<Vec3>& rest = model_.elastic.rest;
  const Vec3 outward = skin_normal(rest, skin_, vertex);
  pad_ = find_pad(rest, skin_, rest[vertex], outward, radius_m);
  model_.loads.back().loads.supports = pad_faces(rest, pad_, stiffness_pa_per_m);
  const std::vector<dynamics::SupportFace> faces = model_.loads.back().loads.supports;
  stepper_->set_pad(faces);
}

void LiveBody::aim(const Vec3& by_m, double speed_m_s) {
  if (!is_finite(by_m) || !(speed_m_s > 0.0))
    throw InputError("pad", 0, "a finite place and a speed above zero", "something else");
  aim_m_ = by_m;
  speed_m_s_ = speed_m_s;
}

void LiveBody::release() {
  pad_ = {};
  by_m_ = aim_m_ = {};
  model_.loads.back().loads.supports.clear();
  stepper_->set_pad({});
}

bool LiveBody::step(double step_s, std::uint64_t steps) {
  if (!(step_s > 0.0) || !std::isfinite(step_s))
    throw InputError("step_s", 0, "a finite number above zero", std::to_string(step_s));
  while (steps > 0 && !is_broken_) {
    std::uint64_t now = steps;
    const Vec3 way = aim_m_ - by_m_;
    const double left = length(way);
    if (left > 0.0 && !pad_.faces.empty()) {
      const double reach = speed_m_s_ * step_s;
      by_m_ = left <= reach ? aim_m_ : by_m_ + (reach / left) * way;
      for (dynamics::SupportFace& face : model_.loads.back().loads.supports) face.by_m = by_m_;
      stepper_->move_pad(by_m_);
      now = 1;
    }
    is_broken_ = !stepper_->step(step_s, now);
    steps -= now;
  }
  return !is_broken_;
}

void LiveBody::reset() {
  release();
  is_broken_ = false;
  stepper_->set_state(start_at_rest(model_));
}

LiveReport LiveBody::report() {
  const MotionState& state = stepper_->state();
  LiveReport out;
  out.time_s = state.time_s;
  out.is_broken = is_broken_;
  double farthest_sq = -1.0;
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const double away_sq = length_sq(state.displacement_m[v]);
    const bool is_bad = !std::isfinite(away_sq);
    if (is_bad && is_broken_) {
      out.vertex = static_cast<Index>(v);
      break;
    }
    if (away_sq <= farthest_sq) continue;
    farthest_sq = away_sq;
    if (is_broken_) out.vertex = static_cast<Index>(v);
  }
  out.largest_m = std::sqrt(std::max(0.0, farthest_sq));
  if (is_broken_) return out;
  const dynamics::MotionEnergy energy = measure_energy(model_, state);
  out.kinetic_j = energy.kinetic_j;
  out.elastic_j = energy.elastic_j;
  out.load_j = energy.load_j;
  out.pad_force_n = stepper_->pad_force();
  const dynamics::VolumeCount volume = count_volume(model_, state);
  out.inverted = volume.inverted;
  if (volume.inverted > 0) {
    const Tet& tet = model_.tets[volume.first_inverted];
    out.vertex = *std::max_element(tet.begin(), tet.end(), [&](Index a, Index b) {
      return length_sq(state.displacement_m[a]) < length_sq(state.displacement_m[b]);
    });
  }
  return out;
}

dynamics::StableStep LiveBody::predict_step(double pad_pa_per_m) const {
  MotionModel padded = model_;
  const FacePatch all{skin_, std::vector<double>(skin_.size(), 1.0)};
  padded.loads.back().loads.supports.clear();
  if (pad_pa_per_m > 0.0)
    padded.loads.back().loads.supports = pad_faces(model_.elastic.rest, all, pad_pa_per_m);
  return predict_stable_step(padded, choice_.integrator);
}

}  // namespace palpate::live
