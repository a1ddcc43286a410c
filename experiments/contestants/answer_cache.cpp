#include "experiments/contestants/answer_cache.h"

#include <filesystem>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/file_cache.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/plain_file.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using reference::or_null;

constexpr const char* kSchema = "palpate/answer_cache/1";

json key_of(const ContestantTask& task) {
  json key = {{"contest", task.method.contestant->contest},
              {"method", task.method.method->name},
              {"program", hash_contestant(*task.method.contestant)},
              {"mesh", hash_file(task.mesh_in)},
              {"options", task.options}};
  // A file that an option names counts by what it holds, wherever it lies.
  for (const OptionSpec& option : task.method.method->options) {
    if (option.type != OptionType::kFile || !task.options.contains(option.name)) continue;
    const std::string file = task.options.at(option.name).get<std::string>();
    if (!file.empty()) key["options"][option.name] = hash_file(file);
  }
  if (task.problem_in.empty()) {
    key["stop"] = stop_request(task.stop);
  } else {
    key["problem"] = hash_file(task.problem_in);
  }
  return key;
}

/// The kept answer, or nothing if there is none or it is damaged.
std::optional<ContestantAnswer> load(const fs::path& folder, const json& key) {
  const json kept = read_kept(folder / "answer.json");
  if (!kept.is_object() || kept.value("schema", "") != kSchema || kept.value("key", json()) != key) return {};
  try {
    ContestantAnswer answer;
    answer.outcome = "ok";
    answer.kernel_s = kept.at("kernel_s").get<double>();
    answer.wall_s = kept.at("wall_s").get<double>();
    if (kept.at("user_s").is_number()) answer.user_s = kept.at("user_s").get<double>();
    if (kept.at("peak_rss_bytes").is_number())
      answer.peak_rss_bytes = kept.at("peak_rss_bytes").get<std::uint64_t>();
    answer.report = kept.at("report");
    answer.notes = kept.at("notes").get<std::vector<std::string>>();
    answer.output = folder / kept.at("output").get<std::string>();
    std::error_code error;
    const bool is_there = fs::is_regular_file(answer.output, error);
    const json checksum = is_there ? json(hash_file(answer.output)) : json();
    if (kept.at("checksum") != checksum) return {};
    return answer;
  } catch (const json::exception&) {  // damaged in whatever way: made again
    return {};
  }
}

/// Keeps the answer and returns it with its output's new place.
ContestantAnswer keep(const fs::path& folder, const json& key, ContestantAnswer answer) {
  json kept = {{"schema", kSchema},
               {"key", key},
               {"kernel_s", or_null(answer.kernel_s)},
               {"wall_s", or_null(answer.wall_s)},
               {"user_s", or_null(answer.user_s)},
               {"peak_rss_bytes", or_null(answer.peak_rss_bytes)},
               {"report", answer.report},
               {"notes", answer.notes},
               {"output", answer.output.filename().string()},
               {"checksum", nullptr}};
  try {
    fs::create_directories(folder);
    const fs::path output = folder / answer.output.filename();
    if (fs::is_regular_file(answer.output)) {
      copy_file_atomically(answer.output, output, [](const fs::path&) {});
      kept["checksum"] = hash_file(output);
      answer.output = output;
    }
    write_file_atomically(folder / "answer.json", kept.dump(2) + "\n");
  } catch (const InputError& error) {
    answer.notes.push_back(std::string("the answer was not kept in the cache: ") + error.what());
  } catch (const fs::filesystem_error& error) {
    answer.notes.push_back(std::string("the answer was not kept in the cache: ") + error.what());
  }
  return answer;
}

fs::path folder_of(const json& key) {
  return cache_entry("answer_cache", key.dump());
}

/// The same task with another problem.
ContestantTask with_problem(ContestantTask task, const fs::path& problem) {
  task.problem_in = problem;
  return task;
}

/// Those of the problems whose answers are not kept.
std::vector<fs::path> find_missing(const ContestantTask& task, std::span<const fs::path> problems) {
  std::vector<fs::path> missing;
  for (const fs::path& problem : problems) {
    const json key = key_of(with_problem(task, problem));
    if (!load(folder_of(key), key)) missing.push_back(problem);
  }
  return missing;
}

fs::path further_output(const ContestantTask& task, std::size_t k) {
  return task.scratch / ("further_" + std::to_string(k) + ".csv");
}

/// Keeps the answers to further problems, and takes them out of the report. One without its displacement, or
/// a report of another shape, is not kept: it is then asked for by itself.
void keep_further(const ContestantTask& task, std::span<const fs::path> problems, ContestantAnswer& answer) {
  const json reports = answer.report.value("further", json::array());
  answer.report.erase("further");
  if (!reports.is_array() || reports.size() != problems.size()) return;
  for (std::size_t k = 0; k < problems.size(); ++k) {
    const json& report = reports.at(k);
    ContestantAnswer one = answer;
    one.output = further_output(task, k);
    if (!report.is_object() || report.value("outcome", json()) != "converged" ||
        !file_complaint(one.output).empty())
      continue;
    one.report = report;
    const json solve_s = report.value("solve_s", json());
    if (solve_s.is_number()) one.kernel_s = solve_s.get<double>();
    const json key = key_of(with_problem(task, problems[k]));
    keep(folder_of(key), key, std::move(one));
  }
}

}  // namespace

ContestantAnswer run_cached(const ContestantTask& task, bool& was_kept, std::span<const fs::path> further) {
  was_kept = false;
  if (!task.method.contestant->unavailable().empty()) return run_contestant(task);
  const json key = key_of(task);
  const fs::path folder = folder_of(key);
  if (auto kept = load(folder, key)) {
    was_kept = true;
    return *std::move(kept);
  }
  ContestantTask asked = task;
  std::vector<fs::path> missing;
  if (task.method.method->find_option("further") != nullptr) missing = find_missing(task, further);
  if (!missing.empty()) {
    json list = json::array();
    for (std::size_t k = 0; k < missing.size(); ++k)
      list.push_back(
          {{"problem_in", missing[k].string()}, {"displacement_out", further_output(task, k).string()}});
    const fs::path file = task.scratch / "further.json";
    write_file_atomically(file, list.dump(2) + "\n");
    asked.options["further"] = file.string();
  }
  ContestantAnswer answer = run_contestant(asked);
  if (answer.outcome != "ok") return answer;
  keep_further(task, missing, answer);
  return keep(folder, key, std::move(answer));
}

}  // namespace palpate::experiments
