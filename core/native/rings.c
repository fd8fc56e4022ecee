/* The one pass over ordered one-rings: springs, dashpots, shape memory, normals and volume from a single gather. */
#include "body.h"

/* the vectors to the neighbours in a slot, and how fast they grow */
static inline void gather(const body *b, const slot *s, three x, three v, three *arm, three *growth) {
    const char *base = (const char *)b->records;
    const record *r0 = (const record *)(base + s->at[0]), *r1 = (const record *)(base + s->at[1]);
    const record *r2 = (const record *)(base + s->at[2]), *r3 = (const record *)(base + s->at[3]);
    const record *r4 = (const record *)(base + s->at[4]), *r5 = (const record *)(base + s->at[5]);
    const record *r6 = (const record *)(base + s->at[6]), *r7 = (const record *)(base + s->at[7]);
    *arm = minus(lanes_of(r0->x, r1->x, r2->x, r3->x, r4->x, r5->x, r6->x, r7->x), x);
    *growth = minus(lanes_of(r0->v, r1->v, r2->v, r3->v, r4->v, r5->v, r6->v, r7->v), v);
}

/* f = (k (1 - l0 / |d|) + c d.w / d^2) d, with one division: 1 / |d| = |d| / d^2 */
static inline void pull(const slot *s, three d, three w, three *force) {
    lanes square = larger(dot(d, d), all(TINY)), inverse = all(1) / square;
    lanes tension = s->stiffness + (s->damping * dot(d, w) - s->pull * root(square)) * inverse;
    force->x += tension * d.x, force->y += tension * d.y, force->z += tension * d.z;
}

/* a x b + b x c = (a - c) x b: two triangles of the fan round a vertex with one product */
static inline void turn(three a, three b, three c, three *normal) {
    three n = cross(minus(a, c), b);
    normal->x += n.x, normal->y += n.y, normal->z += n.z;
}

static inline three rotated(const three *rows, three q, three offset) {
    return (three){dot(rows[0], q) + offset.x, dot(rows[1], q) + offset.y, dot(rows[2], q) + offset.z};
}

/* -(k1 + (k2 - k1) max(1 - d0 / |u|, 0)) u - c w: a spring of two slopes to the place in the shape at rest */
static inline three hold(const group_matter *m, three u, three w) {
    lanes d = root(larger(dot(u, u), all(TINY)));
    lanes k = m->k1 + m->k_more * larger(all(1) - m->d0 / d, all(0));
    return (three){-(k * u.x + m->damping * w.x), -(k * u.y + m->damping * w.y), -(k * u.z + m->damping * w.z)};
}

/* Set what comes next of every group but for the pressure, and the volume as far as rings span it; where the shape at
 * rest follows the body, `drift` becomes the rigid acceleration that shape memory must not leave. */
static inline void pull_groups(body *b, int fitted) {
    wide volume = {0}, sum[6] = {{0}};
    lanes part[6] = {{0}}, dt = all((real)b->dt), sixth = all((real)1 / 6);
    three offset = splat3(b->translation), linear = splat3(b->drift.linear), angular = splat3(b->drift.angular);
    three gravity = splat3(b->gravity);
    three rows[3] = {splat3(b->rotation), splat3(b->rotation + 3), splat3(b->rotation + 6)};
    for (int64_t g = 0; g < b->groups; g++) {
        const group_matter *m = b->matter + g;
        three x = b->state[g].x, v = b->state[g].v, w = v, d, first, before, after, normal = {all(0), all(0), all(0)};
        /* shape memory first: its root and division are done while the neighbours are gathered */
        if (fitted) {
            three spin = cross(angular, x);
            w = (three){v.x - linear.x - spin.x, v.y - linear.y - spin.y, v.z - linear.z - spin.z};
        }
        three force = hold(m, minus(x, rotated(rows, m->rest, offset)), w);
        if (fitted) {
            three turning = cross(x, force);
            part[0] += force.x, part[1] += force.y, part[2] += force.z;
            part[3] += turning.x, part[4] += turning.y, part[5] += turning.z;
            if (g % RUN == RUN - 1) fold(part, sum, 6);
        }
        const slot *s = b->ring.slots + b->ring.start[g], *end = b->ring.slots + b->ring.start[g + 1];
        if (s < end) {
            gather(b, s, x, v, &first, &w);
            pull(s, first, w, &force);
            for (before = first, s++; s + 1 < end; s += 2, before = after) {
                gather(b, s, x, v, &d, &w);
                pull(s, d, w, &force);
                gather(b, s + 1, x, v, &after, &w);
                pull(s + 1, after, w, &force);
                turn(before, d, after, &normal);
            }
            if (s < end) {
                gather(b, s, x, v, &d, &w);
                pull(s, d, w, &force);
                turn(before, d, first, &normal);
            } else {
                after = cross(before, first);
                normal.x += after.x, normal.y += after.y, normal.z += after.z;
            }
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

static void pull_bend(body *b) {
    for (int64_t g = 0; b->bend.start && g < b->groups; g++) {
        three d, w, force = {all(0), all(0), all(0)}, v = b->next[g].v;
        for (int64_t s = b->bend.start[g]; s < b->bend.start[g + 1]; s++) {
            gather(b, b->bend.slots + s, b->state[g].x, b->state[g].v, &d, &w);
            pull(b->bend.slots + s, d, w, &force);
        }
        lanes by = all((real)b->dt) * b->matter[g].inverse_mass;
        b->next[g].v = (three){v.x + by * force.x, v.y + by * force.y, v.z + by * force.z};
    }
}
