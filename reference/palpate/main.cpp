// Adapter of our own simplifiers.
#include <array>
#include <string_view>

#include "core/base/error.h"
#include "core/simplify/hierarchical.h"
#include "reference/fusion_options.h"
#include "reference/palpate/refined_run.h"
#include "reference/palpate/surface_run.h"

namespace {

using namespace palpate;

reference::Response run_hierarchical(const reference::Request& request) {
  nlohmann::json left = request.options;
  const simplify::SimplifyOptions options = reference::take_fusion_options(request.stop, left);
  reference::require_all_taken(left);
  return reference::run_fusion(request,
                               [&](TetMesh& mesh) { return simplify::simplify_hierarchical(mesh, options); });
}

struct Method {
  std::string_view name;
  reference::Response (*run)(const reference::Request& request);
};

constexpr std::array kMethods{
    Method{"palpate.hierarchical", run_hierarchical},
    Method{"palpate.refined", reference::run_refined},
    Method{"palpate.surface", reference::run_surface},
};

reference::Response run(const reference::Request& request) {
  std::string names;
  for (const Method& method : kMethods) {
    if (request.method == method.name) return method.run(request);
    names += (names.empty() ? "" : ", ") + std::string(method.name);
  }
  throw InputError("method", 0, "one of " + names, request.method);
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, run);
}
