#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/cgal/file_claims.h"

namespace palpate::reference {
namespace {

constexpr std::size_t kWord = 4;  ///< bytes of a number in a binary file
constexpr std::size_t kLongestKeyword = 41;
constexpr double kMostEdges = 1073741823.0;  ///< CGAL 5.5.1 doubles them as an int

bool take(std::string_view& word, std::string_view prefix) {
  if (word.substr(0, prefix.size()) != prefix) return false;
  word.remove_prefix(prefix.size());
  return true;
}

/// Walks as CGAL's File_header_OFF and File_scanner_OFF do (CGAL/IO/OFF), without taking anything on trust.
class OffFile {
 public:
  explicit OffFile(const std::string& where)
      : where_(where), size_(std::filesystem::file_size(where)), file_(where, std::ios::binary) {}

  OffExtras check() {
    read_kind();
    read_counts();
    if (is_binary_) {
      check_binary();
      return {};
    }
    check_text();
    return extras_;
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& expected, const std::string& found) const {
    throw InputError(where_, line, expected, found);
  }

  bool get(char& c) {
    if (!file_.get(c)) return false;
    if (c == '\n') ++line_;
    return true;
  }

  bool skip_line() {
    char c = '\0';
    while (get(c) && c != '\n') {
    }
    return static_cast<bool>(file_);
  }

  /// To the next character that is neither white space nor of a comment. Returns false if there is none.
  bool skip_comments() {
    for (char c = '\0'; get(c);) {
      if (c == '#') {
        skip_line();
      } else if (std::isspace(static_cast<unsigned char>(c)) == 0) {
        file_.unget();
        return true;
      }
    }
    return false;
  }

  /// Letters and digits, or any one character; takes the character behind as well. Returns: the word, and
  /// whether its line ended with it.
  std::string read_word(bool& is_line_over) {
    std::string word;
    char c = '\0';
    if (get(c)) word = c;
    while (word.size() < kLongestKeyword && get(c) && std::isalnum(static_cast<unsigned char>(c)) != 0)
      word += c;
    is_line_over = c == '\n';
    return word;
  }

  /// (ST)(C)(N)(4)(n)OFF or SKEL, and BINARY or the first count.
  void read_kind() {
    bool is_line_over = false;
    const bool has_keyword = skip_comments();
    const std::size_t keyword_line = line_;
    if (has_keyword) extras_.at = static_cast<std::size_t>(file_.tellg());
    const std::string keyword = has_keyword ? read_word(is_line_over) : "";
    std::string_view word = keyword;
    has_textures_ = take(word, "ST");
    is_colored_ = take(word, "C");
    extras_.length = keyword.size() - word.size();
    has_normals_ = take(word, "N");
    is_homogeneous_ = take(word, "4");
    has_dimension_ = take(word, "n");
    is_skeleton_ = word == "SKEL";
    const std::string known = "OFF, NOFF, COFF or CNOFF";
    if (word != "OFF" && !is_skeleton_) fail(keyword_line, known, shown_piece(keyword));
    if (is_colored_ && (has_textures_ || is_homogeneous_)) fail(keyword_line, known, shown_piece(keyword));
    if (!skip_comments()) fail(0, "counts behind " + keyword, "the end of the file");
    if (std::isdigit(file_.peek()) == 0) {
      const std::size_t line = line_;
      const std::string second = read_word(is_line_over);
      if (second != "BINARY") fail(line, "counts or BINARY behind " + keyword, shown_piece(second));
      is_binary_ = true;
      if (!is_line_over) skip_line();
    }
    if (is_binary_ && is_colored_)  // which CGAL 5.5.1 does not pass over
      fail(keyword_line, "OFF BINARY or NOFF BINARY", shown_piece(keyword));
  }

  /// A whole number as text. White space goes before it, no comment. Returns nothing where there is none.
  std::optional<double> read_whole() {
    for (char c = '\0'; get(c);) {
      if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
      const bool is_signed = c == '-' || c == '+';
      if (!is_signed) file_.unget();
      if (std::isdigit(file_.peek()) == 0) return std::nullopt;
      double value = 0.0;
      while (std::isdigit(file_.peek()) != 0) value = std::min(1e18, 10.0 * value + (file_.get() - '0'));
      return c == '-' ? -value : value;
    }
    return std::nullopt;
  }

  /// 32 bits of a binary file, the highest byte first.
  std::optional<double> read_word32() {
    std::array<char, kWord> bytes{};
    if (!file_.read(bytes.data(), bytes.size())) return std::nullopt;
    std::uint32_t bits = 0;
    for (const char byte : bytes) bits = bits << 8U | static_cast<unsigned char>(byte);
    return static_cast<double>(static_cast<std::int32_t>(bits));
  }

  double read_count(const char* what, double most, double least = 0.0) {
    const std::optional<double> count = is_binary_ ? read_word32() : read_whole();
    const std::size_t line = is_binary_ ? 0 : line_;
    if (!count) fail(line, std::string("a number of ") + what, "none");
    if (!(*count >= least) || *count > most) {
      const bool is_size = most == static_cast<double>(size_);
      fail(line,
           std::string(what) + (is_size ? " that " + std::to_string(size_) + " bytes can hold"
                                        : ", " + short_number(least) + " to " + short_number(most)),
           short_number(*count));
    }
    return *count;
  }

  /// CGAL 5.5.1 makes room for all vertices and faces that are claimed before it reads them: none takes less
  /// than a byte.
  void read_counts() {
    const auto most = static_cast<double>(size_);
    if (has_dimension_) read_count("dimensions", std::numeric_limits<std::int32_t>::max());
    vertices_ = read_count("vertices", most);
    faces_ = read_count("faces", most);
    if (!is_skeleton_) read_count("edges", kMostEdges, -kMostEdges);
  }

  /// Numbers of a vertex in front of its colour.
  std::size_t plain_numbers() const {
    const std::size_t own = is_homogeneous_ ? 4 : 3;
    return has_normals_ ? 2 * own : own;
  }

  std::string claim() const {
    return short_number(vertices_) + " vertices and " + short_number(faces_) + " faces, as the header says";
  }

  void check_text() {
    const std::size_t plain = plain_numbers();
    for (auto left = static_cast<std::uint64_t>(vertices_); left > 0; --left) {
      read_row();
      if (numbers_.size() < plain) fail_row("a vertex of " + std::to_string(plain) + " numbers");
      if (is_colored_) check_color(plain, false);
    }
    for (auto left = static_cast<std::uint64_t>(faces_); left > 0; --left) {
      read_row();
      check_face();
      if (is_colored_) check_color(4, true);
    }
  }

  /// The numbers of the next row that has anything but a comment, up to the first that is none.
  void read_row() {
    if (!skip_comments()) fail(0, claim(), std::to_string(rows_) + " rows");
    row_line_ = line_;
    std::getline(file_, row_);
    ++line_;
    ++rows_;
    row_.resize(std::min(row_.size(), row_.find('#')));
    words_.clear();
    words_.str(row_);
    numbers_.clear();
    for (double number = 0.0; words_ >> number;) numbers_.push_back(number);
  }

  [[noreturn]] void fail_row(const std::string& expected) const {
    fail(row_line_, expected, shown_piece(row_));
  }

  void check_face() const {
    if (numbers_.empty()) fail_row("a face");
    const double corners = numbers_.front();
    if (!(corners >= 0.0) || corners > static_cast<double>(size_) || corners != std::floor(corners))
      fail_row("corners of a face that " + std::to_string(size_) + " bytes can hold");
    if (corners != 3.0)
      fail(row_line_, "triangles only", "a polygon of " + short_number(corners) + " corners");
    if (numbers_.size() < 4) fail_row("3 corners");
    for (std::size_t k = 1; k < 4; ++k) {
      if (!is_vertex(numbers_[k]))
        fail(row_line_, "vertices 0 to " + short_number(vertices_ - 1.0), short_number(numbers_[k]));
    }
  }

  bool is_vertex(double index) const {
    return index >= 0.0 && index < vertices_ && index == std::floor(index);
  }

  /// Three or four numbers behind the row's own; a face may go without.
  void check_color(std::size_t own, bool may_lack) const {
    const std::size_t count = numbers_.size();
    if (count == own + 3 || count == own + 4 || (may_lack && count == own)) return;
    fail_row("a colour of 3 or 4 numbers");
  }

  /// CGAL 5.5.1 reads a face's corners and no count of colours behind them, though it writes one.
  void check_binary() {
    const std::size_t texture = has_textures_ ? (is_homogeneous_ ? 3U : 2U) : 0U;
    const std::size_t vertex = kWord * (plain_numbers() + texture);
    const auto start = static_cast<std::uintmax_t>(file_.tellg());
    const double held = std::floor(static_cast<double>(size_ - start) / static_cast<double>(vertex));
    if (held < vertices_) fail(0, claim(), short_number(held) + " vertices");
    file_.seekg(static_cast<std::streamoff>(start) +
                static_cast<std::streamoff>(vertices_) * static_cast<std::streamoff>(vertex));
    const auto faces = static_cast<std::uint64_t>(faces_);
    for (std::uint64_t k = 1; k <= faces; ++k) check_binary_face(static_cast<double>(k));
  }

  void check_binary_face(double number) {
    const auto cut = [&] { fail(0, claim(), short_number(number - 1.0) + " faces"); };
    const std::string face = "face " + short_number(number) + " of " + short_number(faces_);
    const std::optional<double> corners = read_word32();
    if (!corners) cut();
    if (*corners == 0.0)
      fail(0, "three corners of " + face + ", without a count of colours between faces", "0 corners");
    if (*corners != 3.0)
      fail(0, "triangles only", "a polygon of " + short_number(*corners) + " corners, " + face);
    for (int k = 0; k < 3; ++k) {
      const std::optional<double> index = read_word32();
      if (!index) cut();
      if (!is_vertex(*index))
        fail(0, "vertices 0 to " + short_number(vertices_ - 1.0) + " in " + face, short_number(*index));
    }
  }

  std::string where_;
  std::uintmax_t size_ = 0;
  std::ifstream file_;
  std::size_t line_ = 1;
  bool has_textures_ = false;
  bool is_colored_ = false;
  bool has_normals_ = false;
  bool is_homogeneous_ = false;
  bool has_dimension_ = false;
  bool is_skeleton_ = false;
  bool is_binary_ = false;
  OffExtras extras_;
  double vertices_ = 0.0;
  double faces_ = 0.0;
  std::size_t rows_ = 0;  ///< those behind the counts
  std::size_t row_line_ = 0;
  std::string row_;
  std::istringstream words_;
  std::vector<double> numbers_;
};

}  // namespace

OffExtras check_off_file(const std::string& where) {
  return OffFile(where).check();
}

std::string shown_piece(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  const std::size_t first = text.find_first_not_of(" \t\r\n\v\f");
  if (first == std::string_view::npos) return "nothing";
  std::string piece(text.substr(first, kLongest));
  piece.resize(piece.find_last_not_of(" \t\r\n\v\f") + 1);
  for (char& c : piece) {
    if (c < ' ' || c > '~') c = '?';
  }
  return piece;
}

}  // namespace palpate::reference
