/* Who is near whom: a vertex and a face, or two edges. Source: core/body/proximity.py. */
#include "scene.h"

DM_INLINE void dm_minus(const double *a, const double *b, double *r) {
    for (int c = 0; c < 3; c++) r[c] = a[c] - b[c];
}

/* Find the weights of the point of a triangle nearest to p.
 * Source: Ericson, Real-Time Collision Detection, 5.1.5. */
static void dm_weights_on_face(const double *p, const double *a, const double *b, const double *c, double *w) {
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    dm_minus(b, a, ab), dm_minus(c, a, ac), dm_minus(p, a, ap), dm_minus(p, b, bp), dm_minus(p, c, cp);
    double d1 = dm_inner3(ab, ap), d2 = dm_inner3(ac, ap), d3 = dm_inner3(ab, bp), d4 = dm_inner3(ac, bp);
    double d5 = dm_inner3(ab, cp), d6 = dm_inner3(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, v, u;
    if (d1 <= 0 && d2 <= 0) v = 0, u = 0;
    else if (d3 >= 0 && d4 <= d3) v = 1, u = 0;
    else if (d6 >= 0 && d5 <= d6) v = 0, u = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0) v = d1 / (d1 - d3), u = 0;
    else if (vb <= 0 && d2 >= 0 && d6 <= 0) v = 0, u = d2 / (d2 - d6);
    else if (va <= 0 && d4 >= d3 && d5 >= d6) u = (d4 - d3) / ((d4 - d3) + (d5 - d6)), v = 1 - u;
    else v = vb / (va + vb + vc), u = vc / (va + vb + vc);
    w[0] = 1 - v - u, w[1] = v, w[2] = u;
}

DM_INLINE double dm_share_of(double a) { return a < 0 ? 0 : a > 1 ? 1 : a; }

/* Find how far along the segments ab and cd their nearest points lie. Source: Ericson, 5.1.9. */
static void dm_shares_on_edges(const double *a, const double *b, const double *c, const double *d, double *along) {
    double u[3], v[3], r[3];
    dm_minus(b, a, u), dm_minus(d, c, v), dm_minus(a, c, r);
    double uu = dm_inner3(u, u), vv = dm_inner3(v, v), uv = dm_inner3(u, v), ur = dm_inner3(u, r), vr = dm_inner3(v, r);
    double spread = uu * vv - uv * uv;
    double s = spread > 1e-12 * uu * vv ? dm_share_of((uv * vr - ur * vv) / spread) : 0;
    double t = vv > 0 ? (uv * s + vr) / vv : 0;
    if (t < 0 || t > 1) t = dm_share_of(t), s = uu > 0 ? dm_share_of((uv * t - ur) / uu) : 0;
    along[0] = s, along[1] = t;
}

/* Find the signed weights of the four vertices of a pair at their nearest points, the vector between these, and
 * return its length. */
static double dm_measure_pair(const double *const *x, uint32_t ones, double *w, double *between) {
    if (ones == 1) {
        double on[3];
        dm_weights_on_face(x[0], x[1], x[2], x[3], on);
        w[0] = 1, w[1] = -on[0], w[2] = -on[1], w[3] = -on[2];
    } else {
        double along[2];
        dm_shares_on_edges(x[0], x[1], x[2], x[3], along);
        w[0] = 1 - along[0], w[1] = along[0], w[2] = along[1] - 1, w[3] = -along[1];
    }
    for (int c = 0; c < 3; c++) between[c] = w[0] * x[0][c] + w[1] * x[1][c] + w[2] * x[2][c] + w[3] * x[3][c];
    return sqrt(dm_inner3(between, between));
}

/* Put a vertex into the list of what is near; return where. */
static uint32_t dm_note_near(dm_scene_state *s, const dm_surface *f, uint32_t vertex) {
    if (s->place[vertex] != DM_NO_VERTEX) return s->place[vertex];
    s->near = dm_grown(s, s->near, s->near_count, &s->near_room, sizeof *s->near);
    if (!dm_has_room(s)) return 0;
    dm_neighbour *n = s->near + s->near_count;
    *n = (dm_neighbour){.vertex = vertex, .surface = (uint32_t)(f - s->surfaces)};
    return s->place[vertex] = s->near_count++;
}

/* How much an edge sticks out in a direction: 1 where the faces beside it fall away from there, 0 where they are flat
 * or rise, and faces do what is to be done. */
static double dm_sharpness(const dm_scene_state *s, uint32_t edge, const double *point, const double *normal) {
    double least = 1;
    for (int k = 0; k < 2; k++) {
        if (s->across[edge][k] == DM_NO_VERTEX) continue;
        double arm[3];
        dm_minus(s->before[s->across[edge][k]], point, arm);
        double length = sqrt(dm_inner3(arm, arm));
        double slope = length > 0 ? -dm_inner3(arm, normal) / length : 0;
        double sharp = dm_share_of((slope - DM_FLAT) / (DM_SHARP - DM_FLAT));
        least = sharp < least ? sharp : least;
    }
    return least;
}

/* The friction of one side of a pair, at its vertices `at` with their weights. */
static double dm_friction_of(const dm_surface *f, const uint32_t *at, const double *w, uint32_t count) {
    if (!f->body) return f->friction;
    double mu = 0;
    for (uint32_t k = 0; k < count; k++) mu += fabs(w[k]) * (double)f->body->friction[at[k] - f->first];
    return mu;
}

/* Note a pair that is near, with the plane between its two. parts: the triangle of the face, or both edges. */
static void dm_note_pair(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const uint32_t *at, uint32_t ones,
                         const uint32_t *parts) {
    const double *x[4] = {s->before[at[0]], s->before[at[1]], s->before[at[2]], s->before[at[3]]};
    double w[4], between[3], gap = dm_measure_pair(x, ones, w, between);
    if (!(gap < s->reach)) return;
    s->gap = gap < s->gap ? gap : s->gap;
    s->pairs = dm_grown(s, s->pairs, s->pair_count, &s->pair_room, sizeof *s->pairs);
    dm_pair p = {.ones = ones, .gap = gap, .touch = f->offset + g->offset, .weight = 1, .triangle = parts[0]};
    for (uint32_t k = 0; k < 4; k++) p.at[k] = dm_note_near(s, k < ones ? f : g, at[k]);
    if (!dm_has_room(s)) return;
    p.surface[0] = (uint32_t)(f - s->surfaces), p.surface[1] = (uint32_t)(g - s->surfaces);
    for (int c = 0; c < 3; c++) {
        p.normal[c] = gap > 0 ? between[c] / gap : 0;
        double other = 0;
        for (uint32_t k = ones; k < 4; k++) other -= w[k] * x[k][c];
        p.level += p.normal[c] * (other + between[c] / 2);
    }
    double closest = f->closest > g->closest ? f->closest : g->closest;
    p.keep = gap > closest ? closest / 2 + (1 - DM_BOUND) * (gap - closest) / 2 : gap / 2 * (1 - 1e-6);
    if (f == g) {
        const double *rest[4] = {s->rest[at[0]], s->rest[at[1]], s->rest[at[2]], s->rest[at[3]]};
        double was[4], apart[3], far = DM_SELF_SHARE * dm_measure_pair(rest, ones, was, apart);
        p.touch = far < p.touch ? far : p.touch;
    }
    if (ones == 2) {
        double point[3], other[3], back[3];
        int inside = w[0] > 0 && w[1] > 0 && w[2] < 0 && w[3] < 0;
        for (int c = 0; c < 3; c++) {
            point[c] = w[0] * x[0][c] + w[1] * x[1][c], other[c] = -w[2] * x[2][c] - w[3] * x[3][c];
            back[c] = -p.normal[c];
        }
        p.weight = inside ? dm_sharpness(s, parts[0], point, back) * dm_sharpness(s, parts[1], other, p.normal) : 0;
    }
    p.friction = sqrt(dm_friction_of(f, at, w, ones) * dm_friction_of(g, at + ones, w + ones, 4 - ones));
    s->pairs[s->pair_count++] = p;
}

DM_INLINE int dm_share_a_vertex(const uint32_t *a, int m, const uint32_t *b, int n) {
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++)
            if (a[i] == b[j]) return 1;
    return 0;
}

static int dm_points_apart(const dm_scene_state *s, const uint32_t *a, int m, const uint32_t *b, int n) {
    double low[3], high[3], lower[3], higher[3];
    dm_bound_points((const double(*)[3])s->before, a, m, low, high);
    dm_bound_points((const double(*)[3])s->before, b, n, lower, higher);
    return dm_boxes_apart(low, high, lower, higher) >= s->reach;
}

/* Note what of triangle i, and of what it stands for, is near triangle j. */
static void dm_note_triangles(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j) {
    const uint32_t *a = s->corners[i], *b = s->corners[j];
    if (dm_points_apart(s, a, 3, b, 3)) return;
    for (int k = 0; k < 3; k++) {
        if (s->owns[i] >> k & 1 && !dm_share_a_vertex(a + k, 1, b, 3) && !dm_points_apart(s, a + k, 1, b, 3))
            dm_note_pair(s, f, g, (uint32_t[4]){a[k], b[0], b[1], b[2]}, 1, &j);
        if (s->owns[j] >> k & 1 && !dm_share_a_vertex(b + k, 1, a, 3) && !dm_points_apart(s, b + k, 1, a, 3))
            dm_note_pair(s, g, f, (uint32_t[4]){b[k], a[0], a[1], a[2]}, 1, &i);
    }
    for (int k = 0; k < 9; k++) {
        if (!(s->owns[i] >> (3 + k / 3) & 1 && s->owns[j] >> (3 + k % 3) & 1)) continue;
        uint32_t pair[2] = {s->edges_of[i][k / 3], s->edges_of[j][k % 3]};
        const uint32_t *e = s->edges[pair[0]], *h = s->edges[pair[1]];
        if (!dm_share_a_vertex(e, 2, h, 2) && !dm_points_apart(s, e, 2, h, 2))
            dm_note_pair(s, f, g, (uint32_t[4]){e[0], e[1], h[0], h[1]}, 2, pair);
    }
}
