/* Bodies and colliders in contact: the data that a scene keeps between two proximity queries.
 *
 * The guarantee. A search of two surfaces finds every pair of a vertex and a face, and of two edges, nearer than `reach`.
 * Between their nearest points stands a plane; each of the two stays on its own side of it. Pairs that are not found are
 * farther apart than `reach`. A query keeps them while the surfaces have hardly moved relative to each other, and until
 * the next query no vertex moves farther than half of what is left of `reach`. So nothing passes through anything,
 * whatever the forces. The plane of a collider or a prop moves with it: a rigid surface moves as a whole,
 * and the skin is kept ahead of it. If the skin cannot get away, the rigid surface moves only as far as it can.
 * Source: the displacement bounds of offset geometric contact (Chen et al. 2025), with planes in place of spheres,
 * so that surfaces that slide or separate are not stopped.
 */
#ifndef DM_SCENE_H
#define DM_SCENE_H
#include "falling.h"
#include <stddef.h>

enum { DM_WAITING = DM_LANES * DM_LANES }; /* number of pairs that a query collects before it measures them */

typedef struct { /* the surface of a body, or a collider */
    dm_state *body; /* null: a collider */
    dm_falling *prop; /* null: a soft body, or a collider moved by keyframes */
    uint32_t first, count, first_triangle, triangle_count, first_edge, edge_count, first_node, node_count;
    double offset, edge, closest, friction;
    double low[3], high[3]; /* its bounding box at the last query */
    double slack, stale;    /* [m] travel of a vertex since the query: greatest allowed; at which the next is due */
    double moved[3], bent;  /* [m] between the last two queries: mean displacement, and the greatest difference from it */
    double gone, way;       /* [m] greatest displacement: since the query; since pairs were checked, of skin near something */
    double share, tried;    /* of a rigid surface's motion in this substep: share covered, and share tried first */
    double pace, pace_now;  /* of a keyframed collider: share of its remaining path, in this tick, this substep */
    double late, place[3];  /* [m] its lag behind its path, and where the skin last could not get away */
    double origin[3];       /* of the body at the last query */
    double impulse[3];      /* from others in a call [N s] */
    double moment[3];       /* of that impulse, about the origin [N m s] */
    double load, spin_beside[3];        /* in a substep: impulses on it [N s]; sum of impulse times the other's spin */
    double resisting[3], moment_of[3];  /* rolling resistance [N m]: kept over the substeps; in the next one */
    uint64_t changes;       /* of the body, at the last query */
    uint8_t self, moving, kept; /* moving: a collider; kept: it must stay awake */
    uint8_t fitted, stuck, pressed, torn, placed; /* its boxes are up to date; skin cannot get out of its way; wakes in
                                                  * the next substep; it has released skin in this call; was put elsewhere */
} dm_surface;

typedef struct { /* a box with triangles, at most eight in a leaf; its first child follows it, the other one is `next` */
    double low[3], high[3];
    uint32_t start, end, next;
} dm_node;

typedef struct { /* boxes of triangles or edges by coordinate, so that one box is compared with eight at once */
    double *low[3], *high[3];
} dm_boxes;

typedef struct { /* a vertex and a face, or two edges, nearer than `reach` when they were found */
    uint32_t at[4], parts[2]; /* in `near`: vertex and corners, or ends of both edges; the triangle, or both edges */
    uint32_t ones, rigid;   /* vertices on the normal's side, 1 or 2; bits: the first side is rigid, the second is */
    double gap, touch, weight; /* least distance at the last query, distance of touch [m]; share of its impulse, less for
                                * flat edges, 0 if it cannot touch before it is found again */
} dm_pair;

typedef struct { /* the pairs of two surfaces, from `start` up to `end` in the list */
    uint32_t first, second, start, end;
    double reach, used;     /* [m] of the search that found them; relative displacement since then, until the last query */
    double gone;            /* [m] upper bound of their displacement towards each other's planes since they were found */
} dm_run;

typedef struct { /* of a pair: a soft side keeps at least the distance `keep` from normal . x = level */
    double normal[3], level, keep;
} dm_plane;

typedef struct { /* a pair that may touch, with the caller's vertex numbers, in ascending order on each side */
    uint32_t number[4], pair;
} dm_ordered;

typedef struct { /* the pairs of a vertex that is near something: their number, and the end of their list */
    uint32_t count, end;
} dm_tally;

typedef struct { /* a pair that may touch, with its nearest points when it was listed */
    uint32_t at[4], surface[2], ones;
    double weight[4], normal[3], touch, friction, share; /* touch: distance of touch [m] */
} dm_meeting;

typedef struct { /* eight meetings that share no movable vertex, all with a face or all of edges, and their impulses */
    uint32_t at[4][DM_LANES]; /* byte offsets into `moving`; those of empty lanes lead to an immovable entry */
    dm_lanes weight[4];
    dm_vec3 normal, drag, sum;               /* sum: of the impulses since it was listed [N s] */
    dm_vec3 anchor, back;                    /* displacement where it stuck last [m]; velocity back to it [m/s] */
    dm_lanes begin, touch, share, friction;  /* distances [m]: as the substep began, of touch; share of the impulse */
    dm_lanes least, push, give, by;          /* least separating speed [m/s]; give: 1 / mass; by: about share / give */
    dm_mask active;                          /* in this substep */
} dm_batch;

typedef struct { /* of a batch: points of contact [m], vertices in `near`, surfaces, number of lanes; ones: of its pairs */
    dm_wide3 point;
    uint32_t near[DM_LANES][4], surface[DM_LANES][2], count, ones;
} dm_batch_sides;

typedef struct { /* a vertex that is near something */
    dm_quad last;       /* its place after the last substep, relative to its body's origin */
    dm_record *body;    /* null: of a collider */
    uint32_t vertex, surface, held, batch; /* held: it is in that list; batch: 1 + the last one that it is in */
} dm_neighbour;

typedef struct dm_scene_state {
    dm_surface *surfaces;
    int64_t surface_count, vertex_count, triangle_count, edge_count;
    double (*before)[3], (*rest)[3];         /* places of vertices at the last query; at rest; */
    dm_vec3 *noted;                          /* of bodies at the last query, relative to their origins; */
    double (*here)[3], (*aim)[3], (*rate)[3]; /* of colliders: places now, at the end of the tick, and velocities, */
    double (*was)[3];                        /* and places before this substep */
    double (*given)[3];                      /* impulse on each vertex in a call [N s] */
    uint32_t (*corners)[3], (*edges_of)[3], (*edges)[2], (*across)[2]; /* across: far corners of the faces at an edge */
    uint8_t *left_out; /* of self-contact: vertices of faces that intersected others of the body at the start */
    uint32_t *vertex_start, *edge_start, *listed; /* each vertex, in `listed`, and each edge belongs to one triangle */
    dm_boxes boxes, edge_boxes;
    uint32_t *ring_start, *ring, *place; /* neighbours of a vertex; its index in `near` */
    dm_node *nodes;
    dm_neighbour *near;
    uint32_t near_count, near_room, pair_count, pair_room, *pairs_of, pairs_of_room;
    uint32_t candidate_count, candidate_room, *candidates; /* pairs that may touch before they are found again, sorted */
    uint32_t sorted_room, *bins; /* working memory to sort them */
    dm_ordered *sorted;
    uint32_t support_count, standing, support_room, prop_count;
    dm_support *supports; /* pairs without a soft body; in a substep also those with the ground, `standing` in all */
    uint32_t batch_count, batch_room, sides_room, moving_room;
    dm_batch *batches; /* of the meetings, in the order in which they are resolved */
    dm_batch_sides *sides;
    dm_record *moving; /* of `near`: displacement since pairs were listed, then the correction; velocity, 1 / mass */
    uint32_t held_count, held_room, *held;    /* vertices that are beyond a plane in this substep, in `near` */
    uint32_t spent_count, spent_room, *spent; /* pairs whose planes leave little room */
    uint32_t met_count, met_room, *met; /* vertices that are in a meeting, in `near` */
    uint32_t *number;                    /* of vertices, in the caller's order */
    int looks;                           /* the pairs that may touch must be listed again */
    int backwards;                       /* bodies are stepped from the last, still in the cache, to the first */
    int wakes;                           /* something awake may have come near something that sleeps */
    int due;       /* a query is due */
    dm_pair waiting[2][DM_WAITING]; /* pairs of faces, and of edges, that a query has not measured yet */
    uint32_t waiting_count[2], run_count, run_room, kept_count, released_count, released_room;
    uint32_t (*released)[2]; /* body, and collider that let its skin go: they collide again once they are apart */
    dm_run *runs;
    dm_pair *pairs;
    dm_plane *planes; /* of the pairs; */
    double *next;     /* when `gone` of the run reaches this [m], the pair is checked again */
    dm_tally *tally;  /* of `near` */
    double (*there)[3], (*now)[3]; /* places of `near` when pairs were listed; as this substep began */
    uint32_t tally_room, plane_room, next_room, there_room, now_room;
    double touch, edge, tick, dt, substeps, reach, least_reach, approach, fastest, fastest_rigid;
    int32_t code;
    dm_scene_frame *out;
    dm_crossings *found;
    dm_surface *both[2]; /* that are being searched */
} dm_scene_state;

/* Return an array with room for one more item: the old one, with DM_MEMORY in `code`, if memory runs out. */
static void *dm_grown(dm_scene_state *s, void *array, uint32_t count, uint32_t *size, size_t each) {
    if (count < *size) return array;
    uint32_t wanted = *size ? 2 * *size : 256;
    void *made = dm_alloc(wanted, each);
    if (!made) return s->code = DM_MEMORY, array;
    if (array) memcpy(made, array, count * each);
    dm_free(array), *size = wanted;
    return made;
}

/* Return how far anything may move in the next substep [m]; speeds were measured as the tick began. */
DM_INLINE double dm_next_way(const dm_scene_state *s) { return s->fastest * s->dt / DM_BOUND; }

DM_INLINE int dm_has_room(const dm_scene_state *s) { return s->code == DM_OK; }

DM_INLINE int dm_sleeps(const dm_surface *f) { return f->body ? f->body->asleep : f->prop && f->prop->asleep; }

DM_INLINE double dm_skin_of(const dm_surface *f) { return f->prop ? f->prop->skin : 0; }

/* Return the distance at which two surfaces touch [m]. */
DM_INLINE double dm_touch_of(const dm_surface *f, const dm_surface *g) {
    return f->body || g->body ? f->offset + g->offset : dm_skin_of(f) + dm_skin_of(g);
}

DM_INLINE void dm_world_of(const dm_scene_state *s, const dm_surface *f, uint32_t vertex, double *x) {
    if (!f->body) {
        memcpy(x, s->here[vertex], 3 * sizeof(double));
        return;
    }
    for (int c = 0; c < 3; c++) x[c] = f->body->origin[c] + (double)f->body->records[vertex - f->first].x[c];
}
#endif
