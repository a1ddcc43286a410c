#include "core/simplify/skin_guard/face_grid.h"

#include <bit>

#include "core/simplify/skin_guard/skin_faces.h"

namespace palpate::simplify {

FaceGrid::FaceGrid(double cell, std::size_t faces)
    : cell_(cell), cells_(std::bit_ceil(2 * faces + 1)), visited_(faces, 0) {}

std::uint64_t FaceGrid::hash(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ (h >> 29U)) + static_cast<std::uint64_t>(y) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 31U)) + static_cast<std::uint64_t>(z) * 0x94d049bb133111ebULL;
  return h ^ (h >> 30U);
}

void FaceGrid::enter(Index f, const BoundingBox& box) {
  if (visited_.size() <= f) visited_.resize(f + 1, 0);
  for_each_cell(box, [&](std::size_t cell) { cells_[cell].push_back(f); });
}

void FaceGrid::leave(Index f, const BoundingBox& box) {
  for_each_cell(box, [&](std::size_t cell) { erase_one(cells_[cell], f); });
}

}  // namespace palpate::simplify
