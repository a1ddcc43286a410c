// What simulate says of a scene that is not as it was fitted: each way out by itself, and none where there is
// none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/envelope/envelope_output.h"
#include "experiments/files/file_hash.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

json fitted_scene() {
  return json::parse(R"({
    "schema": "palpate/scene/1",
    "mesh": {"file": "organ.mesh", "unit_m": 1},
    "material": {"young_modulus_pa": 10000, "poisson_ratio": 0.45, "density_kg_m3": 1050},
    "strain": "small",
    "model": {"smoothed": "edge_node"},
    "clamp": [{"half_space": {"normal": [0, 0, 1], "offset_m": 0}, "elastic_pa_per_m": 1000000},
              {"box": {"low_m": [0, 0, 0], "high_m": [0.1, 0.1, 0.1]}, "axes": ["x", "y"]}],
    "load": [{"gravity_m_s2": [0, 0, -9.81], "profile": {"times_s": [0, 0.1], "shares": [0, 1]}},
             {"displace": {"sphere": {"center_m": [1, 1, 1], "radius_m": 0.5}, "by_m": [0, 0, -0.005],
                           "elastic_pa_per_m": 5000000},
              "profile": {"times_s": [0, 0.1, 0.3, 0.4], "shares": [0, 1, 1, 0]}, "until_s": 0.45}],
    "analysis": {"dynamic": {"integrator": "symplectic_euler", "time_step_s": 0.001, "duration_s": 0.5,
                             "damping": {"mass_per_s": 20}}},
    "require": {"error": {"measure": "deformation_l2", "at_most": 0.05}},
    "envelope": "envelope.json"})");
}

/// A fitted folder: organ.mesh, envelope.json with all axes measured to 2, and a scene.
class LeavesEnvelope : public testing::Test {
 protected:
  LeavesEnvelope() {
    const TetMesh cube = build_kuhn_cube(2, 0.0, 0);
    write_medit(folder_ / "organ.mesh", cube);
    write_medit(folder_ / "other.mesh", build_kuhn_cube(3, 0.0, 0));
    EnvelopeResult result;
    result.at_most = 0.05;
    result.measure = "deformation_l2";
    result.scene = fitted_scene();
    result.model = result.scene.at("model");
    result.place = place_of(result.scene);
    result.mesh_hash = hash_file(folder_ / "organ.mesh");
    EnvelopeProbe fails;
    fails.factor = 2.2;
    fails.ending = "error";
    for (const EnvelopeAxis axis : axes_of(result.scene)) {
      result.axes.push_back(axis);
      result.borders.push_back({{fails}, 2.0, 2.2, true});
    }
    envelope_ = describe_envelope(result);
  }

  /// What is said of a scene beside the envelope; of the fitted one with a value in another's place, or
  /// without it.
  std::vector<std::string> said(const json& scene) const {
    folder_.add("envelope.json", envelope_.dump());
    return leaves_envelope(read_scene(folder_.add("scene.yaml", scene.dump())));
  }
  std::vector<std::string> said(const char* at, const json& value) const {
    json scene = fitted_scene();
    scene[json::json_pointer(at)] = value;
    return said(scene);
  }
  std::vector<std::string> said_without(const char* at) const {
    const json::json_pointer place(at);
    json scene = fitted_scene();
    scene.at(place.parent_pointer()).erase(place.back());
    return said(scene);
  }

  test::ScratchFolder folder_;
  json envelope_;
};

TEST_F(LeavesEnvelope, NothingIsSaidOfTheFittedSceneHoweverItIsWritten) {
  EXPECT_THAT(said(fitted_scene()), IsEmpty());
  EXPECT_THAT(said_without("/strain"), IsEmpty()) << "small is the default";
  EXPECT_THAT(said("/clamp/1/axes", {"y", "x"}), IsEmpty());
  EXPECT_THAT(said("/clamp/0/elastic_pa_per_m", 1.0e6), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/precision", "double"), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/solver", {{"iterations", 1000}}), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/damping/stiffness_s", 0), IsEmpty());
  // What is written of a motion is no part of it, and neither is what can only be easier.
  EXPECT_THAT(said("/analysis/dynamic/frames", 3), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/probes_m", json::array({json::array({1, 1, 1})})), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/duration_s", 0.4), IsEmpty());
  EXPECT_THAT(said("/analysis/dynamic/time_step_s", 0.0005), IsEmpty());
  EXPECT_THAT(said("/load/1/profile/times_s", {0, 0.2, 0.4, 0.6}), IsEmpty());
  EXPECT_THAT(said("/require/error/at_most", 0.1), IsEmpty());
  EXPECT_THAT(said_without("/require"), IsEmpty());
}

TEST_F(LeavesEnvelope, OtherSupportsAreSaid) {
  EXPECT_THAT(
      said("/clamp/0/elastic_pa_per_m", 2.0e6),
      ElementsAre("support 1: elastic_pa_per_m is 2000000, where 1000000 was fitted: the envelope says "
                  "nothing of it"));
  EXPECT_THAT(said("/clamp/0/half_space/offset_m", 0.01),
              ElementsAre(HasSubstr("support 1: half_space.offset_m is 0.01, where 0 was fitted")));
  EXPECT_THAT(said_without("/clamp/1/axes"),
              ElementsAre(HasSubstr("support 2: axes is [x, y, z], where [x, y] was fitted")));
  EXPECT_THAT(said("/clamp", json::array({fitted_scene().at("clamp").at(0)})),
              ElementsAre(HasSubstr("it has 1 supports (clamp), where 2 were fitted")));
  EXPECT_THAT(said_without("/clamp"), ElementsAre(HasSubstr("it has 0 supports")));
}

TEST_F(LeavesEnvelope, OtherPlacesBedsAndDirectionsOfLoadsAreSaid) {
  EXPECT_THAT(said("/load/1/displace/sphere/center_m", {0, 1, 1}),
              ElementsAre(HasSubstr("load 2: sphere.center_m is [0, 1, 1], where [1, 1, 1] was fitted")));
  EXPECT_THAT(said("/load/1/displace/sphere/radius_m", 0.6),
              ElementsAre(HasSubstr("sphere.radius_m is 0.6")));
  EXPECT_THAT(said("/load/1/displace/elastic_pa_per_m", 1000),
              ElementsAre(HasSubstr("load 2: elastic_pa_per_m is 1000")));
  EXPECT_THAT(said_without("/load/1/displace/elastic_pa_per_m"),
              ElementsAre(HasSubstr("load 2: elastic_pa_per_m is none, where 5000000 was fitted")));
  EXPECT_THAT(said("/load/1/displace/by_m", {0.005, 0, 0}),
              ElementsAre(HasSubstr("load 2 is turned by 90 degrees")));
  EXPECT_THAT(said("/load/1/displace/by_m", {0, 0, 0.005}),
              ElementsAre(HasSubstr("load 2 is turned by 180 degrees")));
}

TEST_F(LeavesEnvelope, SizesOfLoadsToEachOtherAreSaid) {
  EXPECT_THAT(said("/load/1/displace/by_m", {0, 0, -0.009}), IsEmpty()) << "1.8 times, within 1.3 to 0.7";
  EXPECT_THAT(said("/load/1/displace/by_m", {0, 0, -0.00001}),
              ElementsAre(HasSubstr("load 2 is 0.002 times the fitted one and load 1 1 times")));
  json both = fitted_scene();
  both["load"][0]["gravity_m_s2"] = {0, 0, -19.0};
  both["load"][1]["displace"]["by_m"] = {0, 0, -0.0099};
  EXPECT_THAT(said(both), IsEmpty()) << "twice as large together, as measured";
}

TEST_F(LeavesEnvelope, LostAndOtherTimesOfLoadsAreSaid) {
  EXPECT_THAT(said_without("/load/1/profile"),
              ElementsAre(HasSubstr("load 2 is there all at once, where it was fitted with a profile")));
  EXPECT_THAT(said("/load/0/profile/smooth", true),
              ElementsAre(HasSubstr("load 1: profile.smooth is true, where false was fitted")));
  EXPECT_THAT(said("/load/1/profile", {{"times_s", {0, 0.1}}, {"shares", {0, 1}}}),
              ElementsAre(HasSubstr("load 2: profile.shares is [0, 1], where [0, 1, 1, 0] was fitted")));
  EXPECT_THAT(said_without("/load/1/until_s"),
              ElementsAre(HasSubstr("load 2: until_s is none, where 0.45 was fitted")));
  EXPECT_THAT(said("/load/0/until_s", 0.4), ElementsAre(HasSubstr("load 1: until_s is 0.4")));
  // The first load comes three times as fast: the shortest time of all is still that of the second.
  EXPECT_THAT(said("/load/0/profile/times_s", {0, 0.1 / 3.0}),
              ElementsAre(HasSubstr("times of the loads divided by 3, measured to hold up to 2")));
}

TEST_F(LeavesEnvelope, AnotherStrainIntegratorPrecisionOrSolverIsSaid) {
  EXPECT_THAT(said("/strain", "large"), ElementsAre(HasSubstr("strain is large, where small was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/integrator", "trapezoidal"),
              ElementsAre(HasSubstr("integrator is trapezoidal, where symplectic_euler was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/precision", "single"),
              ElementsAre(HasSubstr("precision is single, where double was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/solver", {{"iterations", 5}}),
              ElementsAre(HasSubstr("solver.iterations is 5, where 1000 was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/time_step_s", "auto"),
              ElementsAre(HasSubstr("time_step_s is auto, where 0.001 was fitted")));
  EXPECT_THAT(said_without("/analysis/dynamic/damping"),
              ElementsAre(HasSubstr("damping.mass_per_s is 0, where 20 was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/duration_s", 5),
              ElementsAre(HasSubstr("duration_s is 5, where 0.5 was fitted")));
  EXPECT_THAT(said("/analysis/dynamic/speed_limit_m_s", 1),
              ElementsAre(HasSubstr("speed_limit_m_s is 1, where none was fitted")));
  json still = fitted_scene();
  still["analysis"] = "static";
  for (json& load : still["load"]) {
    load.erase("profile");
    load.erase("until_s");
  }
  EXPECT_THAT(said(still), testing::Contains(HasSubstr("it is at rest (analysis)")));
}

TEST_F(LeavesEnvelope, WhatTheAxesMeasureIsSaidAsBefore) {
  EXPECT_THAT(said("/material/young_modulus_pa", 30000),
              testing::Contains(HasSubstr("Young's modulus times 3, measured to hold up to 2")));
  EXPECT_THAT(said("/material/density_kg_m3", 105),
              testing::Contains(HasSubstr("density divided by 10, measured to hold up to 2")));
  EXPECT_THAT(said("/analysis/dynamic/time_step_s", 0.003),
              ElementsAre(HasSubstr("time step times 3, measured to hold up to 2")));
  EXPECT_THAT(said("/mesh/unit_m", 0.001),
              ElementsAre(HasSubstr("mesh: unit_m is 0.001, where 1 was fitted")));
  EXPECT_THAT(said("/mesh/file", "other.mesh"), ElementsAre(HasSubstr("its mesh is not the fitted one")));
  EXPECT_THAT(said("/model", {{"smoothed", "blend"}}), ElementsAre(HasSubstr("its model is not")));
  EXPECT_THAT(said("/material/poisson_ratio", 0.3), ElementsAre(HasSubstr("Poisson's ratio is another")));
  EXPECT_THAT(said("/require/error/at_most", 0.01),
              ElementsAre(HasSubstr("error.at_most is 0.01, where 0.05 was fitted")));
}

TEST_F(LeavesEnvelope, AnEnvelopeOfAnOlderProgramSaysWhatItKnows) {
  envelope_.erase("scene");
  EXPECT_THAT(said("/clamp/0/elastic_pa_per_m", 2.0e6), ElementsAre(HasSubstr("of an older Palpate")));
  EXPECT_THAT(said("/analysis/dynamic/time_step_s", 0.003),
              ElementsAre(HasSubstr("of an older Palpate"), HasSubstr("time step times 3")));
  envelope_.erase("axes");
  EXPECT_THROW(said(fitted_scene()), InputError);
}

TEST_F(LeavesEnvelope, WhatCouldNotBeMeasuredIsNotSaidToPassTheTolerance) {
  const auto heavier = [&] { return said("/material/density_kg_m3", 4000); };
  ASSERT_THAT(heavier(), testing::Contains(HasSubstr("at 2.2: the error passes the tolerance")));
  for (json& axis : envelope_.at("axes")) axis["ending"] = kNotMeasured;
  EXPECT_THAT(heavier(), testing::Contains(HasSubstr("at 2.2: no error could be measured")));
  EXPECT_THAT(heavier(), testing::Not(testing::Contains(HasSubstr("passes the tolerance"))));
}

}  // namespace
}  // namespace palpate::experiments
