// Adapter of sequential TetFusion.
#include "core/base/error.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/fusion_run.h"
#include "reference/tetfusion/sequential.h"

namespace {

using namespace palpate;

reference::SequentialOptions read_options(const reference::Request& request) {
  nlohmann::json left = request.options;
  if (!left.contains("skip_touched")) left["skip_touched"] = true;
  reference::SequentialOptions options;
  options.common = reference::take_fusion_options(request.stop, left);
  constexpr std::array kOrders{reference::ScanOrder::kIndex, reference::ScanOrder::kReverse,
                               reference::ScanOrder::kRandom};
  options.order = kOrders[reference::take_choice(left, "order", {"index", "reverse", "random"})];
  options.many_passes = reference::take_choice(left, "passes", {"one", "many"}) == 1;
  if (const auto seed = left.find("seed"); seed != left.end()) {
    if (!seed->is_number_unsigned()) throw InputError("seed", 0, "a whole number, 0 or more", seed->dump());
    options.seed = seed->get<std::uint64_t>();
    left.erase(seed);
  }
  reference::require_all_taken(left);
  return options;
}

reference::Response run(const reference::Request& request) {
  if (request.method != "tetfusion.sequential") {
    throw InputError("method", 0, "tetfusion.sequential", request.method);
  }
  const reference::SequentialOptions options = read_options(request);
  return reference::run_fusion(
      request, [&](TetMesh& mesh) { return reference::simplify_sequentially(mesh, options); });
}

}  // namespace

int main(int argc, char** argv) {
  return reference::run_adapter(argc, argv, run);
}
