// The constraints of the thesis's Appendix B as least-squares rows: as printed, and with its misprints
// mended.
#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/solvers/nonnegative_least_squares.h"

namespace palpate::springs {

/// How appendix B is read.
///
///   kPrinted      B.1 - B.17 to the letter, lambda1 put in
///   kB4Sign       the same with the sign of B.4 that B.19 has, so that they leave room for stiffness (S11)
///   kSubstituted  B.18 - B.23 in the place of B.1 and B.4 - B.8, "substituting lambda1 = -1/4", as printed:
///                 kB4Sign with these six rows times 4
///   kCorrected    B.3 - B.6, B.11, B.12, B.14 and B.15 as the Fourier series of eq. 3.15 has them (S6 - S10)
///
/// S6 and so on: docs/errata.md.
enum class ThesisRows { kPrinted, kB4Sign, kSubstituted, kCorrected };

/// Rows a vertex, without the stiffness row.
inline constexpr std::size_t kThesisRows = 17;

/// The only transverse strain ratio that springs alone can have (thesis 3.4).
inline constexpr double kThesisLambda1 = -0.25;

/// Coefficients of a spring in B.1 - B.17, each to be multiplied by w = k U^2 and summed to zero over the
/// springs at a vertex. `direction` is the unit vector away from the vertex; alpha is its angle to z, beta
/// that of its projection to x. On the z axis, where beta has no value, it is 0; the corrected rows don't
/// depend on that, the printed ones do. Throws: ContractError for kSubstituted at another lambda1 than -1/4.
/// Source: thesis, Appendix B.
std::array<double, kThesisRows> thesis_row_coefficients(const Vec3& direction, ThesisRows rows,
                                                        double lambda1 = kThesisLambda1);

/// The ridge with springs between opposite apexes. Without it conjugate gradients don't end: the edges of a
/// kidney alone have singular values from 0.14 to 2.5, with opposite springs they go down to nothing.
inline constexpr double kOppositeRidge = 0.01;

/// How appendix B is read, and with which weights it is solved.
struct ThesisOptions {
  ThesisRows rows = ThesisRows::kCorrected;
  double stiffness_row_weight = 1.0;  ///< the row sum of w = 12 E V_m is multiplied by this; > 0
  /// Adds ridge x the mean squared column length of the 17 rows x |k U^2|^2: of the constants that the rows
  /// leave open, or all but open, the smallest. 0: nothing is added.
  double ridge_relative = 0.0;
  NonnegativeOptions solve;  ///< on the unknowns k U^2 / (E x mean V_m)
};

/// Sets the stiffness of each spring to the least-squares answer of 18 rows a vertex (the 17, and the
/// stiffness row sum of w = 12 E V_m) with k >= 0. The thesis solved the same with MATLAB on a cluster.
///
/// The 17 rows have coefficients up to 35 and the stiffness row has 1: with a weight of 1 the homogeneous
/// rows win and the springs come out much too soft. The weighting of the rows is not that of a tensor norm,
/// so the answer depends on the directions of the axes. Requires: network is build_spring_network(mesh) in
/// metres, with or without opposite apexes. With them a vertex has some 17 unknowns for rows of rank 15 or
/// 16, and the solver needs the ridge (kOppositeRidge). Throws: ContractError unless the weight and the
/// modulus are positive and the ridge is not negative.
NonnegativeReport identify_thesis(const TetMesh& mesh, double young_modulus_pa, const ThesisOptions& options,
                                  SpringNetwork& network);

}  // namespace palpate::springs
