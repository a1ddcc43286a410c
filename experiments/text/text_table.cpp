// Tables of text, folded to the terminal.
#include <algorithm>
#include <numeric>
#include <sstream>

#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kLeastWords = 24;  // columns that a column of words is worth having
constexpr std::size_t kIndent = 4;

void trim_end(std::string& line) {
  line.erase(line.find_last_not_of(' ') + 1);
}

}  // namespace

std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    std::string& line = lines.back();
    if (line.empty()) {
      line = word;
    } else if (display_width(line) + 1 + display_width(word) <= most) {
      line += " " + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

TextTable::TextTable(std::vector<std::string> header, std::string alignment)
    : rows_{std::move(header)}, alignment_(std::move(alignment)) {}

void TextTable::add(std::vector<std::string> row) {
  row.resize(rows_.front().size());
  rows_.push_back(std::move(row));
}

TextTable::Columns TextTable::widths() const {
  Columns widths(rows_.front().size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], display_width(row[i]));
  }
  return widths;
}

std::size_t TextTable::count_names() const {
  const std::size_t columns = rows_.front().size();
  std::size_t count = 1;
  if (columns > 2 && alignment_.starts_with("ll")) count = 2;
  return count;
}

std::string TextTable::padded(std::size_t row, std::size_t column, std::size_t width) const {
  const std::string& cell = rows_[row][column];
  const std::string padding(width - std::min(width, display_width(cell)), ' ');
  const bool right = column < alignment_.size() && alignment_[column] == 'r';
  return right ? padding + cell : cell + padding;
}

/// One row of some columns; what does not fit is taken from the last, which is wrapped below itself.
std::string TextTable::line_of(std::size_t row, const Columns& columns, const Columns& widths,
                               std::size_t most) const {
  std::string line;
  for (std::size_t i = 0; i + 1 < columns.size(); ++i) {
    line += padded(row, columns[i], widths[columns[i]]) + std::string(kGap, ' ');
  }
  const std::size_t used = display_width(line);
  const std::size_t last = columns.back();
  const std::size_t room = most > used ? most - used : 1;
  std::vector<std::string> parts{padded(row, last, widths[last])};
  if (widths[last] > room) parts = wrapped(rows_[row][last], room);
  line += parts.front();
  trim_end(line);
  if (row == 0) line = colored(line, Color::kBold);
  for (std::size_t i = 1; i < parts.size(); ++i) line += "\n" + std::string(used, ' ') + parts[i];
  return line + "\n";
}

std::string TextTable::block_of(const Columns& columns, const Columns& widths, std::size_t most) const {
  std::string text;
  for (std::size_t row = 0; row < rows_.size(); ++row) text += line_of(row, columns, widths, most);
  return text;
}

/// Each row as its names in a line of their own, and "column value" pairs below.
std::string TextTable::records_of(std::size_t names, std::size_t most) const {
  const std::string indent(kIndent, ' ');
  std::string text;
  for (std::size_t row = 1; row < rows_.size(); ++row) {
    std::string name;
    for (std::size_t i = 0; i < names; ++i) name += (i > 0 ? std::string(kGap, ' ') : "") + rows_[row][i];
    text += name + "\n";
    std::string line = indent;
    const auto end_line = [&] {
      if (line != indent) text += line + "\n";
      line = indent;
    };
    for (std::size_t i = names; i < rows_[row].size(); ++i) {
      if (rows_[row][i].empty()) continue;
      const std::string pair = (rows_[0][i].empty() ? "" : rows_[0][i] + " ") + rows_[row][i];
      if (line != indent && display_width(line) + kGap + display_width(pair) > most) end_line();
      if (kIndent + display_width(pair) > most) {
        for (const std::string& part : wrapped(pair, most - kIndent)) text += indent + part + "\n";
        continue;
      }
      line += (line == indent ? "" : std::string(kGap, ' ')) + pair;
    }
    end_line();
  }
  return text;
}

std::string TextTable::text(std::size_t most) const {
  const Columns widths = this->widths();
  Columns all(widths.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::size_t total = std::accumulate(widths.begin(), widths.end(), kGap * (widths.size() - 1));
  const bool ends_in_words = alignment_.size() == widths.size() && alignment_.back() == 'l';
  const std::size_t before = total - widths.back();
  if (total <= most || (ends_in_words && before + kLeastWords <= most)) return block_of(all, widths, most);
  const std::size_t names = count_names();
  std::size_t head = kGap * (names - 1);
  for (std::size_t i = 0; i < names; ++i) head += widths[i];
  if (ends_in_words || head > most / 2) return records_of(names, most);
  std::string text;
  Columns block(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(names));
  std::size_t used = head;
  for (std::size_t i = names; i < widths.size(); ++i) {
    if (block.size() > names && used + kGap + widths[i] > most) {
      text += block_of(block, widths, most) + "\n";
      block.resize(names);
      used = head;
    }
    block.push_back(i);
    used += kGap + widths[i];
  }
  return text + block_of(block, widths, most);
}

}  // namespace palpate::experiments
