// The engine of this program behind the door of the contest `engine`.
#include "experiments/simulation/engine_answer.h"
#include "reference/door/adapter.h"

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::experiments::answer_engine_request);
}
