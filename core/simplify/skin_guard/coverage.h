// Which faces of a skin that changes are enough for which triangle of the input's, and how far either is from
// the other at most.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::simplify {

/// A triangle of the input's skin and the current faces that cover it.
struct CoverProof {
  Index input = 0;
  double reach = 0.0;           ///< no point of it is farther from these
  std::vector<Index> covering;  ///< numbers of faces
};

/// What was proven of both skins, by number.
class Coverage {
 public:
  /// At first the faces are the input's triangles: each covers itself.
  explicit Coverage(std::size_t faces);

  /// Current faces whose union no point of the input's triangle is farther from than reach_of_input.
  std::span<const Index> covering(Index input) const { return covering_[input]; }
  double reach_of_input(Index input) const { return input_reach_[input]; }
  /// No point of the face is farther from the input's skin.
  double reach_of_face(Index f) const { return face_reach_[f]; }

  /// Calls visit(i) for each of the input's triangles that the face covers.
  template <typename Visit>
  void for_each_covered(Index f, const Visit& visit) const {
    for (const Index i : covered_by_[f]) {
      if (covers(f, i)) visit(i);
    }
  }

  /// The face covers nothing any more.
  void take_away(Index f) { covered_by_[f].clear(); }
  /// The face is there, `reach` from the input's skin, and covers nothing as yet.
  void enter(Index f, double reach);
  /// In the place of what was proven for that triangle before. is_fresh(f): the face has come since, with the
  /// number of one that was taken away.
  template <typename IsFresh>
  void take(CoverProof& proof, const IsFresh& is_fresh) {
    for (const Index f : proof.covering) {
      if (is_fresh(f) || !covers(f, proof.input)) covered_by_[f].push_back(proof.input);
    }
    covering_[proof.input].swap(proof.covering);
    input_reach_[proof.input] = proof.reach;
  }

 private:
  bool covers(Index f, Index input) const {
    return std::find(covering_[input].begin(), covering_[input].end(), f) != covering_[input].end();
  }

  std::vector<std::vector<Index>> covering_;
  std::vector<std::vector<Index>> covered_by_;  ///< of each face: may hold some of long ago
  std::vector<double> input_reach_;
  std::vector<double> face_reach_;
};

}  // namespace palpate::simplify
