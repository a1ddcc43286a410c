// Skins of built bodies unlike each other: thin, hollow, lobed, ring-shaped. Deterministic to the byte.
#pragma once

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// A thin curved leaf with two notches in its border, as a spleen is, in millimetres: 112 x 70 x 28 with its
/// cup, some 16 thick. A geodesic sphere of `frequency`, scaled and sheared by maps that are one-to-one, so
/// genus 0 and free of self-intersections. Throws: as build_geodesic_sphere.
SurfaceMesh build_spleen_surface(int frequency);

/// A closed bent bag with a cavity, as a full stomach is, in millimetres: 180 along its axis, walls of 15 to
/// 29. Two skins, the inner one turned inward; each is a geodesic sphere of `frequency`, bent by one map that
/// is one-to-one. Throws: as build_geodesic_sphere.
SurfaceMesh build_stomach_surface(int frequency);

/// A body of six lobes of unlike sizes around a core, some 100 mm across; every ray from its middle meets the
/// skin once, so it is free of self-intersections. Throws: as build_geodesic_sphere.
SurfaceMesh build_lobes_surface(int frequency);

/// A ring of genus 1, in millimetres: 80 between the middles of its tube, which is 20 to 36 thick, on a
/// saddle. 6 `frequency` points along it and 3 `frequency` around it. Throws: InputError unless
/// 1 <= frequency <= 1000.
SurfaceMesh build_ring_surface(int frequency);

}  // namespace palpate
