/* The rigid motion of a body: the pose of its shape at rest, and the rigid part of a velocity field. */
#include "body.h"

/* Diagonalise a symmetric matrix by plane rotations (Jacobi): a = q diag(a) q^T, eigenvectors in the columns of q. */
static void dm_diagonalise(int n, double *a, double *q) {
    for (int i = 0; i < n * n; i++) q[i] = i % (n + 1) == 0;
    for (int sweep = 0; sweep < 30; sweep++) {
        double off = 0, all = 0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                double square = a[i * n + j] * a[i * n + j];
                all += square, off += i < j ? square : 0;
            }
        if (!(off > 1e-34 * all)) return;
        for (int i = 0; i < n; i++)
            for (int j = i + 1; j < n; j++) {
                if (a[i * n + j] == 0) continue;
                double theta = (a[j * n + j] - a[i * n + i]) / (2 * a[i * n + j]);
                double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < n; k++) {
                    double p = a[k * n + i], r = a[k * n + j];
                    a[k * n + i] = c * p - s * r, a[k * n + j] = s * p + c * r;
                }
                for (int k = 0; k < n; k++) {
                    double p = a[i * n + k], r = a[j * n + k];
                    a[i * n + k] = c * p - s * r, a[j * n + k] = s * p + c * r;
                    p = q[k * n + i], r = q[k * n + j];
                    q[k * n + i] = c * p - s * r, q[k * n + j] = s * p + c * r;
                }
            }
    }
}

/* Find the rotation r that maximises trace(r^T h): its quaternion is the eigenvector of the largest eigenvalue of a
 * 4 x 4 matrix. It exists for any h, and is unique if the polar decomposition is. Source: Horn 1987. */
static void dm_nearest_rotation(const double *h, double *r) {
    double xx = h[0], yy = h[4], zz = h[8], q[16];
    double a = h[7] - h[5], b = h[2] - h[6], c = h[3] - h[1], d = h[1] + h[3], e = h[2] + h[6], f = h[5] + h[7];
    double m[16] = {xx + yy + zz, a, b, c, a, xx - yy - zz, d, e, b, d, yy - xx - zz, f, c, e, f, zz - xx - yy};
    dm_diagonalise(4, m, q);
    int best = 0;
    for (int i = 1; i < 4; i++) best = m[5 * i] > m[5 * best] ? i : best;
    double w = q[best], x = q[4 + best], y = q[8 + best], z = q[12 + best];
    double scale = 2 / (w * w + x * x + y * y + z * z);
    double turn[9] = {
        1 - scale * (y * y + z * z), scale * (x * y - w * z), scale * (x * z + w * y),
        scale * (x * y + w * z), 1 - scale * (x * x + z * z), scale * (y * z - w * x),
        scale * (x * z - w * y), scale * (y * z + w * x), 1 - scale * (x * x + y * y),
    };
    memcpy(r, turn, sizeof turn);
}

/* Invert a symmetric 3 x 3 inertia tensor, and destroy it; an axis without inertia (a straight line of vertices)
 * gets no spin. */
static void dm_invert3x3(double *a, double *inverse) {
    double q[9], most = 0;
    dm_diagonalise(3, a, q);
    for (int i = 0; i < 3; i++) most = a[4 * i] > most ? a[4 * i] : most;
    memset(inverse, 0, 9 * sizeof(double));
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 9 && a[4 * i] > 1e-15 * most; k++)
            inverse[k] += q[3 * (k / 3) + i] * q[3 * (k % 3) + i] / a[4 * i];
}

static dm_rigid dm_rigid_part(const dm_state *b, const dm_inertia *at, const double *momentum, const double *turning) {
    dm_rigid r;
    double about[3], moved[3];
    dm_cross3(at->centre, momentum, moved);
    for (int c = 0; c < 3; c++) r.linear[c] = momentum[c] / b->mass_total, about[c] = turning[c] - moved[c];
    for (int c = 0; c < 3; c++) r.angular[c] = dm_inner3(at->inverse + 3 * c, about);
    dm_cross3(r.angular, at->centre, moved), dm_add3(r.linear, -1, moved);
    return r;
}

/* The moments that the fits of the pose and of the motion need, in one pass. For q, the place at rest relative to its
 * centre, sum k1 q = 0; the tension contributes through its pull p, sum p = 0. */
enum { DM_K_X = 0, DM_K_XQ = 3, DM_M_X = 12, DM_M_XX = 15, DM_M_V = 21, DM_M_XV = 24 };

static void dm_pass_moments(dm_state *b, int64_t from, int64_t to, double *sums) {
    dm_wide sum[DM_MOMENTS] = {{0}};
    dm_lanes part[DM_MOMENTS] = {{0}};
    for (int64_t g = from; g < to; g++) {
        dm_vec3 x = b->state[g].x, v = b->state[g].v, q = b->matter[g].rest, p = b->matter[g].pull;
        dm_lanes k = b->matter[g].k1, at[3] = {x.x, x.y, x.z}, m = b->matter[g].mass;
        dm_lanes kx[3] = {k * x.x, k * x.y, k * x.z};
        dm_vec3 mx = {m * x.x, m * x.y, m * x.z}, turning = dm_cross(mx, v);
        for (int c = 0; c < 3; c++) {
            dm_lanes *row = part + DM_K_XQ + 3 * c;
            part[DM_K_X + c] += kx[c];
            row[0] += kx[c] * q.x - at[c] * p.x;
            row[1] += kx[c] * q.y - at[c] * p.y;
            row[2] += kx[c] * q.z - at[c] * p.z;
        }
        part[DM_M_X] += mx.x, part[DM_M_X + 1] += mx.y, part[DM_M_X + 2] += mx.z;
        part[DM_M_XX] += mx.x * x.x, part[DM_M_XX + 1] += mx.y * x.y, part[DM_M_XX + 2] += mx.z * x.z;
        part[DM_M_XX + 3] += mx.x * x.y, part[DM_M_XX + 4] += mx.y * x.z, part[DM_M_XX + 5] += mx.z * x.x;
        part[DM_M_V] += m * v.x, part[DM_M_V + 1] += m * v.y, part[DM_M_V + 2] += m * v.z;
        part[DM_M_XV] += turning.x, part[DM_M_XV + 1] += turning.y, part[DM_M_XV + 2] += turning.z;
        if (g % DM_RUN == DM_RUN - 1) dm_fold(part, sum, DM_MOMENTS);
    }
    dm_fold(part, sum, DM_MOMENTS);
    for (int k = 0; k < DM_MOMENTS; k++) sums[k] = dm_sum_of(sum[k]);
}

static void dm_sum_moments(dm_state *b, double *sums) {
    dm_run_pass(b, dm_pass_moments);
    for (int k = 0; k < DM_MOMENTS; k++) sums[k] = dm_sum_of_slices(b, k);
}

/* Fit the shape at rest to the body: least squares weighted by k1 and the tension. */
static void dm_fit_pose(dm_state *b, const double *sums) {
    /* starting from the last rotation r0, few sweeps are needed: r = r0 fit(r0^T h) */
    double near[9], turn[9], back[9];
    dm_transpose3x3(b->turned, back);
    dm_multiply3x3(back, sums + DM_K_XQ, near);
    dm_nearest_rotation(near, turn);
    dm_multiply3x3(b->turned, turn, b->rotation);
    memcpy(b->turned, b->rotation, sizeof b->turned);
    for (int c = 0; c < 3; c++) b->translation[c] = sums[DM_K_X + c] / b->k1_total;
}

/* Find the centre of mass, and the inertia tensor about it with its inverse. */
static void dm_find_inertia(const dm_state *b, const double *sums, dm_inertia *at) {
    const double *s = sums + DM_M_X, *xx = sums + DM_M_XX;
    double *o = at->centre;
    for (int c = 0; c < 3; c++) o[c] = s[c] / b->mass_total;
    double x2 = xx[0] - o[0] * s[0], y2 = xx[1] - o[1] * s[1], z2 = xx[2] - o[2] * s[2];
    double xy = xx[3] - o[0] * s[1], yz = xx[4] - o[1] * s[2], zx = xx[5] - o[2] * s[0];
    double tensor[9] = {y2 + z2, -xy, -zx, -xy, x2 + z2, -yz, -zx, -yz, x2 + y2};
    memcpy(at->tensor, tensor, sizeof tensor);
    dm_invert3x3(tensor, at->inverse);
}

/* Find the rigid part of the velocities, and the centre and inertia of the mass. */
static void dm_fit_motion(dm_state *b, const double *sums) {
    dm_find_inertia(b, sums, &b->moments);
    b->drift = dm_rigid_part(b, &b->moments, sums + DM_M_V, sums + DM_M_XV);
    memcpy(b->moments.spin, b->drift.angular, sizeof b->moments.spin);
}

/* Fit points at rest to points of equal weight; pose: rotation by rows, then translation. Both arrays are (3,
 * stride), and padded here to a multiple of eight with their first point. Points are taken relative to it, so that
 * rounding stays small. */
static void dm_fit_points(int64_t count, int64_t stride, double *rest, double *points, double *pose) {
    double from[3], to[3], h[9];
    dm_wide sum[15] = {{0}};
    for (int c = 0; c < 3; c++)
        for (int64_t k = count; k % DM_LANES; k++)
            rest[c * stride + k] = rest[c * stride], points[c * stride + k] = points[c * stride];
    for (int64_t k = 0; k < count; k += DM_LANES) {
        dm_wide p[3], q[3];
        DM_UNROLLED for (int c = 0; c < 3; c++) {
            memcpy(q + c, rest + c * stride + k, sizeof *q), memcpy(p + c, points + c * stride + k, sizeof *p);
            q[c] -= rest[c * stride], p[c] -= points[c * stride];
            sum[9 + c] += q[c], sum[12 + c] += p[c];
        }
        DM_UNROLLED for (int c = 0; c < 9; c++) sum[c] += p[c / 3] * q[c % 3];
    }
    for (int c = 0; c < 3; c++)
        from[c] = dm_sum_of(sum[9 + c]) / (double)count, to[c] = dm_sum_of(sum[12 + c]) / (double)count;
    for (int c = 0; c < 9; c++) h[c] = dm_sum_of(sum[c]) - (double)count * to[c / 3] * from[c % 3];
    dm_nearest_rotation(h, pose);
    for (int c = 0; c < 3; c++) from[c] += rest[c * stride], to[c] += points[c * stride];
    for (int c = 0; c < 3; c++) pose[9 + c] = to[c] - dm_inner3(pose + 3 * c, from);
}

/* Find the pose of the shape at rest: that of the pins, or the best fit to a free body, weighted by k1 and the
 * tension or, if all k1 are 0, by mass. */
static void dm_fit_whole(const dm_state *b, double *pose) {
    if (!b->free) {
        memcpy(pose, b->pose, sizeof b->pose);
        return;
    }
    double total_weight = 0, from[3] = {0}, to[3] = {0}, h[9] = {0};
    int by_mass = b->any_k1 == 0;
    dm_wide sum[16] = {{0}};
    dm_lanes part[16] = {{0}};
    for (int64_t g = 0; g < b->groups; g++) {
        const dm_group_matter *m = b->matter + g;
        dm_vec3 x = b->state[g].x, q = m->rest, p = m->pull;
        dm_lanes w = by_mass ? m->mass : m->k1, at[3] = {x.x, x.y, x.z}, wx[3] = {w * x.x, w * x.y, w * x.z};
        part[15] += w, part[12] += w * q.x, part[13] += w * q.y, part[14] += w * q.z;
        for (int c = 0; c < 3; c++) {
            part[9 + c] += wx[c], part[3 * c] += wx[c] * q.x - at[c] * p.x;
            part[3 * c + 1] += wx[c] * q.y - at[c] * p.y, part[3 * c + 2] += wx[c] * q.z - at[c] * p.z;
        }
        if (g % DM_RUN == DM_RUN - 1) dm_fold(part, sum, 16);
    }
    dm_fold(part, sum, 16);
    total_weight = dm_sum_of(sum[15]);
    for (int c = 0; c < 3; c++)
        to[c] = dm_sum_of(sum[9 + c]) / total_weight, from[c] = dm_sum_of(sum[12 + c]) / total_weight;
    for (int k = 0; k < 9; k++) h[k] = dm_sum_of(sum[k]) - total_weight * to[k / 3] * from[k % 3];
    dm_nearest_rotation(h, pose);
    for (int c = 0; c < 3; c++) {
        double back = 0;
        for (int d = 0; d < 3; d++) back += pose[3 * c + d] * (b->rest_centre[d] + from[d]);
        pose[9 + c] = b->origin[c] + to[c] - back;
    }
}

/* Find the present pose of the shape at rest. */
static void dm_pose_now(const dm_state *b, double *pose) {
    if (b->asleep) memcpy(pose, b->still_pose, sizeof b->still_pose);
    else dm_fit_whole(b, pose);
}

/* Find the pose of a free body's shape at rest that was fitted as the substep began. */
static void dm_fitted_pose(const dm_state *b, double *pose) {
    memcpy(pose, b->rotation, sizeof b->rotation);
    for (int c = 0; c < 3; c++)
        pose[9 + c] = b->origin[c] + b->translation[c] - dm_inner3(b->rotation + 3 * c, b->rest_centre);
}
