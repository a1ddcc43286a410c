// What training knows of a network: rank-one terms with a constant each, and what holds the body.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// Rank-one terms in compressed rows. Component 3 v + axis belongs to vertex v.
///
/// Shape:  term q is the sum over i in [offsets[q], offsets[q + 1]) of coefficient[i] u[component[i]], each
///         component once; `constant` holds one positive start a term (c_q at theta0).
struct RankOneTerms {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> component;
  std::vector<double> coefficient;
  std::vector<double> constant;
};

/// Adds a term 1/2 k (e . (u_b - u_a))^2 for each spring. Springs of a stiffness below `least_share` of the
/// mean start there: a constant of zero has no logarithm. In N/m.
void add_spring_terms(const TetMesh& mesh, const SpringNetwork& network, double least_share,
                      RankOneTerms& terms);

/// Adds a term 1/2 V_n m_n (tr eps_n)^2 for each vertex, eps_n the mean strain of its tets weighted by
/// volume, V_n a quarter of their volume: node-averaged dilatation. In Pa; m_n = `modulus_pa` > 0 at the
/// start.
void add_vertex_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms);

/// Adds a term 1/2 V_T m_T (tr eps_T)^2 for each tet. In Pa.
void add_tet_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms);

/// An entry of a symmetric matrix; both (i, j) and (j, i) are given. Equal places add up.
struct StiffnessEntry {
  Index row = 0;
  Index column = 0;
  double value_n_per_m = 0.0;
};

/// What holds the body in one or more cases: B, and the components that are prescribed (1) or free (0).
struct TrainingBoundary {
  std::vector<StiffnessEntry> stiffness;
  std::vector<std::uint8_t> held;
};

}  // namespace palpate::springs
