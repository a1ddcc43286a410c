// What a surface file claims, held against what is there: CGAL 5.5 makes room and reads as it is claimed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpate::reference {

/// The letters of an OFF file of text that say that there are textures and colours ("ST", "C"): without them
/// CGAL 5.5.1 takes a row's first numbers alone, with them also what may not be there.
struct OffExtras {
  std::size_t at = 0;      ///< bytes before them
  std::size_t length = 0;  ///< 0 where there are none, and in binary files
};

/// Walks through an OFF file, of text or binary, the way CGAL 5.5.1 reads it, in time and memory bounded by
/// its size. What passes holds every vertex and triangle that its header claims. Throws: InputError, which
/// names the line or the face, for anything else; for polygons of other than three
///         corners; and for binary files with colours, which CGAL 5.5.1 takes for other numbers.
OffExtras check_off_file(const std::string& where);

/// The same for a PLY file, of text or binary. Properties that CGAL 5.5.1 takes for another type than they
/// have (a whole x, a green of floats beside a red of bytes) are refused too.
void check_ply_file(const std::string& where);

/// A piece of a file for a message: 60 printable characters at most, without blanks around.
std::string shown_piece(std::string_view text);

}  // namespace palpate::reference
