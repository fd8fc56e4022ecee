/* What may change during a simulation: the constants of the laws, and the pins. */
#include "body.h"

static double dm_weighted_mean(const dm_state *b, const double *a) {
    double sum = 0;
    for (int64_t k = 0; k < b->n; k++) sum += b->mass[k] * a[k];
    return sum / b->mass_total;
}

/* Set what depends on the rest lengths of the springs. */
static void dm_set_lengths(dm_state *b) {
    int64_t slots = b->ring.start[b->groups];
    for (int64_t k = 0; k < slots * DM_LANES; k++) {
        int32_t e = b->ring_spring[k];
        b->ring.slots[k / DM_LANES].pull[k % DM_LANES] = e < 0 ? 0 : (dm_real)(b->stiffness[e] * b->rest_length[e]);
    }
}

static void dm_set_springs(dm_state *b, const dm_constants *c) {
    int64_t slots = b->ring.start[b->groups];
    memcpy(b->stiffness, c->stiffness, (size_t)b->spring_count * sizeof(double) * (b->spring_count > 0));
    memcpy(b->tension, c->tension, (size_t)b->spring_count * sizeof(double) * (b->spring_count > 0));
    for (int64_t k = 0; k < slots * DM_LANES; k++) {
        int32_t e = b->ring_spring[k];
        dm_slot *s = b->ring.slots + k / DM_LANES;
        s->stiffness[k % DM_LANES] = e < 0 ? 0 : (dm_real)(c->stiffness[e] + c->tension[e]);
        s->damping[k % DM_LANES] = e < 0 ? 0 : (dm_real)c->damping[e];
    }
    for (dm_irregular_spring *s = b->irregular; s < b->irregular + b->irregular_count; s++)
        s->damping = c->damping[s->spring];
    dm_set_lengths(b);
}

/* Set pull (n, 3), in the order in memory, to the sum of t (q_j - q_i) over the neighbours of each vertex; q of
 * group g is g strides after the first. */
static void dm_sum_tension(const dm_state *b, const dm_vec3 *first, size_t stride, double *pull) {
    memset(pull, 0, (size_t)(3 * b->n) * sizeof *pull);
    for (int64_t e = 0; e < b->spring_count; e++) {
        uint32_t i = b->ends[e][0], j = b->ends[e][1];
        const char *from = (const char *)first;
        dm_quad q = dm_lane3((const dm_vec3 *)(const void *)(from + i / DM_LANES * stride), i);
        dm_quad r = dm_lane3((const dm_vec3 *)(const void *)(from + j / DM_LANES * stride), j);
        for (int d = 0; d < 3; d++) {
            double f = b->tension[e] * ((double)r[d] - (double)q[d]);
            pull[3 * i + (uint32_t)d] += f, pull[3 * j + (uint32_t)d] -= f;
        }
    }
}

/* Set the pull of the tension in the shape at rest. */
static void dm_set_pull(dm_state *b) {
    double *pull = b->pin_room; /* free between ticks */
    dm_sum_tension(b, &b->matter->rest, sizeof *b->matter, pull);
    for (uint32_t i = 0; i < b->n; i++) dm_set_lane3(&b->matter[i / DM_LANES].pull, i, dm_quad_of(pull + 3 * i));
}

static void dm_set_places(dm_state *b) {
    for (int64_t k = 0; k < b->n; k++) {
        double rest[3];
        for (int d = 0; d < 3; d++) rest[d] = b->rest[d * b->n + k] - b->rest_centre[d];
        dm_set_lane3(&b->matter[b->place[k] / DM_LANES].rest, b->place[k], dm_quad_of(rest));
    }
}

/* Return the least power of two that is not smaller. */
static double dm_power_of_two(double a) {
    double power = 1;
    while (power < a) power *= 2;
    while (power <= 1 && power / 2 >= a && power > 1e-300) power /= 2;
    return power;
}

static void dm_set_matter(dm_state *b, const dm_constants *c) {
    double sum[4] = {0}, spread = 0;
    b->mass_total = 0;
    for (int64_t k = 0; k < b->n; k++) {
        b->mass[k] = c->mass[k], b->mass_total += c->mass[k];
        for (int d = 0; d < 3; d++) sum[d] += c->k1[k] * b->rest[d * b->n + k];
        sum[3] += c->k1[k];
    }
    b->any_k1 = sum[3] > 0, b->k1_total = sum[3] > 0 ? sum[3] : 1;
    for (int d = 0; d < 3; d++) {
        const double *x = b->rest + d * b->n;
        b->rest_centre[d] = sum[d] / b->k1_total, b->middle[d] = dm_weighted_mean(b, x);
        for (int64_t k = 0; k < b->n; k++) spread += b->mass[k] * (x[k] - b->middle[d]) * (x[k] - b->middle[d]);
    }
    b->cell = spread > 0 ? dm_power_of_two(4 * sqrt(spread / b->mass_total)) : 1;
    for (int64_t k = 0; k < b->n; k++) {
        uint32_t i = b->place[k], l = i % DM_LANES;
        dm_group_matter *m = b->matter + i / DM_LANES;
        m->mass[l] = (dm_real)c->mass[k], m->inverse_mass[l] = b->inverse_mass[i] = (dm_real)c->inverse_mass[k];
        m->k1[l] = (dm_real)c->k1[k], m->k_more[l] = (dm_real)(c->k2[k] - c->k1[k]);
        m->d0[l] = (dm_real)c->d0[k], m->damping[l] = (dm_real)c->drag[k], b->friction[i] = (dm_real)c->friction[k];
        b->compliance[i] = (dm_real)c->compliance[k];
    }
    dm_set_places(b);
}

/* Set the pose in the form that steps use: about the centre of the shape at rest, relative to the origin. A free body's
 * pose is fitted to its vertices. */
static void dm_place_pose(dm_state *b) {
    if (b->free) dm_fit_whole(b, b->pose);
    memcpy(b->rotation, b->pose, sizeof b->rotation);
    for (int c = 0; c < 3; c++) {
        const double *row = b->pose + 3 * c, *rate = b->pose_rate + 3 * c, *q = b->rest_centre;
        b->translation[c] = b->pose[9 + c] + row[0] * q[0] + row[1] * q[1] + row[2] * q[2] - b->origin[c];
        b->turning[9 + c] = b->pose_rate[9 + c] + rate[0] * q[0] + rate[1] * q[1] + rate[2] * q[2];
    }
    memcpy(b->turning, b->pose_rate, 9 * sizeof(double));
}

DM_INLINE void dm_set_vertex(dm_state *b, uint32_t i, dm_quad x, dm_quad v) {
    b->records[i] = (dm_record){x, v};
    dm_set_lane3(&b->state[i / DM_LANES].x, i, x), dm_set_lane3(&b->state[i / DM_LANES].v, i, v);
}

/* Pin the vertices without inverse mass where they are; pins that were there before keep their exact places. */
static void dm_pin(dm_state *b, const double *inverse_mass) {
    int64_t n = b->n, old = 0, count = 0;
    double *before = b->pin_room;
    memcpy(before, b->pins, (size_t)(3 * n) * sizeof(double));
    uint32_t *was = b->moved; /* both lists ascend; each has a vertex at most once */
    memcpy(was, b->pinned, (size_t)b->pinned_count * sizeof *was);
    for (int64_t k = 0; k < n; k++) {
        int pinned = old < b->pinned_count && was[old] == k;
        if (!(inverse_mass[k] > 0)) {
            const dm_record *r = b->records + b->place[k];
            for (int d = 0; d < 3; d++)
                b->pins[d * n + count] = pinned ? before[d * n + old] : b->origin[d] + (double)r->x[d];
            b->pinned[count++] = (uint32_t)k;
            dm_set_vertex(b, b->place[k], r->x, (dm_quad){0, 0, 0, 0});
        }
        old += pinned;
    }
    b->pinned_count = count;
}

/* Wake a body; positions and velocities do not change. */
static void dm_wake(dm_state *b) { b->asleep = b->rested = 0, b->quiet = 0; }

/* The same for a body that the caller has changed. */
static void dm_change(dm_state *b) {
    dm_wake(b), b->changes++, b->fill_turns = 0;
    memset(b->resisted, 0, sizeof b->resisted);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) b->touches[k].listed = 0;
}

static int32_t dm_state_set_constants(dm_state *b, const dm_constants *c) {
    dm_change(b);
    double (*laws)[DM_LAW] = dm_alloc(c->materials, sizeof *laws);
    if (!laws) return DM_MEMORY;
    memcpy(laws, c->laws, (size_t)c->materials * sizeof *laws * (c->materials > 0));
    for (int64_t k = 0; k < b->surface_count; k++)
        for (int j = 0; j < 2; j++) b->painted[k][j] = c->painted ? c->painted[2 * k + j] : 1;
    if (b->laws && b->free && !c->free) dm_fit_whole(b, b->pose);
    dm_free(b->laws);
    b->laws = laws;
    dm_set_springs(b, c), dm_set_matter(b, c), dm_set_pull(b);
    dm_pin(b, c->inverse_mass);
    if (c->fill != b->fill) b->pressure = 0;
    b->fill = c->fill, b->rest_pressure = c->rest_pressure, b->ground = c->ground, b->free = c->free != 0, b->carried = 0;
    int laid = !b->rigged && c->rigged;
    b->rigged = c->rigged != 0;
    for (int k = 0; laid && k < 12; k++) b->pose[k] = k < 9 && k % 4 == 0;
    memcpy(b->gravity, c->gravity, sizeof b->gravity);
    memcpy(b->fill_share, c->fill_momentum, sizeof b->fill_share);
    memset(b->pose_rate, 0, sizeof b->pose_rate);
    dm_place_pose(b);
    return DM_OK;
}
