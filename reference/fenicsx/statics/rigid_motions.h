// Rigid motions of a body: those that nothing holds, and those that a multigrid has to know.
#pragma once

#include "core/mesh/boundary_problem.h"
#include "reference/fenicsx/statics/elastic_body.h"

namespace palpate::reference::fenicsx {

/// Throws InputError unless held displacements and supports stop all six rigid motions of every connected
/// part of the mesh.
void require_no_free_motion(const TetMesh& mesh, const BoundaryProblem& problem);

/// The six rigid motions of the nodes of a body, orthonormal, for MatSetNearNullSpace.
NullSpace near_null_space(const TetMesh& mesh, const ElasticBody& body);

}  // namespace palpate::reference::fenicsx
