// What all methods of modes are asked for.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/reduced/modal_phase.h"
#include "core/mesh/boundary_problem.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// The finite elements and their modes.
struct ModalBodyOptions {
  int order = 2;
  std::string factor;
  dynamics::ModalOptions modal;
};

/// Takes elements, modes, correction and factor. Throws: InputError.
ModalBodyOptions take_modal_options(nlohmann::json& left);

/// Throws: InputError for large strain.
void refuse_large(StrainSize strain, const std::string& method);

/// Of a large strain, notes that it is taken for a small one.
void note_large(StrainSize strain, const std::string& method, Response& response);

}  // namespace palpate::reference
