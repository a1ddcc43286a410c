// Adapter of reduced.compliance and reduced.modal.
#include "reference/reduced/compliance_run.h"

int main(int argc, char** argv) {
  using namespace palpate::reference;
  return run_adapter(argc, argv, [](const Request& request) { return run_compliance(request); });
}
