#include "core/dynamics/reduced/table_product.h"

#include <Eigen/Core>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

template <typename Number>
void multiply_rows(const std::vector<Number>& rows, std::size_t first, std::size_t last,
                   std::span<const double> x, std::span<double> y) {
  using Rows = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Column = Eigen::Matrix<Number, Eigen::Dynamic, 1>;
  const auto width = static_cast<Eigen::Index>(x.size());
  const auto height = static_cast<Eigen::Index>(last - first);
  const Eigen::Map<const Rows> part(rows.data() + first * x.size(), height, width);
  const Column in = Eigen::Map<const Eigen::VectorXd>(x.data(), width).cast<Number>();
  const Column out = part * in;
  Eigen::Map<Eigen::VectorXd>(y.data(), height) = out.template cast<double>();
}

}  // namespace

void multiply_field(const ComplianceTable& table, std::size_t first, std::size_t last,
                    std::span<const double> x, std::span<double> y) {
  require(x.size() == 3 * table.nodes.size() && y.size() == last - first, "sizes of a table's product");
  if (table.is_single()) {
    multiply_rows(table.field_single, first, last, x, y);
  } else {
    multiply_rows(table.field, first, last, x, y);
  }
}

void multiply_skin(const ComplianceTable& table, std::span<const double> x, std::span<double> y) {
  require(x.size() == 3 * table.nodes.size() && y.size() == x.size(), "sizes of a table's product");
  for (std::size_t row = 0; row < x.size(); ++row) {
    double sum = 0.0;
    for (std::size_t column = 0; column < x.size(); ++column)
      sum += skin_entry(table, row, column) * x[column];
    y[row] = sum;
  }
}

double skin_entry(const ComplianceTable& table, std::size_t row, std::size_t column) {
  const std::size_t place = row * 3 * table.nodes.size() + column;
  return table.is_single() ? static_cast<double>(table.skin_single[place]) : table.skin[place];
}

}  // namespace palpate::dynamics
