/* The vertices and faces that a fingertip may touch within a tick. They are picked from lists with a margin, which are
 * valid until something has moved that far (Verlet 1967). */
#include "body.h"

static double dm_greatest_speed(const dm_state *b) {
    dm_lanes most = dm_splat(0);
    for (int64_t g = 0; g < b->groups; g++) most = dm_vmax(dm_dot(b->state[g].v, b->state[g].v), most);
    return sqrt(dm_most_of(most));
}

/* Return the farthest that a vertex is from where it was. */
static double dm_greatest_way(const dm_state *b, const dm_vec3 *was) {
    dm_lanes most = dm_splat(0);
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 way = dm_sub(b->state[g].x, was[g]);
        most = dm_vmax(dm_dot(way, way), most);
    }
    return sqrt(dm_most_of(most));
}

static void dm_list_vertices(const dm_state *b, dm_near *t, dm_real reach) {
    dm_vec3 centre = {dm_splat(t->centre[0]), dm_splat(t->centre[1]), dm_splat(t->centre[2])};
    t->listed_vertex_count = 0;
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 offset = dm_sub(b->state[g].x, centre);
        dm_mask moves = (dm_mask)(b->matter[g].inverse_mass > dm_splat(0));
        dm_mask near = (dm_mask)(dm_dot(offset, offset) < dm_splat(reach * reach)) & moves;
        for (int l = 0; dm_any_of(near) && l < DM_LANES; l++)
            if (near[l]) t->listed_vertices[t->listed_vertex_count++] = (uint32_t)(g * DM_LANES + l);
    }
}

static void dm_pick_vertices(const dm_state *b, dm_near *t, dm_real reach) {
    t->vertex_count = 0;
    for (int64_t k = 0; k < t->listed_vertex_count; k++) {
        dm_quad offset = b->records[t->listed_vertices[k]].x - t->centre;
        if (dm_dot3(offset, offset) < reach * reach) t->vertices[t->vertex_count++] = t->listed_vertices[k];
    }
}

/* Pick the faces whose spheres may come within reach, and return their number; faces are tested first by the sphere
 * round their corners. from: readable for whole lanes. radii: of the spheres, NULL if not needed. */
static int64_t dm_pick_faces(const dm_state *b, const dm_near *t, const uint32_t (*from)[4], int64_t count,
                             dm_real reach, uint32_t (*to)[4], dm_real *radii) {
    dm_vec3 centre = {dm_splat(t->centre[0]), dm_splat(t->centre[1]), dm_splat(t->centre[2])};
    dm_lanes third = dm_splat((dm_real)1 / 3);
    int64_t picked = 0;
    for (int64_t i = 0; i < count; i += DM_LANES) {
        dm_vec3 x = dm_corners_at(b, from + i, 0, centre), y = dm_corners_at(b, from + i, 1, centre);
        dm_vec3 z = dm_corners_at(b, from + i, 2, centre);
        dm_vec3 middle = {(x.x + y.x + z.x) * third, (x.y + y.y + z.y) * third, (x.z + y.z + z.z) * third};
        dm_vec3 to_x = dm_sub(x, middle), to_y = dm_sub(y, middle), to_z = dm_sub(z, middle), weight;
        dm_lanes most = dm_vmax(dm_vmax(dm_dot(to_x, to_x), dm_dot(to_y, to_y)), dm_dot(to_z, to_z));
        dm_lanes limit = dm_splat(reach) + dm_vsqrt(most);
        dm_mask near = (dm_mask)(dm_dot(middle, middle) < limit * limit);
        if (!dm_any_of(near)) continue;
        dm_vec3 point = dm_nearest_points(x, y, z, &weight);
        dm_lanes distance = dm_vsqrt(dm_dot(point, point));
        for (int64_t l = 0; l < DM_LANES && i + l < count; l++) {
            const uint32_t *at = from[i + l];
            if (!near[l]) continue;
            if (!(b->inverse_mass[at[0]] > 0 || b->inverse_mass[at[1]] > 0 || b->inverse_mass[at[2]] > 0)) continue;
            dm_real radius = dm_met_radius(b, at, t->radius);
            if (distance[l] - radius > reach - t->radius) continue;
            if (radii) radii[picked] = radius;
            memcpy(to[picked++], at, sizeof *to);
        }
    }
    return picked;
}

/* List the vertices, and the corners of the faces, within reach, each once. */
static void dm_list_noted(dm_state *b, dm_near *t) {
    t->noted_count = 0;
    for (int64_t k = 0; k < t->vertex_count + 3 * t->face_count; k++) {
        int64_t corner = k - t->vertex_count;
        uint32_t i = corner < 0 ? t->vertices[k] : t->faces[corner / 3][corner % 3];
        if (!b->is_moved[i]) b->is_moved[i] = 1, t->noted[t->noted_count++] = i;
    }
    for (int64_t k = 0; k < t->noted_count; k++) b->is_moved[t->noted[k]] = 0;
}

/* Find the vertices and faces within reach of a fingertip's centre, in the order of the lists. */
static void dm_pick_near(dm_state *b, dm_near *t, dm_real reach) {
    dm_pick_vertices(b, t, reach);
    const uint32_t (*listed)[4] = (const uint32_t (*)[4])t->listed_faces;
    t->face_count = dm_pick_faces(b, t, listed, t->listed_face_count, reach, t->faces, t->radii);
    for (int64_t k = t->face_count; k % DM_LANES; k++) {
        memcpy(t->faces[k], t->faces[k - 1], sizeof *t->faces);
        t->radii[k] = t->radii[k - 1];
    }
    dm_list_noted(b, t);
}

static void dm_list_near(const dm_state *b, dm_near *t, double reach) {
    dm_list_vertices(b, t, (dm_real)reach);
    t->listed_face_count =
        dm_pick_faces(b, t, (const uint32_t(*)[4])b->triangles, b->triangle_count, (dm_real)reach, t->listed_faces, NULL);
    memcpy(t->listed_at, b->fingers[t->finger].centre, sizeof t->listed_at);
    t->listed = reach, t->listed_finger = t->finger, t->listed_radius = t->radius;
}

/* Move the fingertips by tick t of the motion, not so fast that they could skip the skin. */
static void dm_carry_fingertips(dm_state *b, const dm_motion *m, int64_t t) {
    double share = m->ticks > 1 ? (double)t / (double)(m->ticks - 1) : 0;
    b->finger_count = 0;
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        const dm_fingertip *f = m->fingertips + k;
        if (!f->down) continue;
        dm_near *to = b->touches + b->finger_count++;
        double *here = b->fingers[k].centre, way[3], at[3], far = 0;
        if (f->force > 0) dm_push_on(b, b->fingers + k, f, m->tick);
        for (int c = 0; c < 3; c++) {
            way[c] = f->first[c] + share * (f->last[c] - f->first[c]) - here[c];
            if (f->force > 0) way[c] += b->fingers[k].way * f->inward[c];
            far += way[c] * way[c];
        }
        double most = DM_TRAVEL * f->radius, slow = sqrt(far) > most ? most / sqrt(far) : 1;
        for (int c = 0; c < 3; c++) {
            way[c] *= slow, here[c] += way[c];
            at[c] = here[c] - b->origin[c], way[c] /= m->tick;
        }
        to->finger = k, to->radius = (dm_real)f->radius;
        to->centre = dm_quad_of(at), to->velocity = dm_quad_of(way);
        to->reach = f->radius + 2 * slow * sqrt(far);
    }
}

/* Return whether the lists of a fingertip still contain everything within `asked` of its centre. */
static int dm_is_listed(const dm_state *b, const dm_near *to, double asked, double gone) {
    double way = 0;
    for (int c = 0; c < 3; c++) {
        double step = b->fingers[to->finger].centre[c] - to->listed_at[c];
        way += step * step;
    }
    return to->listed_finger == to->finger && to->listed_radius == to->radius && sqrt(way) + gone + asked <= to->listed;
}

/* Find what the fingertips may touch within the tick. */
static void dm_find_near(dm_state *b, const dm_motion *m) {
    b->skin_travel = 0;
    if (!b->finger_count) return;
    double speed = dm_greatest_speed(b), gone = dm_greatest_way(b, b->listed), asked[DM_MAX_FINGERTIPS];
    int hold = !b->moving;
    for (int k = 0; k < b->finger_count; k++) {
        const dm_near *to = b->touches + k;
        asked[k] = to->reach + 2 * speed * m->tick + DM_NEAR * (double)to->radius;
        hold = hold && dm_is_listed(b, to, asked[k], gone);
    }
    for (int64_t g = 0; !hold && g < b->groups; g++) b->listed[g] = b->state[g].x;
    for (int k = 0; !hold && k < DM_MAX_FINGERTIPS; k++) b->touches[k].listed = 0;
    for (int k = 0; k < b->finger_count; k++) {
        dm_near *to = b->touches + k;
        if (!hold) dm_list_near(b, to, asked[k] + 2 * DM_NEAR * (double)to->radius);
        dm_pick_near(b, to, (dm_real)asked[k]);
        double travel = 2 * DM_TRAVEL * (double)to->radius; /* otherwise the skin could pass the fingertip */
        if (to->vertex_count + to->face_count > 0 && (b->skin_travel == 0 || travel < b->skin_travel))
            b->skin_travel = travel;
    }
}
