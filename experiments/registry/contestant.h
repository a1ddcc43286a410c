// A contestant: its program, the methods that it offers, and which options and stops each takes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/registry/option_spec.h"

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

/// The hash of all that makes the contestant: of its program, or of that and its files together. What the
/// program reads beside them is not known. Throws: InputError if one of them cannot be read.
std::string hash_contestant(const Contestant& contestant);

}  // namespace palpate::experiments
