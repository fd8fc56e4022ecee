/* The pass over the ordered one-rings: springs, dashpots, shape matching, normals and volume from a single gather. */
#include "body.h"

/* of an arm d with relative velocity w: d^2, and d.w */
typedef struct {
    dm_lanes square, closing;
} dm_strain;

/* Gather the vectors to the neighbours in a slot; return their strains. */
DM_INLINE dm_strain dm_gather_slot(const dm_state *b, const dm_slot *s, dm_vec3 x, dm_vec3 v, dm_vec3 *arm) {
    dm_vec3 at, speed;
    dm_gather8(b->records, s->at, &at, &speed);
    *arm = dm_sub(at, x);
    return (dm_strain){dm_vmax(dm_dot(*arm, *arm), dm_splat(DM_LEAST)), dm_dot(*arm, dm_sub(speed, v))};
}

/* Add f = (k (1 - l0 / |d|) + t + c d.w / d^2) d, with a single division: 1 / |d| = |d| / d^2. */
DM_INLINE void dm_add_spring_force(const dm_slot *s, dm_vec3 d, dm_strain e, dm_vec3 *force) {
    dm_lanes root = dm_vsqrt(e.square), inverse = dm_splat(1) / e.square;
    dm_lanes tension = s->stiffness + (s->damping * e.closing - s->pull * root) * inverse;
    force->x += tension * d.x, force->y += tension * d.y, force->z += tension * d.z;
}

/* Add a x b + b x c = (a - c) x b: two triangles of the fan round a vertex by one cross product. */
DM_INLINE void dm_add_fan_normal(const dm_vec3 *arm, dm_vec3 *normal) {
    dm_vec3 m = dm_sub(arm[0], arm[2]), b = arm[1];
    normal->x = normal->x + m.y * b.z - m.z * b.y; /* in this order, each is two fused operations */
    normal->y = normal->y + m.z * b.x - m.x * b.z;
    normal->z = normal->z + m.x * b.y - m.y * b.x;
}

/* Return -(k1 + (k2 - k1) max(1 - d0 / |u|, 0)) u - c w: the force of a bilinear spring to the place at rest. */
DM_INLINE dm_vec3 dm_matching_force(const dm_group_matter *m, dm_vec3 u, dm_vec3 w) {
    dm_lanes k = m->k1, square = dm_dot(u, u), none = dm_splat(0), one = dm_splat(1);
    if (dm_any_of((dm_mask)(square > m->d0 * m->d0))) { /* few vertices are beyond the knee */
        dm_lanes inverse = one / dm_vsqrt(dm_vmax(square, dm_splat(DM_LEAST)));
        k += m->k_more * dm_vmax(one - m->d0 * inverse, none);
    }
    return (dm_vec3){-(k * u.x + m->damping * w.x), -(k * u.y + m->damping * w.y), -(k * u.z + m->damping * w.z)};
}

/* Add the normals of a closed fan; if the number of triangles is odd, the last is added alone. */
DM_INLINE void dm_add_fan(dm_vec3 *arm, int64_t count, dm_vec3 *normal) {
    arm[count] = arm[0], arm[count + 1] = (dm_vec3){dm_splat(0), dm_splat(0), dm_splat(0)};
    for (int64_t k = 0; k < count; k += 2) dm_add_fan_normal(arm + k, normal);
}

/* Add the forces of the springs of a ring, and six times the area vector of its vertex. */
DM_INLINE void dm_add_ring(const dm_state *b, const dm_slot *s, int64_t count, dm_vec3 x, dm_vec3 v, dm_vec3 *force,
                           dm_vec3 *normal) {
    dm_vec3 arm[DM_MAX_RING + 2];
    /* each force is computed a slot late: its root and division take as long as the gather of the next slot */
    dm_strain strain = dm_gather_slot(b, s, x, v, arm);
    for (int64_t k = 1; k < count; k++) {
        dm_strain next = dm_gather_slot(b, s + k, x, v, arm + k);
        dm_add_spring_force(s + k - 1, arm[k - 1], strain, force);
        strain = next;
    }
    dm_add_spring_force(s + count - 1, arm[count - 1], strain, force);
    dm_add_fan(arm, count, normal);
}

/* Set the next velocities of a pinned group, which are unchanged. Return its part of the volume. */
static __attribute__((noinline)) dm_wide dm_pass_pinned(dm_state *b, int64_t g) {
    dm_vec3 arm[DM_MAX_RING + 2], none = {dm_splat(0), dm_splat(0), dm_splat(0)}, normal = none, x = b->state[g].x;
    int64_t count = b->ring.start[g + 1] - b->ring.start[g];
    const dm_slot *s = b->ring.slots + b->ring.start[g];
    dm_lanes fourth;
    for (int64_t k = 0; k < count; k++) arm[k] = dm_sub(dm_gather_quads(b->records, s[k].at, &fourth), x);
    if (count) dm_add_fan(arm, count, &normal);
    b->next[g] = (dm_group_next){b->state[g].v, none};
    return dm_widen(dm_dot(x, normal));
}

/* Set the next velocities of groups, without the pressure. sums: the volume that the rings span and, if the shape at
 * rest follows the body (fitted), the net force and moment of shape matching. */
DM_INLINE void dm_run_ring_groups(dm_state *b, int64_t from, int64_t to, double *sums, int fitted) {
    dm_wide volume = {0}, sum[6] = {{0}};
    dm_lanes part[6] = {{0}}, dt = dm_splat((dm_real)b->dt), sixth = dm_splat((dm_real)1 / 6);
    dm_vec3 offset = dm_splat3(b->translation), none = {dm_splat(0), dm_splat(0), dm_splat(0)};
    dm_vec3 linear = dm_splat3(b->drift.linear), angular = dm_splat3(b->drift.angular);
    dm_vec3 gravity = dm_splat3(b->gravity);
    dm_vec3 rows[3] = {dm_splat3(b->rotation), dm_splat3(b->rotation + 3), dm_splat3(b->rotation + 6)};
    dm_vec3 turning[3] = {dm_splat3(b->turning), dm_splat3(b->turning + 3), dm_splat3(b->turning + 6)};
    dm_vec3 shifting = dm_splat3(b->turning + 9);
    for (int64_t g = from; g < to; g++) {
        const dm_group_matter *m = b->matter + g;
        if (!fitted && !dm_any_of((dm_mask)(m->inverse_mass > dm_splat(0)))) {
            volume += dm_pass_pinned(b, g);
            continue;
        }
        dm_vec3 x = b->state[g].x, v = b->state[g].v, w = v, normal = none;
        /* damping acts on the velocity relative to the moving shape at rest */
        if (b->carried) w = dm_sub(v, dm_rotated(turning, m->rest, shifting));
        if (fitted) {
            dm_vec3 spin = dm_cross(angular, x);
            w = (dm_vec3){v.x - linear.x - spin.x, v.y - linear.y - spin.y, v.z - linear.z - spin.z};
        }
        if (b->moving) w = dm_sub(w, dm_rotated(rows, b->rest_rate[g], none));
        dm_vec3 force = dm_matching_force(m, dm_sub(x, dm_rotated(rows, m->rest, offset)), w);
        /* the tension between displacements is that of the arms, in the springs, minus that of the shape at rest */
        force = dm_sub(force, dm_rotated(rows, m->pull, none));
        if (fitted) {
            dm_vec3 torque = dm_cross(x, force);
            part[0] += force.x, part[1] += force.y, part[2] += force.z;
            part[3] += torque.x, part[4] += torque.y, part[5] += torque.z;
            if (g % DM_RUN == DM_RUN - 1) dm_fold(part, sum, 6);
        }
        const dm_slot *s = b->ring.slots + b->ring.start[g];
        int64_t slots = b->ring.start[g + 1] - b->ring.start[g];
        if (slots) dm_add_ring(b, s, slots, x, v, &force, &normal);
        if (slots) volume += dm_widen(dm_dot(x, normal));
        /* the inverse mass of pinned vertices is 0: they keep the velocity that was set */
        dm_lanes by = dt * m->inverse_mass, fall = dm_blend((dm_mask)(by > dm_splat(0)), dt, dm_splat(0));
        b->next[g].v = (dm_vec3){
            v.x + by * force.x + fall * gravity.x,
            v.y + by * force.y + fall * gravity.y,
            v.z + by * force.z + fall * gravity.z,
        };
        by *= sixth;
        b->next[g].per_pascal = (dm_vec3){by * normal.x, by * normal.y, by * normal.z};
    }
    sums[0] = dm_sum_of(volume);
    if (fitted) dm_fold(part, sum, 6);
    for (int k = 0; fitted && k < 6; k++) sums[1 + k] = dm_sum_of(sum[k]);
}

static void dm_pass_rings(dm_state *b, int64_t from, int64_t to, double *sums) {
    if (b->free) dm_run_ring_groups(b, from, to, sums, 1);
    else dm_run_ring_groups(b, from, to, sums, 0);
}

/* Set the next velocities of all groups, without the pressure, and the volume that the rings span; `drift` of a free
 * body becomes the rigid acceleration by shape matching, which is to be subtracted. */
static void dm_run_rings(dm_state *b) {
    double net[6];
    dm_run_pass(b, dm_pass_rings);
    b->volume = dm_sum_of_slices(b, 0) / 18;
    if (!b->free) return;
    for (int k = 0; k < 6; k++) net[k] = dm_sum_of_slices(b, 1 + k);
    b->drift = dm_rigid_part(b, &b->moments, net, net + 3);
}
