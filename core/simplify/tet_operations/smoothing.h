// Moving free vertices to where the tets around them are better.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/geometry.h"
#include "core/simplify/tet_operations/quality_floor.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/star_quality.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Share of the worst score around that a move or a flip has to leave.
inline constexpr double kLeastOfWorst = 0.5;

/// Moves an apex up to `steps` steps along the gradient of its star's sum of gains, got by forward
/// differences; the first is 0.15 of `edge` long. `direct` makes of a gradient the direction to take, and
/// `try_place` takes a place that is better: it then changes `place` and `figures`, which are those of now.
template <typename Direct, typename TryPlace>
void climb_gains(StarQuality& star, double edge, int steps, const Vec3& place, const StarFigures& figures,
                 const Direct& direct, const TryPlace& try_place) {
  constexpr double kFirstStep = 0.15;
  constexpr double kDifference = 0.01 * kFirstStep;
  constexpr double kShorter = 0.4;  // factor of a step that was too long
  constexpr int kTriesPerStep = 3;
  double step = kFirstStep * edge;
  const double d = kDifference * edge;
  for (int i = 0; i < steps; ++i) {
    const Vec3 gradient = direct(Vec3{star.evaluate(place + Vec3{d, 0.0, 0.0}).sum - figures.sum,
                                      star.evaluate(place + Vec3{0.0, d, 0.0}).sum - figures.sum,
                                      star.evaluate(place + Vec3{0.0, 0.0, d}).sum - figures.sum});
    const double norm = length(gradient);
    if (!(norm > 0.0)) return;
    bool better = false;
    for (int k = 0; k < kTriesPerStep && !better; ++k) {
      better = try_place(place + (step / norm) * gradient);
      if (!better) step *= kShorter;
    }
    if (!better) return;
  }
}

/// Moves one vertex after another; the memory that it works in is kept between them.
class Smoother {
 public:
  /// Holds references to both.
  Smoother(WorkingMesh& mesh, const ScoreRule& rule) : mesh_(mesh), rule_(rule) {}

  /// No move leaves a score below this share of the worst before it (kLeastOfWorst).
  void set_least_of_worst(double share) { least_of_worst_ = share; }

  /// No move leaves a tet below the floor; null: there is none.
  void set_floor(const QualityFloor* floor) { floor_ = floor; }

  /// Moves free vertex v to where the sum of gains around it is larger: towards the volume-weighted centroid
  /// of its star (steps 1, 0.5, 0.2; the first that is better), then up to `steps` steps along the gradient,
  /// got by forward differences. No score around falls below its share of the worst before, and every tet
  /// stays positive, exactly; else v stays. Fills the scores of its star if it moves.
  /// Returns: by how much the sum of gains has grown; 0 if v stays.
  double smooth(Index v, int steps);

  /// One sweep over all free vertices in storage order. Returns how many moved.
  std::uint64_t sweep(int steps);

 private:
  bool try_place(const Vec3& place);
  void climb(int steps);

  WorkingMesh& mesh_;
  const ScoreRule& rule_;
  double least_of_worst_ = kLeastOfWorst;
  const QualityFloor* floor_ = nullptr;
  StarQuality star_;
  Index star_tet_ = kNoIndex;  ///< one of the star
  Vec3 place_;
  StarFigures figures_;
  std::vector<float> scores_;  ///< of the star at `place_`
};

}  // namespace palpate::simplify
