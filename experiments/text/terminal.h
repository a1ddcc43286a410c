// What a person sees: colour where it is wanted, tables that line up, a progress bar with the time left.
#pragma once

#include <chrono>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Whether this stream (1 or 2) takes colour: a terminal, and NO_COLOR not set.
bool takes_color(int stream);

enum class Color { kGreen, kRed, kYellow, kBold, kDim };

/// The text in a colour if standard output takes one, otherwise as it is.
std::string colored(const std::string& text, Color color);

/// Characters as a terminal counts them: the bytes that start one in UTF-8, colours left out.
std::size_t display_width(const std::string& text);

/// The words of a text in lines of at most `most` characters; a longer word stays whole. At least one line.
std::vector<std::string> wrapped(const std::string& text, std::size_t most);

/// Columns that standard output has room for: the environment's COLUMNS, else the terminal's, else 80; at
/// least 40.
std::size_t output_columns();

/// A table of text: columns padded to their widest cell, numbers to the right if asked.
class TextTable {
 public:
  /// `alignment` has one character a column: 'l' or 'r'.
  TextTable(std::vector<std::string> header, std::string alignment);

  void add(std::vector<std::string> row);

  /// The whole table, each line ended, folded to `most` columns: a last column of words is wrapped; where
  /// that does not do, or names (the first columns to the left, two at most) take over half, each row is a
  /// record of "column value" pairs; of figures alone, blocks of columns stand one below the other, each with
  /// the row's names again. A single word that is longer stays whole.
  std::string text(std::size_t most = output_columns()) const;

 private:
  using Columns = std::vector<std::size_t>;
  Columns widths() const;
  std::size_t count_names() const;
  std::string padded(std::size_t row, std::size_t column, std::size_t width) const;
  std::string line_of(std::size_t row, const Columns& columns, const Columns& widths, std::size_t most) const;
  std::string block_of(const Columns& columns, const Columns& widths, std::size_t most) const;
  std::string records_of(std::size_t names, std::size_t most) const;

  std::vector<std::vector<std::string>> rows_;
  std::string alignment_;
};

/// Seconds for a person: "0.8 s", "45 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

/// A short time for a person, three digits: "118 us", "44.3 ms", "2.5 s".
std::string time_text(double seconds);

/// Progress on standard error: a bar with the time left on a terminal, a line now and then otherwise.
class Progress {
 public:
  explicit Progress(bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Starts counting `total` steps.
  void start(std::size_t total);

  /// Says what is being done now.
  void show(const std::string& what);

  /// The same of what may take long: a line of its own where there is no terminal.
  void show_long(const std::string& what);

  /// One step is done; `seconds_left` is the estimate for the rest.
  void step(double seconds_left);

  /// So many steps are done.
  void reach(std::size_t done, double seconds_left);

  /// A line of its own that stays.
  void say(const std::string& line);

 private:
  void draw();
  void clear();

  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  std::size_t done_ = 0;
  std::size_t total_ = 0;
  double seconds_left_ = -1.0;
  std::string what_;
  std::chrono::steady_clock::time_point last_line_;
};

/// Prints a JSON object to standard output.
void print_json(const nlohmann::json& value);

/// Prints one line on standard error, "palpate: ...".
void print_note(const std::string& line);

}  // namespace palpate::experiments
