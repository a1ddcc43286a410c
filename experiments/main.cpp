// The program behind ./palpate.
#include "experiments/commands/commands.h"

int main(int argc, char** argv) {
  return palpate::experiments::run_command_line(argc, argv);
}
