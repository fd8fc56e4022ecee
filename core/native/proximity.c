/* Nearby pairs: a vertex and a face, or two edges. Source: studies/reference/proximity.py. */
#include "scene.h"

/* Add a vertex to the list `near`. */
static void dm_note_near(dm_scene_state *s, const dm_surface *f, uint32_t vertex) {
    s->near = dm_grown(s, s->near, s->near_count, &s->near_room, sizeof *s->near);
    s->tally = dm_grown(s, s->tally, s->near_count, &s->tally_room, sizeof *s->tally);
    if (!dm_has_room(s)) return;
    s->tally[s->near_count] = (dm_tally){0, 0};
    dm_neighbour *n = s->near + s->near_count;
    *n = (dm_neighbour){.vertex = vertex, .surface = (uint32_t)(f - s->surfaces)};
    if (f->body) n->body = f->body->records + (vertex - f->first), n->last = n->body->x;
    s->place[vertex] = s->near_count++;
}

/* Return how much an edge sticks out in a direction: 1 if the faces beside it slope away, 0 if they are flat or
 * rise, when pairs with faces do the work. On a rigid mesh, which may be coarse, one of the two may be flat: two
 * crossed bars touch only at such edges. */
static double dm_sharpness(const dm_scene_state *s, uint32_t edge, const double *point, const double *normal, int rigid) {
    double least = 1, most = 0, flat = 1;
    for (int k = 0; k < 2; k++) {
        if (s->across[edge][k] == DM_NO_VERTEX) continue;
        double arm[3];
        dm_minus(s->before[s->across[edge][k]], point, arm);
        double length = sqrt(dm_inner3(arm, arm));
        double slope = length > 0 ? -dm_inner3(arm, normal) / length : 0;
        double sharp = dm_share_of((slope - DM_FLAT) / (DM_SHARP - DM_FLAT));
        double rises = dm_share_of((slope + DM_SHARP) / (DM_SHARP - DM_FLAT));
        least = sharp < least ? sharp : least, flat = rises < flat ? rises : flat;
        most = sharp > most ? sharp : most;
    }
    if (s->across[edge][1] == DM_NO_VERTEX) most = 1;
    return rigid ? most * flat : least;
}

DM_INLINE const dm_surface *dm_surface_of(const dm_scene_state *s, const dm_pair *p, uint32_t corner) {
    return s->surfaces + s->near[p->at[corner]].surface;
}

/* Return the friction coefficient of one side of a pair, its vertices from `from` to `to`, by their weights. */
static double dm_friction_of(const dm_scene_state *s, const dm_pair *p, uint32_t from, uint32_t to, const double *w) {
    const dm_surface *f = dm_surface_of(s, p, from);
    if (!f->body) return f->friction;
    double mu = 0;
    for (uint32_t k = from; k < to; k++)
        mu += fabs(w[k]) * (double)f->body->friction[s->near[p->at[k]].vertex - f->first];
    return mu;
}

DM_INLINE int dm_share_a_vertex(const uint32_t *a, int m, const uint32_t *b, int n) {
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++)
            if (a[i] == b[j]) return 1;
    return 0;
}

static void dm_note_pair(dm_scene_state *s, const dm_pair *pair, double gap, const double *w, const double *between,
                         int inside);

/* Measure the waiting pairs, eight at once, and list those that are near. */
static void dm_note_waiting(dm_scene_state *s, uint32_t ones) {
    uint32_t count = s->waiting_count[ones - 1];
    const dm_pair *waiting = s->waiting[ones - 1];
    for (uint32_t i = 0; i < count && dm_has_room(s); i += DM_LANES) {
        uint32_t many = count - i < DM_LANES ? count - i : DM_LANES;
        const uint32_t *at[DM_LANES];
        for (uint32_t l = 0; l < DM_LANES; l++) at[l] = waiting[i + (l < many ? l : many - 1)].at;
        dm_wide_mask inside;
        dm_wide w[4];
        dm_wide3 way = dm_wide_measure((const double(*)[3])s->before, at, ones, w, &inside);
        dm_wide gap = dm_wide_root(dm_wide_dot(way, way));
        for (uint32_t l = 0; l < many && dm_has_room(s); l++)
            if (gap[l] < s->reach)
                dm_note_pair(s, waiting + i + l, gap[l], (double[]){w[0][l], w[1][l], w[2][l], w[3][l]},
                             (double[]){way.x[l], way.y[l], way.z[l]}, inside[l] != 0);
    }
    s->waiting_count[ones - 1] = 0;
}

DM_INLINE int dm_is_left_out(const dm_scene_state *s, const uint32_t *at, int count) {
    int found = 0;
    for (int k = 0; k < count; k++) found |= s->left_out[at[k]];
    return found;
}

DM_INLINE void dm_let_wait(dm_scene_state *s, dm_pair pair) {
    uint32_t k = pair.ones - 1;
    if (s->both[0] == s->both[1] && dm_is_left_out(s, pair.at, 4)) return;
    s->waiting[k][s->waiting_count[k]++] = pair;
    if (s->waiting_count[k] == DM_WAITING) dm_note_waiting(s, pair.ones);
}

/* Pair the vertices that belong to the triangles of one leaf with the faces of another, or of the same one. */
static void dm_pair_vertices(dm_scene_state *s, const dm_node *a, const dm_node *b) {
    for (uint32_t k = s->vertex_start[a->start]; k < s->vertex_start[a->end]; k++) {
        const double *x = s->before[s->listed[k]];
        if (dm_boxes_apart(x, x, b->low, b->high) > s->reach) continue;
        for (uint32_t near = dm_near_boxes(&s->boxes, b->start, b->end, x, x, s->reach); near; near &= near - 1) {
            uint32_t face = b->start + (uint32_t)__builtin_ctz(near);
            const uint32_t *at = s->corners[face];
            if (!dm_share_a_vertex(s->listed + k, 1, at, 3))
                dm_let_wait(s, (dm_pair){.at = {s->listed[k], at[0], at[1], at[2]}, .parts = {face}, .ones = 1});
        }
    }
}

/* Pair an edge with those after `from` that belong to the triangles of a leaf. */
static void dm_pair_edge(dm_scene_state *s, uint32_t edge, uint32_t from, uint32_t end) {
    const uint32_t *own = s->edges[edge];
    double low[3], high[3];
    for (int c = 0; c < 3; c++) low[c] = s->edge_boxes.low[c][edge], high[c] = s->edge_boxes.high[c][edge];
    for (; from < end; from += DM_LANES)
        for (uint32_t near = dm_near_boxes(&s->edge_boxes, from, end, low, high, s->reach); near; near &= near - 1) {
            uint32_t other = from + (uint32_t)__builtin_ctz(near);
            const uint32_t *at = s->edges[other];
            if (!dm_share_a_vertex(own, 2, at, 2))
                dm_let_wait(s, (dm_pair){.at = {own[0], own[1], at[0], at[1]}, .parts = {edge, other}, .ones = 2});
        }
}

/* Pair the edges that belong to the triangles of two leaves, or of one. */
static void dm_pair_edges(dm_scene_state *s, const dm_node *a, const dm_node *b) {
    uint32_t end = s->edge_start[a->end];
    for (uint32_t from = s->edge_start[a->start]; from < end; from += DM_LANES)
        for (uint32_t near = dm_near_boxes(&s->edge_boxes, from, end, b->low, b->high, s->reach); near; near &= near - 1) {
            uint32_t edge = from + (uint32_t)__builtin_ctz(near);
            dm_pair_edge(s, edge, a == b ? edge + 1 : s->edge_start[b->start], s->edge_start[b->end]);
        }
}

/* Collect the pairs of the vertices, edges and faces of two leaves, or of one, that may be near. */
static void dm_pair_leaves(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_node *a, const dm_node *b) {
    (void)f, (void)g;
    dm_pair_vertices(s, a, b), dm_pair_edges(s, a, b);
    if (a != b) dm_pair_vertices(s, b, a);
}
