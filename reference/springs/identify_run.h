// Springs for programs that link no solver of ours: a mesh in, constants out.
#pragma once

#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/adapter.h"

namespace palpate::reference {

/// "material" among a request's options: {"young_modulus_pa": E, "poisson_ratio": nu, "density_kg_m3": rho}.
Material material_of(const Request& request);

/// Multiplies all springs by the factor that puts their moduli on their own mesh right for the shear modulus,
/// and returns it.
double calibrate_springs(const TetMesh& mesh, double mu_pa, SpringNetwork& network);

/// A request of the contest springs: "method" is one of springs::spring_method_names(), "options" has
/// "material", "set" (the method's options as text, by name) and "calibrate". Leaves the springs' CSV; the
/// report has the figures of springs::IdentifyReport and, where it was asked for, "calibration_factor".
Response run_identification(const Request& request);

}  // namespace palpate::reference
