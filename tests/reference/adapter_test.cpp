// The adapters as the runner starts them: real processes, real files.
#include "reference/door/adapter.h"
#include "experiments/files/places.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/fusion/hierarchical.h"
#include "experiments/processes/process.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

class Adapter : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("palpate-adapter-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    write_medit(folder_ / "in.mesh", input_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  json request(const char* method) const {
    return {{"schema", "palpate/request/1"},
            {"contest", "simplify"},
            {"method", method},
            {"mesh_in", folder_ / "in.mesh"},
            {"mesh_out", folder_ / "out.mesh"},
            {"stop", {{"fusions", 20}}},
            {"options", json::object()},
            {"threads", 1}};
  }

  /// Starts an adapter; returns its exit code, and fills the response if there is one.
  int run(const char* program, const std::string& request_text, json& response) const {
    std::ofstream(folder_ / "request.json") << request_text;
    std::filesystem::remove(folder_ / "response.json");
    experiments::ProcessSpec spec;
    spec.arguments = {experiments::program_folder() + "/" + program, folder_ / "request.json",
                      folder_ / "response.json"};
    const experiments::ProcessResult result = experiments::run_process(spec);
    EXPECT_EQ(result.end, experiments::ProcessEnd::kExited) << result.message;
    std::ifstream file(folder_ / "response.json");
    response = file ? json::parse(file) : json();
    return result.exit_code;
  }

  std::filesystem::path folder_;
  TetMesh input_ = build_kuhn_cube(9, 0.3, 1);
};

TEST_F(Adapter, HierarchicalAnswersWithItsReportAndMesh) {
  json response;
  ASSERT_EQ(run("palpate_simplify", request("palpate.hierarchical").dump(), response), 0);
  EXPECT_EQ(response["status"], "ok");
  EXPECT_GT(response["kernel_s"].get<double>(), 0.0);
  const json& report = response["report"];
  EXPECT_EQ(report["fusions"], 20);
  EXPECT_EQ(report["stop"], "fusions");
  EXPECT_EQ(report["vertices_in"].get<int>() - report["vertices_out"].get<int>(), 60);
  TetMesh expected = input_;
  simplify::SimplifyOptions options;
  options.stop.fusions = 20;
  simplify::simplify_hierarchical(expected, options);
  EXPECT_EQ(read_medit(folder_ / "out.mesh", ReadOrientation::kKeep).mesh, expected);
}

TEST_F(Adapter, SequentialBansTouchedTetsUnlessToldOtherwise) {
  json banned;
  json free;
  json ask = request("tetfusion.sequential");
  ask["stop"] = {{"limit", true}};
  ASSERT_EQ(run("tetfusion_simplify", ask.dump(), banned), 0);
  ask["options"] = {{"skip_touched", false}, {"order", "random"}, {"seed", 3}, {"passes", "many"}};
  ASSERT_EQ(run("tetfusion_simplify", ask.dump(), free), 0);
  EXPECT_GT(banned["report"]["rejected"]["touched"], 0);
  EXPECT_EQ(free["report"]["rejected"]["touched"], 0);
}

TEST_F(Adapter, RegionsToKeepAreHonouredOrRefused) {
  json ask = request("palpate.hierarchical");
  ask["keep"] = {"sphere 0.5 0.5 0.5 0.2"};
  ask["options"] = {{"near_size", 0.4}, {"reach", 0.3}};
  json response;
  ASSERT_EQ(run("palpate_simplify", ask.dump(), response), 0);
  EXPECT_GT(response["report"]["rejected"]["kept"], 0);
  TetMesh expected = input_;
  simplify::SimplifyOptions options;
  options.stop.fusions = 20;
  options.sizing = {{{.center = {0.5, 0.5, 0.5}, .radius = 0.2}}, 0.4, 0.3};
  simplify::simplify_hierarchical(expected, options);
  EXPECT_EQ(read_medit(folder_ / "out.mesh", ReadOrientation::kKeep).mesh, expected);
  ask["method"] = "tetfusion.sequential";
  ask["options"] = json::object();
  EXPECT_EQ(run("tetfusion_simplify", ask.dump(), response), 2);
  EXPECT_NE(response["message"].get<std::string>().find("keep: expected no region"), std::string::npos);
}

TEST_F(Adapter, BadRequestsEndWithOneMessageAndCodeTwo) {
  const auto changed = [&](const char* key, const json& value) {
    json ask = request("palpate.hierarchical");
    ask[key] = value;
    return ask.dump();
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {changed("method", "palpate.magic"), "palpate.magic"},
      {changed("options", {{"drp", 0.5}}), "drp"},
      {changed("options", {{"drop", "half"}}), "drop"},
      {changed("options", {{"drop", 2.0}}), "drop"},
      {changed("options", {{"levels", "corner"}}), "vertex edge face"},
      {changed("keep", {"cube 0 0 0 1"}), "sphere, half_space or patch"},
      {changed("keep", "sphere 0 0 0 1"), "another type for \"keep\""},
      {changed("options", {{"near_size", 2.0}}), "near_size"},
      {changed("options", {{"reach", -1.0}}), "reach"},
      {changed("stop", {{"ratio", 1.5}}), "ratio"},
      {changed("stop", {{"fusions", -3}}), "fusions"},
      {changed("stop", {{"sometime", true}}), "sometime"},
      {changed("schema", "palpate/request/9"), "palpate/request/1"},
      {changed("mesh_in", (folder_ / "none.mesh").string()), "no such file"},
      {changed("mesh_out", (folder_ / "no" / "folder.mesh").string()), "folder"},
      {"{\"schema\": ", "expected JSON"},
      {"[]", "JSON object"},
  };
  for (const auto& [text, part] : cases) {
    json response;
    EXPECT_EQ(run("palpate_simplify", text, response), 2) << text;
    EXPECT_EQ(response["status"], "bad_input") << text;
    EXPECT_NE(response["message"].get<std::string>().find(part), std::string::npos) << response["message"];
    EXPECT_EQ(response["message"].get<std::string>().find('\n'), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.mesh"));
  }
}

TEST_F(Adapter, AMeshWithNothingToFuseIsAnAnswer) {
  input_ = build_kuhn_cube(2, 0.0, 0);
  write_medit(folder_ / "in.mesh", input_);
  json ask = request("palpate.hierarchical");
  json response;
  ASSERT_EQ(run("palpate_simplify", ask.dump(), response), 0);
  EXPECT_EQ(response["report"]["stop"], "limit");
  EXPECT_NE(response["notes"].dump().find("no tetrahedron can be fused"), std::string::npos);
  EXPECT_EQ(read_medit(folder_ / "out.mesh").mesh, input_);
}

}  // namespace
}  // namespace palpate::reference
