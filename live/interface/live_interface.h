// A body under a finger for callers that know numbers and arrays alone: C, and JavaScript through
// WebAssembly.
//
// Every function that may fail returns 0, or 1 with a message in live_message(). Arrays are read at once and
// may be freed. SI units; vertices count from 0. There is one body and one answer at a time.
#pragma once

#include <stdint.h>

#ifdef __EMSCRIPTEN__
#include <emscripten/emscripten.h>
#define PALPATE_LIVE EMSCRIPTEN_KEEPALIVE
#else
#define PALPATE_LIVE
#endif

extern "C" {

/// What the last failure was, one line; good until the next call.
PALPATE_LIVE const char* live_message();

/// A new setup: mesh of `vertices` points (three numbers each) and `tets` (four vertices each), material, and
/// Rayleigh's shares of damping. Forgets the body before.
PALPATE_LIVE int live_setup(uint32_t vertices, const double* points_m, uint32_t tets,
                            const uint32_t* tet_vertices, double young_modulus_pa, double poisson_ratio,
                            double density_kg_m3, double damping_stiffness_s, double damping_mass_per_s);
/// Its springs: two vertices each.
PALPATE_LIVE int live_springs(uint32_t springs, const uint32_t* ends, const double* rest_length_m,
                              const double* stiffness_n_per_m);
/// An elastic support on faces with weights. As often as there are supports.
PALPATE_LIVE int live_support(uint32_t faces, const uint32_t* face_vertices, const double* weights,
                              double stiffness_pa_per_m);
/// Faces that are held: bit i of `axes` for axis i.
PALPATE_LIVE int live_held(uint32_t faces, const uint32_t* face_vertices, uint32_t axes);

/// The body, of springs with a volume model ("none", "thesis", "tet", "node_average", "node_smoothed").
PALPATE_LIVE int live_build_springs(const char* volume, double theta, const char* shear, int is_large_strain,
                                    const char* large_law, const char* integrator);
/// The body, of smoothed elements: domains "node", "edge", "face" or "tet".
PALPATE_LIVE int live_build_smoothed(double theta, const char* domain, const char* rest, double stabilise,
                                     int is_large_strain, const char* large_law, const char* integrator);
/// "springs", "tets" or "general": what steps it.
PALPATE_LIVE const char* live_engine();
/// Why it is the general one; empty if it is not.
PALPATE_LIVE const char* live_why_general();

/// The longest stable step at rest with such a pad anywhere on the skin, in s, into *step_s (infinity for
/// implicit integrators), and the vertex that sets it.
PALPATE_LIVE int live_predict_step(double pad_pa_per_m, double* step_s, uint32_t* vertex);

/// Pad, motion and steps: LiveBody. live_step writes whether the body is whole (1) or broken (0).
PALPATE_LIVE int live_press(uint32_t vertex, double radius_m, double stiffness_pa_per_m);
PALPATE_LIVE int live_slide(uint32_t vertex, double radius_m, double stiffness_pa_per_m);
PALPATE_LIVE int live_aim(double x_m, double y_m, double z_m, double speed_m_s);
PALPATE_LIVE int live_release();
/// How far the pad is moved now, three numbers.
PALPATE_LIVE int live_pad(double* by_m);
PALPATE_LIVE int live_step(double step_s, uint32_t steps, int* is_whole);
PALPATE_LIVE int live_reset();

/// How many numbers live_report writes.
#define PALPATE_LIVE_REPORT 14
/// time, kinetic, elastic and load energy, the pad's force x, y, z, largest displacement, inverted tets,
/// broken (1) or not (0), the vertex or -1, the pad's displacement x, y, z.
PALPATE_LIVE int live_report(double* numbers);
/// Displacements of all vertices, three numbers each, rounded to single precision.
PALPATE_LIVE int live_displacement(float* numbers);
/// Displacements and velocities in double precision, three numbers a vertex each.
PALPATE_LIVE int live_state(double* displacement_m, double* velocity_m_s);

/// The table of the setup's mesh as it is (the setup's material, supports and held faces): `skin` rising
/// vertices, 3 n x 3 n numbers for skin and for the skin's rows of field (docs/reduced.md).
PALPATE_LIVE int live_table(uint32_t skin, const uint32_t* skin_vertices, const float* skin_compliance,
                            const float* field, uint32_t element_order, uint32_t refine);
/// Presses with the body's pad; call after each live_press and live_slide. The pad's faces are looked for by
/// the places of their vertices: the body may be a simplified one with the same skin.
PALPATE_LIVE int live_answer_press(double stiffness_pa_per_m);
PALPATE_LIVE int live_answer_release();
/// Displacements of the skin's vertices, three numbers each, and the pad's force, three numbers, with the pad
/// moved there.
PALPATE_LIVE int live_answer(double x_m, double y_m, double z_m, float* displacement_m, double* force_n);
}
