// Parts of a run that were run elsewhere: other folders' records and outputs, taken into one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"

namespace palpate::experiments {

/// The machine that times belong to: processor, processors, memory, system, as a provenance names them.
nlohmann::json node_kind(const nlohmann::json& provenance);

/// The provenance of a run whose times were taken from elsewhere, as if it had run on the machine of `now`:
/// it may be continued on any. That of any other run as it is.
nlohmann::json moved_here(nlohmann::json then, const nlohmann::json& now);

/// The runs that `folder` stands for: itself if it is one, or those below it, by name; itself where there are
/// none.
std::vector<std::filesystem::path> find_parts(const std::filesystem::path& folder);

/// Throws: InputError unless find_parts(folder) are runs.
void check_parts(const std::filesystem::path& folder);

/// The runs below `folder`, by name; none if there is no such folder.
std::vector<std::filesystem::path> list_parts(const std::filesystem::path& folder);

/// Takes parts into a run.
class PartTaker {
 public:
  /// `kept`: where each of the plan's cases keeps its output. `beside_file`: what outputs may have beside
  /// them (ContestFiles). `provenance` is the run's, and gets the parts' sittings; `save` writes it to the
  /// disk. Reads which repeats the run has.
  PartTaker(const RunPaths& paths, std::map<std::string, std::filesystem::path> kept, std::string beside_file,
            nlohmann::json& provenance, std::function<void()> save);

  /// Takes the records of `part`, the folder of another run of the same plan, that are not there yet, each
  /// with its output, which must be what its record says (by its hash). A record's times stay what they were
  /// if they come from the same kind of node as those that are there already; otherwise they are left out,
  /// with the reason: times of unlike machines are never put together. The provenance is saved before the
  /// first record is taken, so that whoever goes on after a kill knows whose times are there; a part that is
  /// taken again has its sittings in there once. Returns how many records were taken.
  /// Throws: InputError if the part is of another plan, program or library version, had other inputs, is in
  ///         use, has a record that is none, or an output that is not what its record says.
  std::size_t take(const std::filesystem::path& part, RecordFile& records);

 private:
  void check(const std::filesystem::path& part, const nlohmann::json& theirs) const;
  std::size_t add_sittings(const nlohmann::json& theirs) const;
  void take_output(const std::filesystem::path& part, const std::filesystem::path& kept,
                   const nlohmann::json& record, const nlohmann::json& hash) const;

  const RunPaths& paths_;
  std::map<std::string, std::filesystem::path> kept_;
  std::string beside_file_;
  nlohmann::json& provenance_;
  std::function<void()> save_;
  std::set<std::pair<std::string, int>> recorded_;  ///< case and repeat
  bool is_timed_ = false;                           ///< whether it has repeats of contestants
};

}  // namespace palpate::experiments
