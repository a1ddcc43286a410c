// Contestants: which methods there are, which options and stops each takes, and whether it can run here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contestants/option_spec.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// One method of a contestant.
struct MethodSpec {
  std::string name;  ///< "palpate.hierarchical"
  std::string summary;
  std::vector<std::string> stops;  ///< of "fusions", "tets", "ratio", "limit"; contest simplify alone
  std::vector<OptionSpec> options;
  bool keeps = false;  ///< honours regions to keep, and has the options near_size and reach for them
  bool deterministic =
      true;  ///< the same request gives the same bytes; else repeats may differ, and are judged

  const OptionSpec* find_option(const std::string& option) const;
  bool takes_stop(const std::string& kind) const;
};

/// One folder below reference/ in one contest: a program, and the methods that it offers there.
struct Contestant {
  std::string folder;  ///< its name, "tetfusion"
  std::string contest;
  std::filesystem::path program;     ///< beside its description, in the build's bin folder, or anywhere
  std::vector<std::string> command;  ///< what is started: the program, and the words behind it
  std::vector<std::filesystem::path> files;   ///< that the program needs: scripts among the words, `files`
  std::vector<std::filesystem::path> starts;  ///< other programs of the build that it starts itself
  std::vector<std::string> packages;
  std::string licence;
  std::string source;
  std::vector<MethodSpec> methods;

  /// Why it cannot run here, empty if it can.
  std::string unavailable() const;
};

/// A method together with the contestant that it belongs to.
struct MethodEntry {
  const Contestant* contestant = nullptr;
  const MethodSpec* method = nullptr;
};

/// All contestants that were found, sorted by folder.
class Registry {
 public:
  explicit Registry(std::vector<Contestant> contestants);

  const std::vector<Contestant>& contestants() const { return contestants_; }
  std::vector<std::string> method_names() const;

  /// The method of that name, or nothing.
  std::optional<MethodEntry> find(const std::string& method) const;

 private:
  std::vector<Contestant> contestants_;
};

/// Reads contestant.yaml (palpate/contestant/1). Returns one entry for each contest that it lists.
/// Throws: InputError with file and line.
std::vector<Contestant> read_description(const std::filesystem::path& description,
                                         const std::filesystem::path& bin_folder);

/// Reads every description below reference/, below the folders that the environment variable
/// PALPATE_CONTESTANTS adds (separated by colons) and below those in `more`: each is the folder of a
/// contestant, or holds one folder a contestant. One that is found twice counts once.
/// Throws: InputError, also if two contestants offer a method of the same name.
Registry load_registry(const std::vector<std::filesystem::path>& more = {});

/// The hash of all that makes the contestant: of its program, or of that and its files together. What the
/// program reads beside them is not known. Throws: InputError if one of them cannot be read.
std::string hash_contestant(const Contestant& contestant);

/// Reads an option's value as its type from text, as in `--set name=value` and in YAML.
/// Throws: InputError that starts with `where` and names the choices or the bounds.
nlohmann::json parse_option(const OptionSpec& option, const std::string& text, const std::string& where);

/// Every option of the method, typed: `given` where it is given, the default (if not null) otherwise.
/// `given` maps a name to its text and to the place named in messages.
/// Throws: InputError for an unknown option (with the nearest) or a bad value.
struct GivenOption {
  std::string text;
  std::string where;
};
nlohmann::json resolve_options(const MethodSpec& method, const std::map<std::string, GivenOption>& given);

}  // namespace palpate::experiments
