#include "reference/reduced/pod_file.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/dynamics/pod/training_loads.h"
#include "core/dynamics/reduced/compliance_table.h"
#include "reference/door/json_file.h"
#include "reference/reduced/numbers_file.h"

namespace palpate::reference {
namespace {

using dynamics::PodDomain;
using dynamics::SupportFace;

constexpr const char* kPodSchema = "palpate/pod_body/1";
constexpr std::size_t kMostPodBytes = std::size_t{4} << 30U;
constexpr std::size_t kMostItems = 1U << 24U;
constexpr std::size_t kMostShapes = 1000;
constexpr std::size_t kNine = 9;

template <typename Matrix>
std::vector<double> numbers_of(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

/// The arrays of the domains, one number or row of numbers each.
void append_domains(std::string& out, const std::vector<PodDomain>& domains) {
  std::vector<Index> which;
  std::vector<double> scalars;
  std::vector<double> gradients;
  which.reserve(3 * domains.size());
  scalars.reserve(4 * domains.size());
  for (const PodDomain& domain : domains) {
    which.push_back(static_cast<Index>(domain.of.term));
    which.push_back(static_cast<Index>(domain.of.domain));
    which.push_back(static_cast<Index>(domain.law));
    scalars.insert(scalars.end(),
                   {domain.of.weight, domain.volume_m3, domain.moduli.lambda_pa, domain.moduli.mu_pa});
    const std::vector<double> rows = numbers_of(domain.gradient);
    gradients.insert(gradients.end(), rows.begin(), rows.end());
  }
  append_numbers(out, which);
  append_numbers(out, scalars);
  append_numbers(out, gradients);
}

std::vector<PodDomain> take_domains(NumbersAfter& bytes, std::size_t count, std::size_t shapes,
                                    const std::string& where) {
  const std::vector<Index> which = bytes.take<Index>(3 * count);
  const std::vector<double> scalars = bytes.take_finite<double>(4 * count);
  const std::vector<double> gradients = bytes.take_finite<double>(kNine * shapes * count);
  std::vector<PodDomain> out(count);
  for (std::size_t k = 0; k < count; ++k) {
    PodDomain& domain = out[k];
    const Index law = which[3 * k + 2];
    if (law > static_cast<Index>(dynamics::StrainLaw::kStableNeoHookean))
      throw InputError(where, 0, "a law from 0 to 3", std::to_string(law));
    const double* scalar = scalars.data() + 4 * k;
    if (!(scalar[0] >= 0.0 && scalar[1] >= 0.0))
      throw InputError(where, 0, "weights and volumes of 0 or more", "one that is negative");
    domain.of = {which[3 * k], which[3 * k + 1], scalar[0]};
    domain.volume_m3 = scalar[1];
    domain.law = static_cast<dynamics::StrainLaw>(law);
    domain.moduli = {scalar[2], scalar[3]};
    domain.gradient = Eigen::Map<const Eigen::Matrix<double, 9, Eigen::Dynamic>>(
        gradients.data() + kNine * shapes * k, 9, static_cast<Eigen::Index>(shapes));
  }
  return out;
}

std::vector<SupportFace> take_supports(NumbersAfter& bytes, std::size_t count, std::size_t vertices,
                                       const std::string& where) {
  const std::vector<Triangle> faces = bytes.take<Triangle>(count);
  const std::vector<double> coefficients = bytes.take_finite<double>(count);
  std::vector<SupportFace> out(count);
  for (std::size_t k = 0; k < count; ++k) {
    for (const Index v : faces[k]) {
      if (v >= vertices) throw InputError(where, 0, "supports on vertices of the body", std::to_string(v));
    }
    if (!(coefficients[k] >= 0.0))
      throw InputError(where, 0, "supports of a stiffness of 0 or more", "one that is negative");
    out[k] = {faces[k], coefficients[k], {}};
  }
  return out;
}

PodTraining take_training(const NumbersHeader& header, const std::string& where) {
  PodTraining out;
  out.model = header.word("model");
  if (out.model != "edge_node" && out.model != "tets")
    throw InputError(where, 0, "model edge_node or tets", out.model);
  out.training = header.number<std::size_t>("training", 1, 1000);
  out.validation = header.number<std::size_t>("validation", 0, 100);
  out.modes = header.number<std::size_t>("modes", 1, kMostShapes);
  out.basis_tolerance = header.number<double>("basis_tolerance", 0.0, 1.0);
  out.force_tolerance = header.number<double>("force_tolerance", 0.0, 1.0);
  out.all_domains = header.number<int>("all_domains", 0, 1) == 1;
  out.seed = header.number<std::uint64_t>("seed", 0, 1'000'000);
  return out;
}

}  // namespace

void write_pod(const std::filesystem::path& path, const TrainedPod& trained) {
  const dynamics::PodParts& parts = trained.parts;
  std::string out = kPodSchema;
  const auto line = [&](const char* key, auto value) {
    out += std::string("\n") + key + " ";
    append_number(out, value);
  };
  line("body", trained.body);
  line("places", trained.places);
  line("young_modulus_pa", trained.young_modulus_pa);
  line("poisson_ratio", trained.poisson_ratio);
  out += "\nmodel " + trained.asked.model;
  line("training", trained.asked.training);
  line("validation", trained.asked.validation);
  line("modes", trained.asked.modes);
  line("basis_tolerance", trained.asked.basis_tolerance);
  line("force_tolerance", trained.asked.force_tolerance);
  line("all_domains", trained.asked.all_domains ? 1 : 0);
  line("seed", trained.asked.seed);
  line("training_loads", trained.training_loads);
  line("validation_loads", trained.validation_loads);
  line("domains_of_all", trained.domains_of_all);
  line("force_residual", trained.force_residual);
  if (trained.validation_error) line("validation_error", *trained.validation_error);
  line("training_s", trained.training_s);
  line("vertices", parts.held.size());
  line("shapes", parts.basis.shapes.cols());
  line("domains", parts.domains.size());
  line("supports", parts.supports.size());
  out += "\nend\n";
  append_numbers(out, numbers_of(parts.basis.shapes));
  append_numbers(out, numbers_of(trained.trained_force));
  append_domains(out, parts.domains);
  std::vector<Triangle> faces;
  std::vector<double> coefficients;
  faces.reserve(parts.supports.size());
  coefficients.reserve(parts.supports.size());
  for (const SupportFace& support : parts.supports) {
    faces.push_back(support.face);
    coefficients.push_back(support.coefficient_n_per_m);
  }
  append_numbers(out, faces);
  append_numbers(out, coefficients);
  append_numbers(out, parts.held);
  write_file_atomically(path, out);
}

TrainedPod read_pod(const std::filesystem::path& path) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const std::string where = path.string();
  const std::string text = read_text_file(path, kMostPodBytes);
  const NumbersHeader header(text, kPodSchema, where);
  TrainedPod out;
  out.body = header.number<std::uint64_t>("body", 0, ~std::uint64_t{0});
  out.places = header.number<std::uint64_t>("places", 0, ~std::uint64_t{0});
  out.young_modulus_pa = header.number<double>("young_modulus_pa", 0.0, kMost);
  out.poisson_ratio = header.number<double>("poisson_ratio", -1.0, 0.5);
  out.asked = take_training(header, where);
  out.training_loads = header.number<std::size_t>("training_loads", 1, 1000);
  out.validation_loads = header.number<std::size_t>("validation_loads", 0, 100);
  out.domains_of_all = header.number<std::size_t>("domains_of_all", 1, kMostItems);
  out.force_residual = header.number<double>("force_residual", 0.0, kMost);
  if (header.has("validation_error"))
    out.validation_error = header.number<double>("validation_error", 0.0, kMost);
  out.training_s = header.number<double>("training_s", 0.0, kMost);
  const auto vertices = header.number<std::size_t>("vertices", 4, kMostItems);
  const auto shapes = header.number<std::size_t>("shapes", 1, kMostShapes);
  const auto domains = header.number<std::size_t>("domains", 1, kMostItems);
  const auto supports = header.number<std::size_t>("supports", 0, kMostItems);
  NumbersAfter bytes(text, header.size(), where);
  const std::vector<double> basis = bytes.take_finite<double>(3 * vertices * shapes);
  const auto columns = static_cast<Eigen::Index>(shapes);
  out.parts.basis.shapes =
      Eigen::Map<const Eigen::MatrixXd>(basis.data(), static_cast<Eigen::Index>(3 * vertices), columns);
  const std::vector<double> force = bytes.take_finite<double>(shapes);
  out.trained_force = Eigen::Map<const Eigen::VectorXd>(force.data(), columns);
  out.parts.domains = take_domains(bytes, domains, shapes, where);
  out.parts.supports = take_supports(bytes, supports, vertices, where);
  out.parts.held = bytes.take<std::uint8_t>(vertices);
  for (const std::uint8_t bits : out.parts.held) {
    if (bits > 7) throw InputError(where, 0, "held axes x, y and z", std::to_string(bits));
  }
  bytes.require_end();
  dynamics::require_basis(out.parts.basis, out.parts.held, where);
  return out;
}

void require_pod_fits(const TrainedPod& trained, const TetMesh& mesh, const BoundaryProblem& problem,
                      const PodTraining& asked, const std::string& where) {
  if (trained.parts.held.size() != mesh.points.size() || trained.body != dynamics::hash_body(mesh))
    throw InputError(where, 0, "a body that was trained on this mesh", "another mesh");
  const auto same = [&](const char* name, double has, double wanted) {
    if (has == wanted) return;
    std::string expected = std::string("a body that was trained with ") + name + " ";
    append_number(expected, wanted);
    std::string found;
    append_number(found, has);
    throw InputError(where, 0, expected, found);
  };
  same("young_modulus_pa", trained.young_modulus_pa, problem.material.young_modulus_pa);
  same("poisson_ratio", trained.poisson_ratio, problem.material.poisson_ratio);
  if (trained.asked.model != asked.model)
    throw InputError(where, 0, "a body that was trained with model " + asked.model, trained.asked.model);
  same("training", static_cast<double>(trained.asked.training), static_cast<double>(asked.training));
  same("validation", static_cast<double>(trained.asked.validation), static_cast<double>(asked.validation));
  same("modes", static_cast<double>(trained.asked.modes), static_cast<double>(asked.modes));
  same("basis_tolerance", trained.asked.basis_tolerance, asked.basis_tolerance);
  same("force_tolerance", trained.asked.force_tolerance, asked.force_tolerance);
  same("all_domains", trained.asked.all_domains ? 1.0 : 0.0, asked.all_domains ? 1.0 : 0.0);
  same("seed", static_cast<double>(trained.asked.seed), static_cast<double>(asked.seed));
  if (trained.places != dynamics::hash_load_places(problem))
    throw InputError(where, 0, "loads at the places that the body was trained for", "others");
}

}  // namespace palpate::reference
