/* Eqs. (6) to (8): add the pressure, and advance velocities and positions. */
#include "body.h"

/* Advance groups. */
static void dm_pass_advance(dm_state *b, int64_t from, int64_t to, double *sums) {
    (void)sums;
    dm_lanes p = dm_splat((dm_real)(b->fill != DM_FILL_NONE ? b->pressure : 0)), dt = dm_splat((dm_real)b->dt);
    dm_real limit = (dm_real)b->skin_travel;
    dm_vec3 linear = dm_splat3(b->drift.linear), angular = dm_splat3(b->drift.angular);
    for (int64_t g = from; g < to; g++) {
        dm_vec3 x = b->state[g].x, v = b->next[g].v, n = b->next[g].per_pascal;
        v.x += p * n.x, v.y += p * n.y, v.z += p * n.z;
        if (b->free) { /* subtract the net force and torque of shape matching */
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
        b->state[g] = (dm_group_state){x, v};
        dm_scatter8(x, v, b->records + g * DM_LANES);
    }
}
