#include "experiments/rounds/case_choice.h"

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

/// The words that fit a case, its id apart.
std::vector<std::string> words_of(const Plan& plan, const Case& c) {
  const PlanContestant& contestant = plan.contestants[c.contestant];
  const std::string& subject = plan.subjects[c.subject];
  std::vector<std::string> words{subject, contestant.label};
  const auto add = [&words](const std::vector<std::string>& tags) {
    words.insert(words.end(), tags.begin(), tags.end());
  };
  add(contestant.tags);
  for (const PlanMesh& mesh : plan.meshes) {
    if (mesh.name == subject) add(mesh.tags);
  }
  for (const PlanScene& scene : plan.scenes) {
    if (scene.name == subject) add(scene.tags);
  }
  return words;
}

bool is_pattern(const std::string& word) {
  return word.find_first_of("*?[") != std::string::npos;
}

/// Marks the cases that a word fits.
void mark_cases(const Plan& plan, const std::vector<Case>& cases, const std::string& word,
                std::vector<bool>& wanted) {
  bool found = false;
  std::set<std::string> known;
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::vector<std::string> words = words_of(plan, cases[i]);
    const bool fits = is_pattern(word)
                          ? ::fnmatch(word.c_str(), cases[i].id.c_str(), 0) == 0
                          : word == cases[i].id || std::find(words.begin(), words.end(), word) != words.end();
    if (fits) wanted[i] = true;
    found = found || fits;
    known.insert(words.begin(), words.end());
    ids.push_back(cases[i].id);
  }
  if (found) return;
  if (is_pattern(word))
    throw InputError("--only: the pattern \"" + word + "\" fits no case" + nearest_hint(word, ids));
  const std::vector<std::string> names(known.begin(), known.end());
  const std::vector<std::string>& near = word.find('/') == std::string::npos ? names : ids;
  throw InputError("--only: no mesh, scene, label, tag or case is called \"" + word + "\"" +
                   nearest_hint(word, near));
}

/// Leaves the cases marked that a part names.
void keep_part(const std::vector<Case>& cases, const std::string& part, std::vector<bool>& wanted) {
  std::map<std::string, std::size_t> known;
  for (std::size_t i = 0; i < cases.size(); ++i) known[cases[i].id] = i;
  refuse_no_file(part, "a file of cases, one a line");
  std::ifstream file(part);
  if (!file) throw InputError(part, 0, "a file of cases, one a line", "none that can be read");
  std::vector<bool> named(cases.size(), false);
  bool is_empty = true;
  std::array<char, 65536> line{};  // no case has as long a name
  for (std::size_t number = 1; file.getline(line.data(), line.size()) || file.gcount() > 0; ++number) {
    if (file.fail()) throw InputError(part, number, "a case of the plan", "a longer line");
    std::string id = line.data();
    if (!id.empty() && id.back() == '\r') id.pop_back();  // of a file that was written on Windows
    if (id.empty()) continue;
    is_empty = false;
    const auto found = known.find(id);
    if (found == known.end()) throw InputError(part, number, "a case of the plan", id);
    named[found->second] = wanted[found->second];
  }
  if (is_empty) throw InputError(part, 0, "cases of the plan, one a line", "none");
  wanted = named;
}

}  // namespace

std::vector<std::size_t> choose_cases(const Plan& plan, const std::vector<Case>& cases,
                                      const CaseChoice& choice) {
  std::vector<bool> wanted(cases.size(), choice.only.empty());
  for (const std::string& word : choice.only) mark_cases(plan, cases, word, wanted);
  if (!choice.case_id.empty()) {
    std::vector<bool> both(cases.size(), false);
    for (const std::size_t i : select_cases(cases, choice.case_id)) both[i] = wanted[i];
    wanted = both;
  }
  if (!choice.part.empty()) keep_part(cases, choice.part, wanted);
  std::vector<std::size_t> chosen = with_needed_cases(cases, wanted);
  if (chosen.empty())
    throw InputError("no case of " + (choice.part.empty() ? choice.case_id : choice.part) + " fits " +
                     (choice.only.empty() ? "--case " + choice.case_id : "--only " + joined(choice.only)));
  return chosen;
}

nlohmann::json describe_choice(const CaseChoice& choice) {
  if (choice.is_all()) return nullptr;
  nlohmann::json described = nlohmann::json::object();
  if (!choice.case_id.empty()) described["case"] = choice.case_id;
  if (!choice.only.empty()) described["only"] = choice.only;
  if (!choice.part.empty()) described["part"] = std::filesystem::path(choice.part).filename().string();
  return described;
}

}  // namespace palpate::experiments
