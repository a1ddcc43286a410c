// Adapter of the engine in motion, for the contest stability.
#include "reference/extremes/extreme_run.h"

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::run_extreme);
}
