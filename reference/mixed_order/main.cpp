// Adapter of the methods that spend their unknowns where the error lives.
#include "core/base/error.h"
#include "reference/mixed_order/graded_run.h"
#include "reference/mixed_order/modes_run.h"
#include "reference/mixed_order/quadratic_run.h"

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) {
    if (request.method == "fem.p2_patch" || request.method == "fem.p2_coarse") return run_quadratic(request);
    if (request.method == "fem.p1_modes") return run_modes(request);
    if (request.method == "graded.edge_node") return run_graded(request);
    throw palpate::InputError("method", 0, "fem.p2_patch, fem.p2_coarse, fem.p1_modes or graded.edge_node",
                              request.method);
  });
}
