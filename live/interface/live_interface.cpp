#include "live/interface/live_interface.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/reduced/compliance_table.h"
#include "live/body/live_answer.h"
#include "live/body/live_body.h"

namespace palpate::live {
namespace {

/// What the caller has made so far.
struct Stage {
  std::optional<BodySetup> setup;
  std::unique_ptr<LiveBody> body;
  std::unique_ptr<LiveAnswer> answer;
  std::map<std::array<double, 3>, Index> answer_vertex;  ///< by the place of a skin's vertex
  std::string message;
};

Stage& stage() {
  static Stage the_stage;
  return the_stage;
}

/// Runs `work`; a failure becomes a message and 1.
template <typename Work>
int guarded(const Work& work) {
  try {
    work();
    return 0;
  } catch (const std::exception& error) {
    stage().message = error.what();
  } catch (...) {
    stage().message = "something unknown went wrong";
  }
  return 1;
}

BodySetup& setup() {
  if (!stage().setup) throw InputError("live", 0, "a setup first", "none");
  return *stage().setup;
}

LiveBody& body() {
  if (!stage().body) throw InputError("live", 0, "a body first", "none");
  return *stage().body;
}

LiveAnswer& answer() {
  if (!stage().answer) throw InputError("live", 0, "a table first", "none");
  return *stage().answer;
}

std::array<double, 3> place_of(const Vec3& point) {
  return {point.x, point.y, point.z};
}

std::vector<Triangle> read_faces(std::uint32_t faces, const std::uint32_t* vertices) {
  std::vector<Triangle> out(faces);
  for (std::size_t f = 0; f < faces; ++f) {
    out[f] = {vertices[3 * f], vertices[3 * f + 1], vertices[3 * f + 2]};
    for (const Index v : out[f]) {
      if (v >= setup().mesh.points.size())
        throw InputError("faces", 0, "vertices of the mesh", std::to_string(v));
    }
  }
  return out;
}

void write(const Vec3& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

void build(const ModelChoice& choice) {
  stage().body.reset();
  stage().body = std::make_unique<LiveBody>(setup(), choice);
}

StrainSize strain_of(int is_large) {
  return is_large != 0 ? StrainSize::kLarge : StrainSize::kSmall;
}

void read_mesh(std::uint32_t vertices, const double* points_m, std::uint32_t tets,
               const std::uint32_t* tet_vertices, TetMesh& mesh) {
  mesh.points.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    mesh.points[v] = {points_m[3 * v], points_m[3 * v + 1], points_m[3 * v + 2]};
  mesh.tets.resize(tets);
  for (std::size_t t = 0; t < tets; ++t) {
    std::copy_n(tet_vertices + 4 * t, 4, mesh.tets[t].begin());
    for (const Index v : mesh.tets[t]) {
      if (v >= vertices) throw InputError("tets", 0, "vertices of the mesh", std::to_string(v));
    }
  }
}

void take_table(std::uint32_t skin, const std::uint32_t* skin_vertices, const float* skin_compliance,
                const float* field, int element_order, int refine) {
  const BodySetup& own = setup();
  dynamics::ComplianceTable table;
  table.options = {element_order, refine, 1, own.holding.material.poisson_ratio, false};
  table.body = dynamics::hash_body(own.mesh);
  table.nodes.vertices.assign(skin_vertices, skin_vertices + skin);
  table.order = table.nodes.vertices;
  for (Index v = 0; v < own.mesh.points.size(); ++v) {
    if (!std::binary_search(table.nodes.vertices.begin(), table.nodes.vertices.end(), v))
      table.order.push_back(v);
  }
  const std::size_t numbers = std::size_t{9} * skin * skin;
  table.skin_single.assign(skin_compliance, skin_compliance + numbers);
  table.field_single.assign(field, field + numbers);
  stage().answer.reset();
  stage().answer = std::make_unique<LiveAnswer>(own.mesh, std::move(table), own.holding);
  stage().answer_vertex.clear();
  for (const Index v : answer().vertices()) stage().answer_vertex[place_of(own.mesh.points[v])] = v;
}

/// The body's pad with the vertices of the answer's mesh.
FacePatch pad_of_answer() {
  FacePatch patch = body().pad();
  const std::vector<Vec3>& points = body().model().elastic.rest;
  for (Triangle& face : patch.faces) {
    for (Index& v : face) {
      const auto at = stage().answer_vertex.find(place_of(points[v]));
      if (at == stage().answer_vertex.end())
        throw InputError("pad", 0, "a skin that is the table's", "another one");
      v = at->second;
    }
  }
  return patch;
}

}  // namespace
}  // namespace palpate::live

using palpate::live::body;
using palpate::live::guarded;
using palpate::live::setup;
using palpate::live::stage;

const char* live_message() {
  return stage().message.c_str();
}

int live_setup(uint32_t vertices, const double* points_m, uint32_t tets, const uint32_t* tet_vertices,
               double young_modulus_pa, double poisson_ratio, double density_kg_m3,
               double damping_stiffness_s, double damping_mass_per_s) {
  return guarded([&] {
    stage().body.reset();
    palpate::live::BodySetup made;
    palpate::live::read_mesh(vertices, points_m, tets, tet_vertices, made.mesh);
    made.holding.material = {young_modulus_pa, poisson_ratio, density_kg_m3};
    made.damping_stiffness_s = damping_stiffness_s;
    made.damping_mass_per_s = damping_mass_per_s;
    stage().setup = std::move(made);
  });
}

int live_springs(uint32_t springs, const uint32_t* ends, const double* rest_length_m,
                 const double* stiffness_n_per_m) {
  return guarded([&] {
    palpate::SpringNetwork net;
    for (std::size_t s = 0; s < springs; ++s) net.springs.push_back({ends[2 * s], ends[2 * s + 1]});
    net.rest_length_m.assign(rest_length_m, rest_length_m + springs);
    net.stiffness_n_per_m.assign(stiffness_n_per_m, stiffness_n_per_m + springs);
    setup().springs = std::move(net);
  });
}

int live_support(uint32_t faces, const uint32_t* face_vertices, const double* weights,
                 double stiffness_pa_per_m) {
  return guarded([&] {
    palpate::FacePatch patch{palpate::live::read_faces(faces, face_vertices), {weights, weights + faces}};
    setup().holding.supports.push_back({std::move(patch), stiffness_pa_per_m, {}});
  });
}

int live_held(uint32_t faces, const uint32_t* face_vertices, uint32_t axes) {
  return guarded([&] {
    setup().holding.held.push_back({palpate::live::read_faces(faces, face_vertices),
                                    {(axes & 1U) != 0, (axes & 2U) != 0, (axes & 4U) != 0},
                                    {}});
  });
}

int live_build_springs(const char* volume, double theta, const char* shear, int is_large_strain,
                       const char* large_law, const char* integrator) {
  return guarded([&] {
    palpate::live::ModelChoice choice;
    choice.spring.volume = palpate::dynamics::parse_volume_model(volume);
    choice.spring.strain = palpate::live::strain_of(is_large_strain);
    choice.spring.large_law = palpate::dynamics::parse_strain_law(large_law);
    choice.spring.theta = theta;
    choice.spring.shear = palpate::dynamics::parse_strain_domain(shear);
    choice.integrator = palpate::dynamics::parse_integrator(integrator);
    palpate::live::build(choice);
  });
}

int live_build_smoothed(double theta, const char* domain, const char* rest, double stabilise,
                        int is_large_strain, const char* large_law, const char* integrator) {
  return guarded([&] {
    palpate::live::ModelChoice choice;
    choice.is_smoothed = true;
    choice.blend.strain = palpate::live::strain_of(is_large_strain);
    choice.blend.large_law = palpate::dynamics::parse_strain_law(large_law);
    choice.blend.theta = theta;
    choice.blend.domain = palpate::dynamics::parse_strain_domain(domain);
    choice.blend.rest = palpate::dynamics::parse_strain_domain(rest);
    choice.blend.stabilise = stabilise;
    choice.integrator = palpate::dynamics::parse_integrator(integrator);
    palpate::live::build(choice);
  });
}

const char* live_engine() {
  return stage().body ? stage().body->stepper().engine.c_str() : "";
}

const char* live_why_general() {
  return stage().body ? stage().body->stepper().why_general.c_str() : "";
}

int live_predict_step(double pad_pa_per_m, double* step_s, uint32_t* vertex) {
  return guarded([&] {
    const palpate::dynamics::StableStep stable = body().predict_step(pad_pa_per_m);
    *step_s = stable.step_s;
    *vertex = stable.limiting_vertex;
  });
}

int live_press(uint32_t vertex, double radius_m, double stiffness_pa_per_m) {
  return guarded([&] { body().press(vertex, radius_m, stiffness_pa_per_m); });
}

int live_slide(uint32_t vertex, double radius_m, double stiffness_pa_per_m) {
  return guarded([&] { body().slide(vertex, radius_m, stiffness_pa_per_m); });
}

int live_aim(double x_m, double y_m, double z_m, double speed_m_s) {
  return guarded([&] { body().aim({x_m, y_m, z_m}, speed_m_s); });
}

int live_release() {
  return guarded([] { body().release(); });
}

int live_pad(double* by_m) {
  return guarded([&] { palpate::live::write(body().pad_by_m(), by_m); });
}

int live_step(double step_s, uint32_t steps, int* is_whole) {
  return guarded([&] { *is_whole = body().step(step_s, steps) ? 1 : 0; });
}

int live_reset() {
  return guarded([] { body().reset(); });
}

int live_report(double* numbers) {
  return guarded([&] {
    const palpate::live::LiveReport report = body().report();
    numbers[0] = report.time_s;
    numbers[1] = report.kinetic_j;
    numbers[2] = report.elastic_j;
    numbers[3] = report.load_j;
    palpate::live::write(report.pad_force_n, numbers + 4);
    numbers[7] = report.largest_m;
    numbers[8] = static_cast<double>(report.inverted);
    numbers[9] = report.is_broken ? 1.0 : 0.0;
    numbers[10] = report.vertex == palpate::kNoIndex ? -1.0 : static_cast<double>(report.vertex);
    palpate::live::write(body().pad_by_m(), numbers + 11);
  });
}

int live_displacement(float* numbers) {
  return guarded([&] {
    for (const palpate::Vec3& u : body().state().displacement_m) {
      *numbers++ = static_cast<float>(u.x);
      *numbers++ = static_cast<float>(u.y);
      *numbers++ = static_cast<float>(u.z);
    }
  });
}

int live_state(double* displacement_m, double* velocity_m_s) {
  return guarded([&] {
    const palpate::dynamics::MotionState& state = body().state();
    for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
      palpate::live::write(state.displacement_m[v], displacement_m + 3 * v);
      palpate::live::write(state.velocity_m_s[v], velocity_m_s + 3 * v);
    }
  });
}

int live_table(uint32_t skin, const uint32_t* skin_vertices, const float* skin_compliance, const float* field,
               uint32_t element_order, uint32_t refine) {
  return guarded([&] {
    palpate::live::take_table(skin, skin_vertices, skin_compliance, field, static_cast<int>(element_order),
                              static_cast<int>(refine));
  });
}

int live_answer_press(double stiffness_pa_per_m) {
  return guarded([&] { palpate::live::answer().press(palpate::live::pad_of_answer(), stiffness_pa_per_m); });
}

int live_answer_release() {
  return guarded([] { palpate::live::answer().release(); });
}

int live_answer(double x_m, double y_m, double z_m, float* displacement_m, double* force_n) {
  return guarded([&] {
    const palpate::Vec3 by_m{x_m, y_m, z_m};
    for (const palpate::Vec3& u : palpate::live::answer().displacement(by_m)) {
      *displacement_m++ = static_cast<float>(u.x);
      *displacement_m++ = static_cast<float>(u.y);
      *displacement_m++ = static_cast<float>(u.z);
    }
    palpate::live::write(palpate::live::answer().pad_force(by_m), force_n);
  });
}
