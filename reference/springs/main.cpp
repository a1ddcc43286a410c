// Adapter of our own springs and smoothed finite elements, at rest and in motion.
#include "reference/springs/model_run.h"
#include "reference/springs/motion_run.h"

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) {
    return request.contest == "motion" ? run_motion_request(request) : run_model(request);
  });
}
