/* Eqs. (6) to (8): from what comes next to new velocities and positions. */
#include "body.h"

/* Advance groups; `gone`: the farthest way of those that are near something, and of others. */
static void dm_pass_ways(dm_state *b, int64_t from, int64_t to, double *gone) {
    dm_lanes p = dm_splat((dm_real)(b->fill != DM_FILL_NONE ? b->pressure : 0)), dt = dm_splat((dm_real)b->dt);
    dm_real limit = (dm_real)b->skin_travel;
    dm_vec3 linear = dm_splat3(b->drift.linear), angular = dm_splat3(b->drift.angular);
    dm_lanes most[2] = {dm_splat(0), dm_splat(0)};
    const uint32_t *near = b->near_groups, *end = near + b->near_group_count;
    for (int64_t left = end - near, half; left > 0; left = half) /* those of the slices before */
        if (half = left / 2, near[half] < from) near += half + 1, half = left - half - 1;
    for (int64_t g = from; g < to; g++) {
        dm_vec3 x = b->state[g].x, v = b->next[g].v, n = b->next[g].per_pascal;
        v.x += p * n.x, v.y += p * n.y, v.z += p * n.z;
        if (b->free) { /* whatever net force and torque shape matching left is taken out */
            dm_vec3 spin = dm_cross(angular, x);
            dm_lanes by = dm_blend((dm_mask)(b->matter[g].inverse_mass > dm_splat(0)), dt, dm_splat(0));
            v.x -= by * (linear.x + spin.x), v.y -= by * (linear.y + spin.y), v.z -= by * (linear.z + spin.z);
        }
        dm_vec3 way = {dt * v.x, dt * v.y, dt * v.z};
        if (limit > 0) { /* a deep press must not carry the skin past a fingertip */
            dm_lanes square = dm_dot(way, way);
            dm_mask far = (dm_mask)(square > dm_splat(limit * limit));
            if (dm_any_of(far)) {
                dm_lanes share = dm_blend(far, dm_splat(limit) / dm_vsqrt(square), dm_splat(1));
                way.x *= share, way.y *= share, way.z *= share;
            }
        }
        x.x += way.x, x.y += way.y, x.z += way.z;
        while (near < end && *near < g) near++;
        int far = near == end || *near != g;
        most[far] = dm_vmax(dm_dot(way, way), most[far]);
        b->state[g] = (dm_group_state){x, v};
        dm_scatter8(x, v, b->records + g * DM_LANES);
    }
    for (int far = 0; far < 2; far++) gone[far] = sqrt(dm_most_of(most[far]));
}

static void dm_advance(dm_state *b) {
    dm_run_pass(b, dm_pass_ways);
    b->near_way = dm_most_of_slices(b, 0), b->way = dm_most_of_slices(b, 1);
}
