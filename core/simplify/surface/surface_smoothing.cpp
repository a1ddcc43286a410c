#include "core/simplify/surface/surface_smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {
namespace {

/// mend_boundary: a vertex whose worst tet has this score (q = 0.58) stays where it is; one that moves must
/// better it so much.
constexpr double kWellShaped = 0.2;
constexpr double kWorthMending = 1.1;
constexpr std::array kMendingSteps{1.0, 0.4};

/// smooth_boundary: steps towards the middle of the faces, the longest first, and along the gradient.
constexpr std::array kMiddleSteps{1.0, 0.5, 0.2};
constexpr int kGradientSteps = 2;

/// Shares of the whole move, where the guard refuses more.
constexpr std::array kShares{1.0, 0.5, 0.25};

/// Of the gradient's part along the normal, what is kept: first nothing, then half of it. Of the volume, what
/// may be missing or too much before nothing is; how much more the skin around may be bent than before; and
/// of the worst score, what has to be left.
constexpr std::array kNormalShares{0.0, 0.5};
constexpr double kVolumeLeeway = 0.001;
constexpr double kBendLeeway = 1.02;
constexpr double kFlat = 1e-12;  ///< of the longest edge: what rounding bends a flat skin by
constexpr double kLeastOfWorstOfSkin = 0.9;

/// The faces around a boundary vertex.
struct Fan {
  Vec3 normal;        ///< of the length of twice their area
  Vec3 middle;        ///< of their middles, weighted by area, brought back into the tangent plane
  double edge = 0.0;  ///< the longest
};

Fan measure_fan(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v) {
  const Vec3 p = mesh.points[v];
  Fan fan{{}, p, 0.0};
  Vec3 middle;
  double weight = 0.0;
  for (const Index f : boundary.faces_of(v)) {
    const Triangle& t = boundary.face(f);
    const Vec3 n = cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]);
    const double area = length(n);
    fan.normal = fan.normal + n;
    weight += area;
    middle = middle + (area / 3.0) * (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]);
    for (const Index w : t) fan.edge = std::max(fan.edge, length(mesh.points[w] - p));
  }
  const double size_sq = length_sq(fan.normal);
  if (!(weight > 0.0) || !(size_sq > 0.0)) return fan;
  const Vec3 step = (1.0 / weight) * middle - p;
  fan.middle = p + step - (dot(step, fan.normal) / size_sq) * fan.normal;
  return fan;
}

Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = cross(b - a, c - a);
  const double size = length(normal);
  return size > 0.0 ? (1.0 / size) * normal : Vec3{};
}

/// What the faces around a boundary vertex meet: how much the skin is bent there, for any place of it.
class Rim {
 public:
  void take(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v) {
    faces_.clear();
    for (const Index f : boundary.faces_of(v)) {
      const Triangle& t = boundary.face(f);
      const auto at = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
      const Index a = t[(at + 1) % 3];
      const Index b = t[(at + 2) % 3];
      Face face{a, b, mesh.points[a], mesh.points[b], {}};
      for (const Index g : boundary.faces_of(a)) {
        const Triangle& u = boundary.face(g);
        if (g != f && has_corner(u, b))
          face.outer_normal = unit_normal(mesh.points[u[0]], mesh.points[u[1]], mesh.points[u[2]]);
      }
      faces_.push_back(face);
    }
    for (Face& face : faces_) {
      const auto next = std::find_if(faces_.begin(), faces_.end(),
                                     [&](const Face& other) { return other.first == face.second; });
      face.next = static_cast<std::size_t>(next - faces_.begin()) % faces_.size();
    }
  }

  /// Sum over the edges of these faces of length (1 - cos of the angle between the normals), with v at p.
  double bend(const Vec3& p) {
    normals_.clear();
    for (const Face& face : faces_) normals_.push_back(unit_normal(p, face.a, face.b));
    double sum = 0.0;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      const Face& face = faces_[i];
      sum += length(face.b - face.a) * (1.0 - dot(normals_[i], face.outer_normal)) +
             length(face.b - p) * (1.0 - dot(normals_[i], normals_[face.next]));
    }
    return sum;
  }

 private:
  struct Face {
    Index first;  ///< (v, first, second)
    Index second;
    Vec3 a;  ///< where they are
    Vec3 b;
    Vec3 outer_normal;     ///< of the face beyond
    std::size_t next = 0;  ///< the face that begins with `second`
  };
  std::vector<Face> faces_;
  std::vector<Vec3> normals_;
};

/// How much the skin around a vertex may be bent after a move of it, `edge` being the longest of its faces.
double most_bend(Rim& rim, const Vec3& from, double edge) {
  return kBendLeeway * rim.bend(from) + kFlat * edge;
}

/// The faces around v with another place for it, which is still to be said.
void plan_move(const GuardedBoundary& boundary, Index v, BoundaryChange& change) {
  change.removed.assign(boundary.faces_of(v).begin(), boundary.faces_of(v).end());
  change.fresh.clear();
  for (const Index f : change.removed) change.fresh.push_back(boundary.face(f));
  change.moved = v;
}

bool is_loose(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v) {
  return mesh.is_vertex_alive(v) && mesh.is_on_boundary(v) &&
         hold_on(mesh, boundary, v) == FeatureRank::kNone;
}

class BoundarySmoother {
 public:
  BoundarySmoother(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores, double volume,
                   double worth)
      : mesh_(mesh),
        boundary_(boundary),
        scores_(scores),
        volume_(volume),
        worth_(worth),
        excess_(boundary.volume(mesh) - volume) {}

  /// Whether v has moved.
  bool smooth(Index v) {
    const Vec3 from = mesh_.points[v];
    star_.start(scores_.at(from), from);
    add_star(mesh_, v, kNoIndex, star_);
    star_.close();
    place_ = from;
    figures_ = star_.evaluate(from);
    const StarFigures before = figures_;
    const Fan fan = measure_fan(mesh_, boundary_, v);
    rim_.take(mesh_, boundary_, v);
    most_bend_ = most_bend(rim_, from, fan.edge);
    for (const double step : kMiddleSteps) {
      if (try_place(from + step * (fan.middle - from))) break;
    }
    for (const double share : kNormalShares) {
      if (share > 0.0 && !boundary_.lines().is_empty()) continue;  // beside sharp edges what is flat stays so
      climb_gains(
          star_, fan.edge, kGradientSteps, place_, figures_,
          [&](const Vec3& gradient) { return permitted(gradient, fan.normal, share); },
          [this](const Vec3& place) { return try_place(place); });
    }
    const double worth = before.sum + worth_ * static_cast<double>(star_.size());
    if (!(figures_.sum > worth)) return false;
    plan_move(boundary_, v, change_);
    const Vec3 whole = place_ - from;
    for (const double share : kShares) {
      change_.to = from + share * whole;
      const StarFigures there = star_.evaluate(change_.to);
      if (!(there.sum > worth) || there.worst < kLeastOfWorstOfSkin * before.worst ||
          !star_.is_positive(change_.to) || boundary_.check(mesh_, change_) != BoundaryVerdict::kAllowed)
        continue;
      boundary_.apply(change_);
      apply_move(mesh_, v, change_.to);
      excess_ += dot(fan.normal, share * whole) / 6.0;
      return true;
    }
    return false;
  }

 private:
  /// Along the normal a share of it, and nothing that leads away from the volume that is wanted.
  Vec3 permitted(const Vec3& gradient, const Vec3& normal, double share) const {
    const double size_sq = length_sq(normal);
    if (!(size_sq > 0.0)) return {};
    const double along = dot(gradient, normal);
    const bool leads_away = along * excess_ > 0.0 && std::fabs(excess_) > kVolumeLeeway * volume_;
    const double kept = leads_away ? 0.0 : share;
    return gradient - ((1.0 - kept) * along / size_sq) * normal;
  }

  bool try_place(const Vec3& place) {
    const double least = kLeastOfWorstOfSkin * figures_.worst;
    const StarFigures there = star_.evaluate(place, least);
    if (!(there.worst > 0.0) || there.worst < least || !(there.sum > figures_.sum)) return false;
    if (rim_.bend(place) > most_bend_) return false;
    place_ = place;
    figures_ = there;
    return true;
  }

  WorkingMesh& mesh_;
  GuardedBoundary& boundary_;
  const ScoreRule& scores_;
  double volume_;  ///< that is wanted
  double worth_;   ///< a proof: the gain of a tet, in the mean over the star
  double excess_;  ///< of the volume inside the boundary over it
  StarQuality star_;
  BoundaryChange change_;
  Rim rim_;
  double most_bend_ = 0.0;
  Vec3 place_;
  StarFigures figures_;
};

}  // namespace

void smooth_boundary(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores, double volume,
                     SurfaceReport& report, double worth) {
  BoundarySmoother smoother(mesh, boundary, scores, volume, worth);
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (is_loose(mesh, boundary, v) && smoother.smooth(v)) ++report.moves;
  }
}

void mend_boundary(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                   SurfaceReport& report) {
  StarQuality star;
  BoundaryChange change;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (!is_loose(mesh, boundary, v)) continue;
    const Vec3 from = mesh.points[v];
    star.start(scores.at(from), from);
    add_star(mesh, v, kNoIndex, star);
    star.close();
    const StarFigures now = star.evaluate(from);
    if (now.worst > kWellShaped) continue;
    const Vec3 target = measure_fan(mesh, boundary, v).middle;
    plan_move(boundary, v, change);
    for (const double step : kMendingSteps) {
      change.to = (1.0 - step) * from + step * target;
      const StarFigures then = star.evaluate(change.to);
      if (!(then.worst >= kWorthMending * now.worst) || !star.is_positive(change.to) ||
          boundary.check(mesh, change) != BoundaryVerdict::kAllowed)
        continue;
      boundary.apply(change);
      apply_move(mesh, v, change.to);
      ++report.moves;
      break;
    }
  }
}

bool StepSkinMoves::may_move(Index v) const {
  return is_loose(mesh_, boundary_, v);
}

Vec3 StepSkinMoves::normal_at(Index v) const {
  return measure_fan(mesh_, boundary_, v).normal;
}

bool StepSkinMoves::take_move(Index v, const Vec3& to) {
  Rim rim;
  rim.take(mesh_, boundary_, v);
  const double edge = measure_fan(mesh_, boundary_, v).edge;
  if (rim.bend(to) > most_bend(rim, mesh_.points[v], edge)) return false;
  plan_move(boundary_, v, change_);
  change_.to = to;
  if (boundary_.check(mesh_, change_) != BoundaryVerdict::kAllowed) return false;
  boundary_.apply(change_);
  ++report_.moves;
  return true;
}

}  // namespace palpate::simplify
