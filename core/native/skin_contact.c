/* Contact of fingertips with vertices and faces, and of vertices with the ground.
 * Source: studies/reference/contact.py. */
#include "body.h"

/* Forget the impulses of a fingertip. */
static void dm_forget_impulses(dm_state *b, int finger) {
    for (uint32_t k = 0; k < b->fingers[finger].kept_count; k++)
        b->fingers[finger].kept[b->fingers[finger].kept_at[k]] = (dm_quad){0, 0, 0, 0};
    b->fingers[finger].kept_count = 0;
}

static void dm_mark_moved(dm_state *b, uint32_t i, uint32_t *count) {
    if (!b->is_moved[i]) b->is_moved[i] = 1, b->moved[(*count)++] = i;
}

/* Return the way of a vertex in this substep, limited to the travel of the skin. */
DM_INLINE dm_quad dm_way_of(const dm_state *b, dm_quad v) {
    dm_real dt = (dm_real)b->dt, travel = (dm_real)b->skin_travel, speed = DM_SQRT(dm_dot3(v, v));
    return v * (travel > 0 && speed * dt > travel ? travel / speed : dt);
}

/* Store where the vertices near a fingertip were before this substep; return the highest speed. */
static dm_real dm_note_before(dm_state *b, const dm_near *t) {
    dm_real fastest = 0;
    for (int64_t k = 0; k < t->noted_count; k++) {
        const dm_record *r = b->records + t->noted[k];
        dm_real square = dm_dot3(r->v, r->v);
        fastest = square > fastest ? square : fastest;
        b->before[t->noted[k]] = r->x - dm_way_of(b, r->v);
    }
    return DM_SQRT(fastest);
}

DM_INLINE int dm_was_held(const dm_state *b, int finger, uint32_t number) {
    dm_quad impulse = b->fingers[finger].kept[number];
    return dm_dot3(impulse, impulse) > 0;
}

/* Return the mean vector from a fingertip's centre to the movable vertices inside it, weighted by depth, or 0.
 * Friction is not part of it. */
static dm_quad dm_way_of_push(const dm_state *b, const dm_near *t) {
    dm_quad sum = {0, 0, 0, 0}, from = t->now - (dm_real)b->dt * t->velocity;
    for (int64_t k = 0; k < t->vertex_count; k++) {
        if (!(b->compliance[t->vertices[k]] > 0)) continue;
        dm_quad at = b->before[t->vertices[k]] - from;
        dm_real deep = t->radius - DM_SQRT(dm_dot3(at, at));
        if (deep > 0) sum += deep * at;
    }
    dm_real length = DM_SQRT(dm_dot3(sum, sum));
    return length > 0 ? sum / length : sum;
}

/* Make a contact with the skin of a solid compliant. It yields away from a point behind the fingertip's centre, so
 * that it is pressed down and not aside. Return the gap at which a spring with its present stiffness would begin. */
static dm_real dm_give_way(dm_state *b, const dm_near *t, dm_contact *h, dm_quad at, dm_real apart) {
    dm_real inverse = 1 / (dm_real)(b->dt * b->dt), gap = apart - h->radius;
    h->part = 1; /* its depth follows from its impulse alone */
    h->yields *= (h->corners > 1 ? 4 : 2) * inverse; /* vertices bear half, and faces, of which there are twice as many, the other half */
    if (gap >= 0) return gap;
    dm_quad way = at + t->radius * t->pushed;
    dm_real length = DM_SQRT(dm_dot3(way, way));
    if (length > (dm_real)DM_TRAVEL * t->radius) h->normal = way / length;
    dm_real along = dm_dot3(at, h->normal), deep = DM_SQRT(along * along - gap * (apart + h->radius)) - along;
    /* p = deep / (c (1 - s^2)) with s = deep / most, linearised there */
    dm_real most = (dm_real)DM_MOST_GIVEN * t->radius, s = deep / most;
    s = s < (dm_real)DM_HARDEST ? s : (dm_real)DM_HARDEST;
    dm_real left = 1 - s * s, tangent = left / (1 + s * s);
    h->yields *= left * tangent;
    return -(deep - most * s + most * s * tangent);
}

/* Add the contact of a fingertip with a vertex or a point of a face if it may act in this substep: the point comes
 * within the margin, or was held in the last substep. */
static int64_t dm_list_contact(dm_state *b, const dm_near *t, dm_quad from, uint32_t number, int corners,
                               const uint32_t *corner, dm_quad weight, dm_real radius, dm_real margin, int64_t count) {
    int held = dm_was_held(b, t->finger, number);
    dm_real part = held ? (dm_real)DM_BACK : 1;
    dm_quad at = -from;
    for (int j = 0; j < corners; j++) at += weight[j] * b->before[corner[j]];
    dm_real apart = DM_SQRT(dm_dot3(at, at)), gap = apart - radius;
    int at_centre = apart < t->radius * (dm_real)DM_TOO_NEAR; /* a vertex there has no direction, its faces have */
    if (!(held || gap < margin) || (at_centre && corners == 1)) return count;
    dm_contact *h = b->hits + count;
    *h = (dm_contact){.number = number, .corners = corners, .radius = radius, .part = part, .weight = weight};
    memcpy(h->corner, corner, (size_t)corners * sizeof *corner);
    h->held = b->fingers[t->finger].kept[number];
    dm_real holds = 1 - (dm_real)b->fingers[t->finger].slides; /* as the fingertip slides on the surface at rest */
    h->normal = at_centre ? dm_inward_normal(b, corner) : at / apart;
    for (int j = 0; j < corners; j++) {
        h->friction += holds * weight[j] * b->friction[corner[j]];
        h->yields += weight[j] * b->compliance[corner[j]];
    }
    if (h->yields > 0) gap = dm_give_way(b, t, h, at, apart);
    h->closing = gap > 0 || h->yields > 0 ? -h->part * gap / (dm_real)b->dt : 0;
    return count + 1;
}

/* Add the contacts of a fingertip in this substep, of faces at the points that were nearest when it began. */
static int64_t dm_find_contacts(dm_state *b, const dm_near *t, dm_real margin) {
    dm_quad from = t->now - (dm_real)b->dt * t->velocity;
    dm_vec3 centre = {dm_splat(from[0]), dm_splat(from[1]), dm_splat(from[2])};
    int64_t count = 0;
    for (int64_t k = 0; k < t->vertex_count; k++)
        count = dm_list_contact(b, t, from, t->vertices[k], 1, t->vertices + k, (dm_quad){1, 0, 0, 0}, t->radius, margin,
                                count);
    for (int64_t k = 0; k < t->face_count; k += DM_LANES) {
        const uint32_t (*face)[4] = (const uint32_t (*)[4])t->faces + k;
        dm_vec3 x[3], weight;
        for (int j = 0; j < 3; j++) {
            uint32_t at[DM_LANES];
            dm_lanes fourth;
            for (int l = 0; l < DM_LANES; l++) at[l] = face[l][j] * (uint32_t)sizeof(dm_quad);
            x[j] = dm_sub(dm_gather_quads(b->before, at, &fourth), centre);
        }
        dm_vec3 near = dm_nearest_points(x[0], x[1], x[2], &weight);
        dm_lanes radius;
        memcpy(&radius, t->radii + k, sizeof radius);
        dm_mask met = (dm_mask)(dm_vsqrt(dm_dot(near, near)) < radius + dm_splat(margin));
        for (int l = 0; l < DM_LANES && k + l < t->face_count; l++) {
            uint32_t number = (uint32_t)(b->groups * DM_LANES) + face[l][3];
            if (!met[l] && !dm_was_held(b, t->finger, number)) continue;
            dm_quad here = {weight.x[l], weight.y[l], weight.z[l], 0};
            count = dm_list_contact(b, t, from, number, 3, face[l], here, radius[l], margin, count);
        }
    }
    return count;
}

/* Return the inverse mass of a contact: it moves its part m / count of each vertex, which takes the mean of all its
 * contacts. */
DM_INLINE dm_real dm_compliance_of(const dm_state *b, dm_contact *h) {
    dm_real give = 0, free = 0, most = 0;
    int pinned = 0;
    for (int j = 0; j < h->corners; j++) {
        dm_real inverse = b->inverse_mass[h->corner[j]];
        h->mobility[j] = h->weight[j] * inverse;
        give += h->mobility[j] * h->weight[j] * (dm_real)b->shares[h->corner[j]];
        free += inverse > 0 ? h->weight[j] : 0;
        most = inverse > most ? inverse : most;
        pinned |= !(inverse > 0);
    }
    give = give > DM_LEAST ? give : DM_LEAST;
    if (pinned) { /* a free vertex with a small weight must not be thrown away to move the point */
        dm_real least = (dm_real)DM_PINNED_GIVE * most / (free > DM_LEAST ? free : DM_LEAST);
        give = give > least ? give : least;
    }
    return give;
}

DM_INLINE void dm_share(dm_state *b, const dm_contact *h) {
    for (int j = 0; h->at_work && j < h->corners; j++)
        b->shares[h->corner[j]] += h->weight[j] > (dm_real)DM_ROUNDING;
}

/* Apply an impulse to the vertices of a contact. */
DM_INLINE void dm_push(dm_state *b, const dm_contact *h, dm_quad impulse) {
    for (int j = 0; j < h->corners; j++) {
        uint32_t i = h->corner[j];
        b->records[i].v += h->weight[j] * b->inverse_mass[i] * impulse;
    }
}

/* Warm start: apply the impulses of the last substep, as far as they push along the present normals. */
static void dm_push_as_before(dm_state *b, int64_t count) {
    for (dm_contact *h = b->hits; h < b->hits + count; h++) {
        dm_real push = dm_dot3(h->held, h->normal);
        if (!(push > 0)) h->held = (dm_quad){0, 0, 0, 0};
        dm_push(b, h, h->held);
    }
}

/* One Jacobi sweep over the velocities: change each impulse so that its point stops, within the cone of friction.
 * Return the largest distance [m] by which a change moves a point. */
static dm_real dm_sweep_speeds(dm_state *b, const dm_near *t, int64_t count) {
    dm_contact *end = b->hits + count;
    dm_real most = 0;
    for (dm_contact *h = b->hits; h < end; h++) {
        h->at = -t->velocity;
        for (int j = 0; j < h->corners; j++) h->at += h->weight[j] * b->records[h->corner[j]].v;
        dm_real push = dm_dot3(h->held, h->normal);
        h->at_work = dm_dot3(h->at, h->normal) < h->closing - h->yields * push || push > 0;
        dm_share(b, h);
    }
    for (dm_contact *h = b->hits; h < end; h++) {
        if (!h->at_work) continue;
        dm_real give = dm_compliance_of(b, h), speed = dm_dot3(h->at, h->normal), was = dm_dot3(h->held, h->normal);
        dm_real push = was + (h->closing - speed - h->yields * was) / (give + h->yields);
        push = push * give * (dm_real)b->dt < (dm_real)DM_EXACT * t->radius ? 0 : push;
        dm_quad drag = h->held - was * h->normal - (h->at - speed * h->normal) / give;
        dm_real size = DM_SQRT(dm_dot3(drag, drag)), limit = h->friction * push;
        dm_quad held = push * h->normal + (size > limit ? limit / (size > DM_LEAST ? size : DM_LEAST) : 1) * drag;
        h->change = held - h->held, h->held = held;
        dm_real moved = DM_SQRT(dm_dot3(h->change, h->change)) * give * (dm_real)b->dt;
        most = moved > most ? moved : most;
    }
    for (const dm_contact *h = b->hits; h < end; h++) {
        if (!h->at_work) continue;
        dm_push(b, h, h->change);
        for (int j = 0; j < h->corners; j++) b->shares[h->corner[j]] = 0;
    }
    return most;
}

/* One sweep over the positions: move points that are inside out, without changing velocities; in the first sweep
 * sliding points follow the sphere. Return the largest depth. */
static dm_real dm_sweep_places(dm_state *b, const dm_near *t, int64_t count, int first) {
    dm_contact *end = b->hits + count;
    dm_real deepest = 0;
    for (dm_contact *h = b->hits; h < end; h++) {
        h->at = -t->now;
        for (int j = 0; j < h->corners; j++) h->at += h->weight[j] * b->records[h->corner[j]].x;
        dm_real apart = DM_SQRT(dm_dot3(h->at, h->at)), held = dm_dot3(h->held, h->held);
        h->at_work = apart < h->radius * (dm_real)(1 - DM_ROUNDING) || (first && held > 0 && apart > h->radius);
        h->at_work &= !(h->yields > 0);
        dm_share(b, h);
    }
    for (dm_contact *h = b->hits; h < end; h++) {
        if (!h->at_work) continue;
        dm_real give = dm_compliance_of(b, h), along = dm_dot3(h->at, h->normal);
        dm_quad aside = h->at - along * h->normal;
        dm_real square = h->radius * h->radius - dm_dot3(aside, aside), depth = DM_SQRT(square > 0 ? square : 0) - along;
        dm_real left = (1 - h->part) * depth, most = (dm_real)DM_SLACK / 2 * t->radius, fall = depth + along - h->radius;
        dm_real out = depth > 0 ? depth - (left < most ? left : most) : depth > fall ? depth : fall;
        h->change = out / give * h->normal;
        deepest = depth > deepest ? depth : deepest;
    }
    for (const dm_contact *h = b->hits; h < end; h++) {
        if (!h->at_work) continue;
        for (int j = 0; j < h->corners; j++)
            b->records[h->corner[j]].x += h->mobility[j] * h->change, b->shares[h->corner[j]] = 0;
    }
    return deepest;
}

/* Store the impulses for the next substep, add them up, and store the new velocities of the vertices. */
static void dm_keep_impulses(dm_state *b, const dm_near *t, int64_t count, uint32_t *moved) {
    dm_forget_impulses(b, t->finger);
    uint32_t *kept_count = &b->fingers[t->finger].kept_count;
    for (const dm_contact *h = b->hits; h < b->hits + count; h++) {
        int pinned = 0;
        double at[3] = {0}, held[3] = {h->held[0], h->held[1], h->held[2]}, turn[3];
        for (int j = 0; j < h->corners; j++)
            for (int c = 0; c < 3; c++) at[c] += (double)h->weight[j] * (double)b->before[h->corner[j]][c];
        dm_cross3(at, held, turn);
        for (int c = 0; c < 3; c++) b->skin_push[c] += held[c], b->skin_push[3 + c] += turn[c];
        for (int j = 0; j < h->corners; j++) {
            uint32_t i = h->corner[j];
            pinned |= !(b->inverse_mass[i] > 0);
            if (b->is_moved[i] || !(b->inverse_mass[i] > 0)) continue;
            b->records[i].x = b->before[i] + dm_way_of(b, b->records[i].v);
            dm_mark_moved(b, i, moved);
        }
        if (pinned || !(dm_dot3(h->held, h->held) > 0)) continue; /* at points that cannot move, impulses would add up */
        b->fingers[t->finger].kept[h->number] = h->held;
        b->fingers[t->finger].kept_at[(*kept_count)++] = h->number;
    }
}

/* Write the vertices that contacts moved back into the groups. */
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
            dm_real stop = b->friction[i] * fall / (speed > DM_LEAST ? speed : DM_LEAST);
            dm_real left = 1 - (stop < 1 ? stop : 1);
            for (int c = 0; c < 2; c++) /* the slip of this step as well, or the vertex would creep */
                r->x[c] -= (dm_real)b->dt * (1 - left) * r->v[c], r->v[c] *= left;
            r->v[2] += fall, r->x[2] = height[0];
            dm_mark_moved(b, i, &moved);
        }
    }
    dm_update_groups(b, moved);
}

/* Resolve the contacts of a substep that ends `left` seconds before its tick. */
static void dm_resolve_contact(dm_state *b, double ahead) {
    memset(b->skin_push, 0, sizeof b->skin_push);
    for (dm_near *t = b->touches; t < b->touches + b->finger_count; t++)
        t->now = t->centre - (dm_real)ahead * t->velocity;
    for (int k = 0; k < b->finger_count; k++) {
        dm_near *t = b->touches + k;
        uint32_t moved = 0;
        dm_real fastest = dm_note_before(b, t), dt = (dm_real)b->dt;
        t->pushed = dm_way_of_push(b, t);
        int64_t count = dm_find_contacts(b, t, dt * (2 * fastest + DM_SQRT(dm_dot3(t->velocity, t->velocity))));
        dm_push_as_before(b, count);
        for (int sweep = 0; sweep < DM_SWEEPS; sweep++)
            if (dm_sweep_speeds(b, t, count) < (dm_real)DM_ROUNDING * t->radius) break;
        dm_keep_impulses(b, t, count, &moved);
        for (int sweep = 0; sweep < DM_SWEEPS; sweep++)
            if (dm_sweep_places(b, t, count, sweep == 0) < (dm_real)DM_SLACK * t->radius) break;
        dm_update_groups(b, moved);
    }
    if (b->ground > -INFINITY) dm_rest_on_ground(b);
}
