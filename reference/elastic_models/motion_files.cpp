#include "reference/elastic_models/motion_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/io/displacement_vtu.h"
#include "reference/door/request_options.h"
#include "reference/door/result_folder.h"

namespace palpate::reference {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kMostSeconds = 1e9;
constexpr std::int64_t kMostFrames = 1'000'000;

void append_cell(std::string& row, double value) {
  if (!row.empty() && row.back() != '\n') row += ',';
  if (std::isfinite(value)) append_number(row, value);
}

void append_cells(std::string& row, const Vec3& value) {
  append_cell(row, value.x);
  append_cell(row, value.y);
  append_cell(row, value.z);
}

/// A cell of a CSV of ours; an empty one is null. Not by std::stod, which refuses what is next to nothing.
json read_cell(const std::string& cell) {
  if (cell.empty()) return nullptr;
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  require(error == std::errc() && end == cell.data() + cell.size(), "a cell of a table is no number");
  return value;
}

/// The text of a CSV as columns and rows.
void add_table(const std::string& csv, json& out) {
  std::size_t at = 0;
  bool is_head = true;
  while (at < csv.size()) {
    const std::size_t end = csv.find('\n', at);
    json row = json::array();
    for (std::size_t k = at; k <= end;) {
      const std::size_t stop = std::min(csv.find(',', k), end);
      const std::string cell = csv.substr(k, stop - k);
      row.push_back(is_head ? json(cell) : read_cell(cell));
      k = stop + 1;
    }
    if (is_head) {
      out["columns"] = row;
    } else {
      out["rows"].push_back(row);
    }
    is_head = false;
    at = end + 1;
  }
}

/// To a micrometre's thousandth: for pictures.
json rounded(const std::vector<Vec3>& field) {
  json out = json::array();
  for (const Vec3& u : field) {
    for (const double x : {u.x, u.y, u.z}) out.push_back(std::round(1e9 * x) / 1e9);
  }
  return out;
}

}  // namespace

double estimate_output_bytes(const TetMesh& mesh, std::uint64_t frames, std::uint64_t rows,
                             std::size_t columns) {
  constexpr double kNumber = 24.0;  // "-1.2345678901234567e-123,"
  constexpr double kIndex = 11.0;
  const auto vertices = static_cast<double>(mesh.points.size());
  const auto tets = static_cast<double>(mesh.tets.size());
  const double frame = 1000.0 + vertices * 6.0 * kNumber + tets * (5.0 * kIndex + 3.0);
  return static_cast<double>(frames) * frame +
         static_cast<double>(rows) * static_cast<double>(columns) * kNumber;
}

void require_room(const fs::path& folder, double bytes, double most_bytes) {
  const auto gigabytes = [](double value) { return short_number(value / 1e9) + " GB"; };
  if (bytes > most_bytes)
    throw InputError("frames and history would take up to " + gigabytes(bytes) + ", more than " +
                     gigabytes(most_bytes) + ": ask for fewer frames, or allow more with --max-output-gb");
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (!error && bytes > static_cast<double>(space.available))
    throw InputError("frames and history would take up to " + gigabytes(bytes) + ", but " + folder.string() +
                     " has " + gigabytes(static_cast<double>(space.available)) + " left");
}

Strides::Strides(std::uint64_t samples, std::uint64_t frames, std::uint64_t steps)
    : row(std::max<std::uint64_t>(1, (steps + samples - 1) / samples)) {
  if (frames > 0) frame = std::max<std::uint64_t>(1, steps / frames);
  if (frame > 0) row = std::min(row, frame);
}

MotionFiles::MotionFiles(fs::path folder, const MotionProblem& problem, const TetMesh& mesh)
    : folder_(std::move(folder)), mesh_(&mesh), probes_(problem.probes) {
  std::vector<std::string> names{"time_s",  "kinetic_j", "elastic_j",     "load_j",
                                 "total_j", "volume_m3", "inverted_tets", "largest_speed_m_s"};
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    if (!problem.loads[k].is_tool()) continue;
    tools_.push_back(k);
    for (const char* axis : {"x", "y", "z"})
      names.push_back("tool_" + std::to_string(k + 1) + "_f" + axis + "_n");
  }
  for (std::size_t k = 0; k < probes_.size(); ++k) {
    for (const char* axis : {"x", "y", "z"})
      names.push_back("probe_" + std::to_string(k + 1) + "_u" + axis + "_m");
  }
  names.insert(names.end(), {"largest_displacement_m", "rms_displacement_m"});
  columns_ = names.size();
  for (const std::string& name : names) history_ += (history_.empty() ? "" : ",") + name;
  history_ += '\n';
}

void MotionFiles::add_row(const MotionRow& row) {
  require(row.tool_n.size() == tools_.size(), "a force a tool");
  double largest_m = 0.0;
  double squares = 0.0;
  for (const Vec3& u : row.displacement_m) {
    largest_m = std::max(largest_m, length(u));
    squares += length_sq(u);
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(row.displacement_m.size()));
  max_displacement_m_ = std::max(max_displacement_m_, largest_m);
  max_kinetic_j_ = std::max(max_kinetic_j_, row.kinetic_j);
  const double total_j = row.kinetic_j + row.elastic_j + row.load_j;
  for (const double value : {row.time_s, row.kinetic_j, row.elastic_j, row.load_j, total_j, row.volume_m3,
                             static_cast<double>(row.inverted_tets), row.largest_speed_m_s})
    append_cell(history_, value);
  for (const Vec3& force_n : row.tool_n) append_cells(history_, force_n);
  for (const Index probe : probes_) append_cells(history_, row.displacement_m[probe]);
  append_cell(history_, largest_m);
  append_cell(history_, rms_m);
  history_ += '\n';
}

void MotionFiles::add_frame(double time_s, std::span<const Vec3> displacement_m) {
  if (!frame_times_.empty() && frame_times_.back() == time_s) return;
  const std::vector<Vec3> field(displacement_m.begin(), displacement_m.end());
  if (folder_.empty()) {
    frames_.push_back({time_s, field});
  } else {
    write_displacement_vtu(folder_ / frame_name(frame_times_.size()), *mesh_, field);
  }
  frame_times_.push_back(time_s);
}

void MotionFiles::finish() const {
  if (folder_.empty()) return;
  write_file_atomically(folder_ / "history.csv", history_);
  if (frame_times_.empty()) return;
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<Collection>\n";
  for (std::size_t k = 0; k < frame_times_.size(); ++k) {
    text += "<DataSet timestep=\"";
    append_number(text, frame_times_[k]);
    text += "\" part=\"0\" file=\"" + frame_name(k) + "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  write_file_atomically(folder_ / "frames.pvd", text);
}

ReplayOptions take_replay_options(json& left) {
  ReplayOptions out;
  out.stop_after_s = take_number(left, "stop_after_s", 0.0, kMostSeconds, 0.0);
  out.most_output_bytes = 1e9 * take_number(left, "max_output_gb", 0.0, kMostSeconds, kMostOutputBytes / 1e9);
  out.setup_only = take_option<bool>(left, "setup_only", &json::is_boolean, "true or false", false);
  out.frames = static_cast<std::uint64_t>(take_whole(left, "frames", 0, kMostFrames, 0));
  return out;
}

void clear_folder(const fs::path& folder, const TetMesh& mesh, const MotionFiles& files, std::uint64_t rows,
                  std::uint64_t frames, double most_bytes) {
  require_room(folder, estimate_output_bytes(mesh, frames, rows, files.columns()), most_bytes);
  remove_earlier_results(folder);
}

json describe_replay(const MotionFiles& files, bool is_in_folder) {
  json written{{"schema", "palpate/engine/1"}, {"kind", "replay"}};
  for (const char* key : {"columns", "rows", "frames"}) written[key] = json::array();
  if (is_in_folder) return written;
  add_table(files.history_csv(), written);
  for (const MotionFrame& frame : files.frames())
    written["frames"].push_back(
        {{"time_s", frame.time_s}, {"displacement_m", rounded(frame.displacement_m)}});
  return written;
}

}  // namespace palpate::reference
