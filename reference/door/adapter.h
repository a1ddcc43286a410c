// The door: what an adapter program reads and writes. See reference/PROTOCOL.md.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::reference {

/// A request as the runner wrote it.
///
///   {"schema": "palpate/request/1", "contest": "simplify", "method": "palpate.hierarchical",
///    "mesh_in": "in.mesh", "mesh_out": "out.mesh", "stop": {"fusions": 87} (or "tets", "ratio", "limit":
///    true), "options": {"levels": "vertex", "drop": 0.01}, "threads": 1, "tuned": {"edge_length": 0.1},
///    "keep": ["sphere 0 0 5 2"]}
///
/// In the contest deform there is "problem_in" beside the mesh, "displacement_out" in place of "mesh_out",
/// and no stop (reference/door/deform_problem.h); the contests motion, engine and stability have
/// "history_out" there (reference/door/motion_problem.h, stability_problem.h, contest_files.h). "tuned" is
/// there only if an earlier repeat's search found something, "keep" only if the plan or the command line asks
/// for it.
struct Request {
  std::string contest;
  std::string method;
  std::filesystem::path input;    ///< "mesh_in" (or "surface_in" for meshers)
  std::filesystem::path output;   ///< "mesh_out", or what the contest has in its place
  std::filesystem::path problem;  ///< "problem_in", where the contest has one
  std::filesystem::path folder;   ///< "folder_out": for what is written as it comes; mostly there is none
  nlohmann::json stop;
  nlohmann::json options;
  int threads = 1;
  nlohmann::json tuned = nlohmann::json::object();  ///< what an earlier repeat's search found; {} if nothing
  std::vector<std::string> keep;  ///< regions whose tets are left alone, as simplify::parse_kept_region reads
};

/// What an adapter answers: its own kernel time, and the report of its method.
///
///   {"schema": "palpate/response/1", "status": "ok", "kernel_s": 0.01, "report": {...}, "notes": [...],
///    "tuned": {"edge_length": 0.1}}
/// or {"schema": ..., "status": "bad_input" | "error", "message": "one line"}
struct Response {
  double kernel_s = 0.0;
  nlohmann::json report = nlohmann::json::object();
  std::vector<std::string> notes;
  nlohmann::json tuned = nlohmann::json::object();  ///< name -> number; {} for a method that searches nothing
};

/// Whether an adapter honours Request::keep.
enum class TakesKeep { kNo, kYes };

/// Runs an adapter: reads the request named by argv[1], calls `kernel`, writes the response named by argv[2]
/// (beside it and renamed). InputError becomes status "bad_input" and exit code 2, any other exception status
/// "error" and exit code 3. A request with regions to keep is refused unless the adapter honours them.
/// Returns the exit code.
int run_adapter(int argc, char** argv, const std::function<Response(const Request&)>& kernel,
                TakesKeep takes_keep = TakesKeep::kNo);

}  // namespace palpate::reference
