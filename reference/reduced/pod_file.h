// A reduced body as a file, for other simulators and for a later request.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/dynamics/pod/pod_body.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// What a training was asked for: the options of reduced.pod that shape it.
struct PodTraining {
  std::string model = "edge_node";  ///< or tets
  std::size_t training = 16;
  std::size_t validation = 4;
  std::size_t modes = 24;
  double basis_tolerance = 1e-4;
  double force_tolerance = 1e-2;
  bool all_domains = false;
  std::uint64_t seed = 1;

  bool operator==(const PodTraining&) const = default;
};

/// A trained body, what it was trained on, and what came of that.
struct TrainedPod {
  std::uint64_t body = 0;    ///< hash_body of the mesh
  std::uint64_t places = 0;  ///< hash_load_places of the problem
  double young_modulus_pa = 0.0;
  double poisson_ratio = 0.0;
  PodTraining asked;
  std::size_t training_loads = 0;    ///< that the full model came to rest under
  std::size_t validation_loads = 0;  ///< likewise
  std::size_t domains_of_all = 0;
  double force_residual = 0.0;
  std::optional<double> validation_error;
  double training_s = 0.0;        ///< wall time of the training
  Eigen::VectorXd trained_force;  ///< B^T f of the load that it was trained around, in N
  dynamics::PodParts parts;
};

/// Writes `palpate/pod_body/1` (docs/reduced.md has the layout). The same training gives the same bytes, but
/// for the line `training_s`.
void write_pod(const std::filesystem::path& path, const TrainedPod& trained);

/// Reads it back to the same bits. Throws: InputError with the file's name for anything else: another schema,
/// a size that does not fit, numbers that are not finite, negative weights, shapes that are not orthonormal
/// or move what is held, vertices that are none, bytes that are missing or left over.
TrainedPod read_pod(const std::filesystem::path& path);

/// Throws InputError, with the file's name, if it was not made for this mesh, material, kind of training, or
/// places of the loads. Supports are held against it by PodBody.
void require_pod_fits(const TrainedPod& trained, const TetMesh& mesh, const BoundaryProblem& problem,
                      const PodTraining& asked, const std::string& where);

}  // namespace palpate::reference
