// A body of the contest stability: a mesh, springs, masses and damping as a request sets them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/motion/motion_model.h"
#include "reference/extremes/extreme_mesh.h"

namespace palpate::reference {

enum class ExtremeDamping { kNone, kStiffness, kMass, kAxial, kIsotropic, kDrag };

/// What is asked of the body.
struct ExtremeBody {
  ExtremeMesh mesh;
  bool is_held = true;
  std::string springs = "uniform";
  std::string volume = "none";
  double poisson_ratio = 0.25;
  double stiffness_factor = 1.0;
  double mass_factor = 1.0;
  double mass_ratio = 1.0;
  ExtremeDamping damping = ExtremeDamping::kAxial;
  double damping_ratio = 0.05;
};

/// Takes the body's options out of `options`. Throws: InputError for a wrong type or a value out of range.
ExtremeBody take_extreme_body(nlohmann::json& options);

/// A body that can be moved, and what there is to say of it: "vertices", "tets", "springs",
/// "min_dihedral_deg", "flattened_tets", "rate_per_s" (see below), "mass_ratio", "volume_ratio".
struct BuiltBody {
  dynamics::MotionModel model;
  double size_m = 0.0;  ///< longest side
  nlohmann::json report;
};

/// Young's modulus 10 kPa, density 1050 kg/m^3, large strain. With w the root of the largest row sum of
/// |M^-1 K| of the body without factors (an upper bound on its fastest motion), k and m its mean spring
/// constant and mass, and z the damping ratio:
///
///   stiffness        springs 2 z / w x their constant, strain terms alike
///   mass             vertices 2 z w x their mass
///   axial, isotropic all springs 2 z k / w
///   drag             all vertices 2 z w m
///
/// Throws: InputError for a mesh with flat tets or a setting that the model refuses.
BuiltBody build_extreme_body(const TetMesh& mesh, const ExtremeBody& wanted);

}  // namespace palpate::reference
