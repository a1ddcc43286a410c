#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "reference/cgal/file_claims.h"

namespace palpate::reference {
namespace {

/// A type of numbers of the format, by either of its names.
struct PlyType {
  std::string_view name;
  std::string_view sized_name;
  std::size_t bytes;
  bool is_whole;
  double least;
  double most;
};

constexpr std::array<PlyType, 8> kTypes{{{"char", "int8", 1, true, -128.0, 127.0},
                                         {"uchar", "uint8", 1, true, 0.0, 255.0},
                                         {"short", "int16", 2, true, -32768.0, 32767.0},
                                         {"ushort", "uint16", 2, true, 0.0, 65535.0},
                                         {"int", "int32", 4, true, -2147483648.0, 2147483647.0},
                                         {"uint", "uint32", 4, true, 0.0, 4294967295.0},
                                         {"float", "float32", 4, false, 0.0, 0.0},
                                         {"double", "float64", 8, false, 0.0, 0.0}}};

const PlyType* find_type(std::string_view name) {
  for (const PlyType& type : kTypes) {
    if (type.name == name || type.sized_name == name) return &type;
  }
  return nullptr;
}

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;
  const PlyType* count = nullptr;  ///< of a list, before its values

  bool is_number_of(std::string_view wanted) const { return count == nullptr && type->name == wanted; }
};

struct PlyElement {
  std::string name;
  std::size_t line = 0;
  std::uintmax_t count = 0;
  std::vector<PlyProperty> properties;

  bool is_face() const { return name == "face" || name == "faces"; }

  /// The first of this name, or nullptr: CGAL 5.5.1 looks no further.
  const PlyProperty* find(std::string_view wanted) const {
    for (const PlyProperty& property : properties) {
      if (property.name == wanted) return &property;
    }
    return nullptr;
  }

  bool has_byte(std::string_view wanted) const {
    const PlyProperty* property = find(wanted);
    return property != nullptr && property->is_number_of("uchar");
  }

  /// The list of a face that CGAL 5.5.1 takes for its corners, or nullptr.
  const PlyProperty* corners() const {
    for (const char* wanted : {"vertex_indices", "vertex_index"}) {
      const PlyProperty* property = find(wanted);
      if (property != nullptr && property->count != nullptr &&
          (property->type->name == "int" || property->type->name == "uint"))
        return property;
    }
    return nullptr;
  }
};

enum class PlyForm { kText, kLittle, kBig };

/// Walks as CGAL's PLY_reader does (CGAL/IO/PLY), without taking anything on trust.
class PlyFile {
 public:
  explicit PlyFile(const std::string& where)
      : where_(where), size_(std::filesystem::file_size(where)), file_(where, std::ios::binary) {}

  void check() {
    read_header();
    for (const PlyElement& element : elements_) check_types(element);
    file_.clear();  // the header may have ended with the file
    left_ = size_ - static_cast<std::uintmax_t>(file_.tellg());
    for (const PlyElement& element : elements_) check_element(element);
  }

 private:
  void read_header() {
    std::string line;
    while (std::getline(file_, line)) {
      ++line_;
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (line_ == 1 && word != "ply") fail("ply", line);
      if (line_ == 2) read_form(words, line);
      if (line_ <= 2) continue;
      if (word == "end_header") return;  // the whole word: what only begins so ends nothing for CGAL
      if (word.empty()) fail("a keyword of a PLY header", "an empty line");
      if (word == "element") read_element(words, line);
      if (word == "property") read_property(words, line);
    }
    throw InputError(where_, 0, "end_header", "the end of the file");
  }

  void read_form(std::istringstream& words, const std::string& line) {
    std::string form;
    std::string version;
    words >> form >> version;
    if (form == "binary_little_endian") form_ = PlyForm::kLittle;
    if (form == "binary_big_endian") form_ = PlyForm::kBig;
    if (version.empty() || (form_ == PlyForm::kText && form != "ascii"))
      fail("format ascii, binary_little_endian or binary_big_endian and a version", line);
  }

  /// An element takes a byte at least: CGAL 5.5.1 goes through all that are claimed, be they there or not.
  void read_element(std::istringstream& words, const std::string& line) {
    PlyElement element;
    element.line = line_;
    std::string count;
    words >> element.name >> count;
    const char* end = count.data() + count.size();
    const auto [last, error] = std::from_chars(count.data(), end, element.count);
    if (count.empty() || error != std::errc{} || last != end || element.count > size_ ||
        claimed_ + element.count > size_)
      fail("an element of at most " + std::to_string(size_ - claimed_) + ", as the file has bytes", line);
    claimed_ += element.count;
    elements_.push_back(element);
  }

  /// CGAL 5.5.1 takes the last element for the owner, be there one or not, and leaves out what has a type
  /// that it does not know.
  void read_property(std::istringstream& words, const std::string& line) {
    if (elements_.empty()) fail("an element before its properties", "none");
    PlyProperty property;
    std::string type;
    words >> type;
    const bool is_list = type == "list";
    if (is_list) {
      std::string count;
      words >> count >> type;
      property.count = find_type(count);
    }
    words >> property.name;
    property.type = find_type(type);
    const bool is_counted = !is_list || (property.count != nullptr && property.count->is_whole);
    if (property.type == nullptr || !is_counted || property.name.empty())
      fail("a property, or a list of them, of types of the format", line);
    elements_.back().properties.push_back(property);
  }

  /// Throws: InputError for a property that CGAL 5.5.1 takes for another type than it has, without a look.
  void check_types(const PlyElement& element) const {
    const auto require_type = [&](std::string_view name, std::string_view type, std::string_view other) {
      const PlyProperty* found = element.find(name);
      if (found == nullptr || found->is_number_of(type) || found->is_number_of(other)) return;
      std::string expected = std::string(name) + " of type " + std::string(type);
      if (other != type) expected += " or " + std::string(other);
      throw InputError(where_, element.line, expected + " in element " + element.name,
                       (found->count != nullptr ? "a list of " : "") + std::string(found->type->name));
    };
    const bool is_vertex = element.name == "vertex" || element.name == "vertices";
    if (is_vertex) {
      for (const char* name : {"x", "y", "z"}) require_type(name, "double", "float");
    }
    if (element.is_face() && element.corners() == nullptr)
      throw InputError(where_, element.line, "a list vertex_indices of int or uint in element face", "none");
    if (is_vertex || element.is_face()) {
      const auto has = [&](const char* a, const char* b) {
        return element.has_byte(a) || element.has_byte(b);
      };
      const bool is_long = element.has_byte("red");
      if (has("red", "r") && has("green", "g") && has("blue", "b")) {
        for (const char* name : {is_long ? "red" : "r", is_long ? "green" : "g", is_long ? "blue" : "b"})
          require_type(name, "uchar", "uchar");
      }
    }
    if (element.name == "halfedge") {
      for (const char* name : {"source", "target"}) require_type(name, "uint", "uint");
    }
  }

  void check_element(const PlyElement& element) {
    element_ = &element;
    std::uintmax_t bytes = 0;
    bool has_list = false;
    for (const PlyProperty& property : element.properties) {
      bytes += property.type->bytes;
      has_list = has_list || property.count != nullptr;
    }
    if (element.properties.empty()) return;
    if (form_ != PlyForm::kText && !has_list) {
      item_ = bytes == 0 ? 0 : left_ / bytes;
      if (item_ < element.count) fail_end();
      left_ -= element.count * bytes;
      file_.seekg(static_cast<std::streamoff>(size_ - left_));
      return;
    }
    const PlyProperty* corners = element.is_face() ? element.corners() : nullptr;
    for (item_ = 0; item_ < element.count; ++item_) {
      for (const PlyProperty& property : element.properties) take(property, &property == corners);
    }
  }

  /// Passes a property of one item over.
  void take(const PlyProperty& property, bool is_corners) {
    property_ = &property;
    if (property.count == nullptr) {
      if (form_ == PlyForm::kText)
        take_word(*property.type);
      else
        skip(property.type->bytes);
      return;
    }
    const double count = form_ == PlyForm::kText ? take_word(*property.count) : take_bytes(*property.count);
    if (!(count >= 0.0) || count > static_cast<double>(size_))
      fail(place() + " that " + std::to_string(size_) + " bytes can hold", short_number(count));
    if (is_corners && count != 3.0)
      fail("triangles only", "a polygon of " + short_number(count) + " corners, " + item());
    const auto values = static_cast<std::uintmax_t>(count);
    if (form_ != PlyForm::kText) {
      skip(values * property.type->bytes);
      return;
    }
    for (std::uintmax_t k = 0; k < values; ++k) take_word(*property.type);
  }

  void skip(std::uintmax_t bytes) {
    if (bytes > left_) fail_end();
    file_.ignore(static_cast<std::streamsize>(bytes));
    left_ -= bytes;
  }

  /// A whole number of 1, 2 or 4 bytes.
  double take_bytes(const PlyType& type) {
    if (type.bytes > left_) fail_end();
    left_ -= type.bytes;
    std::array<char, 4> bytes{};
    file_.read(bytes.data(), static_cast<std::streamsize>(type.bytes));
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < type.bytes; ++k) {
      const std::size_t at = form_ == PlyForm::kBig ? k : type.bytes - 1 - k;
      bits = bits << 8U | static_cast<unsigned char>(bytes[at]);
    }
    const double value = bits;
    return value > type.most ? value - 2.0 * (type.most + 1.0) : value;  // the complement of a negative one
  }

  /// The next word of the text. Throws: InputError unless all of it is a number that the type can hold, for
  /// CGAL 5.5.1 takes the rest of a word for the next number.
  double take_word(const PlyType& type) {
    while (row_at_ == std::string::npos ||
           (row_at_ = row_.find_first_not_of(kBlanks, row_at_)) == std::string::npos) {
      if (!std::getline(file_, row_)) fail_end();
      ++line_;
      row_at_ = 0;
      if (row_.find_first_not_of(kBlanks) != std::string::npos) ++rows_;
    }
    const std::size_t end = std::min(row_.find_first_of(kBlanks, row_at_), row_.size());
    const std::string_view word = std::string_view(row_).substr(row_at_, end - row_at_);
    row_at_ = end;
    const char* first = word.data() + (word.front() == '+' ? 1 : 0);
    const char* digits = word.data() + (word.front() == '+' || word.front() == '-' ? 1 : 0);
    const char* last = word.data() + word.size();
    double value = 0.0;
    const auto [parsed, error] = std::from_chars(first, last, value);
    const bool is_number = digits != last && (*digits == '.' || (*digits >= '0' && *digits <= '9'));
    const bool fits =
        !type.is_whole || (error == std::errc{} && word.find_first_of(".eE") == std::string_view::npos &&
                           value >= type.least && value <= type.most);
    if (!is_number || parsed != last || !fits) fail(place() + ", " + std::string(type.name), word);
    return value;
  }

  std::string item() const {
    return element_->name + " " + std::to_string(item_ + 1) + " of " + std::to_string(element_->count);
  }

  std::string place() const { return shown_piece(property_->name) + " of " + shown_piece(item()); }

  /// Fewer rows than elements are said first: what stands in them is in the wrong place then.
  [[noreturn]] void fail(const std::string& expected, std::string_view found) {
    const bool is_body = element_ != nullptr;
    const std::size_t line = is_body && form_ != PlyForm::kText ? 0 : line_;
    const std::string piece = shown_piece(found);
    if (is_body && form_ == PlyForm::kText) {
      while (std::getline(file_, row_)) rows_ += row_.find_first_not_of(kBlanks) != std::string::npos ? 1 : 0;
      if (rows_ < claimed_)
        throw InputError(where_, 0, std::to_string(claimed_) + " elements, as the header says",
                         std::to_string(rows_) + " rows");
    }
    throw InputError(where_, line, expected, piece);
  }

  [[noreturn]] void fail_end() {
    if (form_ == PlyForm::kText) fail(place(), "the end of the file");
    fail(std::to_string(element_->count) + " of element " + shown_piece(element_->name) +
             ", as the header says",
         std::to_string(item_) + " and the end of the file");
  }

  static constexpr const char* kBlanks = " \t\r\n\v\f";

  std::string where_;
  std::uintmax_t size_ = 0;
  std::ifstream file_;
  std::size_t line_ = 0;
  PlyForm form_ = PlyForm::kText;
  std::vector<PlyElement> elements_;
  std::uintmax_t claimed_ = 0;  ///< of all elements together
  const PlyElement* element_ = nullptr;
  const PlyProperty* property_ = nullptr;
  std::uintmax_t item_ = 0;
  std::uintmax_t left_ = 0;  ///< bytes of a binary file
  std::string row_;          ///< of a text
  std::size_t row_at_ = std::string::npos;
  std::uintmax_t rows_ = 0;
};

}  // namespace

void check_ply_file(const std::string& where) {
  PlyFile(where).check();
}

}  // namespace palpate::reference
