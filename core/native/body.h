/* What a body is made of, in one precision and for one instruction set. */
#ifndef DM_BODY_H
#define DM_BODY_H
#include "lanes.h"
#include "methods.h"
#include <float.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK 32 /* triangles that share a bounding box */
#define FACE_SWEEPS 8 /* as in core/body/contact.py */
#define FACE_SLACK 1e-3
#define HELD_GIVE 0.1
#define ROUNDING 1e-6
#define TOO_NEAR 1e-5
#define WEIGHT_FLOOR 1e-6
#define SKIN_TRAVEL 0.5 /* as in core/base.py, with the three below */
#define FINGER_TRAVEL 0.25
#define BLOWN_UP 100.0
#define SAME_SIDE 0.5 /* as in core/mesh/depth.py */

/* Vertices lie in the order in which a wave over the surface meets them, so that neighbours are near in memory; runs of
 * eight with about as many neighbours each make a group. */
typedef struct {
    three x, v;
} group_state;

typedef struct { /* what does not change within a step; rest from its own centre, k_more = k2 - k1 */
    three rest;
    lanes k1, k_more, d0, damping, mass, inverse_mass;
} group_matter;

typedef struct { /* velocities after a step but for the pressure, and what a pascal adds to them */
    three v, per_pascal;
} group_next;

typedef struct { /* v = linear + angular x position */
    double linear[3], angular[3];
} rigid;

typedef struct { /* of the mass: its centre, and the inverse of its moments about it */
    double centre[3], inverse[9];
} inertia;

typedef struct { /* the springs to one neighbour of each vertex of a group; pull = stiffness * rest length */
    lanes stiffness, pull, damping;
    uint32_t at[LANES]; /* byte offset of the neighbour's record */
} slot;

typedef struct { /* slots of group g: from start[g] up to start[g + 1] */
    int64_t *start;
    slot *slots;
} rows;

typedef struct { /* a spring summed by itself, on the ends that say so */
    uint32_t i, j;
    int64_t spring;
    uint8_t on_i, on_j;
    double rest, stiffness, damping;
} irregular_spring;

typedef struct { /* a point on a face, or a vertex, inside a fingertip */
    uint32_t corner[3];
    real weight[3], mobility[3], distance;
    quad normal, impulse, out;
} hit;

typedef struct { /* what a fingertip may meet within a tick */
    int finger;
    quad centre, velocity;
    real radius;
    int64_t vertex_count, face_count;
    uint32_t *vertices, (*faces)[3]; /* by their corners, the last one repeated to fill eight lanes */
} touch;

typedef struct { /* a triangle of the surface at rest, below which fingertips are measured */
    double corner[3][3], normal[3];
    int64_t index, material;
} facet;

struct dm_state {
    int64_t n, groups;
    uint32_t *place, *rank; /* of each of the caller's vertices: in memory, along a curve in space */
    uint32_t *pinned;       /* (pinned_count,) the caller's vertices without an inverse mass */
    uint8_t *loose, any_loose, any_k1;
    int64_t pinned_count;
    double *rest;     /* (3, n) as the caller gave it */
    double *mass;     /* (n,) in the caller's order */
    double *pins;     /* (3, pinned_count) where they are, in the caller's own digits */
    double origin[3], middle[3], cell; /* of the state; of the mass at rest; what the origin moves by */
    record *records;
    group_state *state;
    group_matter *matter;
    group_next *next;

    rows ring;
    int32_t *ring_spring; /* (slots * LANES), -1 is none */
    int64_t irregular_count, fan_count, cap_count, hole_count, triangle_count, spring_count;
    irregular_spring *irregular;
    double *rest_length; /* (spring_count,) */
    uint32_t (*fans)[3], (*caps)[2], *cap_hole;
    double (*holes)[7]; /* centre, pull of the rim, number of edges: room for one step */

    int32_t fill, law_set;
    double rest_volume, rest_area, size, gravity[3], ground, volume, pressure;
    int free, led, carried; /* the shape at rest follows the body; pins were led; and carry the shape at rest */
    double *pin_room;       /* (9 n) for one tick */
    double pose[12], pose_rate[12]; /* of the shape at rest with its pins, and how fast it changes */
    double turning[12];  /* the rate about the centre of the shape at rest */
    double rest_centre[3], rotation[9], translation[3], k1_total, mass_total;
    double turned[9]; /* of the last fit */
    rigid drift;      /* rigid part of the velocities, or the acceleration to take out */
    inertia moments;
    double dt, skin_travel; /* [m] the farthest a vertex may go in a step, 0 where nothing is near */

    uint32_t (*triangles)[3], *box_start, *box_vertex;
    quad (*boxes)[2];
    int64_t box_count;
    real *inverse_mass, *friction;
    int finger_count;
    touch touches[DM_MAX_FINGERTIPS];
    hit *hits;
    uint32_t *shares, *moved; /* contacts that share a vertex; vertices a contact moved */
    uint8_t *is_moved, *touching;
    double inner_force;

    facet *facets;
    double (*facet_boxes)[6]; /* low and high corners of runs of them */
    int64_t facet_count, facet_box_count, law_count;
    double (*laws)[3];        /* K1, K2, x0 of each material */
    struct {
        double centre[3], side[3]; /* where a fingertip is, and the outward normal where it came in */
        int has_side;
    } fingers[DM_MAX_FINGERTIPS];
};
typedef struct dm_state body;

/* one vertex of the vectors of its group */
static inline void set_lane3(three *a, uint32_t i, quad b) {
    a->x[i % LANES] = b[0], a->y[i % LANES] = b[1], a->z[i % LANES] = b[2];
}

static inline void add_lane3(three *a, uint32_t i, const double *b, double by) {
    a->x[i % LANES] += (real)(by * b[0]), a->y[i % LANES] += (real)(by * b[1]), a->z[i % LANES] += (real)(by * b[2]);
}

static inline void position(const body *b, uint32_t i, double *x) {
    for (int c = 0; c < 3; c++) x[c] = b->records[i].x[c];
}

static inline void velocity(const body *b, uint32_t i, double *v) {
    for (int c = 0; c < 3; c++) v[c] = b->records[i].v[c];
}

static inline double inner3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross3(const double *a, const double *b, double *r) {
    r[0] = a[1] * b[2] - a[2] * b[1], r[1] = a[2] * b[0] - a[0] * b[2], r[2] = a[0] * b[1] - a[1] * b[0];
}

/* zeroed and aligned memory for count things, never null for count 0 */
static inline void *room(int64_t count, size_t size) {
    size_t bytes = ((size_t)(count > 0 ? count : 1) * size + 127) / 64 * 64;
    char *raw = calloc(bytes + 64, 1);
    if (!raw) return NULL;
    char *at = (char *)(((uintptr_t)raw + 64) & ~(uintptr_t)63);
    ((char **)at)[-1] = raw;
    return at;
}

static inline void give_back(void *at) {
    if (at) free(((char **)at)[-1]);
}

#endif
