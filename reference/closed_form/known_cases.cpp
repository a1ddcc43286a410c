#include "reference/closed_form/known_cases.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "reference/closed_form/solutions.h"
#include "reference/closed_form/structured_mesh.h"

namespace palpate::reference {
namespace {

constexpr std::array<bool, 3> kAll{true, true, true};
constexpr std::array<bool, 3> kX{true, false, false};
constexpr std::array<bool, 3> kY{false, true, false};
constexpr std::array<bool, 3> kZ{false, false, true};

/// Is `value` zero but for rounding, in a body of about one `size`?
bool is_zero(double value, double size) {
  return std::fabs(value) <= 1e-9 * size;
}

FacePatch whole(std::vector<Triangle> faces) {
  std::vector<double> weight(faces.size(), 1.0);
  return {std::move(faces), std::move(weight)};
}

std::vector<Vec3> at_nodes(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field) {
  std::vector<Vec3> values;
  for (const Vec3& point : mesh.points) values.push_back(field(point));
  for (const auto& [a, b] : build_edges(mesh)) {
    values.push_back(field(0.5 * (mesh.points[a] + mesh.points[b])));
  }
  return values;
}

/// A cube of edge `side_m` of 2, 4, 8 ... cells: two jittered cells a side, refined, so that all sizes are
/// nested.
TetMesh jittered_cube(int cells, double side_m) {
  if (cells < 2 || cells > 64 || (cells & (cells - 1)) != 0) {
    throw InputError("cells", 0, "2, 4, 8, 16, 32 or 64", std::to_string(cells));
  }
  TetMesh mesh = build_kuhn_cube(2, 0.25, 5);
  for (Vec3& point : mesh.points) point = side_m * point;
  for (int size = 2; size < cells; size *= 2) mesh = refine_uniformly(mesh);
  return mesh;
}

/// A bar along x from the origin, of cubic cells.
TetMesh bar_mesh(int cells, double length_m, double side_m) {
  const int along = static_cast<int>(std::lround(cells * length_m / side_m));
  return build_mapped_block({along, cells, cells}, [&](const Vec3& s) {
    return Vec3{length_m * s.x, side_m * s.y, side_m * s.z};
  });
}

/// Faces on the plane where a coordinate is `value`.
std::vector<Triangle> faces_on(const TetMesh& mesh, double Vec3::*axis, double value) {
  return select_boundary(mesh, [&](const Vec3& p) { return is_zero(p.*axis - value, 1.0); });
}

/// Symmetry about the three coordinate planes: no displacement across them.
void hold_symmetry_planes(KnownCase& known) {
  known.problem.held = {{faces_on(known.mesh, &Vec3::x, 0.0), kX, {}},
                        {faces_on(known.mesh, &Vec3::y, 0.0), kY, {}},
                        {faces_on(known.mesh, &Vec3::z, 0.0), kZ, {}}};
}

/// Prescribes `field` on the whole boundary and makes it the answer.
void hold_boundary(KnownCase& known, std::function<Vec3(const Vec3&)> field) {
  known.problem.held = {{build_boundary(known.mesh), kAll, {}}};
  known.problem.held_field_m = at_nodes(known.mesh, field);
  known.displacement = std::move(field);
}

KnownCase patch_test(int cells) {
  KnownCase known;
  known.mesh = build_kuhn_cube(cells, 0.25, 5);
  known.problem.material = {10000.0, 0.3, 1000.0};
  const LinearField field{{Vec3{0.010, -0.004, 0.007}, {0.003, -0.008, 0.002}, {-0.005, 0.006, 0.009}},
                          {0.02, -0.01, 0.03}};
  hold_boundary(known, [field](const Vec3& x) { return field.displacement(x); });
  return known;
}

constexpr double kBarLength = 0.04;
constexpr double kBarSide = 0.01;

KnownCase bar_tension(int cells) {
  KnownCase known;
  known.mesh = bar_mesh(cells, kBarLength, kBarSide);
  known.problem.material = {10000.0, 0.3, 1000.0};
  hold_symmetry_planes(known);
  constexpr double kStress = 250.0;
  known.problem.tractions = {{whole(faces_on(known.mesh, &Vec3::x, kBarLength)), {kStress, 0, 0}, 0.0}};
  known.displacement = [material = known.problem.material](const Vec3& x) {
    return stretched_bar(material, kStress, x);
  };
  return known;
}

KnownCase bar_pads(int cells) {
  KnownCase known;
  known.mesh = bar_mesh(cells, kBarLength, kBarSide);
  known.problem.material = {10000.0, 0.0, 1000.0};
  const BarBetweenPads bar{kBarLength, 1.0e6, 2.0e6, 0.002};
  known.problem.supports = {
      {whole(faces_on(known.mesh, &Vec3::x, 0.0)), bar.near_pa_per_m, {}},
      {whole(faces_on(known.mesh, &Vec3::x, kBarLength)), bar.far_pa_per_m, {bar.moved_m, 0, 0}}};
  known.displacement = [bar, material = known.problem.material](const Vec3& x) {
    return bar.displacement(material, x);
  };
  return known;
}

KnownCase bar_own_weight(int cells) {
  KnownCase known;
  known.mesh = bar_mesh(cells, kBarLength, kBarSide);
  known.problem.material = {10000.0, 0.0, 1050.0};
  constexpr double kGravity = 9.81;
  known.problem.gravity_m_s2 = {kGravity, 0, 0};
  known.problem.held = {{faces_on(known.mesh, &Vec3::x, 0.0), kAll, {}}};
  known.displacement = [material = known.problem.material](const Vec3& x) {
    return hanging_bar(material, kBarLength, kGravity, x);
  };
  return known;
}

KnownCase bar_large_tension(int cells) {
  KnownCase known;
  known.mesh = bar_mesh(cells, kBarLength, kBarSide);
  known.problem.material = {10000.0, 0.3, 1000.0};
  known.problem.strain = StrainSize::kLarge;
  hold_symmetry_planes(known);
  constexpr double kStretch = 1.3;
  const UniaxialStretch answer = stretch_neo_hookean(known.problem.material, kStretch);
  known.problem.tractions = {
      {whole(faces_on(known.mesh, &Vec3::x, kBarLength)), {answer.traction_pa, 0, 0}, 0.0}};
  known.displacement = [across = answer.across](const Vec3& x) {
    return Vec3{(kStretch - 1.0) * x.x, (across - 1.0) * x.y, (across - 1.0) * x.z};
  };
  return known;
}

KnownCase manufactured(int cells) {
  KnownCase known;
  known.mesh = jittered_cube(cells, 1.0);
  known.problem.material = {10000.0, 0.3, 1000.0};
  const std::vector<PlaneWave> waves{{{0.010, 0.004, -0.006}, {2.0, 1.0, -1.5}, 0.3},
                                     {{-0.003, 0.008, 0.005}, {-1.0, 2.5, 1.0}, 1.1},
                                     {{0.004, -0.005, 0.009}, {1.5, -0.5, 2.5}, -0.4}};
  hold_boundary(known, [waves](const Vec3& x) { return wave_displacement(waves, x); });
  known.problem.body_force_n_m3 =
      at_nodes(known.mesh, [&](const Vec3& x) { return wave_body_force(waves, known.problem.material, x); });
  return known;
}

KnownCase thick_sphere(int cells) {
  KnownCase known;
  const PressedShell shell{0.05, 0.1, 1000.0};
  known.mesh = build_shell_octant(cells, cells, shell.inner_m, shell.outer_m);
  known.problem.material = {10000.0, 0.3, 1000.0};
  hold_symmetry_planes(known);
  const auto inside = [&](const Vec3& p) { return is_zero(length(p) - shell.inner_m, shell.outer_m); };
  known.problem.tractions = {{whole(select_boundary(known.mesh, inside)), {}, shell.pressure_pa}};
  known.displacement = [shell, material = known.problem.material](const Vec3& x) {
    return shell.displacement(material, x);
  };
  return known;
}

/// The vertex nearest to a point that is one.
Index vertex_at(const TetMesh& mesh, const Vec3& point) {
  Index nearest = 0;
  for (Index v = 1; v < mesh.points.size(); ++v) {
    if (length_sq(mesh.points[v] - point) < length_sq(mesh.points[nearest] - point)) nearest = v;
  }
  require(is_zero(length(mesh.points[nearest] - point), 1.0),
          "known case: no vertex at the point of its value");
  return nearest;
}

KnownCase cantilever(int cells) {
  if (cells % 2 != 0) throw InputError("cells", 0, "an even number", std::to_string(cells));
  constexpr double kLength = 0.1;
  constexpr double kTraction = -1.0;
  KnownCase known;
  known.mesh = bar_mesh(cells, kLength, kBarSide);
  known.problem.material = {10000.0, 0.25, 1000.0};
  known.problem.held = {{faces_on(known.mesh, &Vec3::x, 0.0), kAll, {}}};
  known.problem.tractions = {{whole(faces_on(known.mesh, &Vec3::x, kLength)), {0, 0, kTraction}, 0.0}};
  const Index tip = vertex_at(known.mesh, {kLength, 0.5 * kBarSide, 0.5 * kBarSide});
  const double force = kTraction * kBarSide * kBarSide;
  known.value = {KnownValue::Kind::kDisplacement, tip, 2, 0,
                 timoshenko_deflection(known.problem.material, kLength, kBarSide, force)};
  return known;
}

/// The elliptic membrane LE1 as a slab of half its thickness with free sides: plane stress but for the slab's
/// own thickness. A quarter of the ring between (x / 2)^2 + y^2 = 1 and (x / 3.25)^2 + (y / 2.75)^2 = 1, in
/// metres.
KnownCase elliptic_membrane(int cells) {
  constexpr double kHalfThickness = 0.05;
  KnownCase known;
  known.mesh = build_mapped_block({cells, 2 * cells, std::max(1, cells / 8)}, [](const Vec3& s) {
    const double angle = s.y * std::numbers::pi / 2.0;
    const double cosine = s.y < 1.0 ? std::cos(angle) : 0.0;
    const double across = s.x * (0.5 + 0.5 * s.x);  // finer toward the inner ellipse
    return Vec3{(2.0 + 1.25 * across) * cosine, (1.0 + 1.75 * across) * std::sin(angle),
                kHalfThickness * s.z};
  });
  known.problem.material = {210.0e9, 0.3, 1000.0};
  hold_symmetry_planes(known);
  const auto outside = [](const Vec3& p) {
    return is_zero(p.x * p.x / (3.25 * 3.25) + p.y * p.y / (2.75 * 2.75) - 1.0, 1.0);
  };
  known.problem.tractions = {{whole(select_boundary(known.mesh, outside)), {}, -10.0e6}};
  known.value = {KnownValue::Kind::kStress, vertex_at(known.mesh, {2.0, 0.0, 0.0}), 1, 1, 92.7e6};
  return known;
}

struct Entry {
  KnownCaseInfo info;
  KnownCase (*build)(int);
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all_entries{
      {{"patch_test", "a linear displacement held on the whole boundary of a cube with jittered vertices",
        "cells a side", "constant strain: exact for linear elements"},
       patch_test},
      {{"bar_tension", "a bar pulled at one end, on symmetry planes", "cells across a side",
        "constant stress: exact for linear elements"},
       bar_tension},
      {{"bar_pads", "a bar between an elastic support and an elastic pad that moves, nu = 0",
        "cells across a side", "constant stress: exact for linear elements"},
       bar_pads},
      {{"bar_own_weight", "a hanging bar under its own weight, nu = 0", "cells across a side",
        "quadratic displacement: exact for quadratic elements"},
       bar_own_weight},
      {{"bar_large_tension", "a neo-Hookean bar stretched by 30%, on symmetry planes", "cells across a side",
        "constant strain: exact for linear elements"},
       bar_large_tension},
      {{"manufactured", "three plane waves, held on the boundary of a jittered cube, with their body force",
        "cells a side, a power of two; nested", "manufactured solution"},
       manufactured},
      {{"thick_sphere", "an eighth of a spherical shell, outer radius twice the inner, pressed from inside",
        "cells along an arc and through the wall",
        "Lame; Timoshenko and Goodier, Theory of Elasticity, article 136"},
       thick_sphere},
      {{"cantilever", "a clamped beam ten times as long as thick, sheared at its end: deflection of the tip",
        "cells across a side, even", "Timoshenko's beam with Cowper's shear coefficient"},
       cantilever},
      {{"elliptic_membrane", "NAFEMS LE1: the stress sigma_yy at D, 92.7 MPa", "cells across the ring",
        "The Standard NAFEMS Benchmarks, Rev. 3, 1990, test LE1"},
       elliptic_membrane}};
  return all_entries;
}

}  // namespace

const std::vector<KnownCaseInfo>& list_known_cases() {
  static const std::vector<KnownCaseInfo> all_infos = [] {
    std::vector<KnownCaseInfo> infos;
    for (const Entry& entry : entries()) infos.push_back(entry.info);
    return infos;
  }();
  return all_infos;
}

KnownCase build_known_case(const std::string& name, int cells) {
  std::string names;
  for (const Entry& entry : entries()) {
    if (entry.info.name == name) return entry.build(cells);
    names += (names.empty() ? "" : ", ") + entry.info.name;
  }
  throw InputError("case", 0, "one of " + names, name);
}

}  // namespace palpate::reference
