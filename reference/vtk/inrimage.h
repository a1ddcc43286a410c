// Labelled images in the Inrimage format.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace palpate::reference {

/// A label a voxel, x fastest, and the voxel's sides.
struct LabelImage {
  std::array<int, 3> size{};
  std::array<double, 3> spacing{};  ///< in the image's unit, mm for a CT
  std::vector<std::uint8_t> labels;
};

/// Reads an unpacked .inr file of one unsigned byte a voxel.
/// Throws: InputError for any other kind, and for a file that is shorter than its header says.
LabelImage read_inrimage(const std::filesystem::path& path);

/// The largest 6-connected component of `label` as a mask of 0 and 1, with enclosed cavities filled.
/// Throws: InputError if no voxel has the label.
std::vector<std::uint8_t> largest_component(const LabelImage& image, std::uint8_t label);

}  // namespace palpate::reference
