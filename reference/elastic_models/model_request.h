// The method and options of springs.* and smoothed.* as an elastic model.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/dynamics/elasticity/volume_models.h"
#include "core/springs/identification/identify.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// What a method's springs come from, and what is added to them.
struct SpringRequest {
  std::optional<springs::SpringMethod> method;  ///< nothing: from a file
  std::string file;
  std::string moduli_file;  ///< beside `file`; empty: none
  springs::IdentifyOptions identify;
  bool calibrate = false;
  std::optional<double> mean_n_per_m;  ///< all springs times one factor, so that their mean is this
  dynamics::SpringModelOptions model;
};

/// A model that a method and its options ask for: springs, or smoothed elements.
struct ModelRequest {
  std::optional<SpringRequest> springs;
  dynamics::BlendOptions blend;  ///< without springs
  std::string frozen_file;       ///< palpate/frozen/1; empty: none of it is frozen
};

/// Takes what makes the model out of `options`; what says how to solve stays. Throws: InputError for an
/// unknown method or a bad value.
ModelRequest take_model_request(const std::string& method, StrainSize strain, nlohmann::json& options);

/// The frozen vertices of a request; none without a file. Throws: InputError for a file that is not as it
/// should be, or of another mesh.
std::vector<Index> read_frozen(const ModelRequest& wanted, const TetMesh& mesh);

/// Builds the model, without what read_frozen says. The report gets identify_s and the figures of identified
/// springs, the notes its warnings. Throws: InputError for a ratio that the model cannot represent, or a
/// springs file that does not fit.
dynamics::BuiltModel build_requested_model(const TetMesh& mesh, const Material& material,
                                           const ModelRequest& wanted, Response& response);

}  // namespace palpate::reference
