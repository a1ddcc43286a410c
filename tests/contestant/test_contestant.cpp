// A contestant for the tests of the runner: a real process that copies its mesh or misbehaves as it is told.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "core/mesh/io/medit.h"

namespace {

using nlohmann::json;
using namespace palpate;

void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

json good_answer(const TetMesh& in, const TetMesh& out) {
  return {{"schema", "palpate/response/1"},
          {"status", "ok"},
          {"kernel_s", 1e-6},
          {"report", {{"tets_in", in.tets.size()}, {"tets_out", out.tets.size()}, {"fusions", 0}}},
          {"notes", json::array()}};
}

/// Behaviours that end the process before there is an answer.
void misbehave_early(const std::string& behave, const std::string& response) {
  if (behave == "crash") {
    std::signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler would exit instead
    ::raise(SIGSEGV);
  }
  if (behave == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  if (behave == "grandchild") {
    if (::fork() == 0) {
      write_text(response + ".grandchild", std::to_string(::getpid()));
      std::this_thread::sleep_for(std::chrono::hours(1));
    }
    std::this_thread::sleep_for(std::chrono::hours(1));
  }
  if (behave == "no_answer") {
    std::cerr << "cannot go on\n";
    std::exit(5);
  }
  if (behave == "garbage") {
    write_text(response, std::string("\x7f\x45\x4c\x46 no answer \0 at all", 23));
    std::exit(0);
  }
  if (behave == "deep_answer") {
    write_text(response, "{\"report\":" + std::string(200'000, '[') + std::string(200'000, ']') + "}");
    std::exit(0);
  }
  if (behave == "huge_answer") {
    write_text(response, std::string(20U << 20U, ' '));
    std::exit(0);
  }
  if (behave == "memory") {
    std::vector<std::vector<char>> blocks;
    while (true) blocks.emplace_back(std::size_t{64} << 20U, 'x');
  }
  if (behave == "refuse" || behave == "fail") {
    const bool refuse = behave == "refuse";
    write_text(response, json({{"schema", "palpate/response/1"},
                               {"status", refuse ? "bad_input" : "error"},
                               {"message", "not this mesh"}})
                             .dump());
    std::exit(refuse ? 2 : 3);
  }
}

void spoil_mesh(const std::string& behave, TetMesh& mesh) {
  if (behave == "invert") std::swap(mesh.tets[0][2], mesh.tets[0][3]);
  if (behave == "drop_tet") mesh.tets.pop_back();
  if (behave == "move_skin") {
    mesh.points[0].x -= 0.125;
  }
}

/// The behaviours that write to what they were given: the mesh itself, or the file that it was copied from.
void spoil_input(const std::string& behave, const std::filesystem::path& mesh_in) {
  TetMesh one;
  one.points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  one.tets = {{0, 1, 2, 3}};
  if (behave == "overwrite_input") {
    std::filesystem::permissions(mesh_in, std::filesystem::perms::owner_all);
    write_medit(mesh_in, one);
  }
  if (behave != "overwrite_source") return;
  const char* source = std::getenv("PALPATE_TEST_SOURCE_MESH");
  if (source != nullptr) write_medit(source, one);
}

/// Writes the mesh; for "alternate" with its tets in another order on every second call.
void write_mesh_out(const std::string& behave, TetMesh mesh, const std::string& path) {
  if (behave == "no_mesh") return;
  if (behave == "nan_mesh") {
    write_text(path,
               "MeshVersionFormatted 2\nDimension 3\nVertices\n4\nnan 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
               "Tetrahedra\n1\n1 2 3 4 0\nEnd\n");
    return;
  }
  if (behave == "alternate") {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    std::rotate(mesh.tets.begin(), mesh.tets.begin() + 1 + now % 97 % (std::ssize(mesh.tets) - 1),
                mesh.tets.end());
  }
  write_medit(path, mesh);
}

/// The behaviours that search for a parameter, or claim to: the search finds 0.5, and what is handed back is
/// kept, but for "tune_anew".
void add_tuned(const std::string& behave, const json& request, json& answer) {
  if (behave == "tune" || behave == "tune_anew") {
    answer["tuned"] =
        behave == "tune" ? request.value("tuned", json{{"length", 0.5}}) : json{{"length", 0.75}};
  }
  if (behave == "tune_text") answer["tuned"] = {{"length", "half"}};
}

std::string answer_text(const std::string& behave, json answer) {
  if (behave == "long_time") answer["kernel_s"] = 1000.0;
  if (behave == "negative_time") answer["kernel_s"] = -1.0;
  if (behave == "zero_time") answer["kernel_s"] = 0.0;
  if (behave == "varying_time") answer["kernel_s"] = 1e-6 * (1.0 + ::getpid() % 997);  // no two alike
  if (behave == "no_time") answer.erase("kernel_s");
  if (behave == "wrong_keys") answer["kernel_seconds"] = 1.0;
  if (behave == "false_count") answer["report"]["tets_out"] = 1;
  std::string text = answer.dump();
  if (behave == "nan_time") text.replace(text.find("\"kernel_s\":1e-06"), 16, "\"kernel_s\":NaN");
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const json request = json::parse(std::ifstream(argv[1]));
  const std::string behave = request.at("options").value("behave", "copy");
  std::this_thread::sleep_for(std::chrono::milliseconds(request.at("options").value("delay_ms", 0)));
  misbehave_early(behave, argv[2]);
  const TetMesh in = read_medit(request.at("mesh_in").get<std::string>()).mesh;
  TetMesh out = in;
  spoil_mesh(behave, out);
  write_mesh_out(behave, out, request.at("mesh_out").get<std::string>());
  json answer = good_answer(in, out);
  add_tuned(behave, request, answer);
  spoil_input(behave, request.at("mesh_in").get<std::string>());
  write_text(argv[2], answer_text(behave, answer));
  return behave == "false_status" ? 3 : 0;
}
