// Adapter of our own simplifiers.
#include "core/base/error.h"
#include "core/simplify/hierarchical.h"
#include "reference/fusion_options.h"

namespace {

using namespace palpate;

reference::Response run(const reference::Request& request) {
  if (request.method != "palpate.hierarchical") {
    throw InputError("method", 0, "palpate.hierarchical", request.method);
  }
  nlohmann::json left = request.options;
  simplify::SimplifyOptions options = reference::take_fusion_options(request.stop, left);
  options.sizing = reference::take_sizing_options(request.keep, left);
  reference::require_all_taken(left);
  return reference::run_fusion(request,
                               [&](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, options); });
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, run, reference::TakesKeep::kYes);
}
