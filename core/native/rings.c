/* The one pass over ordered one-rings: springs, dashpots, shape matching, normals and volume from a single gather. */
#include "body.h"

/* the vectors to the neighbours in a slot, and how fast they grow */
static inline void gather(const body *b, const slot *s, three x, three v, three *arm, three *growth) {
    lanes_of(b->records, s->at, arm, growth);
    *arm = minus(*arm, x), *growth = minus(*growth, v);
}

/* of an arm d that grows by w: |d|, 1 / d^2 and d.w */
typedef struct {
    lanes root, inverse, closing;
} strain;

static inline strain strain_of(three d, three w) {
    lanes square = larger(dot(d, d), all(TINY));
    return (strain){root(square), all(1) / square, dot(d, w)};
}

/* f = (k (1 - l0 / |d|) + c d.w / d^2) d, with one division: 1 / |d| = |d| / d^2 */
static inline void pull(const slot *s, three d, strain e, three *force) {
    lanes tension = s->stiffness + (s->damping * e.closing - s->pull * e.root) * e.inverse;
    force->x += tension * d.x, force->y += tension * d.y, force->z += tension * d.z;
}

/* a x b + b x c = (a - c) x b: two triangles of the fan round a vertex with one product */
static inline void turn(const three *arm, three *normal) {
    three m = minus(arm[0], arm[2]), b = arm[1];
    normal->x = normal->x + m.y * b.z - m.z * b.y; /* in this order each is two fused operations */
    normal->y = normal->y + m.z * b.x - m.x * b.z;
    normal->z = normal->z + m.x * b.y - m.y * b.x;
}

static inline three rotated(const three *rows, three q, three offset) {
    return (three){dot(rows[0], q) + offset.x, dot(rows[1], q) + offset.y, dot(rows[2], q) + offset.z};
}

/* -(k1 + (k2 - k1) max(1 - d0 / |u|, 0)) u - c w: a spring of two slopes to the place in the shape at rest */
static inline three hold(const group_matter *m, three u, three w) {
    lanes k = m->k1, square = dot(u, u);
    if (any((mask)(square > m->d0 * m->d0))) /* few vertices are that far from home */
        k += m->k_more * larger(all(1) - m->d0 / root(larger(square, all(TINY))), all(0));
    return (three){-(k * u.x + m->damping * w.x), -(k * u.y + m->damping * w.y), -(k * u.z + m->damping * w.z)};
}

/* Set what comes next of every group but for the pressure, and the volume as far as rings span it; where the shape at
 * rest follows the body, `drift` becomes the rigid acceleration that shape matching must not leave. */
static inline void pull_groups(body *b, int fitted) {
    wide volume = {0}, sum[6] = {{0}};
    lanes part[6] = {{0}}, dt = all((real)b->dt), sixth = all((real)1 / 6);
    three offset = splat3(b->translation), linear = splat3(b->drift.linear), angular = splat3(b->drift.angular);
    three gravity = splat3(b->gravity), arm[DM_MAX_NEIGHBOURS + 2];
    strain strains[DM_MAX_NEIGHBOURS];
    three rows[3] = {splat3(b->rotation), splat3(b->rotation + 3), splat3(b->rotation + 6)};
    three turning[3] = {splat3(b->turning), splat3(b->turning + 3), splat3(b->turning + 6)}, shifting = splat3(b->turning + 9);
    for (int64_t g = 0; g < b->groups; g++) {
        const group_matter *m = b->matter + g;
        three x = b->state[g].x, v = b->state[g].v, w = v, normal = {all(0), all(0), all(0)};
        /* damping is against the shape at rest as it moves */
        if (b->carried) w = minus(v, rotated(turning, m->rest, shifting));
        if (fitted) {
            three spin = cross(angular, x);
            w = (three){v.x - linear.x - spin.x, v.y - linear.y - spin.y, v.z - linear.z - spin.z};
        }
        three force = hold(m, minus(x, rotated(rows, m->rest, offset)), w);
        if (fitted) {
            three torque = cross(x, force);
            part[0] += force.x, part[1] += force.y, part[2] += force.z;
            part[3] += torque.x, part[4] += torque.y, part[5] += torque.z;
            if (g % RUN == RUN - 1) fold(part, sum, 6);
        }
        const slot *s = b->ring.slots + b->ring.start[g];
        int64_t count = b->ring.start[g + 1] - b->ring.start[g];
        if (count) {
            /* two loops, for a spring's root and division take as long as the next one's gather */
            for (int64_t k = 0; k < count; k++) {
                gather(b, s + k, x, v, arm + k, &w);
                strains[k] = strain_of(arm[k], w);
            }
            for (int64_t k = 0; k < count; k++) pull(s + k, arm[k], strains[k], &force);
            /* the fan closes; where its triangles are odd in number, the last is turned alone */
            arm[count] = arm[0], arm[count + 1] = (three){all(0), all(0), all(0)};
            for (int64_t k = 0; k < count; k += 2) turn(arm + k, &normal);
            volume += widen(dot(x, normal));
        }
        /* held vertices have no inverse mass: they keep the velocity they were given */
        lanes by = dt * m->inverse_mass, fall = select((mask)(by > all(0)), dt, all(0));
        b->next[g].v = (three){
            v.x + by * force.x + fall * gravity.x,
            v.y + by * force.y + fall * gravity.y,
            v.z + by * force.z + fall * gravity.z,
        };
        by *= sixth;
        b->next[g].per_pascal = (three){by * normal.x, by * normal.y, by * normal.z};
    }
    b->volume = total(volume) / 18;
    if (!fitted) return;
    fold(part, sum, 6);
    double net[6];
    for (int k = 0; k < 6; k++) net[k] = total(sum[k]);
    b->drift = rigid_part(b, &b->moments, net, net + 3);
}

static void pull_posed(body *b) { pull_groups(b, 0); }

static void pull_fitted(body *b) { pull_groups(b, 1); }
