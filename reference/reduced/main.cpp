// Adapter of reduced.compliance, at rest and in the ticks of a haptic loop, reduced.modal, at rest, in
// motion, in such ticks and on whole scenes, and reduced.pod, at rest.
#include <csignal>

#include "reference/reduced/compliance_run.h"
#include "reference/reduced/modes/modal_replay.h"
#include "reference/reduced/modes/modal_run.h"
#include "reference/reduced/pod_run.h"
#include "reference/reduced/tick_run.h"

namespace {

volatile std::sig_atomic_t stop_flag = 0;

extern "C" void raise_flag(int /*signal*/) {
  stop_flag = 1;
}

/// From here on what was computed is written; before, a signal ends the program.
const volatile std::sig_atomic_t* catch_stop() {
  std::signal(SIGINT, raise_flag);
  return &stop_flag;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) {
    if (request.contest == "motion") return run_modal_motion(request);
    if (request.method == "reduced.modal_ticks") return run_modal_ticks(request);
    if (request.method == "reduced.modal_replay") return run_modal_replay(request, catch_stop);
    if (request.contest == "engine") return run_compliance_ticks(request);
    if (request.method == "reduced.pod") return run_pod(request);
    return request.method == "reduced.modal" ? run_modal_at_rest(request) : run_compliance(request);
  });
}
