// A small linear system under loads that run straight over a step, stepped without error.
#pragma once

#include <span>
#include <vector>

namespace palpate::dynamics {

/// eta'' + C eta' + Omega^2 eta = G s(t) + D s'(t).
///
/// Shape:  squares (omega^2, in 1/s^2) has k entries, all above zero; damping is k x k, load and load_rate
///         k x l, by rows.
struct SmallSystem {
  std::vector<double> squares;
  std::vector<double> damping;
  std::vector<double> load;
  std::vector<double> load_rate;
  std::size_t loads = 0;

  std::size_t modes() const { return squares.size(); }
};

/// The map of one step of h: eta and eta' at its end from those at its start, for s that runs straight. It is
/// the exponential of the whole system, so no step is too long, and without damping and load the energy is
/// kept to rounding. For one mode it is the closed form of the damped oscillator.
///
/// Source: C. Moler and C. Van Loan, SIAM Review 45 (2003), 3-49, for the exponential (scaling and squaring).
class ExactStep {
 public:
  /// Throws: ContractError for sizes that don't fit or a step that is not above zero.
  ExactStep(const SmallSystem& system, double step_s);

  /// One step. Shape: eta and rate have k entries; from and to, the shares at its ends, l.
  void advance(std::span<double> eta, std::span<double> rate, std::span<const double> from,
               std::span<const double> to);

 private:
  std::size_t modes_ = 0;
  std::size_t loads_ = 0;
  double step_s_ = 0.0;
  double scale_per_s_ = 1.0;  ///< eta is scaled by it, so that both halves of the state are speeds
  std::vector<double> map_;   ///< 2 k x (2 k + 2 l), by columns
  std::vector<double> in_;
  std::vector<double> out_;
};

}  // namespace palpate::dynamics
