// Adapter of structured lattices, at rest and in motion.
#include "reference/lattices/moving_run.h"
#include "reference/lattices/rest_run.h"

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) {
    return request.contest == "motion" ? run_moving_lattice(request) : run_lattice_at_rest(request);
  });
}
