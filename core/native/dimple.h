/* Dimple's native core: soft bodies. Each is defined once, owns its state from then on, and is stepped.
 * studies/reference/twin.py is a readable reference implementation of all of it.
 *
 * SI units. Arrays belong to the caller and are read or written during the call only; vectors of many vertices are
 * component-major, (3, n) doubles. Functions that may fail return a code, and do nothing unless it is DM_OK.
 * Sizes and indices are checked, and numbers must be finite; a body must come from dm_create, must not have been
 * freed by dm_destroy, and may be used by only one thread at a time.
 * The same calls give the same bits: sums run in eight lanes, in a fixed order. In double precision the bits are the
 * same on every machine (except for air, whose power function comes from the machine's library); in single precision
 * they depend on the instruction set, because some sets fuse multiplication and addition.
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
    DM_NUMBER, /* a number that is NaN, infinite, or negative though it must not be */
    DM_MEMORY, /* the machine has no memory left */
    DM_OPTION  /* an unknown fill or precision, or an instruction set this machine lacks */
};

/* The numbers of a material's law: K1, K2 [N/m], x0 [m] and the power, at least 1; Coulomb's coefficient; the damping
 * ratio; and for a measured elastic solid the radius of the spherical measuring tip, or minus that of a flat one [m],
 * otherwise 0. The names are indices of the last ones, and their count. */
enum { DM_FRICTION = 4, DM_DAMPING, DM_LAYER, DM_LAW };

enum { DM_FILL_NONE, DM_FILL_AIR, DM_FILL_LIQUID };
enum { DM_SET_BEST, DM_SET_BASE, DM_SET_AVX2 }; /* base: SSE2 on x86-64, NEON on arm64 */

/* The numbers of a body that may change during its life. */
typedef struct {
    const double *stiffness;    /* (springs,) [N/m] */
    const double *damping;      /* (springs,) of the dashpots [N s/m] */
    const double *tension;      /* (springs,) of shape matching: between displacements of the ends [N/m] */
    const double *mass;         /* (vertices,) [kg] for rigid motion: the mass of loose vertices does not count */
    const double *inverse_mass; /* (vertices,) [1/kg], 0 where pinned */
    const double *friction;     /* (vertices,) coefficient */
    const double *compliance;   /* (vertices,) of the skin under a fingertip [m/N] */
    const double *k1;           /* (vertices,) stiffness of shape matching up to the knee [N/m] */
    const double *k2;           /* (vertices,) its stiffness beyond the knee [N/m] */
    const double *d0;           /* (vertices,) displacement at the knee [m] */
    const double *drag;         /* (vertices,) damping of shape matching [N s/m] */
    const double *laws;         /* (materials, DM_LAW) */
    int64_t materials;
    const double *painted;      /* (surface_vertices, 2) factors of the laws: of K1 and K2, and of x0; null: 1 */
    double gravity[3];    /* [m/s2] */
    double ground;        /* height of the ground plane [m], -INFINITY: none */
    double rest_pressure; /* gauge pressure of the fill in the shape at rest [Pa] */
    double fill_momentum[9]; /* angular momentum of the fill over that of the skin, in the shape at rest, by rows */
    int32_t fill;
    int32_t free;   /* 1: the shape at rest follows the body; 0: it stays with the pins */
    int32_t rigged; /* 1: the shape at rest stays where it is set, whatever the pins do */
} dm_constants;

/* The definition of a body. Start from dm_default_body_def. */
typedef struct {
    int64_t vertices;
    const double *rest;            /* (3, vertices) [m] */
    const uint8_t *loose;          /* (vertices,) 1: the vertex is in no triangle; null: no vertex is loose */
    int64_t width;                 /* of the rings, in the order of core/mesh/rings.py */
    const int64_t *ring;           /* (width, vertices) neighbours */
    const int64_t *ring_spring;    /* (width, vertices), -1: no spring */
    int64_t springs;
    const int64_t *ends;           /* (springs, 2) */
    const double *rest_length;     /* (springs,) [m] */
    int64_t irregular;
    const int64_t *irregular_spring; /* (irregular,) springs that the rings leave out, */
    const uint8_t *irregular_end;    /* (irregular, 2) and at which of their ends */
    int64_t triangles;
    const int64_t *corners;        /* (triangles, 3) */
    int64_t fans;
    const int64_t *fan;            /* (fans, 3) triangles whose first corner has no ring */
    int64_t cap_edges;
    const int64_t *cap_edge;       /* (cap_edges, 2) on the borders of holes */
    const int64_t *cap_hole;       /* (cap_edges,) the hole of each edge */
    double rest_volume;            /* [m3] */
    double rest_area;              /* [m2] of the whole surface, Eq. (3) */
    double size;                   /* longest side [m]: a body that grows to 100 times that has diverged */
    int64_t surface_vertices;      /* of the surface below which fingertips are measured: of this body */
    const double *surface_rest;    /* or, for a proxy, of its mesh: (3, surface_vertices) [m] */
    int64_t surface_triangles;
    const int64_t *surface_corners;  /* (surface_triangles, 3) */
    const int64_t *surface_material; /* (surface_triangles,) */
    dm_constants constants;
} dm_body_def;

/* The motion of one fingertip during a call: straight from `from` to `first` in the first tick, then evenly to
 * `last`; on top of that a given force pushes it to the depth at which the law gives that force. */
typedef struct {
    double from[3], first[3], last[3]; /* centres [m] */
    double radius;                     /* [m] */
    double force;                      /* [N] that pushes it; 0: none */
    double inward[3];                  /* unit vector, the direction of that force */
    const double *factors;             /* (materials, DM_FACTORS) of this tip's force; null: it is the measuring tip. */
    double factors_end;                /* Their depths grow with the square of the index, up to this one [m] */
    int64_t down;                      /* 0: this fingertip is lifted, and the rest does not count */
    int64_t fresh;                     /* 1: it was not down before, or was somewhere else */
} dm_fingertip;

typedef struct {
    int64_t ticks;
    int64_t substeps;        /* of equal length, in each tick */
    double tick;             /* [s] */
    dm_fingertip fingertips[DM_MAX_FINGERTIPS];
    const double *pins_from; /* (3, pinned) start of the path of the pinned vertices, in the caller's order, */
    const double *pins_to;   /* and its end [m]; null: the pins rest */
    double pins_first;       /* share of that path covered at the end of the first tick, */
    double pins_last;        /* and at the end of the last */
} dm_motion;

typedef struct {
    double impulse[3]; /* that the body gave the fingertip [N s] */
    double centre[3];  /* of the fingertip [m] */
    double depth;      /* below the surface at rest, from where it met the skin [m]; negative: it is clear */
    double outward[3]; /* unit normal of the surface there */
    double force[3];   /* on the fingertip: of the law, outward, plus friction [N] */
    double slope;      /* of the law there [N/m] */
    double friction;   /* Coulomb's coefficient there */
    double law[4];     /* K1, K2, x0 and power there, with the factors of the paint and of the tip at this depth */
    int64_t triangle;  /* nearest triangle of the surface; -1: not down */
} dm_touch;

typedef struct {
    dm_touch touches[DM_MAX_FINGERTIPS];
    double volume;    /* [m3], and */
    double pressure;  /* [Pa], when the forces were last evaluated */
    int64_t ticks;    /* number of ticks done */
    int64_t finite;   /* 0: the simulation diverged in the last of them */
    int64_t moved;    /* 0: the body slept all the time and has not moved */
} dm_frame;

DM_API int32_t dm_abi(void);
DM_API const char *dm_instructions(int32_t set); /* name of the set, "" if this machine lacks it */
DM_API const char *dm_message(int32_t code);

DM_API void dm_default_body_def(dm_body_def *def);

/* Create a body at rest. bits: precision of the state, 32 or 64. */
DM_API int32_t dm_create(dm_body **body, const dm_body_def *def, int32_t bits, int32_t set);
DM_API void dm_destroy(dm_body *body); /* null: nothing is done */

/* Give an existing body other numbers; its position does not change. */
DM_API int32_t dm_set_constants(dm_body *body, const dm_constants *constants);
/* Give an existing body another shape at rest (3, vertices) [m], with the lengths and the volume that follow from it.
 * It is reached over the next motion, at a rate (3, vertices) [m/s]; null: at once. surface: (3, surface_vertices)
 * below which fingertips are measured [m]; null if it is the body's own. gain: (3, vertices) added to the velocities
 * [m/s], or null. */
DM_API int32_t dm_set_rest(dm_body *body, const double *rest, const double *surface, const double *rate,
                           const double *gain);
/* Wake a body if it sleeps: what it rested on may be gone. */
DM_API int32_t dm_wake_body(dm_body *body);
DM_API double dm_rest_volume(const dm_body *body); /* [m3] */
/* positions [m], velocities [m/s]: (3, vertices); null velocities: 0. */
DM_API int32_t dm_set_state(dm_body *body, const double *positions, const double *velocities);
/* Either array may be null. The positions of pinned vertices at rest are returned bit for bit. */
DM_API int32_t dm_get_state(const dm_body *body, double *positions, double *velocities);

/* Run the ticks of a motion. */
DM_API int32_t dm_step(dm_body *body, const dm_motion *motion, dm_frame *frame);
/* Set the forces (count,) [N] that the law would give at depths (count,) [m] at the place where a fingertip is down.
 * factors, factors_end: as in dm_fingertip. */
DM_API int32_t dm_get_law(const dm_body *body, int64_t fingertip, const double *factors, double factors_end,
                          int64_t count, const double *depths, double *forces);
/* Run one motion of each of several bodies; the bits are those of dm_step. If one motion is refused, none is run. */
DM_API int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions,
                            dm_frame *const *frames);
/* Set the number of threads, including the caller's, that all later steps use; 1 at first. The bits do not depend on
 * it. */
DM_API void dm_set_workers(int64_t workers);

/* A fine surface that follows a proxy. Its vertices are taken in runs of eight, each with one list of the proxy's
 * vertices that any of the eight follows. */
typedef struct {
    int64_t vertices;          /* of the surface */
    int64_t entries;           /* total length of all lists */
    const int64_t *first;      /* (eights + 1,) start of the list of each run of eight */
    const uint16_t *followed;  /* (entries,) vertices of the proxy */
    const uint16_t *weights;   /* (entries, 8) in units of 1/65535 */
    const float *places;       /* (eights, 6, 8) [m]: place at rest, and the vector that a gradient multiplies */
    int64_t seeds;             /* vertices of the proxy */
    const double *coarse_rest; /* (seeds, 3) [m] */
    int64_t triangles;         /* of the proxy */
    const int64_t *corners;    /* (triangles, 3) */
    int64_t arms;              /* directed edges of the proxy, sorted by their first end */
    const int64_t *ends;       /* (arms,) their second end */
    const int64_t *starts;     /* (seeds + 1,) start of the arms of each seed */
    const double *spread;      /* (arms, 3) factors from the motion along an edge to a gradient [1/m] */
    const double *upright;     /* (seeds, 3) factors from the change of a normal to a gradient */
    double centre[3];          /* origin of the shifts [m] */
} dm_binding;

/* Set the skin (vertices, 3) [m] carried by a proxy at positions (3, seeds) [m], and the motions (seeds, 12) that carry
 * it. */
DM_API int32_t dm_carry(const dm_binding *binding, const double *positions, float *motions, float *skin);

/* Interpolate values (nodes, 4), of which the fourth is unused, at vertices: carried (vertices, 3). by: (vertices,
 * 8) the eight nodes that carry each vertex; shares: (vertices, 8) their weights. */
DM_API int32_t dm_carry_by_nodes(int64_t vertices, int64_t nodes, const uint16_t *by, const float *shares,
                                 const float *values, float *carried);

/* Seeds on a fine surface. Its vertices are points in the space of position and normal. */
typedef struct {
    int64_t vertices;
    const double *place; /* (vertices, 6) [m] */
    int64_t edges;
    const int64_t *ends; /* (edges, 2) */
    int64_t seeds;
    const int64_t *seed; /* (seeds,) vertices */
} dm_cells;

/* Choose up to `most` points, given by place (points, 6), in addition to the first `taken`: each time the point
 * farthest from all those taken or chosen before, as long as the square of that distance is more than `least` [m2].
 * Return the number chosen. */
DM_API int64_t dm_farthest_first(int64_t points, const double *place, int64_t taken, double least, int64_t most,
                                 int64_t *chosen);
/* Set the seed (vertices,) to which each vertex belongs: the nearest of the seeds of its neighbours, -1 if none reaches
 * it; and whether its cell connects it to that seed (vertices,). */
DM_API int32_t dm_grow_cells(const dm_cells *surface, int64_t *cells, uint8_t *joined);
/* Set the DM_FOLLOWED seeds that each vertex follows, and their weights in units of 1/65535: the nearest of the
 * seeds round its cell. around: (seeds, width), filled up with -1. The lists are those of dm_binding, each in
 * ascending order, with room for 8 DM_FOLLOWED entries. */
DM_API int32_t dm_follow_cells(const dm_cells *surface, const int64_t *cells, int64_t width, const int64_t *around,
                               int64_t *first, uint16_t *followed, uint16_t *weights);

/* Flip edges towards a Delaunay triangulation where the surface is nearly flat. points: (vertices, 3) [m]; corners:
 * (triangles, 3), changed in place. */
DM_API int32_t dm_flip_edges(int64_t vertices, const double *points, int64_t triangles, int64_t *corners);

/* A collider: a mesh that bodies touch. It is moved by keyframes, or falls as a rigid body: a prop. */
typedef struct {
    int64_t vertices;
    const double *positions; /* (3, vertices) [m] */
    int64_t triangles;
    const int64_t *corners;  /* (triangles, 3) */
    double friction;         /* coefficient */
    double mass;             /* [kg] of a prop; 0: it is moved by keyframes, and the rest does not count */
    double inverse_inertia[9]; /* about its centre, in the unrotated pose, by rows [1/(kg m2)] */
    double damping;          /* applied while it touches a soft body [N s/m] */
    double skin;             /* distance that it keeps from rigid surfaces [m] */
    const double *arms;      /* (3, vertices) from its centre, in the unrotated pose [m]: of the mesh that touches, */
    const double *seen;      /* and of the visible mesh, which stands on the ground */
} dm_collider_def;

typedef struct { /* pose and motion of a prop, and the forces that pull it */
    double centre[3];   /* of mass [m] */
    double turn[9];     /* rotation matrix, by rows */
    double velocity[3]; /* of its centre [m/s] */
    double momentum[3]; /* angular, about the centre [kg m2/s] */
    double gravity[3];  /* [m/s2] */
    double ground;      /* height of the ground plane [m], -INFINITY: none */
} dm_prop;

typedef struct { /* the path of a collider; null: it rests */
    const double *from, *to; /* (3, vertices) [m] */
    dm_prop *prop;           /* of a prop: its state as the call begins, replaced by that as it ends */
} dm_collider_motion;

typedef struct {
    int64_t ticks;      /* number of ticks done */
    int64_t queries;    /* number of proximity queries */
    int64_t touching;   /* most pairs that touched */
    int64_t truncated;  /* times that a vertex or a prop was held back from an intersection */
    double taken;       /* momentum that this changed [N s] */
} dm_scene_frame;

typedef struct { /* surfaces that intersect */
    int64_t count;       /* number of intersecting pairs of triangles */
    int64_t surfaces[2]; /* of the first pair; bodies are counted first, then colliders */
    double place[3];     /* of the first pair [m] */
} dm_crossings;

/* Create a scene: bodies and colliders that are stepped together and never intersect. The bodies stay the caller's,
 * must outlive the scene, and must have the same precision and instruction set. self: (bodies,) whether a body
 * collides with itself; faces that intersect others of their body now are left out, and left_out (bodies,) reports
 * them. offset: (bodies,) contact distance of each body [m], 0: a share of its mean edge; that of colliders is the
 * least of the bodies. */
DM_API int32_t dm_scene_create(dm_scene **scene, int64_t bodies, dm_body *const *body, const uint8_t *self,
                               const double *offset, int64_t colliders, const dm_collider_def *collider,
                               dm_crossings *left_out);
DM_API void dm_scene_destroy(dm_scene *scene); /* null: nothing is done */
DM_API int32_t dm_scene_find_crossings(dm_scene *scene, dm_crossings *found);
/* Move a collider to another place at once. */
DM_API int32_t dm_scene_set_collider(dm_scene *scene, int64_t collider, const double *positions);
DM_API int32_t dm_scene_get_collider(const dm_scene *scene, int64_t collider, double *positions);
/* Run the ticks of motions (bodies,), which must be equal in ticks, substeps and tick. Colliders (colliders,) have
 * covered the share `first` of their paths at the end of the first tick, and `last` at the end of the last. passed
 * (bodies + colliders, DM_PASSED) is set, for each surface, to the impulse that it got from others [N s], its moment
 * about the origin [N m s], how far the surface lags behind its path [m], 1 from when it pulled skin too far and
 * released it until they are apart, and the place (3,) of either event [m]; given (vertices of all bodies, 3) to the impulse on each vertex [N s].
 * If memory runs out, the current tick is the last. */
DM_API int32_t dm_scene_step(dm_scene *scene, const dm_motion *motions, const dm_collider_motion *colliders,
                             double first, double last, dm_frame *frames, dm_scene_frame *out, double *passed,
                             double *given);
#endif
