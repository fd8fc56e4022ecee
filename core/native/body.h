/* What a body is made of, in one precision and for one instruction set. */
#ifndef DM_BODY_H
#define DM_BODY_H
#include "lanes.h"
#include "methods.h"
#include <stdlib.h>
#include <string.h>

/* Vertices lie in the order in which a wave over the surface meets them, so that neighbours are near in memory; runs of
 * eight with about as many neighbours each make a group. */
typedef struct {
    dm_vec3 x, v;
} dm_group_state;

typedef struct { /* what does not change within a step; rest from its own centre, k_more = k2 - k1 */
    dm_vec3 rest, pull; /* pull: sum of the tensions t (r_j - r_i) of the shape at rest */
    dm_lanes k1, k_more, d0, damping, mass, inverse_mass;
} dm_group_matter;

typedef struct { /* velocities after a step but for the pressure, and what a pascal adds to them */
    dm_vec3 v, per_pascal;
} dm_group_next;

typedef struct { /* v = linear + angular x position */
    double linear[3], angular[3];
} dm_rigid;

typedef struct { /* of the mass: its centre, its moments about it and their inverse; and how fast it turns [1/s] */
    double centre[3], tensor[9], inverse[9], spin[3];
} dm_inertia;

/* the springs to one neighbour of each vertex of a group: with k of the spring and t of shape matching's tension,
 * stiffness = k + t, pull = k * rest length */
typedef struct {
    dm_lanes stiffness, pull, damping;
    uint32_t at[DM_LANES]; /* byte offset of the neighbour's record */
} dm_slot;

typedef struct { /* slots of group g: from start[g] up to start[g + 1] */
    int64_t *start;
    dm_slot *slots;
} dm_rows;

typedef struct { /* a spring summed by itself, on the ends that say so */
    uint32_t i, j;
    int64_t spring;
    uint8_t on_i, on_j;
    double rest, stiffness, damping, tension;
} dm_irregular_spring;

typedef struct { /* a fingertip and a vertex, or the point of a face that was nearest when the substep began */
    uint32_t corner[3], number; /* number: of the vertex, or behind the vertices of the face */
    int corners, at_work;
    dm_quad weight;
    dm_real mobility[3], radius; /* of the sphere there: a facet's is smaller than the fingertip's */
    dm_real part, closing, friction; /* part: of its gap or depth that it loses in a substep; at this speed [m/s] */
    dm_real yields;                  /* what the skin does under an impulse, over the substep [1/kg] */
    dm_quad normal, held, change, at; /* held: the impulse so far [N s]; at: its velocity or place, from the fingertip's */
} dm_contact;

typedef struct { /* what a fingertip may meet within a tick */
    int finger;
    dm_quad centre, velocity, now; /* at the end of the tick, over it, and at the end of the substep */
    dm_quad pushed;                /* unit vector to what gives way, or nothing */
    dm_real radius;
    double reach; /* [m] from the centre: what a body that does not move may be touched by in the tick */
    int64_t vertex_count, face_count, noted_count;
    uint32_t *vertices, (*faces)[4]; /* corners and number, the last one repeated to fill eight lanes */
    dm_real *radii;                  /* of the spheres that the faces meet [m] */
    uint32_t *noted;                 /* each of those vertices and corners once */
    int64_t listed_vertex_count, listed_face_count;
    uint32_t *listed_vertices, (*listed_faces)[4]; /* what they are picked from: */
    double listed_at[3], listed; /* all within so much [m] of this place, 0 where that is not known, */
    dm_real listed_radius;       /* for this fingertip */
    int listed_finger;
} dm_near;

typedef struct { /* a triangle of the surface at rest, below which fingertips are measured */
    double corner[3][3], normal[3], middle[3], extent; /* extent: of the corners from the middle [m] */
    uint32_t vertex[3]; /* of the surface, in the caller's order */
    int64_t index, material;
} dm_facet;

enum { DM_NORMALS = 8 }; /* that hold a sphere: more walls than a fingertip touches at once */
typedef struct { /* a fingertip; vectors but centre and force are in the space of the shape at rest */
    double centre[3], radius;        /* where it is [m] */
    double way;                      /* [m] that a force has pushed it */
    const double *factors;           /* of the force of another tip, null where it is the measuring one, */
    double factors_end;              /* at depths up to this [m] */
    int met, in_contact, beside;           /* it lies on the surface at rest; touches the skin; others did when */
    double deep, depth, zero, height; /* it began. How far it is from its foot; its x [m], from `zero` on; where the skin is */
    double foot[3], anchor[3];       /* spheres on that surface: above it; where friction holds it */
    double outward[3], local[3];     /* unit; its centre when it was evaluated last */
    int64_t facet, material;         /* of the place below its foot, with */
    double weight[3], stiffer, deeper, thickness, thick_at[3]; /* what is painted there, and the thickness [m] at a place */
    double law, slope, stick;        /* [N], [N/m]; of the spring sideways [N/m] */
    double slides;                   /* share of the friction that is used up: with 1 it slides */
    double force[3];                 /* on it [N] */
    int rests;                       /* it was near when the body fell asleep, */
    double rests_at[3], rests_radius; /* there */
    dm_quad *kept;                   /* impulses on vertices and faces in the last substep [N s]; those that are not zero: */
    uint32_t *kept_at, kept_count;
} dm_tip;

/* What is done to some groups, from one up to another, and what is summed up in them. */
enum { DM_MOMENTS = 27 }; /* the most sums: those of dm_pass_moments */
typedef void dm_pass(dm_state *b, int64_t from, int64_t to, double *sums);

struct dm_state {
    int64_t n, groups;
    int64_t slice, slices; /* groups of one, and their number */
    double (*sums)[DM_MOMENTS]; /* (slices,) of the pass under way, */
    dm_pass *pass;              /* which is this */
    uint32_t *place, *rank; /* of each of the caller's vertices: in memory, along a curve in space */
    uint32_t *pinned;       /* (pinned_count,) the caller's vertices without an inverse mass */
    uint8_t *loose, any_k1;
    int64_t pinned_count;
    double *rest;     /* (3, n) as the caller gave it */
    double *mass;     /* (n,) in the caller's order */
    double *pins;     /* (3, pinned_count) where they are, in the caller's own digits */
    double origin[3], middle[3], cell; /* of the state; of the mass at rest; what the origin moves by */
    dm_record *records;
    dm_group_state *state;
    dm_group_matter *matter;
    dm_group_next *next;

    dm_rows ring;
    int32_t *ring_spring; /* (slots * LANES), -1 is none */
    int64_t irregular_count, fan_count, cap_count, hole_count, triangle_count, spring_count;
    dm_irregular_spring *irregular;
    uint32_t (*ends)[2];
    double *rest_length, *stiffness, *tension; /* (spring_count,) with the ends, in the caller's order */
    uint32_t (*fans)[3], (*caps)[2], *cap_hole;
    double (*holes)[7]; /* centre, pull of the rim, number of edges: room for one step */

    int32_t fill;
    double rest_volume, rest_area, size, gravity[3], ground, volume, pressure, rest_pressure;
    double comes_back; /* [s] for so long its skin does, since nothing touches it: about */
    int pins_met;      /* something held a pin back */
    double jumped; /* [m] the farthest that a pin was put after the last tick, to be where it was sent to the digit */
    int free, led, carried; /* the shape at rest follows the body; pins were led; and carry the shape at rest */
    int rigged, moving;     /* the shape at rest stays where it is laid; it changes in the next motion, */
    dm_vec3 *rest_rate;     /* (groups,) so fast [m/s], */
    dm_vec3 *pull_rate;     /* and the pull of its tension with it [N/s] */
    double *pin_room;       /* (9, groups * 8) for one tick */
    double pose[12], pose_rate[12]; /* of the shape at rest with its pins, and how fast it changes */
    double turning[12];  /* the rate about the centre of the shape at rest */
    double rest_centre[3], rotation[9], translation[3], k1_total, mass_total;
    double turned[9]; /* of the last fit */
    dm_rigid drift;      /* rigid part of the velocities, or the acceleration to take out */
    dm_inertia moments;
    double resisted[3]; /* moment that what it touches takes out in the next substep [N m] */
    double dt, skin_travel; /* [m] the farthest a vertex may go in a step, 0 where nothing is near */
    double way;             /* [m] the farthest that one went in the last, before contact */

    uint32_t (*triangles)[4], *box_start, *box_vertex;
    dm_quad (*boxes)[2];
    int64_t box_count;
    dm_real *inverse_mass, *friction, *compliance;
    int finger_count;
    dm_near touches[DM_MAX_FINGERTIPS];
    dm_vec3 *listed; /* (groups,) where vertices were when the lists were made */
    dm_contact *hits;
    dm_quad *before; /* where vertices near a fingertip were at the begin of the step */
    uint32_t *shares, *moved; /* contacts that share a vertex; vertices a contact moved */
    uint8_t *is_moved;

    int meets;             /* it is stepped in a scene */
    uint64_t changes;      /* counts what was done to it but by a scene */
    int rested, asleep;    /* it may sleep; at rest, and not stepped until something wakes it */
    double sag;            /* [m/s] that gravity gives in a substep, and contact takes back as a way; 0 where none does */
    double fastest, quiet; /* [m/s] of the last tick; [s] how long nothing has moved */
    dm_vec3 *still;        /* (groups,) where it was when that began */
    double bounds[2][3], still_pose[12], still_volume; /* of what is asleep */

    dm_facet *facets;
    double (*facet_boxes)[6], (*facet_regions)[6]; /* low and high corners of runs of them, and of runs of those */
    int64_t facet_count, facet_box_count;
    double (*laws)[DM_LAW];   /* of each material */
    double (*painted)[2];     /* of each vertex of the surface: how many times as stiff, and as deep the knee */
    int64_t surface_count;
    int own_surface;          /* its vertices are the body's own */
    double skin_push[6]; /* that contact with fingertips gave the skin in a substep: impulse [N s], and its moment */
    dm_tip fingers[DM_MAX_FINGERTIPS];
};

/* one vertex of the vectors of its group */
DM_INLINE void dm_set_lane3(dm_vec3 *a, uint32_t i, dm_quad b) {
    a->x[i % DM_LANES] = b[0], a->y[i % DM_LANES] = b[1], a->z[i % DM_LANES] = b[2];
}

DM_INLINE dm_quad dm_lane3(const dm_vec3 *a, uint32_t i) {
    return (dm_quad){a->x[i % DM_LANES], a->y[i % DM_LANES], a->z[i % DM_LANES], 0};
}

DM_INLINE void dm_add_lane3(dm_vec3 *a, uint32_t i, const double *b, double by) {
    a->x[i % DM_LANES] += (dm_real)(by * b[0]);
    a->y[i % DM_LANES] += (dm_real)(by * b[1]);
    a->z[i % DM_LANES] += (dm_real)(by * b[2]);
}

DM_INLINE void dm_position(const dm_state *b, uint32_t i, double *x) {
    DM_UNROLLED for (int c = 0; c < 3; c++) x[c] = b->records[i].x[c];
}

DM_INLINE void dm_velocity(const dm_state *b, uint32_t i, double *v) {
    for (int c = 0; c < 3; c++) v[c] = b->records[i].v[c];
}

DM_INLINE double dm_inner3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

DM_INLINE void dm_cross3(const double *a, const double *b, double *r) {
    r[0] = a[1] * b[2] - a[2] * b[1], r[1] = a[2] * b[0] - a[0] * b[2], r[2] = a[0] * b[1] - a[1] * b[0];
}

/* zeroed and aligned memory for count things, never null for count 0 */
static __attribute__((noinline, unused)) void *dm_alloc(int64_t count, size_t size) {
    size_t bytes = ((size_t)(count > 0 ? count : 1) * size + 127) / 64 * 64;
    char *raw = calloc(bytes + 64, 1);
    if (!raw) return NULL;
    char *at = (char *)(((uintptr_t)raw + 64) & ~(uintptr_t)63);
    ((char **)at)[-1] = raw;
    return at;
}

static __attribute__((noinline, unused)) void dm_free(void *at) {
    if (at) free(((char **)at)[-1]);
}

#endif
