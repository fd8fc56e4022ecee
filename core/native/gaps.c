/* Distances between a vertex and a face, or between two edges: for eight pairs at once, or for one. Source:
 * studies/reference/proximity.py. */
#include "scene.h"

DM_INLINE void dm_minus(const double *a, const double *b, double *r) {
    for (int c = 0; c < 3; c++) r[c] = a[c] - b[c];
}

DM_INLINE double dm_share_of(double a) { return a < 0 ? 0 : a > 1 ? 1 : a; }

typedef int64_t dm_wide_mask __attribute__((vector_size(DM_LANES * sizeof(double))));

DM_INLINE dm_wide dm_wide_of(double a) { return (dm_wide){a, a, a, a, a, a, a, a}; }

DM_INLINE dm_wide dm_pick(dm_wide_mask which, dm_wide yes, dm_wide no) {
    return (dm_wide)((which & (dm_wide_mask)yes) | (~which & (dm_wide_mask)no));
}

DM_INLINE dm_wide dm_wide_root(dm_wide a) {
#if defined(__clang__)
    return __builtin_elementwise_sqrt(a);
#else
    for (int l = 0; l < DM_LANES; l++) a[l] = sqrt(a[l]);
    return a;
#endif
}

DM_INLINE dm_wide3 dm_wide_minus(dm_wide3 a, dm_wide3 b) { return (dm_wide3){a.x - b.x, a.y - b.y, a.z - b.z}; }

DM_INLINE dm_wide dm_wide_dot(dm_wide3 a, dm_wide3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

DM_INLINE dm_wide3 dm_wide_plus(dm_wide3 a, dm_wide by, dm_wide3 b) {
    return (dm_wide3){a.x + by * b.x, a.y + by * b.y, a.z + by * b.z};
}

DM_INLINE dm_wide dm_wide_share(dm_wide a) {
    dm_wide none = dm_wide_of(0), one = dm_wide_of(1);
    return dm_pick((dm_wide_mask)(a < none), none, dm_pick((dm_wide_mask)(a > one), one, a));
}

/* Return the vectors to p from the nearest points of triangles, and set their weights. Source: Ericson, Real-Time
 * Collision Detection, 5.1.5. */
DM_INLINE dm_wide3 dm_wide_off_face(dm_wide3 p, dm_wide3 a, dm_wide3 b, dm_wide3 c, dm_wide *w) {
    dm_wide3 ab = dm_wide_minus(b, a), ac = dm_wide_minus(c, a);
    dm_wide3 ap = dm_wide_minus(p, a), bp = dm_wide_minus(p, b), cp = dm_wide_minus(p, c);
    dm_wide d1 = dm_wide_dot(ab, ap), d2 = dm_wide_dot(ac, ap), d3 = dm_wide_dot(ab, bp), d4 = dm_wide_dot(ac, bp);
    dm_wide d5 = dm_wide_dot(ab, cp), d6 = dm_wide_dot(ac, cp), none = dm_wide_of(0), one = dm_wide_of(1);
    dm_wide va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    dm_wide v = vb / (va + vb + vc), u = vc / (va + vb + vc), on = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    dm_wide_mask bc = (dm_wide_mask)(va <= none) & (dm_wide_mask)(d4 >= d3) & (dm_wide_mask)(d5 >= d6);
    dm_wide_mask ca = (dm_wide_mask)(vb <= none) & (dm_wide_mask)(d2 >= none) & (dm_wide_mask)(d6 <= none);
    dm_wide_mask by = (dm_wide_mask)(vc <= none) & (dm_wide_mask)(d1 >= none) & (dm_wide_mask)(d3 <= none);
    dm_wide_mask at_c = (dm_wide_mask)(d6 >= none) & (dm_wide_mask)(d5 <= d6);
    dm_wide_mask at_b = (dm_wide_mask)(d3 >= none) & (dm_wide_mask)(d4 <= d3);
    dm_wide_mask at_a = (dm_wide_mask)(d1 <= none) & (dm_wide_mask)(d2 <= none);
    v = dm_pick(bc, one - on, v), u = dm_pick(bc, on, u);
    v = dm_pick(ca, none, v), u = dm_pick(ca, d2 / (d2 - d6), u);
    v = dm_pick(by, d1 / (d1 - d3), v), u = dm_pick(by, none, u);
    v = dm_pick(at_c, none, v), u = dm_pick(at_c, one, u);
    v = dm_pick(at_b, one, v), u = dm_pick(at_b, none, u);
    v = dm_pick(at_a, none, v), u = dm_pick(at_a, none, u);
    w[0] = one, w[1] = -(one - v - u), w[2] = -v, w[3] = -u;
    return dm_wide_plus(dm_wide_plus(dm_wide_plus(p, w[1], a), w[2], b), w[3], c);
}

/* Return the vectors from the nearest points of segments cd to those of segments ab, and set their weights; inside:
 * whether both points lie between the ends. Source: Ericson, 5.1.9. */
DM_INLINE dm_wide3 dm_wide_off_edge(dm_wide3 a, dm_wide3 b, dm_wide3 c, dm_wide3 d, dm_wide *w, dm_wide_mask *inside) {
    dm_wide3 u = dm_wide_minus(b, a), v = dm_wide_minus(d, c), r = dm_wide_minus(a, c);
    dm_wide uu = dm_wide_dot(u, u), vv = dm_wide_dot(v, v), uv = dm_wide_dot(u, v), none = dm_wide_of(0);
    dm_wide ur = dm_wide_dot(u, r), vr = dm_wide_dot(v, r), spread = uu * vv - uv * uv, one = dm_wide_of(1);
    dm_wide s = dm_wide_share((uv * vr - ur * vv) / spread);
    s = dm_pick((dm_wide_mask)(spread > dm_wide_of(1e-12) * uu * vv), s, none);
    dm_wide t = dm_pick((dm_wide_mask)(vv > none), (uv * s + vr) / vv, none), in = dm_wide_share(t);
    dm_wide back = dm_pick((dm_wide_mask)(uu > none), dm_wide_share((uv * in - ur) / uu), none);
    s = dm_pick((dm_wide_mask)(t != in), back, s), t = in;
    *inside = (dm_wide_mask)(s > none) & (dm_wide_mask)(s < one) & (dm_wide_mask)(t > none) & (dm_wide_mask)(t < one);
    w[0] = one - s, w[1] = s, w[2] = t - one, w[3] = -t;
    dm_wide3 from = dm_wide_plus(dm_wide_plus((dm_wide3){none, none, none}, w[0], a), w[1], b);
    return dm_wide_plus(dm_wide_plus(from, w[2], c), w[3], d);
}

/* written out: a loop over lanes would go through memory */
DM_INLINE dm_wide3 dm_wide_corner(const double (*x)[3], const uint32_t *const *at, int corner) {
    const double *a = x[at[0][corner]], *b = x[at[1][corner]], *c = x[at[2][corner]], *d = x[at[3][corner]];
    const double *e = x[at[4][corner]], *f = x[at[5][corner]], *g = x[at[6][corner]], *h = x[at[7][corner]];
    return (dm_wide3){{a[0], b[0], c[0], d[0], e[0], f[0], g[0], h[0]},
                      {a[1], b[1], c[1], d[1], e[1], f[1], g[1], h[1]},
                      {a[2], b[2], c[2], d[2], e[2], f[2], g[2], h[2]}};
}

/* Find the vectors between the nearest points of eight pairs, and the signed weights of their vertices, whose places
 * are in x. Large, so not inlined. */
static __attribute__((noinline)) dm_wide3 dm_wide_measure(const double (*x)[3], const uint32_t *const *at, uint32_t ones,
                                                          dm_wide *w, dm_wide_mask *inside) {
    dm_wide3 a = dm_wide_corner(x, at, 0), b = dm_wide_corner(x, at, 1);
    dm_wide3 c = dm_wide_corner(x, at, 2), d = dm_wide_corner(x, at, 3);
    *inside = (dm_wide_mask)(a.x == a.x);
    return ones == 1 ? dm_wide_off_face(a, b, c, d, w) : dm_wide_off_edge(a, b, c, d, w, inside);
}

static const uint32_t dm_four[4] = {0, 1, 2, 3};

/* Find the signed weights of the vertices x[at[0]] to x[at[3]] of a pair for its nearest points, and the vector between
 * these; return its length. */
static double dm_measure_pair(const double (*x)[3], const uint32_t *at, uint32_t ones, double *w, double *between) {
    dm_wide weight[4];
    dm_wide_mask inside;
    dm_wide3 way = dm_wide_measure(x, (const uint32_t *[]){at, at, at, at, at, at, at, at}, ones, weight, &inside);
    for (int k = 0; k < 4; k++) w[k] = weight[k][0];
    between[0] = way.x[0], between[1] = way.y[0], between[2] = way.z[0];
    return sqrt(dm_inner3(between, between));
}
