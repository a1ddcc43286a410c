#include "experiments/live/live_table.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "experiments/contests/moving_task.h"
#include "experiments/files/file_cache.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/registry/method_options.h"
#include "experiments/text/terminal.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kTableMethod = "reduced.compliance";

/// The number behind `key` in the lines of a table's head.
std::size_t number_of(const std::string& head, const std::string& key, const std::string& where) {
  const std::size_t at = head.find("\n" + key + " ");
  std::size_t value = 0;
  if (at != std::string::npos) {
    const char* const first = head.data() + at + key.size() + 2;
    const auto [end, error] = std::from_chars(first, head.data() + head.size(), value);
    if (error == std::errc() && *end == '\n') return value;
  }
  throw InputError(where, 0, "a table with the key " + key, "another file");
}

template <typename Item>
std::vector<Item> take(const std::string& bytes, std::size_t at, std::size_t count,
                       const std::string& where) {
  if (at > bytes.size() || count > (bytes.size() - at) / sizeof(Item))
    throw InputError(where, 0, "a whole table", "one that ends early");
  std::vector<Item> out(count);
  std::memcpy(out.data(), bytes.data() + at, count * sizeof(Item));
  return out;
}

/// Of the bits of a mesh.
std::string hash_of(const TetMesh& mesh) {
  std::string bytes(reinterpret_cast<const char*>(mesh.points.data()), mesh.points.size() * sizeof(Vec3));
  bytes.append(reinterpret_cast<const char*>(mesh.tets.data()), mesh.tets.size() * sizeof(Tet));
  return hash_bytes(bytes);
}

/// The bytes of the table's file, made anew.
std::string make_table(const LiveBodyData& out, const Registry& registry) {
  const LiveLevel& whole = out.levels.front();
  const ScratchFolder scratch;
  ContestantTask task = start_task(kTableMethod, reference::problem_to_json(whole.holding), whole.mesh,
                                   registry, scratch.file("body"));
  task.options = resolve_options(*task.method.method, {{"write_table", {"true", "palpate live"}}});
  print_note("making the table of the skin's compliances by quadratic elements");
  const ContestantAnswer answer = run_moving_task(task, out.title);
  const auto bytes = read_bytes(answer.report.at("table_file").get<std::string>());
  if (!bytes) throw UnavailableError(std::string(kTableMethod) + " left no table");
  return *bytes;
}

}  // namespace

LiveTable read_live_table(const std::string& bytes, const std::string& where) {
  const std::size_t end = bytes.find("\nend\n");
  constexpr std::size_t kMostHeadBytes = 1000;
  if (end > kMostHeadBytes)  // npos too
    throw InputError(where, 0, "a file of palpate/compliance_table/1", "something else");
  const std::string head = bytes.substr(0, end + 1);
  const std::size_t rows = number_of(head, "rows", where);
  const std::size_t n = number_of(head, "skin_vertices", where);
  const bool is_single = head.find("\nprecision single\n") != std::string::npos;
  const std::size_t skin_edges = number_of(head, "skin_edges", where);
  if (!is_single || skin_edges != 0 || n > rows)
    throw InputError(where, 0, "a table of single precision with linear reactions", "another one");
  const std::size_t numbers = std::size_t{9} * n * n;
  LiveTable table;
  std::size_t at = end + std::strlen("\nend\n");
  table.vertices = take<std::uint32_t>(bytes, at, n, where);
  at += rows * sizeof(std::uint32_t);
  table.skin = take<float>(bytes, at, numbers, where);
  table.field = take<float>(bytes, at + numbers * sizeof(float), numbers, where);
  return table;
}

void make_live_table(const Registry& registry, LiveBodyData& out) {
  const LiveLevel& whole = out.levels.front();
  const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(whole.mesh);
  const auto skin = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), std::uint8_t{1}));
  if (skin > kMostTableVertices) {
    out.no_table = "the skin has " + std::to_string(skin) + " vertices, and a table of more than " +
                   std::to_string(kMostTableVertices) + " is too large for a page";
    return;
  }
  try {
    const auto entry = registry.find(kTableMethod);
    if (!entry) throw UnavailableError("there is no such method");
    const std::string why = entry->contestant->unavailable();
    if (!why.empty()) throw UnavailableError(why);
    const json key{{"body", hash_of(whole.mesh)},
                   {"poisson_ratio", out.material.poisson_ratio},
                   {"contestant", hash_contestant(*entry->contestant)}};
    const std::filesystem::path kept = cache_entry("live_table", key.dump()) / "skin.compliance";
    if (const auto bytes = read_bytes(kept)) {
      out.table = read_live_table(*bytes, kept.string());
      return;
    }
    const std::string bytes = make_table(out, registry);
    out.table = read_live_table(bytes, kTableMethod);
    create_folder(kept.parent_path());
    write_file_atomically(kept, bytes);
  } catch (const UnavailableError& error) {
    out.no_table = std::string(kTableMethod) + ": " + error.what();
  }
}

}  // namespace palpate::experiments
