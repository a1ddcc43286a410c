// Adapter of our own springs and smoothed finite elements, at rest and in motion; and springs' constants for
// who asks.
#include "reference/springs/identify_run.h"
#include "reference/springs/model_run.h"
#include "reference/springs/motion_run.h"
#include "reference/springs/training_run.h"

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) {
    if (request.contest == "springs") return run_identification(request);
    if (request.contest == "training") return run_training(request);
    return request.contest == "motion" ? run_motion_request(request) : run_model(request);
  });
}
