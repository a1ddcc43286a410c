// When a step of a line search brings enough.
#pragma once

namespace palpate::springs {

/// The share of the decrease that the slope promises which a step has to bring.
/// Source: L. Armijo, Pacific J. Math. 16 (1966), 1-3.
inline constexpr double kSufficientDecrease = 1e-4;

}  // namespace palpate::springs
