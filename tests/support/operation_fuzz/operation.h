// What may be done to a mesh in a sequence of operations, and what may be broken on purpose.
#pragma once

#include <cstddef>

namespace palpate::testing_support {

/// What one operation is.
enum class Operation {
  kRemoveEdge,
  kRemoveFace,
  kEdgesOfTet,
  kSplitEdge,
  kInsertVertex,  ///< amid tets that give way
  kUndo,          ///< of the flip, split or insertion just before
  kSmooth,        ///< by the smoother
  kMove,          ///< anywhere around, if all tets stay positive
  kCollapse,      ///< of one edge, if the link condition holds and all tets stay positive
  kCollapseShortest,
  kRepair,
  kSkin,    ///< palpate.surface takes some tets away, or what it is made of changes the skin in any order
  kFuse,    ///< of one tet
  kRebuild  ///< from the mesh of flips and collapses to that of fusions, or back
};
inline constexpr std::size_t kOperations = 14;

/// Its name, such as "collapse".
const char* operation_name(Operation operation);

/// Which operation is broken on purpose, to see that the judge notices.
enum class Sabotage {
  kNone,
  kMoveUnchecked,       ///< moves turn tets over
  kMoveOnBoundary,      ///< moves take boundary vertices too; the mesh stays valid
  kMoveKept,            ///< moves take vertices of kept tets too; the mesh stays valid
  kCollapseUnchecked,   ///< collapses turn tets over
  kCollapseOnBoundary,  ///< collapses take boundary vertices away
  kFuseOnBoundary,      ///< fusions take tets with a boundary vertex
  kInsertUnseen,        ///< a vertex is inserted that does not see all that is around it
  kLoseTet,             ///< removing an edge loses a tet
  kSkinStrays           ///< changes of the skin are held to ten times the bound that they are judged by
};

}  // namespace palpate::testing_support
