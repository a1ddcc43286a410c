#include "experiments/scene_reader/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using test::SceneText;
using testing::HasSubstr;

class SceneFile : public testing::Test {
 protected:
  SceneFile() { write_medit(folder_ / "cube.mesh", build_kuhn_cube(2, 0.0, 0)); }

  Scene read(const SceneText& text) const { return read_scene(folder_.add("scene.yaml", text.yaml())); }

  std::string error_of(const SceneText& text) const {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  test::ScratchFolder folder_;
};

TEST_F(SceneFile, HoldsWhatItSays) {
  SceneText text;
  text.material = "{young_modulus_pa: 2000, poisson_ratio: 0.3, density_kg_m3: 900}";
  text.clamp =
      "\n  - {half_space: {normal: [0, 0, 2], offset_m: 0.01}, elastic_pa_per_m: 1.0e6}"
      "\n  - {box: {low_m: [0, 0, 0], high_m: [1, 1, 1]}, axes: [x, z]}";
  text.load =
      "\n  - {gravity_m_s2: [0, 0, -9.81]}"
      "\n  - {displace: {sphere: {center_m: [1, 2, 3], radius_m: 0.5}, by_m: [0, 0.1, 0], elastic_pa_per_m: "
      "7}}"
      "\n  - {force: {sphere: {surface_point: {direction: [0, 3, 4]}, radius_relative: 0.2}, total_n: [1, 0, "
      "0]}}";
  text.rest = "strain: large\nmodel: {springs: isotropy_patch, volume: tet}\n";
  const Scene scene = read(text);
  EXPECT_EQ(scene.name, "scene");
  EXPECT_EQ(scene.material.young_modulus_pa, 2000.0);
  EXPECT_EQ(scene.material.poisson_ratio, 0.3);
  EXPECT_EQ(scene.material.density_kg_m3, 900.0);
  EXPECT_EQ(scene.strain, StrainSize::kLarge);
  EXPECT_EQ(scene.model->method, "springs.isotropy_patch");
  EXPECT_EQ(scene.model->set.at("volume").text, "tet");
  ASSERT_EQ(scene.clamps.size(), 2U);
  EXPECT_EQ(scene.clamps[0].region.normal, (Vec3{0, 0, 1})) << "normals are made unit vectors";
  EXPECT_EQ(scene.clamps[0].elastic_pa_per_m, 1.0e6);
  EXPECT_FALSE(scene.clamps[1].elastic_pa_per_m.has_value());
  EXPECT_EQ(scene.clamps[1].axes, (std::array<bool, 3>{true, false, true}));
  ASSERT_EQ(scene.loads.size(), 3U);
  EXPECT_EQ(scene.loads[0].kind, SceneLoad::Kind::kGravity);
  EXPECT_EQ(scene.loads[1].elastic_pa_per_m, 7.0);
  EXPECT_EQ(scene.loads[1].region.center, (Vec3{1, 2, 3}));
  EXPECT_LT(length(*scene.loads[2].region.surface_direction - Vec3{0, 0.6, 0.8}), 1e-15);
  EXPECT_EQ(scene.loads[2].region.radius_relative, 0.2);
  EXPECT_FALSE(scene.is_dynamic);
}

TEST_F(SceneFile, OrgansKnowTheirUnit) {
  SceneText text;
  text.mesh = "{make: kidney, vertices: 1503}";
  EXPECT_EQ(read(text).mesh.unit_m, 0.001);
  text.mesh = "{make: bean, length_m: 0.2}";
  EXPECT_EQ(read(text).mesh.length_m, 0.2);
  EXPECT_FALSE(read(text).mesh.unit_m.has_value());
}

TEST_F(SceneFile, ASurfaceHasItsFillingBesideIt) {
  folder_.add("skin.stl", "solid a\nendsolid a\n");
  SceneText text;
  text.mesh = "{file: skin.stl, unit_m: 0.001, vertices: 1500, repair: true}";
  EXPECT_EQ(read(text).mesh.size.vertices, 1500U);
  EXPECT_TRUE(read(text).mesh.repair);
  text.mesh = "{file: skin.stl, unit_m: 0.001, edge_length: 4}";
  EXPECT_EQ(read(text).mesh.size.edge_length, 4.0);
  EXPECT_FALSE(read(text).mesh.repair);
  text.mesh = "{file: skin.stl, unit_m: 0.001, edge_length: 4, vertices: 1500}";
  EXPECT_THAT(error_of(text), HasSubstr("not both"));
  text.mesh = "{file: skin.stl, unit_m: 0.001, skin: fine}";
  EXPECT_THAT(error_of(text), HasSubstr("\"skin\" belongs to \"make\", not to the file of a surface"));
  text.mesh = "{file: cube.mesh, unit_m: 0.001, repair: true}";
  EXPECT_THAT(error_of(text), HasSubstr("\"repair\" belongs to the file of a surface"));
  text.mesh = "{make: bean, repair: true}";
  EXPECT_THAT(error_of(text), HasSubstr("\"repair\" belongs to the file of a surface"));
  text.mesh = "{file: cube.mesh, unit_m: 0.001, vertices: 1500}";
  EXPECT_THAT(error_of(text), HasSubstr("\"vertices\" belongs to \"make\", not to a file"));
}

TEST_F(SceneFile, ADynamicAnalysisIsReadAndMarked) {
  SceneText text;
  text.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: 3.0e-4, duration_s: 1.0}}";
  EXPECT_TRUE(read(text).is_dynamic);
  text.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: 0, duration_s: 1.0}}";
  EXPECT_THAT(error_of(text), HasSubstr("time_step_s: expected a number above 0"));
  text.analysis = "modal";
  EXPECT_THAT(error_of(text), HasSubstr("expected static or {dynamic: ...}, found \"modal\""));
}

TEST_F(SceneFile, EveryModelHasItsMethod) {
  for (const auto& [model, method] :
       {std::pair{"{finite_elements: p2}", "fem.p2"}, std::pair{"{tensor_mass: true}", "tensor_mass"},
        std::pair{"{smoothed: blend, theta: 0.5}", "smoothed.blend"}}) {
    SceneText text;
    text.rest = std::string("model: ") + model + "\n";
    EXPECT_EQ(read(text).model->method, method);
  }
  SceneText text;
  text.rest = "model: {springs: lloyd, tensor_mass: true}\n";
  EXPECT_THAT(error_of(text), HasSubstr("one model, not two"));
  text.rest = "model: {volume: tet}\n";
  EXPECT_THAT(error_of(text), HasSubstr("expected one of springs"));
}

TEST_F(SceneFile, PoissonRatiosOutsideTheirRange) {
  for (const char* ratio : {"-1", "0.5", "0.7", "-3", "nan", "0.49999999999999994"}) {
    SceneText text;
    text.material = std::string("{young_modulus_pa: 2000, poisson_ratio: ") + ratio + ", density_kg_m3: 900}";
    EXPECT_THAT(error_of(text), HasSubstr("scene.yaml:3: poisson_ratio: expected a")) << ratio;
  }
}

TEST_F(SceneFile, ModulusAndDensityAreAboveZero) {
  for (const char* bad : {"0", "-5", "inf"}) {
    SceneText text;
    text.material = std::string("{young_modulus_pa: ") + bad + ", poisson_ratio: 0.3, density_kg_m3: 900}";
    EXPECT_THAT(error_of(text), HasSubstr("young_modulus_pa: expected a number")) << bad;
    text.material = std::string("{young_modulus_pa: 1, poisson_ratio: 0.3, density_kg_m3: ") + bad + "}";
    EXPECT_THAT(error_of(text), HasSubstr("density_kg_m3: expected a number")) << bad;
  }
  SceneText text;
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 0}]";
  EXPECT_THAT(error_of(text), HasSubstr("elastic_pa_per_m: expected a number above 0"));
}

TEST_F(SceneFile, UnknownKeysAreNamedWithTheNearest) {
  SceneText text;
  text.rest = "strian: large\n";
  EXPECT_THAT(error_of(text), HasSubstr("scene.yaml:7: unknown key \"strian\"; did you mean \"strain\"?"));
  text.rest = "";
  text.load = "[{gravty_m_s2: [0, 0, -1]}]";
  EXPECT_THAT(error_of(text), HasSubstr("did you mean \"gravity_m_s2\"?"));
  text.load = "[{force: {sphere: {centre_m: [0, 0, 0], radius_m: 1}, total_n: [1, 0, 0]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("did you mean \"center_m\"?"));
}

/// A part of a scene that is wrong, and what is said of it.
TEST_F(SceneFile, WrongPartsAreRefused) {
  const auto with_mesh = [](const std::string& mesh) {
    SceneText text;
    text.mesh = mesh;
    return text;
  };
  const auto with_clamp = [](const std::string& clamp) {
    SceneText text;
    text.clamp = clamp;
    return text;
  };
  const auto with_load = [](const std::string& load) {
    SceneText text;
    text.load = load;
    return text;
  };
  EXPECT_THAT(error_of(with_mesh("{file: none.mesh, unit_m: 1}")), HasSubstr("found none at"));
  EXPECT_THAT(error_of(with_mesh("{file: cube.mesh}")), HasSubstr("how long is the mesh?"));
  EXPECT_THAT(error_of(with_mesh("{make: bar}")), HasSubstr("how long is the mesh?"));
  EXPECT_THAT(error_of(with_mesh("{make: kindey}")), HasSubstr("did you mean \"kidney\"?"));
  EXPECT_THAT(error_of(with_mesh("{make: bar, file: cube.mesh, unit_m: 1}")),
              HasSubstr("one of \"make\" and"));
  EXPECT_THAT(error_of(with_mesh("{make: bar, unit_m: 1, length_m: 1}")), HasSubstr("not both"));
  EXPECT_THAT(error_of(with_clamp("[{elastic_pa_per_m: 1}]")), HasSubstr("expected one region"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0, 0], offset_m: 0}}]")),
              HasSubstr("not all zero"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0], offset_m: 0}}]")),
              HasSubstr("three numbers"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0, 1]}}]")),
              HasSubstr("one of \"offset_m\" and"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0, 1], share: 1.5}}]")),
              HasSubstr("from 0 to 1"));
  EXPECT_THAT(error_of(with_clamp("[{sphere: {center_m: [0, 0, 0], radius_m: 0}}]")),
              HasSubstr("a positive number"));
  EXPECT_THAT(error_of(with_clamp("[{box: {low_m: [1, 0, 0], high_m: [0, 1, 1]}}]")),
              HasSubstr("low_m below high_m"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [w]}]")),
              HasSubstr("expected x, y or z"));
  EXPECT_THAT(error_of(with_clamp("[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [x], "
                                  "elastic_pa_per_m: 1}]")),
              HasSubstr("axes belong to a hard clamp"));
  EXPECT_THAT(error_of(with_load("[]")), HasSubstr("one that does something"));
  EXPECT_THAT(error_of(with_load("[{gravity_m_s2: [0, 0, 0]}]")), HasSubstr("one that does something"));
  EXPECT_THAT(error_of(with_load("[{gravity_m_s2: [0, 0, 1]}, {gravity_m_s2: [0, 1, 0]}]")),
              HasSubstr("gravity twice"));
  EXPECT_THAT(error_of(with_load("[{force: {sphere: {center_m: [0, 0, 0], radius_m: 1}}}]")),
              HasSubstr("\"total_n\" is missing"));
}

TEST_F(SceneFile, TrainedSpringsHaveNoPlaceForTheirFile) {
  test::SceneText text;
  text.rest = "model: {springs: trained}\n";
  EXPECT_THAT(error_of(text), HasSubstr(":7: springs: expected springs that are found on the mesh"));
}

TEST(Scenes, OfTheProjectCanBeReadAndAreNamed) {
  const auto names = scene_names();
  ASSERT_GE(names.size(), 20U);
  for (const std::string& name : names) {
    const Scene scene = read_scene(scene_path(name));
    EXPECT_EQ(scene.name, name);
  }
}

}  // namespace
}  // namespace palpate::experiments
