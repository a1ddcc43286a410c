#include "reference/engine/motion_output.h"

#include <algorithm>
#include <cmath>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/dynamics/motion/frozen_part.h"
#include "core/mesh/io/displacement_vtu.h"
#include "reference/door/result_folder.h"

namespace palpate::reference {
namespace fs = std::filesystem;
namespace {

void append_cell(std::string& row, double value) {
  if (!row.empty() && row.back() != '\n') row += ',';
  if (std::isfinite(value)) append_number(row, value);
}

void append_cells(std::string& row, const Vec3& value) {
  append_cell(row, value.x);
  append_cell(row, value.y);
  append_cell(row, value.z);
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

MotionOutput::MotionOutput(fs::path folder, const MotionProblem& problem, const TetMesh& mesh)
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

void MotionOutput::add_row(const MotionPhase& phase, dynamics::MotionForces& forces,
                           const dynamics::MotionState& state) {
  const dynamics::MotionEnergy energy = measure_energy(phase.model, state);
  const dynamics::VolumeCount volume = count_volume(phase.model, state);
  double speed = 0.0;
  for (const Vec3& v : state.velocity_m_s) speed = std::max(speed, length(v));
  double largest_m = 0.0;
  double squares = 0.0;
  for (const Vec3& u : state.displacement_m) {
    largest_m = std::max(largest_m, length(u));
    squares += length_sq(u);
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(state.displacement_m.size()));
  max_displacement_m_ = std::max(max_displacement_m_, largest_m);
  max_kinetic_j_ = std::max(max_kinetic_j_, energy.kinetic_j);
  for (const double value : {state.time_s, energy.kinetic_j, energy.elastic_j, energy.load_j,
                             energy.total_j(), volume.volume_m3, static_cast<double>(volume.inverted), speed})
    append_cell(history_, value);
  if (!tools_.empty()) {
    const std::vector<Vec3> pushes = forces.group_forces(state);
    for (const std::size_t tool : tools_) {
      const auto at = std::find(phase.loads.begin(), phase.loads.end(), tool);
      append_cells(history_, at == phase.loads.end()
                                 ? Vec3{}
                                 : pushes[static_cast<std::size_t>(at - phase.loads.begin()) + 1]);
    }
  }
  if (!frozen_.empty()) {
    std::vector<Vec3> force(state.displacement_m.size());
    forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s, force);
    const double now_n = dynamics::frozen_force(frozen_, force);
    const bool is_known = !std::isnan(max_frozen_force_n_);  // a NaN stays
    if (is_known && !(now_n <= max_frozen_force_n_)) max_frozen_force_n_ = now_n;
  }
  for (const Index probe : probes_) append_cells(history_, state.displacement_m[probe]);
  append_cell(history_, largest_m);
  append_cell(history_, rms_m);
  history_ += '\n';
}

void MotionOutput::add_frame(const dynamics::MotionState& state) {
  if (!frame_times_.empty() && frame_times_.back() == state.time_s) return;
  if (folder_.empty()) {
    frames_.push_back({state.time_s, state.displacement_m});
    frame_times_.push_back(state.time_s);
    return;
  }
  write_displacement_vtu(folder_ / frame_name(frame_times_.size()), *mesh_, state.displacement_m);
  frame_times_.push_back(state.time_s);
}

void MotionOutput::finish() const {
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

}  // namespace palpate::reference
