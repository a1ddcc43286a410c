#include "reference/linear_systems/factor.h"

#include <algorithm>
#include <memory>

#ifdef PALPATE_HAS_CHOLMOD
#include <cholmod.h>
#endif

#include "core/base/error.h"

namespace palpate::reference {
namespace {

#ifdef PALPATE_HAS_CHOLMOD
constexpr bool kHasCholmod = true;

class CholmodFactor : public dynamics::SymmetricFactor {
 public:
  explicit CholmodFactor(const dynamics::LowerHalf& matrix) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.quick_return_if_not_posdef = 1;
    cholmod_sparse lower{};
    lower.nrow = lower.ncol = matrix.size();
    lower.nzmax = matrix.rows.size();
    lower.p = const_cast<int*>(matrix.offsets.data());    // NOLINT(cppcoreguidelines-pro-type-const-cast)
    lower.i = const_cast<int*>(matrix.rows.data());       // NOLINT(cppcoreguidelines-pro-type-const-cast)
    lower.x = const_cast<double*>(matrix.values.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    lower.stype = -1;
    lower.itype = CHOLMOD_INT;
    lower.xtype = CHOLMOD_REAL;
    lower.dtype = CHOLMOD_DOUBLE;
    lower.sorted = 1;
    lower.packed = 1;
    factor_ = cholmod_analyze(&lower, &common_);
    if (factor_ != nullptr) cholmod_factorize(&lower, factor_, &common_);
    const bool is_good = factor_ != nullptr && common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
    if (is_good) return;
    const bool is_full = common_.status == CHOLMOD_OUT_OF_MEMORY || common_.status == CHOLMOD_TOO_LARGE;
    release();
    throw UnavailableError(is_full ? "the factors of the stiffness are too large for the memory"
                                   : "the stiffness is not positive definite: it cannot be factored");
  }
  ~CholmodFactor() override { release(); }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  void solve(std::span<double> columns) const override {
    if (factor_->n == 0) return;
    cholmod_dense right{};
    right.nrow = right.d = factor_->n;
    right.ncol = columns.size() / factor_->n;
    right.nzmax = columns.size();
    right.x = columns.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* solved = cholmod_solve(CHOLMOD_A, factor_, &right, &common_);
    if (solved == nullptr) throw UnavailableError("CHOLMOD could not solve");
    const auto* from = static_cast<const double*>(solved->x);
    std::copy(from, from + columns.size(), columns.begin());
    cholmod_free_dense(&solved, &common_);
  }

  std::size_t entries() const override { return factor_->xsize; }

 private:
  void release() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  mutable cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
};
#else
constexpr bool kHasCholmod = false;
#endif

}  // namespace

std::string best_factor_name() {
  return kHasCholmod ? "cholmod" : "eigen";
}

dynamics::FactorMaker choose_factor(const std::string& name) {
  const std::string chosen = name == "auto" ? best_factor_name() : name;
  if (chosen == "eigen") return dynamics::factor_simplicial;
#ifdef PALPATE_HAS_CHOLMOD
  if (chosen == "cholmod")
    return [](const dynamics::LowerHalf& matrix) { return std::make_unique<CholmodFactor>(matrix); };
#endif
  throw InputError("factor", 0, "auto or eigen: this program was built without CHOLMOD", chosen);
}

}  // namespace palpate::reference
