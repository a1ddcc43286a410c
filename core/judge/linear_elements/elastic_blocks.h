// The stiffness of linear elements as 3 x 3 blocks, and a solver for several loads at once: the judge's own.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// 3 x 3, by rows.
using Block = std::array<double, 9>;

/// A symmetric matrix of blocks in compressed rows; entries of one row rise by column.
///
/// Shape:  first has one entry a vertex and one more: row v holds entries first[v] .. first[v + 1] of column
/// and block.
struct BlockRows {
  std::vector<std::size_t> first;
  std::vector<Index> column;
  std::vector<Block> block;

  std::size_t size() const { return first.size() - 1; }
};

/// Several vector fields side by side: component a of field j at vertex v is values[(3 v + a) width + j].
struct FieldBlock {
  std::size_t width = 0;
  std::vector<double> values;

  FieldBlock() = default;
  FieldBlock(std::size_t vertices, std::size_t fields) : width(fields), values(3 * vertices * fields) {}
  double* row(std::size_t r) { return values.data() + r * width; }
  const double* row(std::size_t r) const { return values.data() + r * width; }
  std::size_t rows() const { return width == 0 ? 0 : values.size() / width; }
};

/// Volume of a tet and the gradients of its four linear shape functions. Requires: a positive volume.
struct TetGradients {
  double volume = 0.0;
  std::array<Vec3, 4> gradient;
};
/// Those of one tet of the mesh.
TetGradients tet_gradients(const TetMesh& mesh, const Tet& tet);

/// The stiffness of linear elements, integral of lambda div u div v + 2 mu e(u) : e(v), of the free body.
/// Requires: every vertex in a tet, positive volumes.
BlockRows build_stiffness(const TetMesh& mesh, double lambda, double mu);

/// y = A x.
void multiply(const BlockRows& matrix, const FieldBlock& x, FieldBlock& y);

/// y = B x for a matrix of diagonal blocks alone.
void apply_blocks(std::span<const Block> blocks, const FieldBlock& x, FieldBlock& y);

/// Dot products, field by field.
std::vector<double> dots(const FieldBlock& x, const FieldBlock& y);

/// The diagonal blocks.
std::vector<Block> diagonal_blocks(const BlockRows& matrix);

/// Inverses of symmetric positive blocks; empty if one is not positive to rounding.
std::vector<Block> invert_blocks(std::span<const Block> blocks);

/// Solves A x = f for all fields by conjugate gradients in step, each with its own lengths, preconditioned by
/// the inverses of the diagonal blocks, from `x` as it is given.
///
/// Requires: f orthogonal to the null space of A; x is any of the solutions.
/// Returns:  whether every field reached |r| <= tolerance |f| in the preconditioner's norm within `most`
/// steps.
bool solve_fields(const BlockRows& matrix, std::span<const Block> inverse_diagonal, const FieldBlock& f,
                  FieldBlock& x, double tolerance, std::size_t most);

}  // namespace palpate::judge
