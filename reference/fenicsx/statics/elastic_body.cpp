#include "reference/fenicsx/statics/elastic_body.h"

#include <dolfinx/common/IndexMap.h>
#include <dolfinx/common/log.h>
#include <dolfinx/fem/Constant.h>
#include <dolfinx/fem/CoordinateElement.h>
#include <dolfinx/fem/DofMap.h>
#include <dolfinx/fem/Form.h>
#include <dolfinx/fem/Function.h>
#include <dolfinx/fem/FunctionSpace.h>
#include <dolfinx/fem/assembler.h>
#include <dolfinx/fem/petsc.h>
#include <dolfinx/fem/utils.h>
#include <dolfinx/graph/AdjacencyList.h>
#include <dolfinx/la/petsc.h>
#include <dolfinx/mesh/Mesh.h>

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "elasticity.h"
#include "reference/fenicsx/statics/mpi_processes.h"

namespace palpate::reference::fenicsx {
namespace {

namespace fem = dolfinx::fem;
using Form = fem::Form<PetscScalar>;

/// The compiled forms of one degree and one size of strain.
struct CompiledForms {
  ufcx_form* energy;
  ufcx_form* force;
  ufcx_form* tangent;
  ufcx_form* load;
  ufcx_function_space* (*space)(const char*);
  const char* displacement;  ///< its name in elasticity.py
};

CompiledForms compiled_forms(int degree, StrainSize strain) {
  const bool small = strain == StrainSize::kSmall;
  if (degree == 1) {
    return {small ? form_elasticity_small_energy1 : form_elasticity_large_energy1,
            small ? form_elasticity_small_force1 : form_elasticity_large_force1,
            small ? form_elasticity_small_tangent1 : form_elasticity_large_tangent1,
            form_elasticity_load1,
            functionspace_form_elasticity_small_force1,
            "u1"};
  }
  return {small ? form_elasticity_small_energy2 : form_elasticity_large_energy2,
          small ? form_elasticity_small_force2 : form_elasticity_large_force2,
          small ? form_elasticity_small_tangent2 : form_elasticity_large_tangent2,
          form_elasticity_load2,
          functionspace_form_elasticity_small_force2,
          "u2"};
}

/// The part of `count` things that process `rank` of `size` brings in.
std::array<std::size_t, 2> part_of(std::size_t count, int rank, int size) {
  const auto r = static_cast<std::size_t>(rank);
  const auto n = static_cast<std::size_t>(size);
  return {count * r / n, count * (r + 1) / n};
}

std::shared_ptr<dolfinx::mesh::Mesh> create_mesh(const TetMesh& mesh) {
  loguru::g_stderr_verbosity = loguru::Verbosity_WARNING;
  const int rank = process_rank();
  const int size = process_count();
  const auto [first_tet, end_tet] = part_of(mesh.tets.size(), rank, size);
  std::vector<std::int64_t> vertices;
  std::vector<std::int32_t> offsets{0};
  vertices.reserve(4 * (end_tet - first_tet));
  for (std::size_t t = first_tet; t < end_tet; ++t) {
    vertices.insert(vertices.end(), mesh.tets[t].begin(), mesh.tets[t].end());
    offsets.push_back(static_cast<std::int32_t>(vertices.size()));
  }
  const auto [first_point, end_point] = part_of(mesh.points.size(), rank, size);
  std::vector<double> points;
  for (std::size_t p = first_point; p < end_point; ++p) {
    const Vec3& point = mesh.points[p];
    points.insert(points.end(), {point.x, point.y, point.z});
  }
  return std::make_shared<dolfinx::mesh::Mesh>(dolfinx::mesh::create_mesh(
      PETSC_COMM_WORLD, dolfinx::graph::AdjacencyList<std::int64_t>(std::move(vertices), std::move(offsets)),
      fem::CoordinateElement(dolfinx::mesh::CellType::tetrahedron, 1), points, {points.size() / 3, 3},
      dolfinx::mesh::GhostMode::none));
}

/// The ends of the six edges of a tet, in the order in which dolfinx numbers midpoints.
constexpr std::array<std::array<std::size_t, 2>, 6> kMidpoints{
    {{2, 3}, {1, 3}, {1, 2}, {0, 3}, {0, 2}, {0, 1}}};

Triangle sorted(Triangle face) {
  std::sort(face.begin(), face.end());
  return face;
}

}  // namespace

struct ElasticBody::Parts {
  std::shared_ptr<dolfinx::mesh::Mesh> mesh;
  Material material;
  StrainSize strain;
  int degree;
  std::shared_ptr<fem::FunctionSpace> space;
  std::shared_ptr<fem::Function<PetscScalar>> displacement;
  std::shared_ptr<fem::Constant<PetscScalar>> body_force;
  std::unique_ptr<Form> energy;
  std::unique_ptr<Form> force;
  std::unique_ptr<Form> tangent;
  std::unique_ptr<Form> load;
  std::vector<Edge> nodes;
  std::vector<PetscInt> global_numbers;

  Parts(std::shared_ptr<dolfinx::mesh::Mesh> mesh_given, const Material& material_given,
        StrainSize strain_given, int degree_given)
      : mesh(std::move(mesh_given)), material(material_given), strain(strain_given), degree(degree_given) {
    create_forms();
    name_nodes();
  }

  void create_forms() {
    const CompiledForms forms = compiled_forms(degree, strain);
    space = std::make_shared<fem::FunctionSpace>(
        fem::create_functionspace(forms.space, forms.displacement, mesh));
    displacement = std::make_shared<fem::Function<PetscScalar>>(space);
    body_force = std::make_shared<fem::Constant<PetscScalar>>(std::vector<PetscScalar>{0.0, 0.0, 0.0});
    const std::map<std::string, std::shared_ptr<const fem::Constant<PetscScalar>>> constants{
        {"first_lame_pa", std::make_shared<fem::Constant<PetscScalar>>(material.lambda_pa())},
        {"shear_modulus_pa", std::make_shared<fem::Constant<PetscScalar>>(material.mu_pa())},
        {"body_force", body_force}};
    const std::map<std::string, std::shared_ptr<const fem::Function<PetscScalar>>> functions{
        {forms.displacement, displacement}};
    const auto create = [&](const ufcx_form* form) {
      const std::vector<std::shared_ptr<const fem::FunctionSpace>> spaces(
          static_cast<std::size_t>(form->rank), space);
      return std::make_unique<Form>(
          fem::create_form<PetscScalar>(*form, spaces, functions, constants, {}, mesh));
    };
    energy = create(forms.energy);
    force = create(forms.force);
    tangent = create(forms.tangent);
    load = create(forms.load);
  }

  std::size_t cell_count() const {
    return static_cast<std::size_t>(mesh->topology().index_map(3)->size_local());
  }

  /// The four vertices of a cell, as the given mesh counts them.
  std::array<Index, 4> vertices_of(std::size_t cell) const {
    const auto points = mesh->geometry().dofmap().links(static_cast<int>(cell));
    const auto& given = mesh->geometry().input_global_indices();
    std::array<Index, 4> vertices{};
    for (std::size_t i = 0; i < 4; ++i)
      vertices[i] = static_cast<Index>(given[static_cast<std::size_t>(points[i])]);
    return vertices;
  }

  void name_nodes() {
    const auto& map = *space->dofmap()->index_map;
    const auto count =
        static_cast<std::size_t>(map.size_local()) + static_cast<std::size_t>(map.num_ghosts());
    nodes.assign(count, {kNoIndex, kNoIndex});
    for (std::size_t cell = 0; cell < cell_count(); ++cell) {
      const auto dofs = space->dofmap()->cell_dofs(static_cast<int>(cell));
      const std::array<Index, 4> vertices = vertices_of(cell);
      for (std::size_t i = 0; i < dofs.size(); ++i) {
        const std::array<std::size_t, 2> ends = i < 4 ? std::array{i, i} : kMidpoints[i - 4];
        const auto [a, b] = std::minmax(vertices[ends[0]], vertices[ends[1]]);
        nodes[static_cast<std::size_t>(dofs[i])] = {a, b};
      }
    }
    std::vector<std::int32_t> local(count);
    for (std::size_t i = 0; i < count; ++i) local[i] = static_cast<std::int32_t>(i);
    std::vector<std::int64_t> global(count);
    map.local_to_global(local, global);
    global_numbers.assign(global.begin(), global.end());
  }

  /// The nodes of a cell's face with the vertices `given`.
  LocalFace local_face(std::size_t cell, std::size_t place, const Triangle& given) const {
    const std::array<Index, 4> vertices = vertices_of(cell);
    const auto dofs = space->dofmap()->cell_dofs(static_cast<int>(cell));
    std::array<std::size_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] =
          static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), given[k]) - vertices.begin());
    LocalFace face;
    face.given = place;
    for (std::size_t k = 0; k < 3; ++k) face.nodes[k] = dofs[corners[k]];
    if (degree == 1) return face;
    face.node_count = 6;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
      const auto at = std::find(kMidpoints.begin(), kMidpoints.end(), std::array{a, b});
      face.nodes[3 + k] = dofs[4 + static_cast<std::size_t>(at - kMidpoints.begin())];
    }
    return face;
  }

  void set_displacement(const Vector& u) const {
    const LocalEntries entries(u.get());
    std::copy(entries.get().begin(), entries.get().end(), displacement->x()->mutable_array().begin());
  }
};

ElasticBody::ElasticBody(const TetMesh& mesh, const Material& material, StrainSize strain, int degree)
    : ElasticBody(std::make_unique<Parts>(create_mesh(mesh), material, strain, degree)) {}

ElasticBody::ElasticBody(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

ElasticBody::~ElasticBody() = default;

std::unique_ptr<ElasticBody> ElasticBody::with_linear_shapes() const {
  return std::unique_ptr<ElasticBody>(
      new ElasticBody(std::make_unique<Parts>(parts_->mesh, parts_->material, parts_->strain, 1)));
}

const std::vector<Edge>& ElasticBody::nodes() const {
  return parts_->nodes;
}

std::size_t ElasticBody::owned_nodes() const {
  return static_cast<std::size_t>(parts_->space->dofmap()->index_map->size_local());
}

std::size_t ElasticBody::global_nodes() const {
  return static_cast<std::size_t>(parts_->space->dofmap()->index_map->size_global());
}

const std::vector<PetscInt>& ElasticBody::global_numbers() const {
  return parts_->global_numbers;
}

std::vector<LocalFace> ElasticBody::find_faces(const std::vector<Triangle>& faces) const {
  std::map<Triangle, std::size_t> place_of;
  for (std::size_t f = 0; f < faces.size(); ++f) place_of.emplace(sorted(faces[f]), f);
  std::vector<LocalFace> found;
  for (std::size_t cell = 0; cell < parts_->cell_count() && !place_of.empty(); ++cell) {
    const std::array<Index, 4> vertices = parts_->vertices_of(cell);
    for (const auto& corners : kTetFaces) {
      Triangle face{};
      for (std::size_t k = 0; k < 3; ++k) face[k] = vertices[static_cast<std::size_t>(corners[k])];
      const auto place = place_of.find(sorted(face));
      if (place != place_of.end())
        found.push_back(parts_->local_face(cell, place->second, faces[place->second]));
    }
  }
  return found;
}

Vector ElasticBody::create_vector() const {
  Vector made(dolfinx::la::petsc::create_vector(*parts_->space->dofmap()->index_map, 3));
  const LocalEntries entries(made.get());
  std::fill(entries.get().begin(), entries.get().end(), 0.0);
  return made;
}

Matrix ElasticBody::create_matrix(const char* type) const {
  return Matrix(fem::petsc::create_matrix(*parts_->tangent, type));
}

void ElasticBody::add_tangent(const Vector& u, const Matrix& tangent) {
  parts_->set_displacement(u);
  fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(tangent.get(), ADD_VALUES), *parts_->tangent,
                       {});
}

void ElasticBody::add_mass(const Matrix& mass) const {
  const Form form = fem::create_form<PetscScalar>(
      *(parts_->degree == 1 ? form_elasticity_mass1 : form_elasticity_mass2), {parts_->space, parts_->space},
      std::map<std::string, std::shared_ptr<const fem::Function<PetscScalar>>>{},
      {{"density_kg_m3", std::make_shared<fem::Constant<PetscScalar>>(parts_->material.density_kg_m3)}}, {},
      parts_->mesh);
  fem::assemble_matrix(dolfinx::la::petsc::Matrix::set_block_fn(mass.get(), ADD_VALUES), form, {});
}

void ElasticBody::add_internal_force(const Vector& u, const Vector& force) {
  parts_->set_displacement(u);
  const LocalEntries entries(force.get());
  fem::assemble_vector(entries.get(), *parts_->force);
}

void ElasticBody::add_body_force(const Vec3& force_n_m3, const Vector& force) {
  parts_->body_force->value = {force_n_m3.x, force_n_m3.y, force_n_m3.z};
  const LocalEntries entries(force.get());
  fem::assemble_vector(entries.get(), *parts_->load);
}

void ElasticBody::add_body_force_field(const std::vector<Vec3>& force_n_m3, const std::vector<Edge>& edges,
                                       const Vector& force) {
  const Parts quadratic(parts_->mesh, parts_->material, parts_->strain, 2);
  const std::size_t vertices = force_n_m3.size() - edges.size();
  auto values = quadratic.displacement->x()->mutable_array();
  for (std::size_t node = 0; node < quadratic.nodes.size(); ++node) {
    const Edge& ends = quadratic.nodes[node];
    const std::size_t row =
        ends[0] == ends[1]
            ? ends[0]
            : vertices + static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), ends) -
                                                  edges.begin());
    const Vec3& f = force_n_m3[row];
    std::copy_n(std::array{f.x, f.y, f.z}.begin(), 3, values.begin() + static_cast<std::ptrdiff_t>(3 * node));
  }
  const Form load = fem::create_form<PetscScalar>(
      *(parts_->degree == 1 ? form_elasticity_field_load1 : form_elasticity_field_load2), {parts_->space},
      {{"force_field", quadratic.displacement}},
      std::map<std::string, std::shared_ptr<const fem::Constant<PetscScalar>>>{}, {}, parts_->mesh);
  const LocalEntries entries(force.get());
  fem::assemble_vector(entries.get(), load);
}

double ElasticBody::stored_energy(const Vector& u) {
  parts_->set_displacement(u);
  double here = fem::assemble_scalar(*parts_->energy);
  double sum = 0.0;
  MPI_Allreduce(&here, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

}  // namespace palpate::reference::fenicsx
