#include "core/simplify/cover/patch_shift.h"

namespace palpate::simplify {

bool PatchShift::hold(SheetCover& sheet, std::span<const Tile> faces, std::span<const Tile> others,
                      std::vector<FaceShift>& shifts) {
  if (shifts.size() < faces.size()) shifts.resize(faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k) {
    if (!sheet.is_covered(faces[k], others, shifts[k].over)) return false;
    shifts[k].reach = sheet.reach();
  }
  return true;
}

bool PatchShift::measure(SheetCover& sheet, std::span<const Tile> gone, std::span<const Tile> fresh) {
  return hold(sheet, fresh, gone, fresh_) && hold(sheet, gone, fresh, gone_);
}

}  // namespace palpate::simplify
