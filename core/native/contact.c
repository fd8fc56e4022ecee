/* Fingertips against vertices and faces, vertices against the ground. Source: core/body/contact.py. */
#include "body.h"

static void dm_mark_moved(dm_state *b, uint32_t i, uint32_t *count) {
    if (!b->is_moved[i]) b->is_moved[i] = 1, b->moved[(*count)++] = i;
}

/* Note where a vertex was before this substep; none has gone farther than the skin may travel. */
DM_INLINE void dm_note_before(dm_state *b, uint32_t i) {
    const dm_record *r = b->records + i;
    dm_real dt = (dm_real)b->dt, travel = (dm_real)b->skin_travel, speed = DM_SQRT(dm_dot3(r->v, r->v));
    b->before[i] = r->x - r->v * (travel > 0 && speed * dt > travel ? travel / speed : dt);
}

static void dm_note_all_before(dm_state *b, const dm_near *t) {
    for (int64_t k = 0; k < t->noted_count; k++) dm_note_before(b, t->noted[k]);
}

/* Return the way of a point that is `at` from the centre, over what gives: back by so much of the substep's slip as
 * friction holds, and out to the sphere. The normal is that at the begin of the substep: where the forces of a substep
 * would have carried the point depends on how long it is, and friction may not. */
DM_INLINE dm_quad dm_way_out(const dm_state *b, dm_quad at, dm_quad normal, dm_real radius, dm_real held, dm_real give,
                             dm_real *depth) {
    dm_real reached = dm_dot3(at, normal);
    dm_quad slip = at - reached * normal;
    dm_real length = DM_SQRT(dm_dot3(slip, slip)), share = (dm_real)b->dt * held / (length > DM_TINY ? length : DM_TINY);
    share = share < 1 / give ? share : 1 / give;
    dm_real left = length * (1 - give * share), square = radius * radius - left * left;
    dm_real out = DM_SQRT(square > 0 ? square : 0) - reached;
    *depth = out > 0 ? out : 0;
    return *depth / give * normal - share * slip;
}

/* Move inside vertices to the surface of the sphere and stop them there, as far as friction goes. */
static void dm_resolve_vertices(dm_state *b, const dm_near *t, double *impulse, uint32_t *moved) {
    for (int64_t k = 0; k < t->vertex_count; k++) {
        uint32_t i = t->vertices[k];
        dm_record *r = b->records + i;
        dm_quad offset = r->x - t->centre;
        dm_real distance = DM_SQRT(dm_dot3(offset, offset));
        if (!(distance < t->radius * (dm_real)(1 - DM_ROUNDING))) continue;
        dm_real give = b->inverse_mass[i] > DM_TINY ? b->inverse_mass[i] : DM_TINY, depth;
        dm_quad first = b->before[i] + (dm_real)b->dt * t->velocity - t->centre;
        dm_real apart = DM_SQRT(dm_dot3(first, first));
        if (apart < t->radius * (dm_real)DM_TOO_NEAR) continue; /* no direction: its faces have one */
        dm_quad normal = first / apart, relative = r->v - t->velocity;
        dm_real closing = dm_dot3(relative, normal), push = (closing < 0 ? -closing : 0) / give;
        dm_quad slide = relative - closing * normal;
        dm_real speed = DM_SQRT(dm_dot3(slide, slide)), drag = b->friction[i] * push, most = speed / give;
        drag = (drag < most ? drag : most) / (speed > DM_TINY ? speed : DM_TINY);
        dm_quad j = push * normal - drag * slide;
        r->v += j * b->inverse_mass[i];
        r->x += b->inverse_mass[i] * dm_way_out(b, offset, normal, t->radius, b->friction[i] * push, give, &depth);
        for (int c = 0; c < 3; c++) impulse[c] -= j[c];
        dm_mark_moved(b, i, moved);
    }
}

DM_INLINE dm_vec3 dm_corners_at(const dm_state *b, const uint32_t (*face)[3], int corner, dm_vec3 centre) {
    uint32_t at[DM_LANES];
    dm_vec3 x, v;
    for (int l = 0; l < DM_LANES; l++) at[l] = face[l][corner] * (uint32_t)sizeof(dm_record);
    dm_gather8(b->records, at, &x, &v);
    return dm_sub(x, centre);
}

/* Return the weights of the points of eight triangles nearest to the origin.
 * Source: Ericson, Real-Time Collision Detection, 5.1.5: which of the seven Voronoi regions holds it. */
DM_INLINE dm_vec3 dm_nearest_weights(dm_vec3 a, dm_vec3 b, dm_vec3 c) {
    dm_vec3 ab = dm_sub(b, a), ac = dm_sub(c, a);
    dm_lanes d1 = -dm_dot(ab, a), d2 = -dm_dot(ac, a), d3 = -dm_dot(ab, b), d4 = -dm_dot(ac, b);
    dm_lanes d5 = -dm_dot(ab, c), d6 = -dm_dot(ac, c);
    dm_lanes va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    dm_lanes none = dm_splat(0), one = dm_splat(1);
    /* weights v / whole, w / whole; the first region to hold comes last */
    dm_lanes v = vb, w = vc, whole = va + vb + vc;
    dm_mask in_bc = (dm_mask)(va <= none) & (dm_mask)(d4 >= d3) & (dm_mask)(d5 >= d6);
    w = dm_blend(in_bc, d4 - d3, w), whole = dm_blend(in_bc, (d4 - d3) + (d5 - d6), whole);
    dm_mask in_ac = (dm_mask)(vb <= none) & (dm_mask)(d2 >= none) & (dm_mask)(d6 <= none);
    v = dm_blend(in_ac, none, v), w = dm_blend(in_ac, d2, w), whole = dm_blend(in_ac, d2 - d6, whole);
    dm_mask in_ab = (dm_mask)(vc <= none) & (dm_mask)(d1 >= none) & (dm_mask)(d3 <= none);
    v = dm_blend(in_ab, d1, v), w = dm_blend(in_ab, none, w), whole = dm_blend(in_ab, d1 - d3, whole);
    dm_mask in_c = (dm_mask)(d6 >= none) & (dm_mask)(d5 <= d6), in_b = (dm_mask)(d3 >= none) & (dm_mask)(d4 <= d3);
    dm_mask in_a = (dm_mask)(d1 <= none) & (dm_mask)(d2 <= none), at_corner = in_a | in_b | in_c;
    v = dm_blend(in_c, none, v), w = dm_blend(in_c, one, w);
    v = dm_blend(in_b, one, v), w = dm_blend(in_b, none, w);
    v = dm_blend(in_a, none, v), w = dm_blend(in_a, none, w);
    dm_mask some = ((dm_mask)(whole > dm_splat(DM_TINY)) | (dm_mask)(whole < dm_splat(-DM_TINY))) & ~at_corner;
    whole = dm_blend(some, whole, one);
    v /= whole, w /= whole;
    v = dm_blend(in_bc & ~(in_ac | in_ab | at_corner), one - w, v);
    return (dm_vec3){one - v - w, v, w};
}

/* The inward unit normal of a face: a fingertip came from outside. */
DM_INLINE dm_quad dm_inward_normal(const dm_state *b, const uint32_t *corner) {
    dm_quad a = b->records[corner[0]].x, p = b->records[corner[2]].x - a, q = b->records[corner[1]].x - a;
    dm_quad normal = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0], 0};
    dm_real size = DM_SQRT(dm_dot3(normal, normal));
    return normal / (size > DM_TINY ? size : DM_TINY);
}

/* The points of eight triangles with these weights. */
DM_INLINE dm_vec3 dm_point_on(dm_vec3 p, dm_vec3 q, dm_vec3 r, dm_vec3 w) {
    return (dm_vec3){
        w.x * p.x + w.y * q.x + w.z * r.x, w.x * p.y + w.y * q.y + w.z * r.y, w.x * p.z + w.y * q.z + w.z * r.z,
    };
}

/* Return the points of eight triangles nearest to the origin, and their weights. */
static __attribute__((noinline)) dm_vec3 dm_nearest_points(dm_vec3 p, dm_vec3 q, dm_vec3 r, dm_vec3 *weight) {
    *weight = dm_nearest_weights(p, q, r);
    return dm_point_on(p, q, r, *weight);
}

/* Return the radius of the sphere that a facet meets: smaller, unless it is too large to bend round the fingertip. */
static dm_real dm_met_radius(const dm_state *b, const uint32_t *at, dm_real radius) {
    dm_real bulge = 0;
    for (int j = 0; j < 3; j++) {
        const dm_vec3 *p = &b->matter[at[j] / DM_LANES].rest, *q = &b->matter[at[(j + 1) % 3] / DM_LANES].rest;
        uint32_t k = at[j] % DM_LANES, m = at[(j + 1) % 3] % DM_LANES;
        dm_real x = p->x[k] - q->x[m], y = p->y[k] - q->y[m], z = p->z[k] - q->z[m];
        bulge += (x * x + y * y + z * z) / (18 * radius);
    }
    dm_real left = (dm_real)DM_STIFF * radius - bulge, sunk = (dm_real)DM_SUNK * radius;
    return radius - (sunk < left ? sunk : left > 0 ? left : 0);
}

/* Find the points of the faces that were nearest when the substep began. */
static void dm_face_fingertip(dm_state *b, const dm_near *t) {
    dm_quad from = t->centre - (dm_real)b->dt * t->velocity;
    dm_vec3 centre = {dm_splat(from[0]), dm_splat(from[1]), dm_splat(from[2])};
    for (int64_t k = 0; k < t->face_count; k += DM_LANES) {
        dm_vec3 x[3];
        for (int j = 0; j < 3; j++) {
            uint32_t at[DM_LANES];
            dm_lanes fourth;
            for (int l = 0; l < DM_LANES; l++) at[l] = t->faces[k + l][j] * (uint32_t)sizeof(dm_quad);
            x[j] = dm_sub(dm_gather_quads(b->before, at, &fourth), centre);
        }
        dm_facing *to = b->facing + k / DM_LANES;
        to->first = dm_nearest_points(x[0], x[1], x[2], &to->weight);
    }
}

/* List the faces whose nearest points are inside a sphere now, and count the contacts at each corner. */
static int64_t dm_find_contacts(dm_state *b, const dm_near *t) {
    dm_vec3 centre = {dm_splat(t->centre[0]), dm_splat(t->centre[1]), dm_splat(t->centre[2])};
    int64_t count = 0;
    for (int64_t k = 0; k < t->face_count; k += DM_LANES) {
        const uint32_t (*face)[3] = (const uint32_t (*)[3])t->faces + k;
        dm_vec3 p = dm_corners_at(b, face, 0, centre), q = dm_corners_at(b, face, 1, centre);
        dm_vec3 r = dm_corners_at(b, face, 2, centre), weight = b->facing[k / DM_LANES].weight;
        dm_vec3 first = b->facing[k / DM_LANES].first, at = dm_point_on(p, q, r, weight);
        dm_lanes distance = dm_vsqrt(dm_dot(at, at)), radius;
        memcpy(&radius, t->radii + k, sizeof radius);
        dm_mask inside = (dm_mask)(distance < radius * dm_splat((dm_real)(1 - DM_ROUNDING)));
        if (!dm_any_of(inside)) continue;
        for (int l = 0; l < DM_LANES && k + l < t->face_count; l++) {
            if (!inside[l]) continue;
            dm_contact *h = b->hits + count++;
            memcpy(h->corner, face[l], sizeof h->corner);
            h->weight[0] = weight.x[l], h->weight[1] = weight.y[l], h->weight[2] = weight.z[l];
            h->at = (dm_quad){at.x[l], at.y[l], at.z[l], 0}, h->normal = (dm_quad){first.x[l], first.y[l], first.z[l], 0};
            h->radius = radius[l];
            dm_real apart = DM_SQRT(dm_dot3(h->normal, h->normal));
            if (apart < t->radius * (dm_real)DM_TOO_NEAR) h->normal = dm_inward_normal(b, h->corner);
            else h->normal /= apart;
            for (int j = 0; j < 3; j++) b->shares[h->corner[j]] += h->weight[j] > (dm_real)DM_WEIGHT_FLOOR;
        }
    }
    return count;
}

/* What a contact gives, 1 / mass: each moves its share m / count of a vertex, which then takes the mean of them. */
DM_INLINE dm_real dm_compliance_of(const dm_state *b, const dm_contact *h, dm_real *mobility) {
    dm_real give = 0, free = 0, most = 0;
    int pinned = 0;
    for (int j = 0; j < 3; j++) {
        dm_real inverse = b->inverse_mass[h->corner[j]];
        mobility[j] = h->weight[j] * inverse;
        give += mobility[j] * h->weight[j] * (dm_real)b->shares[h->corner[j]];
        free += inverse > 0 ? h->weight[j] : 0;
        most = inverse > most ? inverse : most;
        pinned |= !(inverse > 0);
    }
    give = give > DM_TINY ? give : DM_TINY;
    if (pinned) { /* a free vertex must not be flung away to move a point it hardly carries */
        dm_real least = (dm_real)DM_PINNED_GIVE * most / (free > DM_TINY ? free : DM_TINY);
        give = give > least ? give : least;
    }
    return give;
}

/* One sweep over the faces, all from the same state; return how deep the deepest was. */
static dm_real dm_resolve_faces(dm_state *b, const dm_near *t, double *impulse, uint32_t *moved) {
    int64_t count = dm_find_contacts(b, t);
    dm_real deepest = 0;
    for (dm_contact *h = b->hits; h < b->hits + count; h++) {
        const uint32_t *at = h->corner;
        dm_real mu = 0, give = dm_compliance_of(b, h, h->mobility), depth;
        dm_quad relative = -t->velocity;
        for (int j = 0; j < 3; j++) {
            relative += h->weight[j] * b->records[at[j]].v, mu += h->weight[j] * b->friction[at[j]];
        }
        dm_real closing = dm_dot3(relative, h->normal), push = (closing < 0 ? -closing : 0) / give;
        dm_quad slide = relative - closing * h->normal;
        dm_real speed = DM_SQRT(dm_dot3(slide, slide)), drag = mu * push, most = speed / give;
        drag = (drag < most ? drag : most) / (speed > DM_TINY ? speed : DM_TINY);
        h->impulse = push * h->normal - drag * slide;
        h->out = dm_way_out(b, h->at, h->normal, h->radius, mu * push, give, &depth);
        deepest = depth > deepest ? depth : deepest;
    }
    for (const dm_contact *h = b->hits; h < b->hits + count; h++) {
        for (int j = 0; j < 3; j++) {
            dm_record *r = b->records + h->corner[j];
            r->x += h->out * h->mobility[j], r->v += h->impulse * h->mobility[j];
            b->shares[h->corner[j]] = 0;
            dm_mark_moved(b, h->corner[j], moved);
        }
        for (int c = 0; c < 3; c++) impulse[c] -= h->impulse[c];
    }
    return deepest;
}

/* Bring the vertices that contacts moved back into the groups. */
static void dm_update_groups(dm_state *b, uint32_t moved) {
    for (uint32_t k = 0; k < moved; k++) {
        uint32_t i = b->moved[k];
        dm_set_lane3(&b->state[i / DM_LANES].x, i, b->records[i].x);
        dm_set_lane3(&b->state[i / DM_LANES].v, i, b->records[i].v);
        b->is_moved[i] = 0;
    }
}

static void dm_rest_on_ground(dm_state *b) {
    dm_lanes height = dm_splat((dm_real)(b->ground - b->origin[2]));
    uint32_t moved = 0;
    for (int64_t g = 0; g < b->groups; g++) {
        dm_mask low = (dm_mask)(b->state[g].x.z < height) & (dm_mask)(b->matter[g].inverse_mass > dm_splat(0));
        for (uint32_t l = 0; dm_any_of(low) && l < DM_LANES; l++) {
            uint32_t i = (uint32_t)g * DM_LANES + l;
            if (!low[l]) continue;
            dm_record *r = b->records + i;
            dm_real fall = r->v[2] < 0 ? -r->v[2] : 0, speed = DM_SQRT(r->v[0] * r->v[0] + r->v[1] * r->v[1]);
            dm_real stop = b->friction[i] * fall / (speed > DM_TINY ? speed : DM_TINY);
            dm_real left = 1 - (stop < 1 ? stop : 1);
            for (int c = 0; c < 2; c++) /* the slip of the step as well, or it would creep */
                r->x[c] -= (dm_real)b->dt * (1 - left) * r->v[c], r->v[c] *= left;
            r->v[2] += fall, r->x[2] = height[0];
            dm_mark_moved(b, i, &moved);
        }
    }
    dm_update_groups(b, moved);
}

static void dm_note_contact(dm_state *b) {
    memset(b->touching, 0, (size_t)(b->groups * DM_LANES));
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        dm_real reach = t->radius * (dm_real)(1 + DM_ROUNDING);
        for (int64_t k = 0; k < t->vertex_count; k++) {
            dm_quad offset = b->records[t->vertices[k]].x - t->centre;
            if (dm_dot3(offset, offset) < reach * reach) b->touching[t->vertices[k]] = 1;
        }
    }
}

static void dm_resolve_contact(dm_state *b, dm_frame *frame) {
    if (b->law_set == DM_LAWS_PAPER) dm_note_contact(b);
    for (int k = 0; k < b->finger_count; k++) {
        const dm_near *t = b->touches + k;
        double *impulse = frame->touches[t->finger].impulse;
        uint32_t moved = 0;
        dm_note_all_before(b, t);
        if (b->law_set != DM_LAWS_PAPER) dm_face_fingertip(b, t);
        dm_resolve_vertices(b, t, impulse, &moved);
        int sweeps = b->law_set != DM_LAWS_PAPER && t->face_count ? DM_FACE_SWEEPS : 0;
        for (int sweep = 1; sweep <= sweeps; sweep++) {
            dm_real depth = dm_resolve_faces(b, t, impulse, &moved);
            if (depth <= 0 || (sweep >= DM_LEAST_SWEEPS && depth < (dm_real)DM_FACE_SLACK * t->radius)) break;
        }
        dm_update_groups(b, moved);
    }
    if (b->ground > -INFINITY) dm_rest_on_ground(b);
}
