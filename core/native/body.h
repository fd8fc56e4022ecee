/* The parts of a body, in one precision and for one instruction set. */
#ifndef DM_BODY_H
#define DM_BODY_H
#include "lanes.h"
#include "methods.h"
#include <stdlib.h>
#include <string.h>

/* Vertices are stored in the order in which a wave over the surface reaches them, so that neighbours are near in
 * memory. A group is a run of eight vertices with about the same number of neighbours. */
typedef struct {
    dm_vec3 x, v;
} dm_group_state;

typedef struct { /* constant within a step; rest is relative to its centre, k_more = k2 - k1 */
    dm_vec3 rest, pull; /* pull: sum of the tensions t (r_j - r_i) of the shape at rest */
    dm_lanes k1, k_more, d0, damping, mass, inverse_mass;
} dm_group_matter;

typedef struct { /* velocities after a step without the pressure, and what one pascal adds to them */
    dm_vec3 v, per_pascal;
} dm_group_next;

typedef struct { /* v = linear + angular x position */
    double linear[3], angular[3];
} dm_rigid;

typedef struct { /* of the mass: centre, inertia tensor about it and its inverse, and angular velocity [1/s] */
    double centre[3], tensor[9], inverse[9], spin[3];
} dm_inertia;

/* The springs to one neighbour of each vertex of a group. With k of the spring and t of the tension of shape matching,
 * stiffness = k + t and pull = k * rest length. */
typedef struct {
    dm_lanes stiffness, pull, damping;
    uint32_t at[DM_LANES]; /* byte offset of the neighbour's record */
} dm_slot;

typedef struct { /* slots of group g: from start[g] up to start[g + 1] */
    int64_t *start;
    dm_slot *slots;
} dm_rows;

typedef struct { /* a spring outside the rings; on_i, on_j: whether its force acts on that end here */
    int64_t spring;
    uint8_t on_i, on_j;
    double damping;
} dm_irregular_spring;

typedef struct { /* of a fingertip with a vertex, or with the point of a face that was nearest as the substep began */
    uint32_t corner[3], number; /* number: of the vertex, or vertices + number of the face */
    int corners, at_work;
    dm_quad weight;
    dm_real mobility[3], radius; /* radius: of the sphere there; smaller than the fingertip's on a face */
    dm_real part, closing, friction; /* part: share of its depth removed in a substep; closing: at this speed [m/s] */
    dm_real yields;                  /* compliance of the skin under an impulse, over the substep [1/kg] */
    dm_quad normal, held, change, at; /* held: the impulse so far [N s]; at: velocity or place from the fingertip's */
} dm_contact;

typedef struct { /* the part of a body that a fingertip may touch within a tick */
    int finger;
    dm_quad centre, velocity, now; /* at the end of the tick, over it, and at the end of the substep */
    dm_quad pushed;                /* unit vector towards the skin that yields, or 0 */
    dm_real radius;
    double reach; /* [m] from the centre: touch range in the tick if the body does not move */
    int64_t vertex_count, face_count, noted_count;
    uint32_t *vertices, (*faces)[4]; /* corners and number, the last one repeated to fill eight lanes */
    dm_real *radii;                  /* of the spheres that the faces meet [m] */
    uint32_t *noted;                 /* these vertices and corners, each once */
    int64_t listed_vertex_count, listed_face_count;
    uint32_t *listed_vertices, (*listed_faces)[4]; /* the lists from which they are picked: */
    double listed_at[3], listed; /* all within `listed` [m] of this place, 0 if unknown, */
    dm_real listed_radius;       /* for this fingertip */
    int listed_finger;
} dm_near;

typedef struct { /* a triangle of the surface at rest, below which fingertips are measured */
    double corner[3][3], normal[3], middle[3], extent; /* extent: of the corners from the middle [m] */
    uint32_t vertex[3]; /* numbers in the surface, in the caller's order */
    int64_t index, material;
} dm_facet;

typedef struct { /* a fingertip; all vectors except centre and force are in the space of the shape at rest */
    double centre[3], radius;        /* [m] */
    double way;                      /* [m] displacement by the given force */
    const double *factors;           /* of the force of a tip other than the measuring one, or null, */
    double factors_end;              /* at depths up to this [m] */
    int met, in_contact, beside;           /* below the surface at rest; touches the skin; others did at first touch */
    double deep, depth, zero, height; /* [m] distance to its foot; deep - zero; zero of the depth; height of the skin */
    double foot[3], anchor[3];       /* centres of spheres on that surface: the foot; where friction holds the tip */
    double outward[3], local[3];     /* unit normal; the centre at the last evaluation */
    int64_t facet, material;         /* of the place below its foot; */
    double weight[3], stiffer, deeper, thickness, thick_at[3]; /* painted factors there; thickness [m], and its place */
    double law, slope, stick;        /* [N]; [N/m]; stiffness of the tangential spring [N/m] */
    double slides;                   /* share of the friction that is used; 1: it slides */
    double force[3];                 /* on the fingertip [N] */
    int rests;                       /* it was near as the body fell asleep, */
    double rests_at[3], rests_radius; /* with this centre and radius */
    dm_quad *kept;                   /* impulses on vertices and faces in the last substep [N s], */
    uint32_t *kept_at, kept_count;   /* and the numbers of those that are not zero */
} dm_tip;

/* An operation on the groups from `from` to `to`, which adds up sums over them. */
enum { DM_MOMENTS = 27 }; /* greatest number of sums: that of dm_pass_moments */
typedef void dm_pass(dm_state *b, int64_t from, int64_t to, double *sums);

struct dm_state {
    int64_t n, groups;
    int64_t slice, slices; /* groups in a slice, and number of slices */
    double (*sums)[DM_MOMENTS]; /* (slices,) of the current pass, */
    dm_pass *pass;              /* and that pass */
    uint32_t *place, *rank; /* of each of the caller's vertices: index in memory; position along a curve in space */
    uint32_t *pinned;       /* (pinned_count,) the caller's vertices without an inverse mass */
    uint8_t *loose, any_k1;
    int64_t pinned_count;
    double *rest;     /* (3, n) as the caller gave it */
    double *mass;     /* (n,) in the caller's order */
    double *pins;     /* (3, n) places of the pins, bit for bit as the caller gave them */
    double origin[3], middle[3], cell; /* [m] of the state; centre of mass at rest; step in which the origin moves */
    dm_record *records;
    dm_group_state *state;
    dm_group_matter *matter;
    dm_group_next *next;

    dm_rows ring;
    int32_t *ring_spring; /* (slots * LANES), -1: none */
    int64_t irregular_count, fan_count, cap_count, hole_count, triangle_count, spring_count;
    dm_irregular_spring *irregular;
    uint32_t (*ends)[2];
    double *rest_length, *stiffness, *tension; /* (spring_count,) with the ends, in the caller's order */
    uint32_t (*fans)[3], (*caps)[2], *cap_hole;
    double (*holes)[7]; /* centre, force on the rim, number of edges: working memory of a step */

    int32_t fill;
    double rest_volume, rest_area, size, gravity[3], ground, volume, pressure, rest_pressure;
    double comes_back; /* [s] remaining time in which the skin recovers, since nothing touches it */
    int pins_met;      /* something held a pin back */
    int free, led, carried; /* the shape at rest follows the body; pins were moved, and carry it */
    int rigged, moving;     /* the shape at rest stays where it is set; it changes in the next motion, */
    dm_vec3 *rest_rate;     /* (groups,) at this rate [m/s], */
    dm_vec3 *pull_rate;     /* and the pull of its tension at this one [N/s] */
    double *pin_room;       /* (9, groups * 8) working memory of a tick */
    double pose[12], pose_rate[12]; /* of the shape at rest with its pins, and its rate [1/s] */
    double turning[12];  /* that rate, about the centre of the shape at rest */
    double rest_centre[3], rotation[9], translation[3], k1_total, mass_total;
    double turned[9]; /* rotation of the last fit */
    dm_rigid drift;      /* rigid part of the velocities, or the rigid acceleration to subtract */
    dm_inertia moments;
    double fill_share[9]; /* angular momentum of the fill over that of the skin, in the shape at rest */
    double fill_momentum[3]; /* that of the fill as the substep began [N m s], */
    int fill_turns;          /* which is known: nothing has changed the body since */
    double resisted[3]; /* rolling resistance of the surfaces that it touches, in the next substep [N m] */
    double dt, skin_travel; /* [s]; [m] farthest that a vertex may move in a step, 0: no limit */

    uint32_t (*triangles)[4];
    dm_real *inverse_mass, *friction, *compliance;
    int finger_count;
    dm_near touches[DM_MAX_FINGERTIPS];
    dm_vec3 *listed; /* (groups,) places of the vertices when the lists were made */
    dm_contact *hits;
    dm_quad *before; /* places of vertices near a fingertip at the beginning of the step */
    uint32_t *shares, *moved; /* number of contacts that share a vertex; vertices moved by a contact */
    uint8_t *is_moved;

    int meets;             /* it is stepped in a scene */
    uint64_t changes;      /* counts changes from outside a scene */
    int rested, asleep;    /* it may fall asleep; it sleeps: it is not stepped until something wakes it */
    double fastest, quiet; /* [m/s] greatest speed in the last tick; [s] time since it became quiet */
    dm_vec3 *still;        /* (groups,) its places when it became quiet */
    double bounds[2][3], still_pose[12], still_volume; /* of a body that sleeps */

    dm_facet *facets;
    double (*facet_boxes)[6], (*facet_regions)[6]; /* low and high corners: of runs of facets; of runs of these boxes */
    int64_t facet_count, facet_box_count;
    double (*laws)[DM_LAW];   /* of each material */
    double (*painted)[2];     /* of each vertex of the surface: factors of the stiffness and of the knee's depth */
    int64_t surface_count;
    int own_surface;          /* the vertices of the surface are the body's own */
    double skin_push[6]; /* of contact with fingertips on the skin in a substep: impulse [N s], and its moment */
    dm_tip fingers[DM_MAX_FINGERTIPS];
};

/* Set the vector of one vertex among those of its group. */
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

DM_INLINE void dm_add3(double *a, double by, const double *b) {
    for (int c = 0; c < 3; c++) a[c] += by * b[c];
}

/* Set r = a b, for matrices by rows. */
DM_INLINE void dm_multiply3x3(const double *a, const double *b, double *r) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) r[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

DM_INLINE void dm_transpose3x3(const double *a, double *r) {
    for (int k = 0; k < 9; k++) r[k] = a[k % 3 * 3 + k / 3];
}

/* Return zeroed and aligned memory for `count` items, null if there is none left; count 0 is allowed. */
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
