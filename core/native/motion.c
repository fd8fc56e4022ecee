/* Eqs. (6) to (8): from what comes next to new velocities and positions. */
#include "body.h"

static inline void advance(body *b, double pressure, int fitted) {
    lanes p = all((real)pressure), dt = all((real)b->dt);
    real limit = (real)b->skin_travel;
    three linear = splat3(b->drift.linear), angular = splat3(b->drift.angular);
    for (int64_t g = 0; g < b->groups; g++) {
        three x = b->state[g].x, v = b->next[g].v, n = b->next[g].per_pascal;
        v.x += p * n.x, v.y += p * n.y, v.z += p * n.z;
        if (fitted) { /* whatever net force and torque shape matching left is taken out */
            three spin = cross(angular, x);
            lanes by = select((mask)(b->matter[g].inverse_mass > all(0)), dt, all(0));
            v.x -= by * (linear.x + spin.x), v.y -= by * (linear.y + spin.y), v.z -= by * (linear.z + spin.z);
        }
        three way = {dt * v.x, dt * v.y, dt * v.z};
        if (limit > 0) { /* a deep press must not carry the skin past a fingertip */
            lanes square = dot(way, way);
            mask far = (mask)(square > all(limit * limit));
            if (any(far)) {
                lanes share = select(far, all(limit) / root(square), all(1));
                way.x *= share, way.y *= share, way.z *= share;
            }
        }
        x.x += way.x, x.y += way.y, x.z += way.z;
        b->state[g] = (group_state){x, v};
        quads_of(x, &b->records[g * LANES].x);
        quads_of(v, &b->records[g * LANES].v);
    }
}

static void advance_posed(body *b, double pressure) { advance(b, pressure, 0); }

static void advance_fitted(body *b, double pressure) { advance(b, pressure, 1); }
