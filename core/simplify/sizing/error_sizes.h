// Sizes from a solution: where linear elements are in error, and how fine a mesh has to be there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::simplify {

/// The error of a displacement field that is linear in each tet, as an energy a tet, in J for SI units:
///
///   e_T = 1/2 integral over T of (s* - s) : C^-1 (s* - s),   s the stress in T, s* the recovered one,
///
/// s* linear in T between its values at the vertices: the mean of the stresses around each, by volume; the
/// integral is exact.
///
/// Shape:   one displacement a vertex. Requires: positive tets, mu > 0, 3 lambda + 2 mu > 0.
/// Source:  O. Zienkiewicz and J. Zhu, Int. J. Numer. Meth. Engng 33 (1992), 1331-1364; with means in the
///          place of patches fitted by least squares.
std::vector<double> estimate_tet_errors(const TetMesh& mesh, double lambda_pa, double mu_pa,
                                        std::span<const Vec3> displacement);

/// Sizes at the vertices with which the energy of the error is least for a given number of tets.
///
///   error density e_T / V_T = c h_T^2, so c = e_T / (V_T h_T^2), h_T = V_T^(1/3);
///   least integral of c h^2 with the integral of h^-3 given:  h = (c / c_least)^(-1/5), at most 1
///
/// c is averaged by volume over the tets at a vertex, then over neighbours until it has spread by about
/// `spread`: a coarse mesh cannot follow what is narrower than its edges. c_least is the value that a tenth
/// of the volume lies below, so the sizes there are 1. Nothing is smaller than `least_size`. A field without
/// error has size 1.
///
/// Requires: positive tets, one error a tet, not negative. Throws: InputError for a least_size outside (0,
/// 1], a spread that is negative or not finite.
std::vector<double> sizes_of_errors(const TetMesh& mesh, std::span<const double> tet_errors,
                                    double least_size, double spread);

/// Lowers sizes until no edge's ends differ by more than `growth` a wanted edge length: for an edge of length
/// l, size_a <= size_b + growth l / far, with `far` the edge length where the size is 1.
/// Throws: InputError unless growth and far are above 0.
void limit_growth(const TetMesh& mesh, double growth, double far, std::vector<double>& sizes);

/// The edge length where the size is 1 of a mesh of so many tets: (graded volume / (0.1 tets))^(1/3), of a
/// mesh whose tets have 0.1 l^3 (a regular one 0.118). A mesh is only made coarser, so sizes below what
/// `mesh` has are raised to that, in `sizes` too; the far length then makes the count come out. Throws:
/// InputError unless there are to be fewer tets than there are, at least 1, and for a size that is not above
/// 0.
double fit_sizes(const TetMesh& mesh, std::uint64_t tets, std::vector<double>& sizes);

}  // namespace palpate::simplify
