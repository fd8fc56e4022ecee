/* The equations of the paper, literally. Source: core/body/paper.py. */
#include "body.h"

static void face_normal(const body *b, const uint32_t *corner, double *n) {
    double x[3], y[3], z[3];
    position(b, corner[0], x), position(b, corner[1], y), position(b, corner[2], z);
    for (int c = 0; c < 3; c++) y[c] -= x[c], z[c] -= x[c];
    cross3(y, z, n);
}

static double length3(const double *a) { return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

/* p = f / A_c, Eq. (2): a third of each triangle's area for each of its corners in contact */
static double inner_pressure(const body *b) {
    double area = 0, n[3];
    for (int64_t t = 0; t < b->triangle_count; t++) {
        const uint32_t *corner = b->triangles[t];
        int touching = b->touching[corner[0]] + b->touching[corner[1]] + b->touching[corner[2]];
        if (touching) face_normal(b, corner, n), area += touching * length3(n) / 2;
    }
    return area > 0 ? b->inner_force / (area / 3) : 0;
}

/* Start from no force but gravity. */
static void fall(body *b) {
    for (int64_t g = 0; g < b->groups; g++) {
        three v = b->state[g].v, gravity = splat3(b->gravity), none = {all(0), all(0), all(0)};
        lanes dt = select((mask)(b->matter[g].inverse_mass > all(0)), all((real)b->dt), all(0));
        v.x += dt * gravity.x, v.y += dt * gravity.y, v.z += dt * gravity.z;
        b->next[g] = (group_next){v, none};
    }
}

/* What a pascal does is A_0 / n_0 times the unit sum of the unit normals round a vertex, Eq. (3). */
static void spread_pressure(body *b) {
    double n[3];
    for (int64_t t = 0; t < b->triangle_count; t++) {
        const uint32_t *corner = b->triangles[t];
        face_normal(b, corner, n);
        double size = length3(n);
        for (int c = 0; c < 3; c++) n[c] /= size > 1e-30 ? size : 1e-30;
        for (int k = 0; k < 3; k++) add_lane3(&b->next[corner[k] / LANES].per_pascal, corner[k], n, 1);
    }
    for (int64_t g = 0; g < b->groups; g++) {
        three *sum = &b->next[g].per_pascal;
        lanes share = all((real)(b->rest_area / (double)b->n * b->dt)) * b->matter[g].inverse_mass;
        share /= root(larger(dot(*sum, *sum), all(TINY)));
        sum->x *= share, sum->y *= share, sum->z *= share;
    }
}
