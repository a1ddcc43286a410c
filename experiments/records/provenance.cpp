#include "experiments/records/provenance.h"

#include <unistd.h>
#include <yaml-cpp/yaml.h>
#include <CLI/Version.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <sstream>

#include "experiments/files/file_hash.h"
#include "experiments/files/places.h"
#include "experiments/judging/measure.h"
#include "experiments/records/key_forms.h"
#include "experiments/records/source_version.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::or_null;

/// The value behind the first line that starts with `key` in a file of "key : value" lines.
std::string system_value(const char* path, const std::string& key) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(':');
    if (line.rfind(key, 0) != 0 || colon == std::string::npos) continue;
    const std::size_t start = line.find_first_not_of(" \t", colon + 1);
    return start == std::string::npos ? "" : line.substr(start);
  }
  return "unknown";
}

std::string operating_system() {
  std::ifstream file("/etc/os-release");
  std::string line;
  while (std::getline(file, line)) {
    if (line.rfind("PRETTY_NAME=\"", 0) == 0) return line.substr(13, line.size() - 14);
  }
  return "unknown";
}

json load_averages() {
  std::array<double, 3> load{};
  if (::getloadavg(load.data(), 3) != 3) return nullptr;
  return load;
}

/// Versions of the libraries that the programs were built with.
json library_versions() {
  json versions = {{"nlohmann_json", std::to_string(NLOHMANN_JSON_VERSION_MAJOR) + "." +
                                         std::to_string(NLOHMANN_JSON_VERSION_MINOR) + "." +
                                         std::to_string(NLOHMANN_JSON_VERSION_PATCH)},
                   {"cli11", CLI11_VERSION}};
  std::istringstream vendors(PALPATE_VENDOR_VERSIONS);  // "cgal=5.5.1 vtk=9.1.0 ..."
  for (std::string vendor; vendors >> vendor;) {
    const std::size_t equals = vendor.find('=');
    if (equals != std::string::npos) versions[vendor.substr(0, equals)] = vendor.substr(equals + 1);
  }
  return versions;
}

/// Programs by their names; those from elsewhere, and the files that they need, with the folders of their
/// contestants in front.
json program_hashes(const Plan& plan, const Registry& registry) {
  json hashes = json::object();
  hashes["palpate"] = hash_file("/proc/self/exe");
  std::map<std::filesystem::path, std::string> programs;  // with the folders of their contestants
  const auto add = [&](const std::string& method) {
    const Contestant& entry = *registry.find(method)->contestant;
    if (!entry.unavailable().empty()) return;
    programs[entry.program] = entry.folder;
    for (const std::filesystem::path& file : entry.files) programs[file] = entry.folder;
  };
  for (const PlanContestant& contestant : plan.contestants) add(contestant.method);
  for (const PlanContestant& simplifier : plan.simplifiers) {
    if (!simplifier.method.empty()) add(simplifier.method);
  }
  if (plan.reference) add(plan.reference->method);
  for (const auto& [program, folder] : programs) {
    const std::string name = program.filename().string();
    std::string key = program.parent_path() == program_folder() ? name : folder + "/" + name;
    while (hashes.contains(key)) key += "+";  // another folder of that name
    hashes[key] = hash_file(program);
  }
  return hashes;
}

/// Hashes of the files that contestants take: options of the type file, and training plans.
json contestant_files(const Plan& plan, const Registry& registry) {
  json hashes = json::object();
  for (const PlanContestant& contestant : plan.contestants) {
    if (!contestant.train.empty()) hashes[contestant.label + ".train"] = hash_file(contestant.train);
    for (const auto& [name, given] : contestant.set) {
      const OptionSpec* option = registry.find(contestant.method)->method->find_option(name);
      if (option->type == OptionType::kFile && !given.text.empty())
        hashes[contestant.label + "." + name] = hash_file(given.text);
    }
  }
  return hashes;
}

json seeds_of(const Plan& plan) {
  json seeds = json::object();
  for (const PlanMesh& mesh : plan.meshes) {
    if (mesh.shape) seeds["mesh " + mesh.name] = mesh.shape->seed;
  }
  for (const PlanScene& scene : plan.scenes) {
    if (scene.scene.mesh.shape) seeds["scene " + scene.name] = scene.scene.mesh.shape->seed;
  }
  for (const PlanContestant& contestant : plan.contestants) {
    if (!contestant.seeds.empty()) seeds[contestant.label] = contestant.seeds;
  }
  return seeds;
}

/// What a run keeps from its start to its end, resumed or not: times of two processors or compilers do not
/// belong into one median.
constexpr std::array<std::pair<const char*, const char*>, 8> kSameThroughout{{
    {"processor", "processor"},
    {"processors", "number of processors"},
    {"memory", "memory of the machine"},
    {"system", "operating system"},
    {"compiler", "compiler"},
    {"flags", "flags of the compiler"},
    {"build_type", "build type"},
    {"libraries", "version of a library"},
}};

/// Unit and direction of the measures that the plan compares: the report knows none by itself.
json compared_measures(const Plan& plan) {
  json measures = json::object();
  for (const std::string& name : plan.compared) {
    const Measure& measure = *find_measure(name);
    measures[name] = {{"unit", measure.unit}, {"better", measure.better}};
  }
  return measures;
}

bool is_object(const json& value) {
  return value.is_object();
}

bool are_objects(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), is_object);
}

bool are_named(const json& value) {
  return are_objects(value) && std::all_of(value.begin(), value.end(), [](const json& one) {
           return !one.contains("name") || one.at("name").is_string();
         });
}

bool are_texts(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), is_text);
}

bool are_counts(const json& value) {
  return value.is_object() && std::all_of(value.begin(), value.end(), is_count);
}

constexpr std::array<KeyForm, 13> kProvenanceForms{{
    {"plan", "a text", is_text},
    {"plan_hash", "a text", is_text},
    {"cases", "a list of texts", are_texts},
    {"sittings", "a list of objects", are_objects},
    {"meshes", "a list of objects with names", are_named},
    {"problems", "an object", is_object},
    {"files", "an object", is_object},
    {"programs", "an object", is_object},
    {"measures", "an object", is_object},
    {"trained", "an object", is_object},
    {"repeats", kCountForm, is_count},
    {"warmup", kCountForm, is_count},
    {"repeats_of", "whole numbers from 0 to 1000000000", are_counts},
}};

}  // namespace

json read_provenance(const std::filesystem::path& file) {
  json value = reference::read_json_file(file);
  if (!value.is_object()) throw InputError(file.string(), 0, "the provenance of a run", "something else");
  check_keys(value, kProvenanceForms, file.string());
  return value;
}

std::string utc_now(bool for_file_name) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  const char* form = for_file_name ? "%Y%m%dT%H%M%SZ" : "%Y-%m-%dT%H:%M:%SZ";
  std::strftime(text.data(), text.size(), form, &parts);
  return text.data();
}

json build_provenance(const Plan& plan, const Registry& registry, int threads) {
  const SourceVersion version = find_source_version();
  return {{"schema", "palpate/provenance/1"},
          {"version", PALPATE_VERSION},
          {"plan", plan.name},
          {"plan_hash", hash_file(plan.file)},
          {"commit", version.commit},
          {"dirty", or_null(version.dirty)},
          {"source", version.source},
          {"compiler", PALPATE_COMPILER},
          {"flags", PALPATE_FLAGS},
          {"build_type", PALPATE_BUILD_TYPE},
          {"libraries", library_versions()},
          {"programs", program_hashes(plan, registry)},
          {"files", contestant_files(plan, registry)},
          {"system", operating_system()},
          {"processor", system_value("/proc/cpuinfo", "model name")},
          {"processors", ::sysconf(_SC_NPROCESSORS_ONLN)},
          {"memory", system_value("/proc/meminfo", "MemTotal")},
          {"load", load_averages()},
          {"seeds", seeds_of(plan)},
          {"threads", threads},
          {"repeats", plan.run.repeats},
          {"warmup", plan.run.warmup},
          {"until_width", or_null(plan.run.until_width)},
          {"halving_from", plan.run.halving_from > 0 ? json(plan.run.halving_from) : json()},
          {"most_repeats", plan.run.until_width ? json(plan.run.most_repeats) : json()},
          {"order_seed", plan.run.order_seed},
          {"timeout_s", plan.run.timeout_s},
          {"memory_mib", plan.run.memory_mib},
          {"measures", compared_measures(plan)},
          {"plan_data", read_yaml(plan.file).json()},
          {"started_at", utc_now()}};
}

json describe_sitting(const json& now) {
  json sitting = json::object();
  for (const char* key : {"started_at", "commit", "dirty", "source", "load"}) sitting[key] = now.at(key);
  return sitting;
}

std::vector<std::string> find_changes(const json& then, const json& now) {
  std::vector<std::string> changes;
  const auto compare = [&](const std::string& what, const json& before, const json& after) {
    if (before != after) changes.push_back(what + " (" + before.dump() + " then, " + after.dump() + " now)");
  };
  if (then.value("plan_hash", json()) != now.value("plan_hash", json()))
    changes.emplace_back("the plan changed");
  compare("the number of threads changed", then.value("threads", json()), now.value("threads", json()));
  for (const auto& [key, what] : kSameThroughout) {
    compare(std::string("the ") + what + " changed", then.value(key, json()), now.value(key, json()));
  }
  const json files_then = then.value("files", json::object());
  const json files_now = now.value("files", json::object());
  for (const auto& [name, hash] : files_then.items()) {
    if (files_now.value(name, json()) != hash) changes.push_back("the file of " + name + " changed");
  }
  const json programs_then = then.value("programs", json::object());
  const json programs_now = now.value("programs", json::object());
  for (const auto& [name, hash] : programs_now.items()) {
    if (programs_then.value(name, json()) != hash) changes.push_back("the program " + name + " changed");
  }
  for (const auto& [name, hash] : programs_then.items()) {
    if (!programs_now.contains(name)) changes.push_back("the program " + name + " is gone");
  }
  return changes;
}

}  // namespace palpate::experiments
