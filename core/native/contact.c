/* Fingertips against vertices and faces, vertices against the ground. Source: core/body/contact.py. */
#include "body.h"

static void mark_moved(body *b, uint32_t i, uint32_t *count) {
    if (!b->is_moved[i]) b->is_moved[i] = 1, b->moved[(*count)++] = i;
}

/* Move inside vertices to the surface of the sphere and stop them there, as far as friction goes. */
static void meet_vertices(body *b, const touch *t, double *impulse, uint32_t *moved) {
    for (int64_t k = 0; k < t->vertex_count; k++) {
        uint32_t i = t->vertices[k];
        record *r = b->records + i;
        quad offset = r->x - t->centre;
        real distance = SQRT(dot3(offset, offset));
        if (!(distance < t->radius * (real)(1 - ROUNDING))) continue;
        if (distance < t->radius * (real)TOO_NEAR) continue; /* no direction: its faces have one */
        real give = b->inverse_mass[i] > TINY ? b->inverse_mass[i] : TINY;
        quad normal = offset / distance, relative = r->v - t->velocity;
        real closing = dot3(relative, normal), push = (closing < 0 ? -closing : 0) / give;
        quad slide = relative - closing * normal;
        real speed = SQRT(dot3(slide, slide)), drag = b->friction[i] * push, most = speed / give;
        drag = (drag < most ? drag : most) / (speed > TINY ? speed : TINY);
        quad j = push * normal - drag * slide;
        r->v += j * b->inverse_mass[i];
        r->x += (t->radius - distance) / give * b->inverse_mass[i] * normal;
        for (int c = 0; c < 3; c++) impulse[c] -= j[c];
        mark_moved(b, i, moved);
    }
}

static inline three corners_at(const body *b, const uint32_t (*face)[3], int corner, three centre) {
    uint32_t at[LANES];
    three x, v;
    for (int l = 0; l < LANES; l++) at[l] = face[l][corner] * (uint32_t)sizeof(record);
    lanes_of(b->records, at, &x, &v);
    return minus(x, centre);
}

/* Return the weights of the points of eight triangles nearest to the origin.
 * Source: Ericson, Real-Time Collision Detection, 5.1.5: which of the seven Voronoi regions holds it. */
static inline three nearest(three a, three b, three c) {
    three ab = minus(b, a), ac = minus(c, a);
    lanes d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b), d5 = -dot(ab, c), d6 = -dot(ac, c);
    lanes va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, none = all(0), one = all(1);
    lanes v = vb, w = vc, whole = va + vb + vc; /* weights v / whole, w / whole; the first region to hold comes last */
    mask in_bc = (mask)(va <= none) & (mask)(d4 >= d3) & (mask)(d5 >= d6);
    w = select(in_bc, d4 - d3, w), whole = select(in_bc, (d4 - d3) + (d5 - d6), whole);
    mask in_ac = (mask)(vb <= none) & (mask)(d2 >= none) & (mask)(d6 <= none);
    v = select(in_ac, none, v), w = select(in_ac, d2, w), whole = select(in_ac, d2 - d6, whole);
    mask in_ab = (mask)(vc <= none) & (mask)(d1 >= none) & (mask)(d3 <= none);
    v = select(in_ab, d1, v), w = select(in_ab, none, w), whole = select(in_ab, d1 - d3, whole);
    mask in_c = (mask)(d6 >= none) & (mask)(d5 <= d6), in_b = (mask)(d3 >= none) & (mask)(d4 <= d3);
    mask in_a = (mask)(d1 <= none) & (mask)(d2 <= none), at_corner = in_a | in_b | in_c;
    v = select(in_c, none, v), w = select(in_c, one, w);
    v = select(in_b, one, v), w = select(in_b, none, w);
    v = select(in_a, none, v), w = select(in_a, none, w);
    mask some = ((mask)(whole > all(TINY)) | (mask)(whole < all(-TINY))) & ~at_corner;
    whole = select(some, whole, one);
    v /= whole, w /= whole;
    v = select(in_bc & ~(in_ac | in_ab | at_corner), one - w, v);
    return (three){one - v - w, v, w};
}

/* The inward unit normal of a face: a fingertip came from outside. */
static quad inward(const body *b, const uint32_t *corner) {
    quad a = b->records[corner[0]].x, p = b->records[corner[2]].x - a, q = b->records[corner[1]].x - a;
    quad normal = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0], 0};
    real size = SQRT(dot3(normal, normal));
    return normal / (size > TINY ? size : TINY);
}

/* List the faces inside a sphere with their nearest points, and count the contacts at each corner. */
static int64_t find_hits(body *b, const touch *t) {
    three centre = {all(t->centre[0]), all(t->centre[1]), all(t->centre[2])};
    int64_t count = 0;
    for (int64_t k = 0; k < t->face_count; k += LANES) {
        const uint32_t (*face)[3] = (const uint32_t (*)[3])t->faces + k;
        three p = corners_at(b, face, 0, centre), q = corners_at(b, face, 1, centre);
        three r = corners_at(b, face, 2, centre), weight = nearest(p, q, r);
        three at = {
            weight.x * p.x + weight.y * q.x + weight.z * r.x,
            weight.x * p.y + weight.y * q.y + weight.z * r.y,
            weight.x * p.z + weight.y * q.z + weight.z * r.z,
        };
        lanes distance = root(dot(at, at));
        mask inside = (mask)(distance < all(t->radius * (real)(1 - ROUNDING)));
        if (!any(inside)) continue;
        for (int l = 0; l < LANES && k + l < t->face_count; l++) {
            if (!inside[l]) continue;
            hit *h = b->hits + count++;
            memcpy(h->corner, face[l], sizeof h->corner);
            h->weight[0] = weight.x[l], h->weight[1] = weight.y[l], h->weight[2] = weight.z[l];
            h->distance = distance[l] > TINY ? distance[l] : TINY;
            h->normal = (quad){at.x[l], at.y[l], at.z[l], 0} / h->distance;
            if (h->distance < t->radius * (real)TOO_NEAR) h->normal = inward(b, h->corner);
            for (int j = 0; j < 3; j++) b->shares[h->corner[j]] += h->weight[j] > (real)WEIGHT_FLOOR;
        }
    }
    return count;
}

/* What a contact gives, 1 / mass: each moves its share m / count of a vertex, which then takes the mean of them. */
static inline real give_of(const body *b, const hit *h, real *mobility) {
    real give = 0, free = 0, most = 0;
    int held = 0;
    for (int j = 0; j < 3; j++) {
        real inverse = b->inverse_mass[h->corner[j]];
        mobility[j] = h->weight[j] * inverse;
        give += mobility[j] * h->weight[j] * (real)b->shares[h->corner[j]];
        free += inverse > 0 ? h->weight[j] : 0;
        most = inverse > most ? inverse : most;
        held |= !(inverse > 0);
    }
    give = give > TINY ? give : TINY;
    if (held) { /* a free vertex must not be flung away to move a point it hardly carries */
        real least = (real)HELD_GIVE * most / (free > TINY ? free : TINY);
        give = give > least ? give : least;
    }
    return give;
}

/* One sweep over the faces, all from the same state; return how deep the deepest was. */
static real meet_faces(body *b, const touch *t, double *impulse, uint32_t *moved) {
    int64_t count = find_hits(b, t);
    real nearest_at = t->radius;
    for (hit *h = b->hits; h < b->hits + count; h++) {
        const uint32_t *at = h->corner;
        real mu = 0, give = give_of(b, h, h->mobility);
        quad relative = -t->velocity;
        for (int j = 0; j < 3; j++)
            relative += h->weight[j] * b->records[at[j]].v, mu += h->weight[j] * b->friction[at[j]];
        real closing = dot3(relative, h->normal), push = (closing < 0 ? -closing : 0) / give;
        quad slide = relative - closing * h->normal;
        real speed = SQRT(dot3(slide, slide)), drag = mu * push, most = speed / give;
        drag = (drag < most ? drag : most) / (speed > TINY ? speed : TINY);
        h->impulse = push * h->normal - drag * slide;
        h->out = (t->radius - h->distance) / give * h->normal;
        nearest_at = h->distance < nearest_at ? h->distance : nearest_at;
    }
    for (const hit *h = b->hits; h < b->hits + count; h++) {
        for (int j = 0; j < 3; j++) {
            record *r = b->records + h->corner[j];
            r->x += h->out * h->mobility[j], r->v += h->impulse * h->mobility[j];
            b->shares[h->corner[j]] = 0;
            mark_moved(b, h->corner[j], moved);
        }
        for (int c = 0; c < 3; c++) impulse[c] -= h->impulse[c];
    }
    return t->radius - nearest_at;
}

/* Bring the vertices that contacts moved back into the groups. */
static void take_back(body *b, uint32_t moved) {
    for (uint32_t k = 0; k < moved; k++) {
        uint32_t i = b->moved[k];
        set_lane3(&b->state[i / LANES].x, i, b->records[i].x), set_lane3(&b->state[i / LANES].v, i, b->records[i].v);
        b->is_moved[i] = 0;
    }
}

static void rest_on_ground(body *b) {
    lanes height = all((real)(b->ground - b->origin[2]));
    uint32_t moved = 0;
    for (int64_t g = 0; g < b->groups; g++) {
        mask low = (mask)(b->state[g].x.z < height) & (mask)(b->matter[g].inverse_mass > all(0));
        for (uint32_t l = 0; any(low) && l < LANES; l++) {
            uint32_t i = (uint32_t)g * LANES + l;
            if (!low[l]) continue;
            record *r = b->records + i;
            real fall = r->v[2] < 0 ? -r->v[2] : 0, speed = SQRT(r->v[0] * r->v[0] + r->v[1] * r->v[1]);
            real stop = b->friction[i] * fall / (speed > TINY ? speed : TINY), left = 1 - (stop < 1 ? stop : 1);
            r->v[0] *= left, r->v[1] *= left, r->v[2] += fall, r->x[2] = height[0];
            mark_moved(b, i, &moved);
        }
    }
    take_back(b, moved);
}

static void note_touching(body *b) {
    memset(b->touching, 0, (size_t)(b->groups * LANES));
    for (const touch *t = b->touches; t < b->touches + b->finger_count; t++) {
        real reach = t->radius * (real)(1 + ROUNDING);
        for (int64_t k = 0; k < t->vertex_count; k++) {
            quad offset = b->records[t->vertices[k]].x - t->centre;
            if (dot3(offset, offset) < reach * reach) b->touching[t->vertices[k]] = 1;
        }
    }
}

static void meet(body *b, dm_frame *frame) {
    if (b->law_set == DM_LAWS_PAPER || b->fill == DM_FILL_PAPER) note_touching(b);
    for (int k = 0; k < b->finger_count; k++) {
        const touch *t = b->touches + k;
        double *impulse = frame->touches[t->finger].impulse;
        uint32_t moved = 0;
        meet_vertices(b, t, impulse, &moved);
        int sweeps = b->law_set != DM_LAWS_PAPER && t->face_count ? FACE_SWEEPS : 0;
        while (sweeps-- && meet_faces(b, t, impulse, &moved) >= (real)FACE_SLACK * t->radius) {
        }
        take_back(b, moved);
    }
    if (b->ground > -INFINITY) rest_on_ground(b);
}
