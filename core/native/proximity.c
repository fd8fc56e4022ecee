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

/* The friction of the vertices `from` up to `to` of a pair, with their weights. */
static double dm_friction_of(const dm_scene_state *s, const dm_pair *p, uint32_t from, uint32_t to, const double *w) {
    const dm_surface *f = s->surfaces + p->surface[from > 0];
    if (!f->body) return f->friction;
    double mu = 0;
    for (uint32_t k = from; k < to; k++)
        mu += fabs(w[k]) * (double)f->body->friction[s->near[p->at[k]].vertex - f->first];
    return mu;
}

DM_INLINE double dm_approach(const dm_scene_state *s, const dm_pair *p, uint32_t from, uint32_t to, const double *w) {
    double speed = 0;
    for (uint32_t k = from; k < to; k++) {
        const dm_neighbour *n = s->near + p->at[k];
        const dm_surface *f = s->surfaces + n->surface;
        double v[3];
        if (f->body) dm_velocity(f->body, n->vertex - f->first, v);
        else memcpy(v, s->rate[n->vertex], sizeof v);
        speed -= w[k] * dm_inner3(p->normal, v);
    }
    return speed > 0 ? speed : 0;
}

/* Set the plane between the nearest points of a pair at positions x, and how near each may come to it: the faster it
 * comes towards the other, the larger its part of the distance. */
static void dm_set_plane(const dm_scene_state *s, dm_pair *p, const double *const *x, const double *w,
                         const double *between, double gap) {
    double a = s->surfaces[p->surface[0]].closest, b = s->surfaces[p->surface[1]].closest, closest = a > b ? a : b;
    for (int c = 0; c < 3; c++) p->normal[c] = gap > 0 ? between[c] / gap : 0;
    double u = dm_approach(s, p, 0, p->ones, w) + DM_SLOW, v = dm_approach(s, p, p->ones, 4, w) + DM_SLOW;
    double share[2] = {u / (u + v), 0}, most = 1 - DM_LEAST_SHARE;
    if (gap <= closest) share[0] = 0.5;
    share[0] = share[0] < DM_LEAST_SHARE ? DM_LEAST_SHARE : share[0] > most ? most : share[0];
    share[1] = 1 - share[0], p->level = 0;
    for (int c = 0; c < 3; c++) {
        double other = 0;
        for (uint32_t k = p->ones; k < 4; k++) other -= w[k] * x[k][c];
        p->level += p->normal[c] * (other + share[1] * between[c]);
    }
    for (int k = 0; k < 2; k++) {
        double whole = share[k] * gap, least = whole / 2 < closest / 2 ? whole / 2 : closest / 2;
        p->keep[k] = gap > closest ? least + (1 - DM_BOUND) * (whole - least) : whole * (1 - 1e-6);
        p->way[k] = whole - p->keep[k];
    }
}

/* Note a pair, where it is near, with the plane between its two. */
static void dm_note_pair(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_close *close) {
    const uint32_t *at = close->at, *parts = close->parts, ones = close->ones;
    const double *x[4] = {s->before[at[0]], s->before[at[1]], s->before[at[2]], s->before[at[3]]};
    double w[4], between[3], gap = dm_measure_pair(x, ones, w, between);
    if (!(gap < s->reach)) return;
    if (close->swapped) {
        const dm_surface *other = f;
        f = g, g = other;
    }
    s->gap = gap < s->gap ? gap : s->gap;
    s->pairs = dm_grown(s, s->pairs, s->pair_count, &s->pair_room, sizeof *s->pairs);
    dm_pair p = {.ones = ones, .gap = gap, .touch = f->offset + g->offset, .weight = 1, .triangle = parts[0]};
    for (uint32_t k = 0; k < 4; k++) p.at[k] = dm_note_near(s, k < ones ? f : g, at[k]);
    if (!dm_has_room(s)) return;
    p.surface[0] = (uint32_t)(f - s->surfaces), p.surface[1] = (uint32_t)(g - s->surfaces);
    dm_set_plane(s, &p, x, w, between, gap);
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
    s->pairs[s->pair_count++] = p;
}

DM_INLINE int dm_share_a_vertex(const uint32_t *a, int m, const uint32_t *b, int n) {
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++)
            if (a[i] == b[j]) return 1;
    return 0;
}

/* Keep a vertex and a face, or two edges, that are close. */
static void dm_keep_close(dm_scene_state *s, dm_close close) {
    const uint32_t *at = close.at;
    const double *x[4] = {s->before[at[0]], s->before[at[1]], s->before[at[2]], s->before[at[3]]};
    double w[4], between[3];
    if (!(dm_measure_pair(x, close.ones, w, between) < s->wide)) return;
    s->close = dm_grown(s, s->close, s->close_count, &s->close_room, sizeof *s->close);
    if (dm_has_room(s)) s->close[s->close_count++] = close;
}

/* Is a point, or the ball round an edge, farther than a search looks from the ball round a triangle or another edge? */
DM_INLINE int dm_balls_apart(const dm_scene_state *s, const double *a, double r, const double *b, double q) {
    double way[3], most = s->wide + r + q;
    dm_minus(a, b, way);
    return dm_inner3(way, way) >= most * most;
}

static void dm_keep_edges(dm_scene_state *s, uint32_t i, uint32_t j) {
    for (int k = 0; k < 3; k++) {
        uint32_t pair[2] = {s->edges_of[i][k]};
        const uint32_t *e = s->edges[pair[0]];
        const double *ball = s->edge_balls[pair[0]];
        if (!(s->owns[i] >> (3 + k) & 1)) continue;
        if (dm_balls_apart(s, ball, ball[3], s->balls[j], s->balls[j][3])) continue;
        for (int l = 0; l < 3; l++) {
            if (!(s->owns[j] >> (3 + l) & 1)) continue;
            const uint32_t *h = s->edges[pair[1] = s->edges_of[j][l]];
            const double *other = s->edge_balls[pair[1]];
            if (!dm_balls_apart(s, ball, ball[3], other, other[3]) && !dm_share_a_vertex(e, 2, h, 2))
                dm_keep_close(s, (dm_close){{e[0], e[1], h[0], h[1]}, 2, {pair[0], pair[1]}, 0});
        }
    }
}

/* Keep what of triangle i, and of what it stands for, is close to triangle j. */
static void dm_keep_triangles(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j) {
    const uint32_t *a = s->corners[i], *b = s->corners[j];
    const double *p = s->balls[i], *q = s->balls[j];
    if (dm_balls_apart(s, p, p[3], q, q[3])) return;
    for (int k = 0; k < 3; k++) {
        if (s->owns[i] >> k & 1 && !dm_share_a_vertex(a + k, 1, b, 3) && !dm_balls_apart(s, s->before[a[k]], 0, q, q[3]))
            dm_keep_close(s, (dm_close){{a[k], b[0], b[1], b[2]}, 1, {j, 0}, 0});
        if (s->owns[j] >> k & 1 && !dm_share_a_vertex(b + k, 1, a, 3) && !dm_balls_apart(s, s->before[b[k]], 0, p, p[3]))
            dm_keep_close(s, (dm_close){{b[k], a[0], a[1], a[2]}, 1, {i, 0}, f != g});
    }
    dm_keep_edges(s, i, j);
}
