// Prints experiments/schema/plan.schema.json as it is to be:
//   build/release/bin/print_plan_schema > experiments/schema/plan.schema.json
#include <exception>
#include <iostream>

#include "experiments/files/places.h"
#include "experiments/runner/plan_schema.h"
#include "reference/door/json_file.h"

int main() {
  using namespace palpate;
  try {
    const std::string file = experiments::source_folder() + "/experiments/schema/plan_values.json";
    const std::string text = reference::read_text_file(file, std::size_t{1} << 20U);
    std::cout << experiments::write_plan_schema(reference::parse_ordered_json(text, file));
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
