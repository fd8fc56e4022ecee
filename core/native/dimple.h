/* Dimple's native core: one soft body behind one handle, stepped as core/solver/semi_implicit.py does.
 *
 * SI units. Arrays belong to the caller and are read or written during the call only; positions and velocities are
 * component-major, (3, n) doubles. Every function but the first three returns a code; nothing is done unless it is
 * DM_OK, and no input makes them crash: handles are looked up, sizes and indices checked, numbers must be finite.
 * Order: dm_create, every dm_set_* once (again at will), then dm_set_state, dm_step, dm_read as often as wanted.
 * The same calls give the same bits: sums run in eight lanes, in a fixed order. In double precision they are the same
 * on every machine (but for air, whose power comes from its library); in single precision they depend on its
 * instruction set, for some fuse multiplication and addition.
 */
#ifndef DIMPLE_H
#define DIMPLE_H
#include <stdint.h>

#if defined(_WIN32)
#define DM_API __declspec(dllexport)
#else
#define DM_API __attribute__((visibility("default")))
#endif

#define DM_ABI 2 /* changes with anything below */
#define DM_MAX_FINGERS 3
#define DM_MAX_STEPS 1000000 /* in one call */
#define DM_MAX_VERTICES (1 << 24)
#define DM_MAX_NEIGHBOURS 64 /* of a vertex, in its ring */

typedef uint64_t dm_body; /* never 0; not reused after dm_free */

enum {
    DM_OK,
    DM_HANDLE, /* no such body */
    DM_BUSY,   /* another thread is inside this body */
    DM_SIZE,   /* a count that does not fit the body, or a null array */
    DM_INDEX,  /* a vertex or spring that does not exist */
    DM_NUMBER, /* NaN, infinite, or negative where that makes no sense */
    DM_MEMORY, /* the machine has none left */
    DM_ORDER,  /* stepped before everything was set */
    DM_OPTION  /* an unknown law, fill or precision, or an instruction set this machine lacks */
};

enum { DM_FILL_NONE, DM_FILL_AIR, DM_FILL_LIQUID, DM_FILL_PAPER };
enum { DM_LAWS_CONSISTENT, DM_LAWS_PAPER };
enum { DM_SET_BEST, DM_SET_BASE, DM_SET_AVX2 }; /* base: SSE2 on x86-64, NEON on arm64 */

DM_API int32_t dm_abi(void);
DM_API const char *dm_instructions(int32_t set); /* its name, "" where this machine lacks it */
DM_API const char *dm_message(int32_t code);

/* Best rotation r (3x3, by rows) for h = sum of w x q^T: the r that maximises trace(r^T h). */
DM_API int32_t dm_fit_rotation(const double *h, double *r);

/* bits: 32 or 64, of the state.  rest: (3, n).  ring, ring_spring: (width, n) as in core/mesh/rings.py, -1 is no spring. */
DM_API int32_t dm_create(dm_body *body, int32_t bits, int32_t set, int64_t n, const double *rest, int64_t width,
                         const int64_t *ring, const int64_t *ring_spring);
DM_API int32_t dm_free(dm_body body);

/* pairs: (m, 2).  rest, stiffness, damping: (m,).  loose: (l,) springs that rings leave out, at ends (l, 2). */
DM_API int32_t dm_set_springs(dm_body body, int64_t m, const int64_t *pairs, const double *rest,
                              const double *stiffness, const double *damping, int64_t l, const int64_t *loose,
                              const uint8_t *ends);
/* Springs between any vertices, beside those of the rings. */
DM_API int32_t dm_set_bend(dm_body body, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                           const double *damping);
/* triangles: (t, 3). */
DM_API int32_t dm_set_faces(dm_body body, int64_t t, const int64_t *triangles);
/* corners: (c, 3) triangles whose first corner has no ring.  cap_edges: (e, 2), cap_loop: (e,) the hole of each. */
DM_API int32_t dm_set_fill(dm_body body, int32_t fill, double rest_volume, int64_t c, const int64_t *corners,
                           int64_t e, const int64_t *cap_edges, const int64_t *cap_loop);
/* (n,) each; inverse_mass is 0 where held. */
DM_API int32_t dm_set_matter(dm_body body, int64_t n, const double *mass, const double *inverse_mass,
                             const double *friction);
DM_API int32_t dm_set_memory(dm_body body, int64_t n, const double *k1, const double *k2, const double *d0,
                             const double *damping);
/* gravity: (3,).  ground: height of a plane, -INFINITY where there is none.  rest_area: of the surface, Eq. (3). */
DM_API int32_t dm_set_world(dm_body body, int32_t laws, double rest_area, const double *gravity, double ground);

/* pose: rotation by rows, then translation (12,), or null where the shape at rest follows the body.
 * pace: how fast the pose changes, as many numbers a second, or null where it rests. */
DM_API int32_t dm_set_state(dm_body body, int64_t n, const double *positions, const double *velocities,
                            const double *pose, const double *pace);
/* What Eq. (2) needs: the sum of K(x) and the vertices in contact. */
DM_API int32_t dm_set_contact(dm_body body, double inner_force, int64_t count, const int64_t *vertices);

/* Run ticks of `tick` seconds in equal substeps.  centres: (fingers, ticks + 1, 3) at the ends of the ticks;
 * radii: (fingers,);  impulses: (fingers, 3), what the fingertips received. */
DM_API int32_t dm_step(dm_body body, int64_t ticks, int64_t substeps, double tick, int64_t fingers,
                       const double *centres, const double *radii, double *impulses);
/* pressure: of the last step.  Null arrays are left out, and vertices held without a velocity: they have not moved. */
DM_API int32_t dm_read(dm_body body, int64_t n, double *positions, double *velocities, double *pressure);
/* vertices: (n,) room for, count: how many there were. */
DM_API int32_t dm_read_contact(dm_body body, int64_t n, int64_t *vertices, int64_t *count);
#endif
