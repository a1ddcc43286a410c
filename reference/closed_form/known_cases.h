// Problems of elasticity with a known answer, ready to be solved: what the reference has to prove itself on.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// One number that a theory or a benchmark gives for one vertex.
struct KnownValue {
  enum class Kind { kDisplacement, kStress };
  Kind kind = Kind::kDisplacement;
  Index vertex = 0;
  std::size_t row = 0;     ///< the component of the displacement, or the row of the stress
  std::size_t column = 0;  ///< of the stress
  double value = 0.0;      ///< in m, or in Pa
};

/// A problem and what is known of its answer: the displacement everywhere, one value, or both.
struct KnownCase {
  TetMesh mesh;
  BoundaryProblem problem;
  std::function<Vec3(const Vec3&)> displacement;  ///< at a rest point, in m; empty where it is not known
  std::optional<KnownValue> value;
};

/// What one case is: a name for plans, what it asks for, how its mesh grows with `cells`, and where its
/// answer is from.
struct KnownCaseInfo {
  std::string name;
  std::string summary;
  std::string cells;
  std::string source;
};

/// All cases, in the order in which a reader wants them: exact ones first.
const std::vector<KnownCaseInfo>& list_known_cases();

/// The case `name` on a mesh of `cells` cells.
/// Throws: InputError for an unknown name, or a count that the case cannot have.
KnownCase build_known_case(const std::string& name, int cells);

}  // namespace palpate::reference
