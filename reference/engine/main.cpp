// Our engine on bodies that move: the contestant engine.*.
#include <csignal>

#include "reference/engine/engine_request.h"

namespace {

volatile std::sig_atomic_t stop_flag = 0;

extern "C" void raise_flag(int /*signal*/) {
  stop_flag = 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, raise_flag);  // what was computed until then is written
  return palpate::reference::run_adapter(argc, argv, [](const palpate::reference::Request& request) {
    return palpate::reference::answer_engine_request(request, &stop_flag);
  });
}
