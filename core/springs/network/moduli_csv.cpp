#include "core/springs/network/moduli_csv.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"

namespace palpate::springs {
namespace {

constexpr const char* kVertexHeader = "vertex,modulus_pa";
constexpr const char* kTetHeader = "tet,modulus_pa";

/// "NUMBER,MODULUS" with the number that is due.
bool parse_row(const std::string& line, std::size_t due, double& modulus) {
  std::size_t number = 0;
  const char* end = line.data() + line.size();
  const auto [comma, first_error] = std::from_chars(line.data(), end, number);
  if (first_error != std::errc() || comma == end || *comma != ',' || number != due) return false;
  const auto [stop, second_error] = std::from_chars(comma + 1, end, modulus);
  return second_error == std::errc() && stop == end && std::isfinite(modulus) && modulus >= 0.0;
}

}  // namespace

void write_moduli_csv(const std::filesystem::path& path, const DilatationModuli& moduli) {
  std::string text = moduli.at_vertices ? kVertexHeader : kTetHeader;
  text += '\n';
  for (std::size_t i = 0; i < moduli.modulus_pa.size(); ++i) {
    text += std::to_string(i) + ",";
    append_number(text, moduli.modulus_pa[i]);
    text += '\n';
  }
  write_file_atomically(path, text);
}

DilatationModuli read_moduli_csv(const std::filesystem::path& path, const TetMesh& mesh) {
  refuse_no_file(path, "a file");
  std::ifstream in(path);
  if (!in) throw InputError(path.string(), 0, "a file that can be read", "none");
  std::string line;
  std::getline(in, line);
  if (line != kVertexHeader && line != kTetHeader)
    throw InputError(path.string(), 1, std::string(kVertexHeader) + " or " + kTetHeader,
                     "\"" + line.substr(0, 60) + "\"");
  DilatationModuli moduli;
  moduli.at_vertices = line == kVertexHeader;
  const std::size_t wanted = moduli.at_vertices ? mesh.points.size() : mesh.tets.size();
  const std::string kind = moduli.at_vertices ? "vertices" : "tetrahedra";
  while (std::getline(in, line)) {
    const std::size_t due = moduli.modulus_pa.size();
    if (due == wanted)
      throw InputError(path.string(), due + 2, "the " + std::to_string(wanted) + " " + kind + " of the mesh",
                       "more: the moduli are of another mesh");
    double modulus = 0.0;
    if (!parse_row(line, due, modulus))
      throw InputError(path.string(), due + 2,
                       "\"" + std::to_string(due) + ",\" and a finite modulus of at least 0",
                       "\"" + line.substr(0, 60) + "\"");
    moduli.modulus_pa.push_back(modulus);
  }
  if (moduli.modulus_pa.size() != wanted)
    throw InputError(path.string(), 0, "the " + std::to_string(wanted) + " " + kind + " of the mesh",
                     std::to_string(moduli.modulus_pa.size()) + ": the moduli are of another mesh");
  return moduli;
}

}  // namespace palpate::springs
