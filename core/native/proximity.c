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

/* Return whether two sets of vertices are farther apart than the reach of the query along an axis. */
DM_INLINE int dm_are_apart(const dm_scene_state *s, const uint32_t *a, int m, const uint32_t *b, int n) {
    for (int c = 0; c < 3; c++) {
        double low = s->before[a[0]][c], high = low, lower = s->before[b[0]][c], higher = lower;
        for (int i = 1; i < m; i++) {
            double x = s->before[a[i]][c];
            low = x < low ? x : low, high = x > high ? x : high;
        }
        for (int i = 1; i < n; i++) {
            double x = s->before[b[i]][c];
            lower = x < lower ? x : lower, higher = x > higher ? x : higher;
        }
        if (lower - high > s->reach || low - higher > s->reach) return 1;
    }
    return 0;
}

static void dm_pair_edges(dm_scene_state *s, uint32_t i, uint32_t j) {
    for (int k = 0; k < 3; k++) {
        if (!(s->owns[i] >> (3 + k) & 1)) continue;
        uint32_t edge = s->edges_of[i][k], a = s->edges[edge][0], b = s->edges[edge][1];
        for (int l = 0; l < 3; l++) {
            if (!(s->owns[j] >> (3 + l) & 1)) continue;
            uint32_t other = s->edges_of[j][l], c = s->edges[other][0], d = s->edges[other][1];
            if (a != c && a != d && b != c && b != d && !dm_are_apart(s, s->edges[edge], 2, s->edges[other], 2))
                dm_let_wait(s, (dm_pair){{a, b, c, d}, {edge, other}, 2, 0});
        }
    }
}

/* Collect the pairs of the corners, edges and faces that triangles i and j represent, if they may be near. */
static void dm_pair_triangles(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j) {
    (void)f, (void)g;
    const uint32_t *a = s->corners[i], *b = s->corners[j];
    for (int k = 0; k < 3; k++) {
        if (s->owns[i] >> k & 1 && !dm_share_a_vertex(a + k, 1, b, 3) && !dm_are_apart(s, a + k, 1, b, 3))
            dm_let_wait(s, (dm_pair){{a[k], b[0], b[1], b[2]}, {j, 0}, 1, 0});
        if (s->owns[j] >> k & 1 && !dm_share_a_vertex(b + k, 1, a, 3) && !dm_are_apart(s, b + k, 1, a, 3))
            dm_let_wait(s, (dm_pair){{b[k], a[0], a[1], a[2]}, {i, 0}, 1, 0});
    }
    dm_pair_edges(s, i, j);
}
