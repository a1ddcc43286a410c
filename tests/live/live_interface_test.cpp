// The interface of numbers and arrays, and the same sources compiled to WebAssembly: both builds hold one
// state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "live/interface/live_interface.h"
#include "tests/support/live_cases.h"
#include "tests/support/scratch_folder.h"

namespace palpate::live {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

template <typename Number, typename List>
std::vector<Number> flat(const List& items) {
  std::vector<Number> out;
  for (const auto& item : items) out.insert(out.end(), item.begin(), item.end());
  return out;
}

/// A cube and what is done to it, as the request of step_in_node.cjs.
json make_request(const BodySetup& setup, const json& model, const json& actions) {
  std::vector<double> points;
  for (const Vec3& p : setup.mesh.points) points.insert(points.end(), {p.x, p.y, p.z});
  const Material& material = setup.holding.material;
  const ElasticSupport& support = setup.holding.supports.front();
  return {{"points", points},
          {"tets", flat<std::uint32_t>(setup.mesh.tets)},
          {"material", {material.young_modulus_pa, material.poisson_ratio, material.density_kg_m3}},
          {"damping", {setup.damping_stiffness_s, setup.damping_mass_per_s}},
          {"springs",
           {{"ends", flat<std::uint32_t>(setup.springs.springs)},
            {"rest_length_m", setup.springs.rest_length_m},
            {"stiffness_n_per_m", setup.springs.stiffness_n_per_m}}},
          {"supports", json::array({{{"faces", flat<std::uint32_t>(support.patch.faces)},
                                     {"weights", support.patch.weight},
                                     {"stiffness_pa_per_m", support.stiffness_pa_per_m}}})},
          {"model", model},
          {"actions", actions}};
}

void expect_done(int result) {
  ASSERT_EQ(result, 0) << live_message();
}

void set_up(const json& request) {
  const auto points = request.at("points").get<std::vector<double>>();
  const auto tets = request.at("tets").get<std::vector<std::uint32_t>>();
  const json& material = request.at("material");
  expect_done(live_setup(static_cast<std::uint32_t>(points.size() / 3), points.data(),
                         static_cast<std::uint32_t>(tets.size() / 4), tets.data(), material[0], material[1],
                         material[2], request.at("damping")[0], request.at("damping")[1]));
  const json& springs = request.at("springs");
  const auto ends = springs.at("ends").get<std::vector<std::uint32_t>>();
  const auto rest = springs.at("rest_length_m").get<std::vector<double>>();
  const auto stiffness = springs.at("stiffness_n_per_m").get<std::vector<double>>();
  expect_done(
      live_springs(static_cast<std::uint32_t>(rest.size()), ends.data(), rest.data(), stiffness.data()));
  for (const json& support : request.at("supports")) {
    const auto faces = support.at("faces").get<std::vector<std::uint32_t>>();
    const auto weights = support.at("weights").get<std::vector<double>>();
    expect_done(live_support(static_cast<std::uint32_t>(weights.size()), faces.data(), weights.data(),
                             support.at("stiffness_pa_per_m")));
  }
}

void build(const json& model) {
  const auto text = [](const json& value) { return value.get<std::string>(); };
  if (model.contains("smoothed")) {
    const json& m = model.at("smoothed");
    expect_done(live_build_smoothed(m[0], text(m[1]).c_str(), text(m[2]).c_str(), m[3], m[4],
                                    text(m[5]).c_str(), text(m[6]).c_str()));
  } else {
    const json& m = model.at("springs");
    expect_done(live_build_springs(text(m[0]).c_str(), m[1], text(m[2]).c_str(), m[3], text(m[4]).c_str(),
                                   text(m[5]).c_str()));
  }
}

void act(const json& action) {
  const auto name = action[0].get<std::string>();
  int is_whole = 0;
  if (name == "live_press") expect_done(live_press(action[1], action[2], action[3]));
  if (name == "live_aim") expect_done(live_aim(action[1], action[2], action[3], action[4]));
  if (name == "live_release") expect_done(live_release());
  if (name == "live_step") expect_done(live_step(action[1], action[2], &is_whole));
}

/// Displacements, velocities and the report, as step_in_node.cjs writes them.
std::vector<double> run_native(const json& request) {
  set_up(request);
  build(request.at("model"));
  for (const json& action : request.at("actions")) act(action);
  const std::size_t vertices = request.at("points").size() / 3;
  std::vector<double> out(6 * vertices + PALPATE_LIVE_REPORT);
  expect_done(live_state(out.data(), out.data() + 3 * vertices));
  expect_done(live_report(out.data() + 6 * vertices));
  return out;
}

std::vector<double> run_wasm(const json& request) {
  const test::ScratchFolder folder;
  const fs::path in = folder.path() / "request.json";
  const fs::path out = folder.path() / "state.bin";
  std::ofstream(in) << request.dump();
  const fs::path engine = fs::path(experiments::program_folder()).parent_path() / "page" / "live_engine.js";
  const std::string command = "node '" + experiments::source_folder() + "/tests/live/step_in_node.cjs' '" +
                              engine.string() + "' '" + in.string() + "' '" + out.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  const auto bytes = experiments::read_bytes(out);
  if (!bytes) return {};
  std::vector<double> numbers(bytes->size() / sizeof(double));
  std::memcpy(numbers.data(), bytes->data(), numbers.size() * sizeof(double));
  return numbers;
}

json press_and_release(const BodySetup& setup, double step_s) {
  return json::array({json::array({"live_press", testing_support::top_vertex(setup.mesh), 0.015, 5e6}),
                      json::array({"live_aim", 0.001, 0.0, -0.004, 0.1}),
                      json::array({"live_step", step_s, 700}), json::array({"live_release"}),
                      json::array({"live_step", step_s, 300})});
}

/// The same bits after 1,000 steps: no fast-math and no contraction on either side, sums in one order, square
/// roots and quotients that IEEE rounds in one way; and no function of the C library, which need not. So the
/// tolerance is zero, and one bit that differs anywhere is a difference of the sources as they were compiled.
TEST(LiveWebAssembly, HoldsTheStateOfTheNativeBuildToTheBitOverAThousandSteps) {
  const BodySetup setup = testing_support::make_live_cube(5);
  const std::vector<json> models{
      {{"springs", {"none", 0.6, "node", 1, "corotated", "symplectic_euler"}}},
      {{"springs", {"node_average", 0.6, "node", 1, "corotated", "symplectic_euler"}}},
      {{"springs", {"none", 0.6, "node", 1, "corotated", "runge_kutta_4"}}},
      {{"smoothed", {0.0, "node", "edge", 0.0, 1, "corotated", "symplectic_euler"}}},
      {{"smoothed", {0.7, "node", "tet", 0.0, 0, "corotated", "symplectic_euler"}}},
  };
  for (const json& model : models) {
    const json request = make_request(setup, model, press_and_release(setup, 2e-4));
    const std::vector<double> native = run_native(request);
    ASSERT_EQ(native[native.size() - 5], 0.0) << model;   // not broken
    ASSERT_GT(native[native.size() - 7], 1e-5) << model;  // and in motion
    EXPECT_EQ(run_wasm(request), native) << model;
  }
}

/// The comparison sees a single spring that is stiffer by a millionth.
TEST(LiveWebAssembly, DiffersWhereASpringDoes) {
  const BodySetup setup = testing_support::make_live_cube(3);
  json request = make_request(setup, {{"springs", {"none", 0.6, "node", 1, "corotated", "symplectic_euler"}}},
                              press_and_release(setup, 2e-4));
  const std::vector<double> native = run_native(request);
  request["springs"]["stiffness_n_per_m"][40] = 1.000001 * setup.springs.stiffness_n_per_m[40];
  EXPECT_NE(run_wasm(request), native);
}

TEST(LiveInterface, SaysWhatIsWrong) {
  const BodySetup setup = testing_support::make_live_cube(2);
  const json request = make_request(setup, {}, {});
  set_up(request);
  EXPECT_EQ(live_build_springs("nothing", 0.6, "node", 1, "corotated", "symplectic_euler"), 1);
  EXPECT_THAT(live_message(), testing::HasSubstr("node_average"));
  EXPECT_EQ(live_build_springs("none", 0.6, "node", 1, "corotated", "leapfrog"), 1);
  EXPECT_THAT(live_message(), testing::HasSubstr("leapfrog"));
  int is_whole = 0;
  EXPECT_EQ(live_step(1e-4, 1, &is_whole), 1) << "there is no body";
  const std::uint32_t faces[] = {0, 1, 27};
  const double weight = 1.0;
  EXPECT_EQ(live_support(1, faces, &weight, 1e6), 1) << "vertex 27 is not there";
  EXPECT_THAT(live_message(), testing::HasSubstr("27"));
  build({{"springs", {"none", 0.6, "node", 1, "corotated", "symplectic_euler"}}});
  EXPECT_EQ(live_answer_press(5e6), 1) << "there is no table";
  EXPECT_EQ(live_press(13, 0.01, 5e6), 1) << "inside";
  EXPECT_EQ(live_press(0, 0.01, 5e6), 0);
}

}  // namespace
}  // namespace palpate::live
