#include "reference/reduced/table_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using dynamics::ComplianceTable;

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

constexpr const char* kSchema = "palpate/compliance_table/1";
constexpr std::size_t kMostBytes = std::size_t{8} << 30U;
constexpr std::size_t kMostVertices = 1U << 24U;

template <typename Item>
void append(std::string& out, const std::vector<Item>& items) {
  const std::size_t at = out.size();
  out.resize(at + items.size() * sizeof(Item));
  if (!items.empty()) std::memcpy(out.data() + at, items.data(), items.size() * sizeof(Item));
}

/// Takes arrays out of the bytes after the header.
class Bytes {
 public:
  Bytes(const std::string& text, std::size_t at, std::string where)
      : text_(text), at_(at), where_(std::move(where)) {}

  template <typename Item>
  std::vector<Item> take(std::size_t count) {
    if (count > (text_.size() - at_) / sizeof(Item))
      throw InputError(where_, 0, std::to_string(count) + " numbers more", "the end of the file");
    std::vector<Item> items(count);
    if (count > 0) std::memcpy(items.data(), text_.data() + at_, count * sizeof(Item));
    at_ += count * sizeof(Item);
    return items;
  }

  template <typename Number>
  std::vector<Number> take_finite(std::size_t count) {
    std::vector<Number> numbers = take<Number>(count);
    for (const Number number : numbers) {
      if (!std::isfinite(number)) throw InputError(where_, 0, "finite numbers", "one that is not");
    }
    return numbers;
  }

  void require_end() const {
    if (at_ != text_.size())
      throw InputError(where_, 0, "the end of the file", std::to_string(text_.size() - at_) + " bytes more");
  }

 private:
  const std::string& text_;
  std::size_t at_;
  std::string where_;
};

/// The lines "key value" between schema and "end".
class Header {
 public:
  Header(const std::string& text, std::string where) : where_(std::move(where)) {
    std::size_t at = 0;
    for (std::size_t line = 1; line <= 20; ++line) {
      const std::size_t end = text.find('\n', at);
      if (end == std::string::npos || end - at > 200) break;
      const std::string words = text.substr(at, end - at);
      at = end + 1;
      if (line == 1) {
        if (words != kSchema) break;
      } else if (words == "end") {
        size_ = at;
        return;
      } else {
        const std::size_t space = words.find(' ');
        if (space == std::string::npos) break;
        if (!values_.insert({words.substr(0, space), words.substr(space + 1)}).second) break;
      }
    }
    throw InputError(where_, 0, std::string("a file of ") + kSchema, "something else");
  }

  template <typename Number>
  Number number(const char* key, Number least, Number most) const {
    const std::string found = word(key);
    Number value{};
    const auto [end, error] = std::from_chars(found.data(), found.data() + found.size(), value);
    if (error != std::errc() || end != found.data() + found.size() || !(value >= least && value <= most))
      throw InputError(where_, 0, std::string(key) + ": a number within its bounds", found);
    return value;
  }

  std::string word(const char* key) const {
    const auto at = values_.find(key);
    if (at == values_.end()) throw InputError(where_, 0, std::string("the key ") + key, "none");
    return at->second;
  }

  std::size_t size() const { return size_; }

 private:
  std::string where_;
  std::map<std::string, std::string> values_;
  std::size_t size_ = 0;
};

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
  append(out, table.order);
  append(out, table.nodes.edges);
  append(out, table.skin);
  append(out, table.skin_single);
  append(out, table.field);
  append(out, table.field_single);
  write_file_atomically(path, out);
}

ComplianceTable read_table(const std::filesystem::path& path) {
  const std::string where = path.string();
  const std::string text = read_text_file(path, kMostBytes);
  const Header header(text, where);
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
  Bytes bytes(text, header.size(), where);
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
