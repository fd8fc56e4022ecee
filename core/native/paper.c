/* The equations of the paper, literally. Source: core/body/paper.py. */
#include "body.h"

static void dm_face_normal(const dm_state *b, const uint32_t *corner, double *n) {
    double x[3], y[3], z[3];
    dm_position(b, corner[0], x), dm_position(b, corner[1], y), dm_position(b, corner[2], z);
    for (int c = 0; c < 3; c++) y[c] -= x[c], z[c] -= x[c];
    dm_cross3(y, z, n);
}

static double dm_length3(const double *a) { return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

/* p = f / A_c, Eq. (2): a third of each triangle's area for each of its corners in contact */
static double dm_paper_pressure(const dm_state *b) {
    double area = 0, n[3];
    for (int64_t t = 0; t < b->triangle_count; t++) {
        const uint32_t *corner = b->triangles[t];
        int touching = b->touching[corner[0]] + b->touching[corner[1]] + b->touching[corner[2]];
        if (touching) dm_face_normal(b, corner, n), area += touching * dm_length3(n) / 2;
    }
    return area > 0 ? b->inner_force / (area / 3) : 0;
}

/* Start from no force but gravity. */
static void dm_apply_gravity(dm_state *b) {
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 v = b->state[g].v, gravity = dm_splat3(b->gravity), none = {dm_splat(0), dm_splat(0), dm_splat(0)};
        dm_mask moves = (dm_mask)(b->matter[g].inverse_mass > dm_splat(0));
        dm_lanes dt = dm_blend(moves, dm_splat((dm_real)b->dt), dm_splat(0));
        v.x += dt * gravity.x, v.y += dt * gravity.y, v.z += dt * gravity.z;
        b->next[g] = (dm_group_next){v, none};
    }
}

/* k (|l| - |l0|) / |l0| along each spring, Eq. (4) */
static void dm_paper_spring_force(dm_state *b) {
    for (int64_t e = 0; e < b->spring_count; e++) {
        uint32_t i = b->ends[e][0], j = b->ends[e][1];
        double x[3], arm[3], rest = b->rest_length[e];
        dm_position(b, i, x), dm_position(b, j, arm);
        for (int c = 0; c < 3; c++) arm[c] -= x[c];
        double tension = b->stiffness[e] * (dm_length3(arm) - rest) / (rest > 1e-30 ? rest : 1e-30);
        for (int c = 0; c < 3; c++) arm[c] *= tension;
        dm_add_force(b, i, arm, 1), dm_add_force(b, j, arm, -1);
    }
}

/* What a pascal does is A_0 / n_0 times the unit sum of the unit normals round a vertex, Eq. (3). */
static void dm_paper_pressure_force(dm_state *b) {
    double n[3];
    for (int64_t t = 0; t < b->triangle_count; t++) {
        const uint32_t *corner = b->triangles[t];
        dm_face_normal(b, corner, n);
        double size = dm_length3(n);
        for (int c = 0; c < 3; c++) n[c] /= size > 1e-30 ? size : 1e-30;
        for (int k = 0; k < 3; k++) dm_add_lane3(&b->next[corner[k] / DM_LANES].per_pascal, corner[k], n, 1);
    }
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 *sum = &b->next[g].per_pascal;
        dm_lanes share = dm_splat((dm_real)(b->rest_area / (double)b->n * b->dt)) * b->matter[g].inverse_mass;
        share /= dm_vsqrt(dm_vmax(dm_dot(*sum, *sum), dm_splat(DM_TINY)));
        sum->x *= share, sum->y *= share, sum->z *= share;
    }
}
