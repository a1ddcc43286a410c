#include "experiments/text/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "core/base/number_text.h"

namespace palpate::experiments {
namespace {

constexpr auto kLinePeriod = std::chrono::seconds(15);

std::size_t terminal_width() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

/// COLUMNS of the environment, or 0 if there is none or it is no number.
std::size_t columns_asked_for() {
  const char* text = std::getenv("COLUMNS");
  const long value = text == nullptr ? 0 : std::strtol(text, nullptr, 10);
  return value > 0 ? static_cast<std::size_t>(value) : 0;
}

}  // namespace

std::size_t display_width(const std::string& text) {
  std::size_t width = 0;
  bool escape = false;
  for (const char c : text) {
    if (c == '\033') escape = true;
    if (!escape && (static_cast<unsigned char>(c) & 0xc0U) != 0x80U) ++width;
    if (escape && c == 'm') escape = false;
  }
  return width;
}

std::size_t output_columns() {
  constexpr std::size_t kLeast = 40;
  std::size_t columns = columns_asked_for();
  winsize size{};
  if (columns == 0 && ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0) columns = size.ws_col;
  return columns == 0 ? 80 : std::max(kLeast, columns);
}

bool takes_color(int stream) {
  const char* refused = std::getenv("NO_COLOR");
  const char* kind = std::getenv("TERM");
  return (refused == nullptr || *refused == '\0') && ::isatty(stream) == 1 &&
         (kind == nullptr || std::strcmp(kind, "dumb") != 0);
}

std::string colored(const std::string& text, Color color) {
  if (!takes_color(STDOUT_FILENO)) return text;
  static constexpr std::array<const char*, 5> kCodes{"32", "31", "33", "1", "2"};
  return std::string("\033[") + kCodes.at(static_cast<std::size_t>(color)) + "m" + text + "\033[0m";
}

std::string time_text(double seconds) {
  const double size = std::abs(seconds);
  if (size >= 1.0 || size == 0.0) return three_digits(seconds) + " s";
  return size >= 1e-3 ? three_digits(1e3 * seconds) + " ms" : three_digits(1e6 * seconds) + " us";
}

std::string duration_text(double seconds) {
  std::array<char, 48> text{};
  if (seconds < 9.95) {
    std::snprintf(text.data(), text.size(), "%.1f s", seconds);
    return text.data();
  }
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole < 60) return std::to_string(whole) + " s";
  if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
}

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  clear();
}

void Progress::start(std::size_t total) {
  total_ = total;
  done_ = 0;
  last_line_ = std::chrono::steady_clock::now();
}

void Progress::show(const std::string& what) {
  what_ = what;
  if (terminal_) draw();
}

void Progress::show_long(const std::string& what) {
  show(what);
  if (!terminal_) say(what);
}

void Progress::step(double seconds_left) {
  reach(done_ + 1, seconds_left);
}

void Progress::reach(std::size_t done, double seconds_left) {
  done_ = done;
  seconds_left_ = seconds_left;
  if (terminal_) {
    draw();
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (quiet_ || now - last_line_ < kLinePeriod) return;
  last_line_ = now;
  std::cerr << "palpate: " << done_ << " of " << total_ << " done"
            << (seconds_left < 0.0 ? "" : ", about " + duration_text(seconds_left) + " left") << '\n';
}

void Progress::say(const std::string& line) {
  clear();
  if (!quiet_) std::cerr << "palpate: " << line << '\n';
}

void Progress::draw() {
  if (quiet_) return;
  constexpr std::size_t kBar = 24;
  const std::size_t filled = total_ > 0 ? std::min(kBar, kBar * done_ / total_) : 0;
  std::string line = "[" + std::string(filled, '#') + std::string(kBar - filled, '.') + "] " +
                     std::to_string(done_) + "/" + std::to_string(total_);
  if (seconds_left_ >= 0.0) line += ", " + duration_text(seconds_left_) + " left";
  line += "  " + what_;
  const std::size_t width = terminal_width() - 1;
  if (line.size() > width) line.resize(width);
  std::cerr << "\r\033[K" << line << std::flush;
  drawn_ = true;
}

void Progress::clear() {
  if (drawn_) std::cerr << "\r\033[K" << std::flush;
  drawn_ = false;
}

void print_json(const nlohmann::json& value) {
  std::cout << value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

void print_note(const std::string& line) {
  std::string shown = line;  // a text out of a file could tell the terminal what to do
  for (char& c : shown) {
    if ((c >= 0 && c < ' ' && c != '\n' && c != '\t') || c == '\x7f') c = '?';
  }
  std::cerr << "palpate: " << shown << '\n';
}

}  // namespace palpate::experiments
