// Adapter of our own simplifiers: one line a method.
#include <array>
#include <string>

#include "core/base/error.h"
#include "reference/palpate/methods.h"

namespace {

using namespace palpate::reference;

struct Method {
  const char* name;
  Response (*run)(const Request&);
};

constexpr std::array kMethods{
    Method{"palpate.hierarchical", run_hierarchical},
    Method{"palpate.outcome", run_outcome},
    Method{"palpate.refined", run_refined},
    Method{"palpate.surface", run_surface},
};

Response run(const Request& request) {
  std::string names;
  for (const Method& method : kMethods) {
    if (request.method == method.name) return method.run(request);
    names += names.empty() ? method.name : std::string(" or ") + method.name;
  }
  throw palpate::InputError("method", 0, names, request.method);
}

}  // namespace

int main(int argc, char** argv) {
  return run_adapter(argc, argv, run, TakesKeep::kYes);
}
