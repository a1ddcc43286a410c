#include "reference/linear_systems/answer_cost.h"

#include <memory>
#include <vector>

#include "reference/linear_systems/factor.h"

namespace palpate::reference {

AnswerCost measure_cost(const dynamics::BlockMatrix& matrix, const dynamics::SymmetricFactor& factor,
                        std::size_t unknowns) {
  AnswerCost cost;
  cost.unknowns = unknowns;
  cost.stiffness_entries = 9 * matrix.blocks.size();
  cost.factor_entries = factor.entries();
  const std::vector<Vec3> x(matrix.rows(), Vec3{1.0, 2.0, 3.0});
  std::vector<Vec3> y(matrix.rows());
  cost.product_s = median_seconds([&] { multiply(matrix, x, y); });
  std::vector<double> column(unknowns, 1.0);
  cost.answer_s = median_seconds([&] {
    std::fill(column.begin(), column.end(), 1.0);
    factor.solve(column);
  });
  return cost;
}

AnswerCost measure_cost(const dynamics::BlockMatrix& matrix, std::span<const std::uint8_t> held) {
  const dynamics::FreeNumbers free = dynamics::number_free(held);
  const auto factor = choose_factor("auto")(lower_half(matrix, free));
  return measure_cost(matrix, *factor, free.count);
}

void report_cost(const AnswerCost& cost, nlohmann::json& report) {
  report["unknowns"] = cost.unknowns;
  report["stiffness_entries"] = cost.stiffness_entries;
  report["factor_entries"] = cost.factor_entries;
  report["product_s"] = cost.product_s;
  report["answer_s"] = cost.answer_s;
}

}  // namespace palpate::reference
