#include "experiments/case_record.h"

#include <array>

#include "core/base/error.h"
#include "experiments/file_hash.h"
#include "experiments/judge_record.h"
#include "experiments/measure.h"
#include "experiments/mesh_source.h"
#include "experiments/provenance.h"
#include "experiments/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kDiffers = "output differs between repeats";

template <typename T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

json describe_stop(const Stop& stop) {
  json value = {{"kind", stop_name(stop.kind)}, {"value", nullptr}};
  if (stop.kind == StopKind::kRatio) value["value"] = stop.value;
  if (stop.kind == StopKind::kFusions || stop.kind == StopKind::kTets) {
    value["value"] = static_cast<std::int64_t>(stop.value);
  }
  if (!stop.of.empty()) value["of"] = stop.of;
  return value;
}

json mesh_facts(const RunMesh& mesh) {
  return {{"name", mesh.name},
          {"vertices", mesh.mesh.points.size()},
          {"tets", mesh.mesh.tets.size()},
          {"hash", mesh.hash},
          {"ideal_volume", mesh.ideal_volume}};
}

json base_record(const Plan& plan, const RunMesh& mesh) {
  return {{"schema", "palpate/record/1"},
          {"plan", plan.name},
          {"mesh", mesh_facts(mesh)},
          {"message", ""},
          {"violations", json::array()},
          {"null_reasons", json::object()},
          {"report", nullptr},
          {"tuned", json::object()},
          {"searched", false},
          {"notes", json::array()},
          {"judge", nullptr},
          {"output_hash", nullptr},
          {"mesh_file", nullptr}};
}

/// Bounds of the plan that the record's figures do not keep.
void add_bound_violations(const Plan& plan, json& record) {
  json& violations = record["violations"];
  for (const AcceptBound& bound : plan.accept) {
    const Measure& measure = *find_measure(bound.measure);
    const auto figure = figure_of(record, measure);
    if (!figure) {
      violations.push_back(bound.measure + " has no figure");
    } else if (bound.max && *figure > *bound.max) {
      violations.push_back(bound.measure + " is " + short_number(*figure) + ", at most " +
                           short_number(*bound.max) + " is accepted");
    } else if (bound.min && *figure < *bound.min) {
      violations.push_back(bound.measure + " is " + short_number(*figure) + ", at least " +
                           short_number(*bound.min) + " is accepted");
    }
  }
}

/// What the adapter reports of the mesh has to be what the judge counts.
void add_report_violations(json& record) {
  for (const auto& [reported, counted] :
       {std::pair{"tets_out", "tets"}, std::pair{"vertices_out", "vertices"}}) {
    const json said = record.at("report").value(reported, json());
    const json seen = record.at("judge").value(counted, json());
    if (said.is_number() && seen.is_number() && said != seen) {
      record["violations"].push_back(std::string("reports ") + reported + " " + said.dump() +
                                     ", the judge counts " + seen.dump());
    }
  }
}

/// The judge's figures and violations of an output, from an earlier repeat if it is the same.
void judge_answer(const RepeatFacts& facts, const ContestantAnswer& answer, const std::vector<json>& earlier,
                  json& record) {
  const std::string hash = hash_file(answer.mesh_out);
  const json* same = nullptr;
  bool differs = false;
  for (const json& other : earlier) {
    if (!other.at("output_hash").is_string()) continue;
    if (other.at("output_hash") == hash) {
      same = &other;
    } else {
      differs = true;
    }
  }
  if (same != nullptr) {
    record["judge"] = same->at("judge");
    record["violations"] = json::array();
    if (!record["judge"].value("valid", false))
      record["violations"] = record["judge"].value("findings", json::array());
  } else {
    const TetMesh output = read_mesh(answer.mesh_out, ReadOrientation::kKeep).mesh;
    Judgement judgement = judge_output(output, facts.mesh.mesh, facts.contestant.keep);
    add_region_figures(judgement.figures, output, facts.mesh.mesh, facts.plan.region);
    record["judge"] = judgement.figures;
    record["violations"] = judgement.violations;
  }
  record["output_hash"] = hash;
  if (!differs) return;
  if (facts.deterministic) {
    record["violations"].push_back(kDiffers);
  } else {
    record["notes"].push_back(std::string(kDiffers) + ": the method is not deterministic");
  }
}

void add_null_reasons(json& record) {
  const std::string reason = record.at("outcome").get<std::string>();
  for (const char* key :
       {"kernel_s", "wall_s", "user_s", "peak_rss_bytes", "report", "judge", "output_hash"}) {
    if (record.contains(key) && record.at(key).is_null()) record["null_reasons"][key] = reason;
  }
}

}  // namespace

json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                  const std::vector<json>& earlier) {
  json record = base_record(facts.plan, facts.mesh);
  record["case"] = facts.run_case.id;
  record["contestant"] = facts.contestant.method;
  record["label"] = facts.contestant.label;
  record["required"] = facts.contestant.required;
  record["options"] = facts.run_case.options;
  record["keep"] = facts.contestant.keep;
  record["stop"] = describe_stop(facts.stop);
  record["sweep"] = facts.run_case.sweep;
  record["seed"] = or_null(facts.run_case.seed);
  record["repeat"] = facts.repeat;
  record["warmup"] = facts.warmup;
  record["kernel_s"] = or_null(answer.kernel_s);
  record["wall_s"] = or_null(answer.wall_s);
  record["user_s"] = or_null(answer.user_s);
  record["peak_rss_bytes"] = or_null(answer.peak_rss_bytes);
  record["outcome"] = answer.outcome;
  record["message"] = answer.message;
  if (answer.outcome == "ok") {
    record["report"] = answer.report;
    record["tuned"] = answer.tuned;
    record["searched"] = answer.searched;
    record["notes"] = answer.notes;
    try {
      judge_answer(facts, answer, earlier, record);
      add_report_violations(record);
      add_bound_violations(facts.plan, record);
      const bool accepted = record.at("violations").empty();
      record["outcome"] = accepted ? "accepted" : "rejected";
      if (!accepted) record["message"] = reason_of(record);
    } catch (const InputError& error) {
      std::string message = error.what();  // names the scratch file: of no use to a reader
      const std::size_t name = message.find(answer.mesh_out.filename().string());
      if (name != std::string::npos) message.erase(0, name);
      record["outcome"] = "bad_answer";
      record["message"] = "its mesh cannot be read: " + message;
    }
  }
  add_null_reasons(record);
  record["finished_at"] = utc_now();
  return record;
}

json build_input_record(const Plan& plan, const RunMesh& mesh) {
  json record = base_record(plan, mesh);
  Judgement judgement = judge_mesh(mesh.mesh);
  add_region_figures(judgement.figures, mesh.mesh, mesh.mesh, plan.region);
  record["case"] = mesh.name + "/input";
  record["contestant"] = nullptr;
  record["label"] = "input";
  record["required"] = true;
  record["options"] = json::object();
  record["keep"] = json::array();
  record["stop"] = nullptr;
  record["sweep"] = json::object();
  record["seed"] = nullptr;
  record["repeat"] = 0;
  record["warmup"] = false;
  for (const char* key : {"kernel_s", "wall_s", "user_s", "peak_rss_bytes"}) {
    record[key] = nullptr;
    record["null_reasons"][key] = "the input mesh itself: nothing ran";
  }
  record["judge"] = judgement.figures;
  record["output_hash"] = mesh.hash;
  record["mesh_file"] = "meshes/" + mesh.name + "/input.mesh";
  record["violations"] = judgement.violations;
  record["outcome"] = judgement.violations.empty() ? "accepted" : "rejected";
  if (!judgement.violations.empty()) record["message"] = reason_of(record);
  record["finished_at"] = utc_now();
  return record;
}

std::string reason_of(const json& record) {
  const json violations = record.value("violations", json::array());
  if (violations.empty()) return record.value("message", "");
  const std::string first = violations.front().get<std::string>();
  return violations.size() == 1 ? first : first + " (and " + std::to_string(violations.size() - 1) + " more)";
}

}  // namespace palpate::experiments
