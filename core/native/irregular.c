/* Springs and faces at vertices without a ring, and the cones that close holes for the volume, one by one in double
 * precision. Source: studies/reference/laws.py _add_irregular, core/body/pressure.py volume_and_gradient. */
#include "body.h"

static void dm_add_force(dm_state *b, uint32_t i, const double *f, double sign) {
    dm_add_lane3(&b->next[i / DM_LANES].v, i, f, sign * b->dt * (double)b->inverse_mass[i]);
}

/* add f to 6 dV/dx of a vertex; return the volume that it contributes */
static double dm_add_normal(dm_state *b, uint32_t i, const double *x, const double *f) {
    dm_add_lane3(&b->next[i / DM_LANES].per_pascal, i, f, b->dt * (double)b->inverse_mass[i] / 6);
    return dm_inner3(x, f) / 18;
}

static void dm_add_irregular_forces(dm_state *b) {
    for (const dm_irregular_spring *s = b->irregular; s < b->irregular + b->irregular_count; s++) {
        int64_t e = s->spring;
        uint32_t i = b->ends[e][0], j = b->ends[e][1];
        double xi[3], xj[3], vi[3], vj[3], square = 0, growth = 0;
        dm_position(b, i, xi), dm_position(b, j, xj);
        dm_velocity(b, i, vi), dm_velocity(b, j, vj);
        for (int c = 0; c < 3; c++) {
            xj[c] -= xi[c];
            square += xj[c] * xj[c], growth += xj[c] * (vj[c] - vi[c]);
        }
        square = square > 1e-30 ? square : 1e-30;
        double tension = b->stiffness[e] * (1 - b->rest_length[e] / sqrt(square)) + b->tension[e]
                         + s->damping * growth / square;
        for (int c = 0; c < 3; c++) xj[c] *= tension;
        if (s->on_i) dm_add_force(b, i, xj, 1);
        if (s->on_j) dm_add_force(b, j, xj, -1);
    }
}

static double dm_add_fans(dm_state *b) {
    double volume = 0, x[3], y[3], z[3], f[3];
    for (int64_t k = 0; k < b->fan_count; k++) {
        dm_position(b, b->fans[k][0], x), dm_position(b, b->fans[k][1], y), dm_position(b, b->fans[k][2], z);
        dm_cross3(y, z, f);
        volume += dm_add_normal(b, b->fans[k][0], x, f);
    }
    return volume;
}

/* at: positions (n, 3) in the order in memory; null: those of the body. */
DM_INLINE void dm_place_at(const dm_state *b, const double *at, uint32_t i, double *x) {
    if (at) memcpy(x, at + 3 * i, 3 * sizeof *x);
    else dm_position(b, i, x);
}

static void dm_find_hole_centres(dm_state *b, const double *at) {
    for (int64_t h = 0; h < b->hole_count; h++) memset(b->holes[h], 0, 6 * sizeof(double));
    for (int64_t e = 0; e < b->cap_count; e++) {
        double *hole = b->holes[b->cap_hole[e]], x[3];
        dm_place_at(b, at, b->caps[e][0], x);
        for (int c = 0; c < 3; c++) hole[c] += x[c] / hole[6];
    }
}

static double dm_add_caps(dm_state *b) {
    double volume = 0, x[3], y[3], f[3];
    dm_find_hole_centres(b, NULL);
    for (int64_t e = 0; e < b->cap_count; e++) {
        double *hole = b->holes[b->cap_hole[e]];
        dm_position(b, b->caps[e][0], x), dm_position(b, b->caps[e][1], y);
        dm_cross3(y, hole, f);
        volume += dm_add_normal(b, b->caps[e][0], x, f);
        dm_cross3(hole, x, f);
        volume += dm_add_normal(b, b->caps[e][1], y, f);
        dm_cross3(x, y, f);
        for (int c = 0; c < 3; c++) hole[3 + c] += f[c] / hole[6];
    }
    /* the apex of a cone moves with the mean of its rim */
    for (int64_t e = 0; e < b->cap_count; e++) {
        dm_position(b, b->caps[e][0], x);
        volume += dm_add_normal(b, b->caps[e][0], x, b->holes[b->cap_hole[e]] + 3);
    }
    return volume;
}

/* Return the volume [m3], summed over all faces: for laws that do not need it in each step. */
static double dm_volume_of_faces(dm_state *b, const double *at) {
    double volume = 0, x[3], y[3], z[3], f[3];
    for (int64_t t = 0; t < b->triangle_count; t++) {
        const uint32_t *corner = b->triangles[t];
        dm_place_at(b, at, corner[0], x), dm_place_at(b, at, corner[1], y), dm_place_at(b, at, corner[2], z);
        dm_cross3(y, z, f);
        volume += dm_inner3(x, f) / 6;
    }
    dm_find_hole_centres(b, at);
    for (int64_t e = 0; e < b->cap_count; e++) {
        dm_place_at(b, at, b->caps[e][0], x), dm_place_at(b, at, b->caps[e][1], y);
        dm_cross3(y, b->holes[b->cap_hole[e]], f);
        volume += dm_inner3(x, f) / 6;
    }
    return volume;
}
