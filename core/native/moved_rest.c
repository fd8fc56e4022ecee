/* A shape at rest that changes during a simulation, as when a rig bends it.
 * Source: core/body/moved_rest.py with_rest. */
#include "body.h"

/* Move the places at rest at their rate for some ticks. During a tick they stay at the mean place of its substeps,
 * so that the body neither leads nor lags. */
static void dm_move_places(dm_state *b, double ticks, double tick) {
    dm_lanes by = dm_splat((dm_real)(ticks * tick));
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 *rest = &b->matter[g].rest, *pull = &b->matter[g].pull, v = b->rest_rate[g], p = b->pull_rate[g];
        rest->x += by * v.x, rest->y += by * v.y, rest->z += by * v.z;
        pull->x += by * p.x, pull->y += by * p.y, pull->z += by * p.z;
    }
}

/* After the last tick: the places at rest are exactly those of the new shape. */
static void dm_finish_places(dm_state *b, const dm_motion *m) {
    dm_move_places(b, (1 + 1 / (double)m->substeps) / 2, m->tick);
    dm_set_places(b);
    b->moving = 0;
}

/* Find the mean of vectors (3, n), weighted by k1. */
static void dm_mean_by_k1(const dm_state *b, const double *a, double *mean) {
    double sum[4] = {0};
    for (int64_t k = 0; k < b->n; k++) {
        double k1 = (double)b->matter[b->place[k] / DM_LANES].k1[b->place[k] % DM_LANES];
        for (int d = 0; d < 3; d++) sum[d] += k1 * a[d * b->n + k];
        sum[3] += k1;
    }
    for (int d = 0; d < 3; d++) mean[d] = sum[d] / (sum[3] > 0 ? sum[3] : 1);
}

static void dm_state_set_rest(dm_state *b, const double *rest, const double *surface, int64_t surface_vertices,
                              const double *rate, const double *gain) {
    int64_t n = b->n;
    double *at = b->pin_room + 3 * n; /* unused between ticks; in the order in memory, relative to the middle, for exact volumes */
    memcpy(b->rest, rest, (size_t)(3 * n) * sizeof(double));
    dm_mean_by_k1(b, rest, b->rest_centre); /* places are relative to it */
    for (int64_t k = 0; k < n; k++)
        for (int d = 0; d < 3; d++) at[3 * b->place[k] + (uint32_t)d] = rest[d * n + k] - b->rest_centre[d];
    for (int64_t e = 0; e < b->spring_count; e++) {
        const double *p = at + 3 * b->ends[e][0], *q = at + 3 * b->ends[e][1];
        double arm[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
        b->rest_length[e] = sqrt(dm_inner3(arm, arm));
    }
    dm_set_lengths(b), dm_set_places(b), dm_set_pull(b);
    double volume = dm_volume_of_faces(b, at);
    if (volume > 0) b->rest_volume = volume; /* a rig may turn a body inside out */
    dm_reshape_facets(b, surface, surface_vertices);
    double drift[3] = {0};
    if (rate && b->free) dm_mean_by_k1(b, rate, drift); /* for a free body only the shape counts */
    for (int64_t k = 0; rate && k < n; k++) {
        double way[3] = {rate[k] - drift[0], rate[n + k] - drift[1], rate[2 * n + k] - drift[2]};
        dm_set_lane3(&b->rest_rate[b->place[k] / DM_LANES], b->place[k], dm_quad_of(way));
    }
    if (rate) {
        dm_sum_tension(b, b->rest_rate, sizeof *b->rest_rate, b->pin_room);
        for (uint32_t i = 0; i < n; i++)
            dm_set_lane3(&b->pull_rate[i / DM_LANES], i, dm_quad_of(b->pin_room + 3 * i));
    }
    for (int64_t k = 0; gain && k < n; k++) {
        double more[3] = {gain[k], gain[n + k], gain[2 * n + k]};
        dm_record *r = b->records + b->place[k];
        if (b->inverse_mass[b->place[k]] > 0) dm_set_vertex(b, b->place[k], r->x, r->v + dm_quad_of(more));
    }
    b->moving = rate != NULL;
    dm_change(b);
    dm_place_pose(b);
}

static double dm_state_rest_volume(const dm_state *b) { return b->rest_volume; }
