/* Intersections of triangles. Source: studies/reference/crossing.py. */
#include "scene.h"

/* Return whether the segment ab passes through a triangle: its point in their plane is inside all three edges. */
static int dm_passes(const double *a, const double *b, const double *const *t) {
    double u[3], v[3], n[3], from[3], way[3], across[3];
    dm_minus(t[1], t[0], u), dm_minus(t[2], t[0], v), dm_cross3(u, v, n);
    dm_minus(a, t[0], from), dm_minus(b, a, way);
    double here = dm_inner3(from, n), slope = dm_inner3(way, n);
    if (slope == 0) return 0;
    double share = -here / slope;
    if (!(share >= 0 && share <= 1)) return 0;
    for (int k = 0; k < 3; k++) {
        double x[3], edge[3];
        for (int c = 0; c < 3; c++) x[c] = a[c] + share * way[c] - t[k][c];
        dm_minus(t[(k + 1) % 3], t[k], edge), dm_cross3(edge, x, across);
        if (dm_inner3(across, n) < 0) return 0;
    }
    return 1;
}

static int dm_triangles_cross(const dm_scene_state *s, const uint32_t *a, const uint32_t *b) {
    const double *x[3] = {s->before[a[0]], s->before[a[1]], s->before[a[2]]};
    const double *y[3] = {s->before[b[0]], s->before[b[1]], s->before[b[2]]};
    int found = 0;
    for (int k = 0; k < 3 && !found && !dm_share_a_vertex(a, 3, b, 3); k++)
        found = dm_passes(x[k], x[(k + 1) % 3], y) || dm_passes(y[k], y[(k + 1) % 3], x);
    return found;
}

static void dm_count_crossing(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j) {
    const uint32_t *a = s->corners[i], *b = s->corners[j];
    if (f == g && (dm_is_left_out(s, a, 3) || dm_is_left_out(s, b, 3))) return;
    dm_crossings *found = s->found;
    if (found->count++) return;
    found->surfaces[0] = f - s->surfaces, found->surfaces[1] = g - s->surfaces;
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) found->place[c] += (s->before[a[k]][c] + s->before[b[k]][c]) / 6;
}

/* Count the triangles of two leaves, or of one, that intersect, or leave them out. */
DM_INLINE void dm_find_crossings(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_node *a,
                                 const dm_node *b, int leave_out) {
    for (uint32_t i = a->start; i < a->end; i++) {
        double low[3], high[3];
        for (int c = 0; c < 3; c++) low[c] = s->boxes.low[c][i], high[c] = s->boxes.high[c][i];
        for (uint32_t near = dm_near_boxes(&s->boxes, b->start, b->end, low, high, 0); near; near &= near - 1) {
            uint32_t j = b->start + (uint32_t)__builtin_ctz(near);
            if ((a == b && i >= j) || !dm_triangles_cross(s, s->corners[i], s->corners[j])) continue;
            if (!leave_out) dm_count_crossing(s, f, g, i, j);
            for (int k = 0; leave_out && k < 3; k++) s->left_out[s->corners[i][k]] = s->left_out[s->corners[j][k]] = 1;
        }
    }
}

static void dm_count_crossings(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_node *a, const dm_node *b) {
    dm_find_crossings(s, f, g, a, b, 0);
}

static void dm_leave_out_crossings(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_node *a, const dm_node *b) {
    dm_find_crossings(s, f, g, a, b, 1);
}

/* Leave out of self-contact the vertices of faces that intersect others of their body now, and report the pairs. */
static void dm_leave_out(dm_scene_state *s, dm_crossings *left_out) {
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count && f->body; f++) {
        s->found = left_out++;
        memset(s->found, 0, sizeof *s->found);
        if (!f->self) continue;
        dm_note_surface(s, f), dm_fit_boxes(s, f);
        dm_visit_pairs(s, f, f, 0, dm_count_crossings), dm_visit_pairs(s, f, f, 0, dm_leave_out_crossings);
    }
}

/* Count the intersecting pairs of triangles, and set the place of the first. */
static void dm_scene_state_find(dm_scene_state *s, dm_crossings *found) {
    memset(found, 0, sizeof *found);
    s->found = found;
    for (int64_t k = 0; k < s->surface_count; k++)
        dm_note_surface(s, s->surfaces + k), dm_fit_boxes(s, s->surfaces + k);
    for (int64_t i = 0; i < s->surface_count; i++)
        for (int64_t j = i; j < s->surface_count; j++) {
            const dm_surface *f = s->surfaces + i, *g = s->surfaces + j;
            if (dm_may_touch(s, f, g)) dm_visit_pairs(s, f, g, 0, dm_count_crossings);
        }
    s->run_count = 0, s->due = 1; /* the places that all displacements are counted from have changed */
}
