#include "core/springs/network/springs_csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"
#include "core/mesh/topology.h"
#include "core/springs/network/network.h"

namespace palpate::springs {
namespace {

constexpr std::string_view kHeader = "vertex_a,vertex_b,rest_length_m,stiffness_n_per_m";
constexpr double kLengthTolerance = 1e-6;

std::string read_text(const std::filesystem::path& path) {
  refuse_no_file(path, "a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string(), 0, "a file that can be read", "none");
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw InputError(path.string(), 0, "a file that can be read", "a read error");
  return text;
}

/// The lines of a file one by one, without their ends; "\r\n" is one.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::size_t number_ = 0;
};

struct Row {
  Edge pair{};
  double rest_length = 0.0;
  double stiffness = 0.0;
};

/// Takes the text up to the next comma, or all of it, as a number.
template <typename Number>
bool take(std::string_view& text, Number& value, bool last) {
  const std::size_t end = std::min(text.find(','), text.size());
  if (last != (end == text.size())) return false;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + end, value);
  if (error != std::errc() || stop != text.data() + end) return false;
  text.remove_prefix(std::min(end + 1, text.size()));
  return true;
}

/// The words of a row, or an InputError.
class RowReader {
 public:
  RowReader(std::string file, const TetMesh& mesh) : file_(std::move(file)), mesh_(mesh) {}

  Row read(std::string_view line, std::size_t number) const {
    Row row;
    std::string_view text = line;
    if (!take(text, row.pair[0], false) || !take(text, row.pair[1], false) ||
        !take(text, row.rest_length, false) || !take(text, row.stiffness, true) ||
        !std::isfinite(row.rest_length) || !std::isfinite(row.stiffness)) {
      throw InputError(file_, number, "two vertices and two finite numbers, separated by commas",
                       "\"" + std::string(line.substr(0, 60)) + "\"");
    }
    check(row, number);
    return row;
  }

 private:
  void check(const Row& row, std::size_t number) const {
    const auto [a, b] = row.pair;
    if (a >= b)
      throw InputError(file_, number, "vertex_a below vertex_b", std::to_string(a) + "," + std::to_string(b));
    if (b >= mesh_.points.size()) {
      throw InputError(file_, number, "vertices of the mesh, 0 to " + std::to_string(mesh_.points.size() - 1),
                       std::to_string(b) + ": the springs are of another mesh");
    }
    if (row.stiffness < 0.0)
      throw InputError(file_, number, "a stiffness of at least 0", text_of(row.stiffness));
    const double length_of_mesh = length(mesh_.points[b] - mesh_.points[a]);
    if (std::abs(row.rest_length - length_of_mesh) > kLengthTolerance * length_of_mesh) {
      throw InputError(file_, number,
                       "the distance of vertices " + std::to_string(a) + " and " + std::to_string(b) + ", " +
                           text_of(length_of_mesh) + " m",
                       text_of(row.rest_length) + ": the springs are of another mesh, or of another unit");
    }
  }

  static std::string text_of(double value) {
    std::string text;
    append_number(text, value);
    return text;
  }

  std::string file_;
  const TetMesh& mesh_;
};

std::string name_of(const Edge& pair) {
  return "(" + std::to_string(pair[0]) + ", " + std::to_string(pair[1]) + ")";
}

/// Each row is a spring that the mesh can have, and each edge of the mesh has a row.
void check_pairs(const std::string& file, const TetMesh& mesh, const std::vector<Edge>& pairs) {
  const std::vector<Edge> edges = build_edges(mesh);
  std::size_t next = 0;
  bool only_edges = true;
  for (const Edge& edge : edges) {
    while (next < pairs.size() && pairs[next] < edge) ++next, only_edges = false;
    if (next == pairs.size() || pairs[next] != edge)
      throw InputError(file, 0, "a row for every edge of the mesh", "none for " + name_of(edge));
    ++next;
  }
  if (only_edges && next == pairs.size()) return;
  const std::vector<Edge> possible = build_spring_network(mesh, true).springs;
  for (std::size_t row = 0; row < pairs.size(); ++row) {
    if (!std::binary_search(possible.begin(), possible.end(), pairs[row])) {
      throw InputError(file, row + 2, "an edge of the mesh, or the two apexes of an interior face",
                       name_of(pairs[row]) + ": the springs are of another mesh");
    }
  }
}

}  // namespace

void write_springs_csv(const std::filesystem::path& path, const SpringNetwork& network) {
  std::string text(kHeader);
  text += '\n';
  text.reserve(64 * network.springs.size());
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    append_number(text, network.springs[s][0]);
    text += ',';
    append_number(text, network.springs[s][1]);
    text += ',';
    append_number(text, network.rest_length_m[s]);
    text += ',';
    append_number(text, network.stiffness_n_per_m[s]);
    text += '\n';
  }
  write_file_atomically(path, text);
}

SpringNetwork read_springs_csv(const std::filesystem::path& path, const TetMesh& mesh) {
  const std::string text = read_text(path);
  Lines lines(text);
  std::string_view line;
  if (!lines.next(line) || line != kHeader) {
    throw InputError(path.string(), 1, "\"" + std::string(kHeader) + "\"",
                     "\"" + std::string(line.substr(0, 60)) + "\"");
  }
  const RowReader reader(path.string(), mesh);
  SpringNetwork network;
  while (lines.next(line)) {
    const Row row = reader.read(line, lines.number());
    if (!network.springs.empty() && !(network.springs.back() < row.pair)) {
      throw InputError(path.string(), lines.number(), "rows sorted by vertices, each pair once",
                       name_of(row.pair) + " after " + name_of(network.springs.back()));
    }
    network.springs.push_back(row.pair);
    network.rest_length_m.push_back(row.rest_length);
    network.stiffness_n_per_m.push_back(row.stiffness);
  }
  check_pairs(path.string(), mesh, network.springs);
  return network;
}

}  // namespace palpate::springs
