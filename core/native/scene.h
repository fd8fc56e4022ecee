/* Bodies and colliders that meet: what a scene keeps between two queries of who is near whom.
 *
 * The guarantee. A query finds every pair of a vertex and a face, and of two edges, nearer than `reach`. Between their
 * nearest points stands a plane; until the next query each stays on its side of it. Pairs that are not found are
 * farther apart than `reach`, and no vertex goes farther than half of that. So nothing passes through anything,
 * whatever the forces. A plane beside a collider or a prop moves with it: what is rigid goes its way as a whole, and the
 * skin is kept ahead of it. Where skin cannot get away, the rigid one goes only so far as it can.
 * Source: the displacement bounds of offset geometric contact (Chen et al. 2025), with planes in place of spheres, so
 * that what slides along or goes away is not stopped.
 */
#ifndef DM_SCENE_H
#define DM_SCENE_H
#include "falling.h"
#include <stddef.h>

enum { DM_WAITING = DM_LANES * DM_LANES }; /* pairs that a query measures together */

typedef struct { /* the surface of a body, or a collider */
    dm_state *body; /* null: a collider */
    dm_falling *prop; /* null: a soft body, or a collider that is led */
    uint32_t first, count, first_triangle, triangle_count, first_edge, edge_count, first_node, node_count;
    double offset, edge, closest, friction;
    double low[3], high[3]; /* where it was at the last query */
    double slack, stale;    /* [m] how far any vertex may go since the query, and after what way the next one is due */
    double gone, way;       /* [m] no vertex has gone farther since the query; nor in this substep */
    double jumped, met_way; /* [m] the farthest that one was put between two calls; and that contact let one go */
    double share, tried;    /* of its way in this substep, that what is rigid goes, and that it tries at first */
    double pace, pace_now;  /* of the way that is left, that what is led goes in this tick, and in this substep */
    double late, place[3];  /* [m] how far what is led is behind its way, and where the skin could not get away last */
    double origin[3];       /* of the body at the last query */
    double impulse[3];      /* that others gave it in a call [N s] */
    double moment[3];       /* of that about the origin [N m s] */
    double load, spin_beside[3];        /* of a substep: what presses it [N s]; sum of that by how fast it turns */
    double resisting[3], moment_of[3];  /* that resist its rolling: kept from substep to substep, and in the next [N m] */
    uint64_t changes;       /* of the body, at the last query */
    uint8_t self, moving, kept, touched; /* moving: a collider; kept: awake by something that moves */
    uint8_t fitted, stuck, pressed, torn; /* its boxes are where it is; skin cannot get out of its way; it wakes in the next
                                          * substep; it was let go of in this call */
} dm_surface;

typedef struct { /* a box with the triangles in it; its first child follows it, its other one is `next` */
    double low[3], high[3];
    uint32_t start, end, next;
} dm_node;

typedef struct { /* a vertex and a face, or two edges, that are nearer than `reach` at the query */
    uint32_t at[4], parts[2]; /* vertex and corners, or ends of both edges: in the list of what is near; the triangle, or both edges */
    uint32_t ones, rigid;   /* how many lie on the side of the normal, 1 or 2; bits: the first is rigid, the second is */
} dm_pair;

typedef struct { /* the pairs of two surfaces: up to this end */
    uint32_t first, second, end;
    double gone;            /* [m] both together at most since the query */
} dm_run;

typedef struct { /* between the two of a pair: each soft side keeps at least so far from normal . x = level */
    double normal[3], level, keep;
    double next;            /* when both have gone so far [m], it is looked at again */
} dm_plane;

typedef struct { /* a pair that may touch */
    uint32_t pair;
    double gap, touch, weight; /* at the query, and at which they touch [m]; of what they do: fades where edges are flat */
} dm_candidate;

typedef struct { /* with its vertices in the order of the caller, each side from the lowest */
    uint32_t number[4], ones;
    dm_candidate own;
} dm_ordered;

typedef struct { /* of a vertex that is near something, its pairs: how many, and where their list ends */
    uint32_t count, end;
} dm_tally;

typedef struct { /* two that may touch: their nearest points at the last look */
    uint32_t at[4], surface[2];
    double weight[4], normal[3], point[3];           /* point: where they meet [m] */
    double gap, touch, give, friction, share;        /* distances: there, and at which they touch [m]; give: 1 / mass */
} dm_meeting;

typedef struct { /* eight meetings that have no vertex in common, and what passes between them */
    uint32_t at[4][DM_LANES]; /* byte offsets into `moving`; an empty lane has no weight */
    dm_lanes weight[4];
    dm_vec3 normal, drag, sum;               /* sum: of the impulses since the last look [N s] */
    dm_vec3 anchor, back;                    /* where on its way it stuck last [m]; how fast it is to go back there [m/s] */
    dm_lanes gap, begin, touch;              /* distances: at the look, as the substep began, and at which they touch [m] */
    dm_lanes least, push, friction, give, by; /* least: speed apart [m/s]; give: 1 / mass; by: share of what it does over it */
    dm_mask active;                          /* in this substep */
} dm_batch;

typedef struct { /* of a batch, what a substep does not ask for: where they meet [m], whose they are, how many lanes */
    dm_wide point[3];
    uint32_t surface[DM_LANES][2], count;
} dm_batch_sides;

typedef struct { /* a vertex that is near something: a line of the cache */
    dm_quad from, last; /* where it is at the last look and before this substep, from the origin of its body */
    dm_record *body;    /* null: of a collider */
    uint32_t vertex, surface, held, batch; /* held: it is in that list; batch: after the last that it is in */
} dm_neighbour;

typedef struct dm_scene_state {
    dm_surface *surfaces;
    int64_t surface_count, vertex_count, triangle_count, edge_count;
    double (*before)[3], (*rest)[3];         /* where vertices were at the last query; at rest; */
    double (*here)[3], (*aim)[3], (*rate)[3]; /* of colliders: where they are, are to be, and how fast */
    double (*was)[3];                        /* and were before this substep */
    double (*given)[3];                      /* impulse that each vertex got in a call [N s] */
    uint32_t (*corners)[3], (*edges_of)[3], (*edges)[2], (*across)[2]; /* across: of the faces beside an edge */
    uint8_t *left_out; /* of self contact: vertices of faces that passed through others of the body at the start */
    uint8_t *owns; /* bits: a triangle stands for these of its corners, and of its edges */
    uint32_t *ring_start, *ring, *place; /* neighbours of a vertex; where it is in the list of what is near */
    dm_node *nodes;
    dm_neighbour *near;
    uint32_t near_count, near_room, pair_count, pair_room, *pairs_of, pairs_of_room;
    uint32_t candidate_count, candidate_room; /* pairs that may touch before the next query */
    dm_candidate *candidates;
    uint32_t sorted_room, *bins; /* room to put them in order */
    dm_ordered *sorted;
    uint32_t support_count, standing, support_room, prop_count;
    dm_support *supports; /* of the pairs without a soft body; in a substep, with those on the ground: `standing` */
    uint32_t batch_count, batch_room, sides_room, moving_room;
    dm_batch *batches; /* of the meetings, in the order in which they are taken */
    dm_batch_sides *sides;
    dm_record *moving; /* what is near: its way since the look, then by how much it is brought apart; its speed, 1 / mass */
    uint32_t held_count, held_room, *held;    /* near ones that are beyond a plane in this substep */
    uint32_t spent_count, spent_room, *spent; /* pairs whose planes have little left */
    uint32_t met_count, met_room, *met; /* near ones that meet something since the last look */
    uint32_t *number;                    /* of vertices, in the order of the caller */
    int looks;                           /* normals must be computed again */
    int backwards;                       /* bodies are stepped from the last to the first: it is still in the cache */
    int wakes;                           /* what is awake may have come near what sleeps */
    int due;       /* a query is */
    dm_pair waiting[2][DM_WAITING]; /* faces, and edges, that a query has not measured yet */
    uint32_t waiting_count[2], run_count, run_room, released_count, released_room;
    uint32_t (*released)[2]; /* surfaces of which one was torn past the other: they meet again when they are apart */
    dm_run *runs;
    dm_pair *pairs;
    dm_plane *planes; /* of the pairs */
    dm_tally *tally;  /* of what is near */
    double (*there)[3]; /* where that was at the last look */
    uint32_t tally_room, plane_room, there_room;
    double touch, edge, tick, dt, substeps, reach, least_reach, gap, approach, fastest, fastest_rigid;
    int32_t code;
    dm_scene_frame *out;
    dm_crossings *found;
    dm_surface *both[2]; /* that are searched now */
} dm_scene_state;

/* Make room for one more; null where there is none, and the scene knows. */
static void *dm_grown(dm_scene_state *s, void *array, uint32_t count, uint32_t *size, size_t each) {
    if (count < *size) return array;
    uint32_t wanted = *size ? 2 * *size : 256;
    void *made = dm_alloc(wanted, each);
    if (!made) return s->code = DM_MEMORY, array;
    if (array) memcpy(made, array, count * each);
    dm_free(array), *size = wanted;
    return made;
}

DM_INLINE int dm_has_room(const dm_scene_state *s) { return s->code == DM_OK; }

DM_INLINE int dm_sleeps(const dm_surface *f) { return f->body ? f->body->asleep : f->prop && f->prop->asleep; }

DM_INLINE double dm_skin_of(const dm_surface *f) { return f->prop ? f->prop->skin : 0; }

/* The distance at which two surfaces touch. */
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
