#include "reference/reduced/modes/modal_options.h"

#include <vector>

#include "core/base/error.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

using nlohmann::json;

ModalBodyOptions take_modal_options(json& left) {
  ModalBodyOptions options;
  options.order = take_choice(left, "elements", {"p2", "p1"}) == 0 ? 2 : 1;
  options.modal.modes = static_cast<std::size_t>(take_whole(left, "modes", 1, 1000, 60));
  options.modal.correction = take_option<bool>(left, "correction", &json::is_boolean, "true or false", true);
  const std::vector<std::string> factors{"auto", "cholmod", "eigen"};
  options.factor = factors[take_choice(left, "factor", factors)];
  return options;
}

void refuse_large(StrainSize strain, const std::string& method) {
  if (strain == StrainSize::kLarge) throw InputError("strain", 0, "small: " + method + " is linear", "large");
}

void note_large(StrainSize strain, const std::string& method, Response& response) {
  if (strain == StrainSize::kLarge)
    response.notes.push_back(method + " is linear: large strains and rotations are taken for small ones");
}

}  // namespace palpate::reference
