// reduced.compliance, reduced.modal and reduced.pod as the runner starts them: against FEniCSx, and what they
// refuse.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/closed_form/structured_mesh.h"
#include "reference/door/deform_problem.h"
#include "reference/door/json_file.h"
#include "reference/reduced/pod_file.h"
#include "reference/reduced/table_file.h"
#include "tests/support/contestant_starter.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using dynamics::ComplianceTable;
using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

/// A cube on an elastic foot that is pressed by a pad, pulled by its weight, and held at one side.
BoundaryProblem loaded_cube(const TetMesh& mesh) {
  BoundaryProblem problem;
  problem.material = {1e4, 0.3, 1000.0};
  problem.gravity_m_s2 = {0.0, 1.0, -9.81};
  const auto add = [](FacePatch& patch, const Triangle& face, double weight) {
    patch.faces.push_back(face);
    patch.weight.push_back(weight);
  };
  problem.supports = {{{}, 1e6, {}}, {{}, 2e6, {0.0, 0.0, -0.01}}};
  problem.tractions = {{{}, {10.0, 0.0, -50.0}, 20.0}};
  problem.held = {{{}, {false, true, true}, {0.0, 0.01, 0.0}}};
  for (const Triangle& face : build_boundary(mesh)) {
    const Vec3 middle = (1.0 / 3.0) * (mesh.points[face[0]] + mesh.points[face[1]] + mesh.points[face[2]]);
    if (middle.z < 1e-9) add(problem.supports[0].patch, face, middle.x);
    if (middle.z > 1.0 - 1e-9) {
      add(middle.x < 0.5 ? problem.supports[1].patch : problem.tractions[0].patch, face, 0.5);
    } else if (middle.x < 1e-9) {
      problem.held[0].faces.push_back(face);
    }
  }
  return problem;
}

class Reduced : public testing::Test {
 protected:
  ContestantAnswer ask(const std::string& method, const json& options) {
    return starter_.run(method, mesh_, problem_to_json(problem_), options);
  }

  std::vector<Vec3> displacement(const ContestantAnswer& answer) {
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    std::vector<Vec3> rows = read_displacement(answer.output, mesh_.points.size(), build_edges(mesh_).size());
    rows.resize(mesh_.points.size());
    return rows;
  }

  double midpoints_off(const ContestantAnswer& a, const ContestantAnswer& b) {
    const std::size_t vertices = mesh_.points.size();
    const std::size_t edges = build_edges(mesh_).size();
    const std::vector<Vec3> first = read_displacement(a.output, vertices, edges);
    const std::vector<Vec3> second = read_displacement(b.output, vertices, edges);
    EXPECT_EQ(second.size(), vertices + edges);
    return difference(first, second);
  }

  static double difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0.0;
    double size = 1e-300;
    for (std::size_t v = 0; v < std::min(a.size(), b.size()); ++v) {
      most = std::max(most, length(a[v] - b[v]));
      size = std::max(size, length(a[v]));
    }
    return most / size;
  }

  test::ContestantStarter starter_;
  test::ScratchFolder scratch_;
  TetMesh mesh_ = build_kuhn_cube(3, 0.25, 6);
  BoundaryProblem problem_ = loaded_cube(mesh_);
};

TEST_F(Reduced, ComplianceAgreesWithFenicsx) {
  for (const std::string order : {"p1", "p2"}) {
    const ContestantAnswer elements = ask("fem." + order, {{"rtol", 1e-13}});
    const ContestantAnswer table =
        ask("reduced.compliance", {{"elements", order},
                                   {"reactions", order == "p1" ? "linear" : "quadratic"},
                                   {"midpoints", order == "p2"},
                                   {"precision", "double"}});
    EXPECT_LT(difference(displacement(elements), displacement(table)), 1e-6) << order;
    if (order == "p2") {
      EXPECT_LT(midpoints_off(elements, table), 1e-6);
    }
    const double energy = elements.report.at("energy_j").get<double>();
    EXPECT_NEAR(table.report.at("energy_j").get<double>(), energy, 1e-6 * energy);
    for (std::size_t s = 0; s < 2; ++s) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double force = elements.report.at("support_forces_n")[s][axis].get<double>();
        EXPECT_NEAR(table.report.at("support_forces_n")[s][axis].get<double>(), force, 1e-5);
      }
    }
    EXPECT_GT(table.report.at("skin_table_bytes").get<double>(), 0.0);
  }
}

TEST_F(Reduced, LinearReactionsAreNearerThanLinearElementsWhereTractionsAreContinuous) {
  problem_ = {};  // a bed on all sides: its traction is as continuous as the displacement
  problem_.material = {1e4, 0.3, 1000.0};
  problem_.gravity_m_s2 = {1.0, 2.0, -9.81};
  problem_.supports = {{{build_boundary(mesh_), {}}, 1e4, {}}};
  problem_.supports[0].patch.weight.assign(problem_.supports[0].patch.faces.size(), 1.0);
  const std::vector<Vec3> quadratic = displacement(ask("fem.p2", json::object()));
  const std::vector<Vec3> linear = displacement(ask("fem.p1", json::object()));
  const double off = difference(quadratic, displacement(ask("reduced.compliance", json::object())));
  EXPECT_LT(off, 0.5 * difference(quadratic, linear));
  EXPECT_GT(off, 1e-7);
}

TEST_F(Reduced, ModalAtRestAgreesWithFenicsx) {
  const std::vector<Vec3> elements = displacement(ask("fem.p2", {{"rtol", 1e-13}}));
  EXPECT_LT(difference(elements, displacement(ask("reduced.modal", {{"modes", 5}}))), 1e-6);
  EXPECT_GT(difference(elements, displacement(ask("reduced.modal", {{"modes", 5}, {"correction", false}}))),
            1e-3);
}

TEST_F(Reduced, TheSameRequestGivesTheSameBytesOnOneThreadAndTwo) {
  for (const char* method : {"reduced.compliance", "reduced.modal"}) {
    std::vector<std::string> bytes;
    for (const char* threads : {"1", "2"}) {
      setenv("OMP_NUM_THREADS", threads, 1);
      bytes.push_back(read_text_file(ask(method, json::object()).output, 1U << 20U));
    }
    unsetenv("OMP_NUM_THREADS");
    EXPECT_EQ(bytes[0], bytes[1]);
  }
}

TEST_F(Reduced, ATableIsWrittenReadBackToTheBitAndAnswersTheSame) {
  const json small{{"elements", "p1"}};
  json writing = small;
  writing["write_table"] = true;
  const ContestantAnswer made = ask("reduced.compliance", writing);
  const std::vector<Vec3> first = displacement(made);
  const std::filesystem::path file = made.report.at("table_file").get<std::string>();
  EXPECT_EQ(made.report.at("table_format"), "palpate/compliance_table/1");
  const ComplianceTable table = read_table(file);
  const auto copy = scratch_ / "copy";
  write_table(copy, table);
  EXPECT_EQ(read_text_file(file, 1U << 28U), read_text_file(copy, 1U << 28U));
  json reading = small;
  reading["table"] = copy.string();
  const ContestantAnswer again = ask("reduced.compliance", reading);
  EXPECT_EQ(displacement(again), first);
  EXPECT_EQ(again.report.at("identify_s"), 0.0);

  // Another body, or another kind of table: refused.
  mesh_.points[0].x -= 0.01;
  const ContestantAnswer other = ask("reduced.compliance", reading);
  EXPECT_EQ(other.outcome, "bad_input");
  EXPECT_THAT(other.message, HasSubstr("another mesh"));
  mesh_.points[0].x += 0.01;
  reading["elements"] = "p2";
  EXPECT_EQ(ask("reduced.compliance", reading).outcome, "bad_input");
}

TEST_F(Reduced, ABrokenTableIsRefused) {
  const ContestantAnswer made = ask("reduced.compliance", {{"elements", "p1"}, {"write_table", true}});
  ASSERT_EQ(made.outcome, "ok") << made.message;
  const std::string good = read_text_file(made.report.at("table_file").get<std::string>(), 1U << 28U);
  const auto refused = [&](std::string bytes) {
    const auto path = scratch_ / "broken";
    std::ofstream(path, std::ios::binary) << bytes;
    EXPECT_THROW(read_table(path), InputError);
  };
  refused("");
  refused("palpate/compliance_table/2" + good.substr(good.find('\n')));
  refused(good.substr(0, good.size() - 1));
  refused(good + "x");
  std::string nan = good;
  for (std::size_t k = 1; k <= 4; ++k) nan[nan.size() - k] = static_cast<char>(0xff);
  refused(nan);
  std::string many = good;
  many.replace(many.find("skin_vertices ") + 14, 1, "9");
  refused(many);
  EXPECT_NO_THROW(read_table(made.report.at("table_file").get<std::string>()));
}

TEST_F(Reduced, SaysWhatItCannotDo) {
  problem_.strain = StrainSize::kLarge;
  for (const char* method : {"reduced.compliance", "reduced.modal"}) {
    const ContestantAnswer answer = ask(method, json::object());
    EXPECT_EQ(answer.outcome, "bad_input");
    EXPECT_THAT(answer.message, HasSubstr("linear"));
  }
  problem_ = loaded_cube(mesh_);
  EXPECT_EQ(ask("reduced.compliance", {{"elements", "p1"}, {"reactions", "quadratic"}}).outcome, "bad_input");
  EXPECT_EQ(ask("reduced.compliance", {{"colour", "red"}}).outcome, "bad_input");
  problem_.supports.clear();
  problem_.held.clear();
  const ContestantAnswer free = ask("reduced.modal", json::object());
  EXPECT_EQ(free.outcome, "bad_input");
  EXPECT_THAT(free.message, HasSubstr("left free"));
}

/// A rod in motion through the door.
TEST_F(Reduced, PodIsTrainedBesideItsLoadAndMeetsTheFullModel) {
  problem_.strain = StrainSize::kLarge;
  problem_.gravity_m_s2 = {};
  problem_.held.clear();
  problem_.supports[0].stiffness_pa_per_m = 1e5;
  problem_.supports[1].by_m = {0.0, 0.05, -0.15};
  problem_.supports[1].stiffness_pa_per_m = 1e5;
  const json options = {{"check", true}, {"training", 8}, {"validation", 2}, {"force_tolerance", 1e-3}};
  const ContestantAnswer answer = ask("reduced.pod", options);
  const std::vector<Vec3> u = displacement(answer);
  ASSERT_FALSE(u.empty());
  EXPECT_EQ(answer.report.at("training_loads"), 8);
  EXPECT_LE(answer.report.at("force_residual").get<double>(), 1e-3);
  EXPECT_LT(answer.report.at("domains").get<double>(),
            0.5 * answer.report.at("domains_of_all").get<double>());
  // What it says of itself is what the full model says of it.
  const double off = difference(displacement(ask("smoothed.edge_node", json::object())), u);
  EXPECT_LT(off, 0.1);
  EXPECT_LT(answer.report.at("test_error").get<double>(), 0.1);
  EXPECT_GT(answer.report.at("test_error").get<double>(), 1e-6);  // it never saw this load
  // The same request, the same answer: the loads are drawn from a seed.
  EXPECT_EQ(difference(u, displacement(ask("reduced.pod", options))), 0.0);

  EXPECT_EQ(ask("reduced.pod", {{"modes", 0}}).outcome, "bad_input");
  BoundaryProblem good = problem_;
  problem_.held = {{{problem_.supports[0].patch.faces[0]}, {true, true, true}, {0.0, 0.01, 0.0}}};
  EXPECT_THAT(ask("reduced.pod", json::object()).message, HasSubstr("held faces that are moved"));
  problem_ = good;
  problem_.strain = StrainSize::kSmall;
  EXPECT_THAT(ask("reduced.pod", json::object()).message, HasSubstr("small strain"));
}

class PodFile : public Reduced {
 protected:
  PodFile() {
    problem_.strain = StrainSize::kLarge;
    problem_.gravity_m_s2 = {};
    problem_.held = {{{problem_.supports[0].patch.faces[0]}, {true, false, false}, {}}};
    problem_.supports[0].stiffness_pa_per_m = 1e5;
    problem_.supports[1].by_m = {0.0, 0.05, -0.15};
    problem_.supports[1].stiffness_pa_per_m = 1e5;
  }

  /// Trains once and keeps the file.
  std::filesystem::path train() {
    json writing = options_;
    writing["write_body"] = true;
    const ContestantAnswer made = ask("reduced.pod", writing);
    first_ = displacement(made);
    first_report_ = made.report;
    std::filesystem::path kept = scratch_ / "kept.pod";
    if (made.outcome == "ok")
      std::filesystem::copy_file(made.report.at("body_file").get<std::string>(), kept);
    return kept;
  }

  ContestantAnswer ask_from(const std::filesystem::path& file, json options) {
    options["body"] = file.string();
    return ask("reduced.pod", options);
  }

  json options_ = {{"training", 4}, {"validation", 2}, {"force_tolerance", 1e-3}};
  std::vector<Vec3> first_;
  json first_report_;
};

TEST_F(PodFile, AnswersToTheBitWhatTheTrainingDid) {
  const std::filesystem::path file = train();
  ASSERT_FALSE(first_.empty());
  EXPECT_EQ(first_report_.at("body_format"), "palpate/pod_body/1");
  EXPECT_NEAR(first_report_.at("load_share").get<double>(), 1.0, 1e-15);
  const auto copy = scratch_ / "copy.pod";
  write_pod(copy, read_pod(file));
  EXPECT_EQ(read_text_file(file, 1U << 28U), read_text_file(copy, 1U << 28U));
  const ContestantAnswer again = ask_from(copy, options_);
  EXPECT_EQ(displacement(again), first_);
  EXPECT_EQ(again.report.at("identify_s"), 0.0);
  EXPECT_GT(again.report.at("read_s").get<double>(), 0.0);
  for (const char* key :
       {"training_s", "validation_error", "domains", "domains_of_all", "force_residual", "training_loads"})
    EXPECT_EQ(again.report.at(key), first_report_.at(key)) << key;
  EXPECT_LT(again.report.at("training_s").get<double>(), first_report_.at("identify_s").get<double>() + 1e-9);

  // Another load at the same places is what the file is for: as near as the validation says of such loads.
  problem_.supports[1].by_m = {0.0, 0.02, -0.08};
  for (Traction& traction : problem_.tractions) traction.traction_pa = 0.5 * traction.traction_pa;
  const ContestantAnswer other = ask_from(file, options_);
  ASSERT_EQ(other.outcome, "ok") << other.message;
  EXPECT_NE(displacement(other), first_);
  EXPECT_LT(other.report.at("load_share").get<double>(), 0.7);
  EXPECT_LT(difference(displacement(ask("smoothed.edge_node", json::object())), displacement(other)), 0.1);
}

TEST_F(PodFile, OneOfAnotherTrainingIsRefused) {
  const std::filesystem::path file = train();
  ASSERT_FALSE(first_.empty());
  const auto refused = [&](const char* why) {
    const ContestantAnswer answer = ask_from(file, options_);
    EXPECT_EQ(answer.outcome, "bad_input");
    EXPECT_THAT(answer.message, HasSubstr(why));
  };
  const BoundaryProblem good = problem_;
  problem_.material.poisson_ratio = 0.31;
  refused("poisson_ratio 0.31");
  problem_ = good;
  problem_.material.young_modulus_pa = 2e4;
  refused("young_modulus_pa 20000");
  problem_ = good;
  problem_.supports[0].stiffness_pa_per_m = 2e5;
  refused("the supports and held faces that the basis was trained on");
  problem_ = good;
  problem_.supports[0].patch.faces.pop_back();
  problem_.supports[0].patch.weight.pop_back();
  refused("the supports and held faces that the basis was trained on");
  problem_ = good;
  problem_.held.clear();
  refused("the supports and held faces that the basis was trained on");
  problem_ = good;
  problem_.tractions[0].patch.faces.pop_back();
  problem_.tractions[0].patch.weight.pop_back();
  refused("loads at the places");
  problem_ = good;
  problem_.gravity_m_s2 = {0.0, 0.0, -1.0};
  refused("loads at the places");
  problem_ = good;
  mesh_.points[0].x -= 1e-9;
  refused("another mesh");
  mesh_.points[0].x += 1e-9;
  options_["seed"] = 2;
  refused("seed 2");
  options_["seed"] = 1;
  EXPECT_EQ(ask_from(file, options_).outcome, "ok");
}

TEST_F(PodFile, ABrokenOneIsRefused) {
  const std::filesystem::path file = train();
  ASSERT_FALSE(first_.empty());
  const std::string good = read_text_file(file, 1U << 28U);
  const auto refused = [&](const std::string& bytes, const char* why) {
    const auto path = scratch_ / "broken.pod";
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      read_pod(path);
      ADD_FAILURE() << "read, where " << why << " was wanted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      EXPECT_THAT(error.what(), HasSubstr(why));
    }
  };
  const auto with = [&](const std::string& key, const std::string& value) {
    const std::size_t at = good.find("\n" + key + " ") + 1;
    return good.substr(0, at) + key + " " + value + good.substr(good.find('\n', at));
  };
  const std::size_t numbers = good.find("\nend\n") + 5;
  const auto with_number = [&](std::size_t at, double value) {
    std::string bytes = good;
    bytes.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
    return bytes;
  };
  refused("", "palpate/pod_body/1");
  refused("palpate/pod_body/2" + good.substr(good.find('\n')), "palpate/pod_body/1");
  refused(good.substr(0, numbers), "the end of the file");
  refused(good.substr(0, good.size() - 1), "the end of the file");
  refused(good + "x", "1 bytes more");
  refused(with("vertices", "9999999"), "the end of the file");
  refused(with("shapes", "0"), "shapes");
  refused(with("poisson_ratio", "nan"), "poisson_ratio");
  refused(with("model", "springs"), "model edge_node or tets");
  refused(with_number(numbers, std::nan("")), "finite numbers");
  refused(with_number(numbers, 0.9), "orthonormal");
  std::string held = good;
  held.back() = 8;
  refused(held, "held axes");
  EXPECT_NO_THROW(read_pod(file));
  // Weights, laws and supports that cannot be.
  TrainedPod trained = read_pod(file);
  const auto rewritten = [&](const TrainedPod& wrong) {
    write_pod(scratch_ / "wrong.pod", wrong);
    return read_text_file(scratch_ / "wrong.pod", 1U << 28U);
  };
  TrainedPod wrong = trained;
  wrong.parts.domains[0].of.weight = -1.0;
  refused(rewritten(wrong), "weights and volumes of 0 or more");
  wrong = trained;
  wrong.parts.domains[0].law = static_cast<dynamics::StrainLaw>(4);
  refused(rewritten(wrong), "a law from 0 to 3");
  wrong = trained;
  wrong.parts.supports[0].face[0] = 1U << 30U;
  refused(rewritten(wrong), "vertices of the body");
  wrong = trained;
  wrong.parts.held.assign(wrong.parts.held.size(), 7);
  refused(rewritten(wrong), "held vertices where they are");
}

}  // namespace
}  // namespace palpate::reference
