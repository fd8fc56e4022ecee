/* Dimple's native core: soft bodies, each defined once, which then own their state and are stepped.
 * The readable twin of all of it is studies/reference/twin.py.
 *
 * SI units. Arrays belong to the caller and are read or written during the call only; vectors of many vertices are
 * component-major, (3, n) doubles. Functions that may fail return a code, and nothing is done unless it is DM_OK.
 * Sizes and indices are checked and numbers must be finite; a body must be one that dm_create made and dm_destroy has
 * not freed, used by one thread at a time.
 * The same calls give the same bits: sums run in eight lanes, in a fixed order. In double precision they are the same
 * on every machine (but for air, whose power comes from its library); in single precision they depend on its
 * instruction set, for some fuse multiplication and addition.
 */
#ifndef DIMPLE_H
#define DIMPLE_H
#include "constants.h"
#include <stdint.h>

#if defined(_WIN32)
#define DM_API __declspec(dllexport)
#else
#define DM_API __attribute__((visibility("default")))
#endif

typedef struct dm_body dm_body;
typedef struct dm_scene dm_scene;

enum {
    DM_OK,
    DM_SIZE,   /* a count out of range, or a null array */
    DM_INDEX,  /* a vertex, spring, hole or material that does not exist */
    DM_NUMBER, /* NaN, infinite, or negative where that makes no sense */
    DM_MEMORY, /* the machine has none left */
    DM_OPTION  /* an unknown fill or precision, or an instruction set this machine lacks */
};

/* of the law of a material: K1, K2 [N/m], x0 [m] and its power, 1 or more; Coulomb's coefficient; damping ratio; and where
 * an elastic solid was measured, the radius of the sphere, or minus that of the flat tip, that did [m], else 0 */
enum { DM_FRICTION = 4, DM_DAMPING, DM_LAYER, DM_LAW };

enum { DM_FILL_NONE, DM_FILL_AIR, DM_FILL_LIQUID };
enum { DM_SET_BEST, DM_SET_BASE, DM_SET_AVX2 }; /* base: SSE2 on x86-64, NEON on arm64 */

/* The numbers of a body that may change while it lives. */
typedef struct {
    const double *stiffness;    /* (springs,) [N/m] */
    const double *damping;      /* (springs,) of their dashpots [N s/m] */
    const double *tension;      /* (springs,) between the displacements of their ends, of shape matching [N/m] */
    const double *mass;         /* (vertices,) [kg] for rigid motion: that of loose vertices does not count */
    const double *inverse_mass; /* (vertices,) [1/kg], 0 where pinned */
    const double *friction;     /* (vertices,) coefficient */
    const double *compliance;   /* (vertices,) of the skin under a fingertip [m/N] */
    const double *k1;           /* (vertices,) shape matching up to the knee [N/m] */
    const double *k2;           /* (vertices,) beyond the knee [N/m] */
    const double *d0;           /* (vertices,) displacement at the knee [m] */
    const double *drag;         /* (vertices,) damping of shape matching [N s/m] */
    const double *laws;         /* (materials, DM_LAW) */
    int64_t materials;
    const double *painted;      /* (surface_vertices, 2) times K1 and K2, and x0, of the laws; null: 1 */
    double gravity[3];    /* [m/s2] */
    double ground;        /* height of a plane [m], -INFINITY where there is none */
    double rest_pressure; /* of the fill in the shape at rest, above that outside [Pa] */
    int32_t fill;
    int32_t free;   /* the shape at rest follows the body; 0: it stays with the pins */
    int32_t rigged; /* it stays where it is laid, wherever the pins are */
} dm_constants;

/* What a body is. Start from dm_default_body_def. */
typedef struct {
    int64_t vertices;
    const double *rest;            /* (3, vertices) [m] */
    const uint8_t *loose;          /* (vertices,) in no triangle; null: none is */
    int64_t width;                 /* of the rings, as core/mesh/rings.py orders them */
    const int64_t *ring;           /* (width, vertices) neighbours */
    const int64_t *ring_spring;    /* (width, vertices), -1 is no spring */
    int64_t springs;
    const int64_t *ends;           /* (springs, 2) */
    const double *rest_length;     /* (springs,) [m] */
    int64_t irregular;
    const int64_t *irregular_spring; /* (irregular,) springs that rings leave out */
    const uint8_t *irregular_end;    /* (irregular, 2) at which of their ends */
    int64_t triangles;
    const int64_t *corners;        /* (triangles, 3) */
    int64_t fans;
    const int64_t *fan;            /* (fans, 3) triangles whose first corner has no ring */
    int64_t cap_edges;
    const int64_t *cap_edge;       /* (cap_edges, 2) borders of holes */
    const int64_t *cap_hole;       /* (cap_edges,) the hole of each */
    double rest_volume;            /* [m3] */
    double rest_area;              /* [m2] of the whole surface, Eq. (3) */
    double size;                   /* longest side [m]: a body a hundred times as large has blown up */
    int64_t surface_vertices;      /* of the surface below which fingertips are measured: of this body or, where this */
    const double *surface_rest;    /* is a proxy, of its mesh: (3, surface_vertices) [m] */
    int64_t surface_triangles;
    const int64_t *surface_corners;  /* (surface_triangles, 3) */
    const int64_t *surface_material; /* (surface_triangles,) */
    dm_constants constants;
} dm_body_def;

/* Where one fingertip goes during a call: straight from `from` to `first` in the first tick, then evenly to `last`; from
 * there a force pushes it on to the depth at which the law answers that force. */
typedef struct {
    double from[3], first[3], last[3]; /* centres [m] */
    double radius;                     /* [m] */
    double force;                      /* [N] 0: none pushes it */
    double inward[3];                  /* unit, the way it does */
    const double *factors;             /* (materials, DM_FACTORS) of the force of this tip, at depths that go up with the square */
    double factors_end;                /* of their number, to this one [m]; null: it is the measuring tip */
    int64_t down;                      /* 0: this one is lifted and the rest does not count */
    int64_t fresh;                     /* it was not down before, or elsewhere */
} dm_fingertip;

typedef struct {
    int64_t ticks;
    int64_t substeps;        /* equal ones in each tick */
    double tick;             /* [s] */
    dm_fingertip fingertips[DM_MAX_FINGERTIPS];
    const double *pins_from; /* (3, pinned) where pinned vertices, in the caller's order, are led from, */
    const double *pins_to;   /* and to [m]; null: they rest */
    double pins_first;       /* share of that way at the end of the first tick, */
    double pins_last;        /* and of the last */
} dm_motion;

typedef struct {
    double impulse[3]; /* that the body gave it [N s] */
    double centre[3];  /* where it is [m] */
    double depth;      /* below the surface at rest, from where the skin was met [m], negative where it is clear */
    double outward[3]; /* unit, of the surface there */
    double force[3];   /* on it: of the law, outward, and of friction [N] */
    double slope;      /* of the law there [N/m] */
    double friction;   /* Coulomb's coefficient there */
    double law[4];     /* K1, K2, x0 and power there, with what is painted and the factor of the tip at this depth */
    int64_t triangle;  /* of the surface, the nearest; -1: not down */
} dm_touch;

typedef struct {
    dm_touch touches[DM_MAX_FINGERTIPS];
    double volume;    /* [m3] and */
    double pressure;  /* [Pa] when the forces were last evaluated */
    int64_t ticks;    /* done */
    int64_t finite;   /* 0: it has blown up in the last of them */
    int64_t moved;    /* 0: it was asleep all the time, at rest, and is where it was */
} dm_frame;

DM_API int32_t dm_abi(void);
DM_API const char *dm_instructions(int32_t set); /* its name, "" where this machine lacks it */
DM_API const char *dm_message(int32_t code);

DM_API void dm_default_body_def(dm_body_def *def);

/* bits: 32 or 64, of the state. The body is at rest. */
DM_API int32_t dm_create(dm_body **body, const dm_body_def *def, int32_t bits, int32_t set);
DM_API void dm_destroy(dm_body *body); /* null is taken */

/* Give a living body other numbers; where it is does not change. */
DM_API int32_t dm_set_constants(dm_body *body, const dm_constants *constants);
/* Give a living body another shape at rest (3, vertices) [m], and with it lengths and volume. Over the next motion it
 * comes there at a rate (3, vertices) [m/s]; null: at once. surface: (3, surface_vertices) below which fingertips are
 * measured [m]; null where it is the body's own. gain: (3, vertices) by which the body's speeds grow [m/s], or null. */
DM_API int32_t dm_set_rest(dm_body *body, const double *rest, const double *surface, const double *rate,
                           const double *gain);
/* Let a body move again where it sleeps: what it rested on may be gone. */
DM_API int32_t dm_wake_body(dm_body *body);
DM_API double dm_rest_volume(const dm_body *body); /* [m3] */
/* positions, velocities: (3, vertices); null velocities are 0. */
DM_API int32_t dm_set_state(dm_body *body, const double *positions, const double *velocities);
/* Either may be null. Pinned vertices at rest get their very bits back. */
DM_API int32_t dm_get_state(const dm_body *body, double *positions, double *velocities);

/* Run the ticks of a motion. */
DM_API int32_t dm_step(dm_body *body, const dm_motion *motion, dm_frame *frame);
/* Set the forces (count,) [N] of the law on a fingertip where it is down, if it were at depths (count,) [m] there.
 * factors, factors_end: as of its motion. */
DM_API int32_t dm_get_law(const dm_body *body, int64_t fingertip, const double *factors, double factors_end,
                          int64_t count, const double *depths, double *forces);
/* Run a motion of each of several bodies; the bits are those of dm_step. Where one is refused, none is run. */
DM_API int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions,
                            dm_frame *const *frames);
/* Let whatever is stepped from now on use so many threads, with that of the caller; 1 until then. The bits do not depend
 * on it. */
DM_API void dm_set_workers(int64_t workers);

/* A fine surface that follows a proxy: eight vertices after the other, with a list of what any of them follows. */
typedef struct {
    int64_t vertices;          /* of the surface */
    int64_t entries;           /* of all lists together */
    const int64_t *first;      /* (eights + 1,) where the list of each eight vertices begins */
    const uint16_t *followed;  /* (entries,) vertices of the proxy */
    const uint16_t *weights;   /* (entries, 8) of 65535 */
    const float *places;       /* (eights, 6, 8) [m]: x, y and z at rest, and from where a gradient acts */
    int64_t seeds;             /* vertices of the proxy */
    const double *coarse_rest; /* (seeds, 3) [m] */
    int64_t triangles;         /* of the proxy */
    const int64_t *corners;    /* (triangles, 3) */
    int64_t arms;              /* directed edges of the proxy, by their first end */
    const int64_t *ends;       /* (arms,) their other one */
    const int64_t *starts;     /* (seeds + 1,) where those of each begin */
    const double *spread;      /* (arms, 3) what turns the motion along an edge into a gradient [1/m] */
    const double *upright;     /* (seeds, 3) what turns the change of a normal into a gradient */
    double centre[3];          /* from which shifts are measured [m] */
} dm_binding;

/* Set the skin (vertices, 3) [m] of a proxy at positions (3, seeds) [m], and the motions (seeds, 12) that carry it. */
DM_API int32_t dm_carry(const dm_binding *binding, const double *positions, float *motions, float *skin);

/* Set what vertices (vertices, 3) have of values (nodes, 4), of which the fourth is not used, of the eight nodes
 * (vertices, 8) that carry each, by shares (vertices, 8). */
DM_API int32_t dm_carry_by_nodes(int64_t vertices, int64_t nodes, const uint16_t *by, const float *shares,
                                 const float *values, float *carried);

/* Seeds on a fine surface, whose vertices have places in the space of position and normal. */
typedef struct {
    int64_t vertices;
    const double *place; /* (vertices, 6) [m] */
    int64_t edges;
    const int64_t *ends; /* (edges, 2) */
    int64_t seeds;
    const int64_t *seed; /* (seeds,) vertices */
} dm_cells;

/* Choose (most,) of points at places (points, 6) beside the first `taken`, the farthest from all of those and from all
 * chosen before, as long as the square of that distance is more than `least` [m2]. Return how many. */
DM_API int64_t dm_farthest_first(int64_t points, const double *place, int64_t taken, double least, int64_t most,
                                 int64_t *chosen);
/* Set the seed (vertices,) that each vertex belongs to, the nearest of those that its neighbours belong to, -1 where
 * none spreads to; and whether its cell joins it to that seed (vertices,). */
DM_API int32_t dm_grow_cells(const dm_cells *surface, int64_t *cells, uint8_t *joined);
/* Set which seeds each vertex follows, DM_FOLLOWED of them, with which weights of 65535: the nearest of those round its
 * cell, around (seeds, width), the rest of a row -1. They are listed as in dm_binding, in order in each list; there is
 * room for 8 DM_FOLLOWED entries in each. */
DM_API int32_t dm_follow_cells(const dm_cells *surface, const int64_t *cells, int64_t width, const int64_t *around,
                               int64_t *first, uint16_t *followed, uint16_t *weights);

/* Flip blunt edges of triangles (triangles, 3) on points (vertices, 3) [m], in place, where the surface is nearly flat. */
DM_API int32_t dm_flip_edges(int64_t vertices, const double *points, int64_t triangles, int64_t *corners);

/* A mesh that bodies meet and that goes where it is led. */
typedef struct {
    int64_t vertices;
    const double *positions; /* (3, vertices) [m] */
    int64_t triangles;
    const int64_t *corners;  /* (triangles, 3) */
    double friction;         /* coefficient */
    double mass;             /* [kg] of a prop, a rigid body that falls; 0: it is led, and the rest does not count */
    double inverse_inertia[9]; /* about its centre, as it lies where it has not turned, by rows [1/(kg m2)] */
    double damping;          /* while it touches a soft body [N s/m] */
    double skin;             /* from what does not give it keeps so far [m] */
    const double *arms;      /* (3, vertices) from its centre where it has not turned [m]: of what touches, */
    const double *seen;      /* and of what stands on the ground */
} dm_collider_def;

typedef struct { /* where a prop is, how it moves, and what pulls it */
    double centre[3];   /* of its mass [m] */
    double turn[9];     /* rotation, by rows */
    double velocity[3]; /* of its centre [m/s] */
    double momentum[3]; /* angular, about it [kg m2/s] */
    double gravity[3];  /* [m/s2] */
    double ground;      /* height of a plane [m], -INFINITY where there is none */
} dm_prop;

typedef struct { /* the way of a collider: null where it rests */
    const double *from, *to; /* (3, vertices) [m] */
    dm_prop *prop;           /* of a prop: as the call begins, and then as it ends */
} dm_collider_motion;

typedef struct {
    int64_t ticks;      /* done */
    int64_t queries;    /* of who is near whom */
    int64_t pairs;      /* the most that were near each other */
    int64_t touching;   /* the most that touched */
    int64_t truncated;  /* times that a vertex was held back from passing through something */
    double taken;       /* momentum that this took [N s] */
    double gap;         /* the least distance at a query [m], infinite where nothing was near */
} dm_scene_frame;

typedef struct { /* what passes through each other */
    int64_t count;       /* pairs of triangles */
    int64_t surfaces[2]; /* of the first: bodies, then colliders */
    double place[3];     /* [m] */
} dm_crossings;

/* Bodies and colliders that nothing passes through, stepped together; the bodies stay the caller's, outlive the scene
 * and are all of one precision and instruction set. self: (bodies,) whether each meets itself too, but for the faces that
 * pass through others of it now: left_out (bodies,) says how many. offset: (bodies,) the distance that each holds [m], 0
 * for a share of its edges; a collider holds the least. */
DM_API int32_t dm_scene_create(dm_scene **scene, int64_t bodies, dm_body *const *body, const uint8_t *self,
                               const double *offset, int64_t colliders, const dm_collider_def *collider,
                               dm_crossings *left_out);
DM_API void dm_scene_destroy(dm_scene *scene); /* null is taken */
DM_API int32_t dm_scene_find_crossings(dm_scene *scene, dm_crossings *found);
/* Put a collider elsewhere at once. */
DM_API int32_t dm_scene_set_collider(dm_scene *scene, int64_t collider, const double *positions);
DM_API int32_t dm_scene_get_collider(const dm_scene *scene, int64_t collider, double *positions);
/* Run the ticks of motions (bodies,), equal in ticks, substeps and tick; colliders (colliders,) are at the share
 * `first` of their way at the end of the first tick and at `last` of the last. passed (bodies + colliders, DM_PASSED) is
 * set to the impulse that each got from others [N s] and its moment about the origin [N m s], how far it is behind its way
 * [m], 1 where skin that it pulled too far was let go, and the place (3,) of either; given (vertices of all bodies, 3) to
 * the impulse of each vertex [N s]. If memory runs out, the tick under way is the last. */
DM_API int32_t dm_scene_step(dm_scene *scene, const dm_motion *motions, const dm_collider_motion *colliders,
                             double first, double last, dm_frame *frames, dm_scene_frame *out, double *passed,
                             double *given);
#endif
