// What a surface file claims, held against what is there: CGAL 5.5 makes room and reads as it is claimed.
#pragma once

#include <string>
#include <string_view>

namespace palpate::reference {

/// Walks through an OFF file, of text or binary, the way CGAL 5.5.1 reads it, in time and memory bounded by
/// its size. What passes holds every vertex and triangle that its header claims. Throws: InputError, which
/// names the line or the face, for anything else; for polygons of other than three
///         corners; and for what CGAL 5.5.1 takes wrongly (colours that are cut short, textures in text).
void check_off_file(const std::string& where);

/// The same for a PLY file, of text or binary. Properties that CGAL 5.5.1 takes for another type than they
/// have (a whole x, a red of floats beside a red of bytes) are refused too.
void check_ply_file(const std::string& where);

/// A piece of a file for a message: 60 printable characters at most, without blanks around.
std::string shown_piece(std::string_view text);

}  // namespace palpate::reference
