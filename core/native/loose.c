/* What the rings leave out, one by one and in double: springs and faces at vertices without a ring, and the cones
 * that close the holes for the volume. Source: core/body/springs.py _add_irregular, core/body/pressure.py _add_corners. */
#include "body.h"

static void add_force(body *b, uint32_t i, const double *f, double sign) {
    three *to = &b->next[i / LANES].v;
    double by = sign * b->dt * (double)b->inverse_mass[i];
    *lane(&to->x, i) += (real)(by * f[0]), *lane(&to->y, i) += (real)(by * f[1]);
    *lane(&to->z, i) += (real)(by * f[2]);
}

/* add f to the sum of normals round a vertex, 6 dV/dx; return what that adds to the volume */
static double add_normal(body *b, uint32_t i, const double *x, const double *f) {
    three *to = &b->next[i / LANES].per_pascal;
    double by = b->dt * (double)b->inverse_mass[i] / 6;
    *lane(&to->x, i) += (real)(by * f[0]), *lane(&to->y, i) += (real)(by * f[1]);
    *lane(&to->z, i) += (real)(by * f[2]);
    return (x[0] * f[0] + x[1] * f[1] + x[2] * f[2]) / 18;
}

static void cross3(const double *a, const double *b, double *r) {
    r[0] = a[1] * b[2] - a[2] * b[1], r[1] = a[2] * b[0] - a[0] * b[2], r[2] = a[0] * b[1] - a[1] * b[0];
}

static void pull_loose(body *b) {
    for (const loose_spring *s = b->loose; s < b->loose + b->loose_count; s++) {
        double xi[3], xj[3], vi[3], vj[3], square = 0, growth = 0;
        position(b, (uint32_t)s->i, xi), position(b, (uint32_t)s->j, xj);
        velocity(b, (uint32_t)s->i, vi), velocity(b, (uint32_t)s->j, vj);
        for (int c = 0; c < 3; c++) {
            xj[c] -= xi[c];
            square += xj[c] * xj[c], growth += xj[c] * (vj[c] - vi[c]);
        }
        square = square > 1e-30 ? square : 1e-30;
        double length = sqrt(square), tension;
        if (b->laws == DM_LAWS_PAPER) /* Eq. (4) */
            tension = s->stiffness * (length - s->rest) / (s->rest > 1e-30 ? s->rest : 1e-30);
        else
            tension = s->stiffness * (1 - s->rest / length) + s->damping * growth / square;
        for (int c = 0; c < 3; c++) xj[c] *= tension;
        if (s->on_i) add_force(b, (uint32_t)s->i, xj, 1);
        if (s->on_j) add_force(b, (uint32_t)s->j, xj, -1);
    }
}

static double add_corners(body *b) {
    double volume = 0, x[3], y[3], z[3], f[3];
    for (int64_t k = 0; k < b->corner_count; k++) {
        position(b, b->corners[k][0], x), position(b, b->corners[k][1], y), position(b, b->corners[k][2], z);
        cross3(y, z, f);
        volume += add_normal(b, b->corners[k][0], x, f);
    }
    return volume;
}

static double add_caps(body *b) {
    double volume = 0, x[3], y[3], f[3];
    for (int64_t h = 0; h < b->hole_count; h++) memset(b->holes[h], 0, 6 * sizeof(double));
    for (int64_t e = 0; e < b->cap_count; e++) {
        double *hole = b->holes[b->cap_hole[e]];
        position(b, b->caps[e][0], x);
        for (int c = 0; c < 3; c++) hole[c] += x[c] / hole[6];
    }
    for (int64_t e = 0; e < b->cap_count; e++) {
        double *hole = b->holes[b->cap_hole[e]];
        position(b, b->caps[e][0], x), position(b, b->caps[e][1], y);
        cross3(y, hole, f);
        volume += add_normal(b, b->caps[e][0], x, f);
        cross3(hole, x, f);
        volume += add_normal(b, b->caps[e][1], y, f);
        cross3(x, y, f);
        for (int c = 0; c < 3; c++) hole[3 + c] += f[c] / hole[6];
    }
    /* the tip of a cone moves with the mean of its rim */
    for (int64_t e = 0; e < b->cap_count; e++) {
        position(b, b->caps[e][0], x);
        volume += add_normal(b, b->caps[e][0], x, b->holes[b->cap_hole[e]] + 3);
    }
    return volume;
}
