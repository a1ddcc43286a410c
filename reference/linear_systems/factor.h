// Which sparse factorisation systems are solved with.
#pragma once

#include <string>

#include "core/dynamics/linear_algebra/sparse_factor.h"

namespace palpate::reference {

/// "cholmod" where the program was built with it, else "eigen".
std::string best_factor_name();

/// The factorisation of a name: "auto", "cholmod" (supernodal, ordered by nested dissection) or "eigen".
/// Throws: InputError for cholmod in a program that was built without it.
/// Source: Y. Chen, T. A. Davis, W. W. Hager and S. Rajamanickam, ACM Trans. Math. Softw. 35 (2008).
dynamics::FactorMaker choose_factor(const std::string& name);

}  // namespace palpate::reference
