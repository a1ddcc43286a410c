#include "reference/reduced/table_file.h"

#include <algorithm>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/door/json_file.h"
#include "reference/reduced/numbers_file.h"

namespace palpate::reference {
namespace {

using dynamics::ComplianceTable;

constexpr const char* kSchema = "palpate/compliance_table/1";
constexpr std::size_t kMostBytes = std::size_t{8} << 30U;
constexpr std::size_t kMostVertices = 1U << 24U;

}  // namespace

void write_table(const std::filesystem::path& path, const ComplianceTable& table) {
  std::string out = kSchema;
  const auto line = [&](const char* key, auto value) {
    out += std::string("\n") + key + " ";
    append_number(out, value);
  };
  line("body", table.body);
  line("elements", table.options.element_order);
  line("refine", table.options.refine);
  line("reactions", table.options.reaction_order);
  line("poisson_ratio", table.options.poisson_ratio);
  out += table.is_single() ? "\nprecision single" : "\nprecision double";
  line("midpoints", table.options.midpoints ? 1 : 0);
  line("rows", table.order.size());
  line("skin_vertices", table.nodes.vertices.size());
  line("skin_edges", table.nodes.edges.size());
  out += "\nend\n";
  append_numbers(out, table.order);
  append_numbers(out, table.nodes.edges);
  append_numbers(out, table.skin);
  append_numbers(out, table.skin_single);
  append_numbers(out, table.field);
  append_numbers(out, table.field_single);
  write_file_atomically(path, out);
}

ComplianceTable read_table(const std::filesystem::path& path) {
  const std::string where = path.string();
  const std::string text = read_text_file(path, kMostBytes);
  const NumbersHeader header(text, kSchema, where);
  ComplianceTable table;
  table.body = header.number<std::uint64_t>("body", 0, ~std::uint64_t{0});
  table.options.element_order = header.number<int>("elements", 1, 2);
  table.options.refine = header.number<int>("refine", 0, 1);
  table.options.reaction_order = header.number<int>("reactions", 1, 2);
  table.options.poisson_ratio = header.number<double>("poisson_ratio", -1.0, 0.5);
  table.options.midpoints = header.number<int>("midpoints", 0, 1) == 1;
  const std::string precision = header.word("precision");
  if (precision != "single" && precision != "double")
    throw InputError(where, 0, "precision single or double", precision);
  const auto vertices = header.number<std::size_t>("rows", 4, kMostVertices);
  const auto skin = header.number<std::size_t>("skin_vertices", 4, vertices);
  const auto edges = header.number<std::size_t>("skin_edges", 0, kMostVertices);
  NumbersAfter bytes(text, header.size(), where);
  table.order = bytes.take<Index>(vertices);
  table.nodes.vertices.assign(table.order.begin(), table.order.begin() + static_cast<std::ptrdiff_t>(skin));
  std::vector<Index> sorted = table.order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t v = 0; v < sorted.size(); ++v) {
    if (sorted[v] != v) throw InputError(where, 0, "each vertex once", "another order");
  }
  table.nodes.edges = bytes.take<Edge>(edges);
  const std::size_t columns = 3 * table.nodes.size();
  if (precision == "single") {
    table.skin_single = bytes.take_finite<float>(columns * columns);
    table.field_single = bytes.take_finite<float>(3 * vertices * columns);
  } else {
    table.skin = bytes.take_finite<double>(columns * columns);
    table.field = bytes.take_finite<double>(3 * vertices * columns);
  }
  bytes.require_end();
  return table;
}

}  // namespace palpate::reference
