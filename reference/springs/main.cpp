// Adapter of our own springs and smoothed finite elements.
#include "reference/springs/model_run.h"

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::run_model);
}
