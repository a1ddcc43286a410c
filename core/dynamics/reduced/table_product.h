// Products with the rows of a table.
#pragma once

#include <span>

#include "core/dynamics/reduced/compliance_table.h"

namespace palpate::dynamics {

/// y = rows [first, last) of the field's table times x, summed in the precision that it is stored in.
void multiply_field(const ComplianceTable& table, std::size_t first, std::size_t last,
                    std::span<const double> x, std::span<double> y);

/// y = the skin's table times x, summed in double precision.
void multiply_skin(const ComplianceTable& table, std::span<const double> x, std::span<double> y);

/// One entry of the skin's table.
double skin_entry(const ComplianceTable& table, std::size_t row, std::size_t column);

}  // namespace palpate::dynamics
