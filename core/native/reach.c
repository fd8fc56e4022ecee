/* What each fingertip may meet within a tick: found once, by bounding boxes first. */
#include "body.h"

static real greatest_speed(const body *b) {
    lanes most = all(0);
    for (int64_t g = 0; g < b->groups; g++) most = larger(dot(b->state[g].v, b->state[g].v), most);
    real speed = 0;
    for (int l = 0; l < LANES; l++) speed = most[l] > speed ? most[l] : speed;
    return SQRT(speed);
}

static void bound_boxes(body *b) {
    for (int64_t k = 0; k < b->box_count; k++) {
        quad low = b->records[b->box_vertex[b->box_start[k]]].x, high = low;
        for (uint32_t at = b->box_start[k] + 1; at < b->box_start[k + 1]; at++) {
            quad x = b->records[b->box_vertex[at]].x;
            for (int c = 0; c < 4; c++) {
                low[c] = x[c] < low[c] ? x[c] : low[c];
                high[c] = x[c] > high[c] ? x[c] : high[c];
            }
        }
        b->boxes[k][0] = low, b->boxes[k][1] = high;
    }
}

static void reach_vertices(const body *b, touch *t, real reach) {
    three centre = {all(t->centre[0]), all(t->centre[1]), all(t->centre[2])};
    t->vertex_count = 0;
    for (int64_t g = 0; g < b->groups; g++) {
        three offset = minus(b->state[g].x, centre);
        mask near = (mask)(dot(offset, offset) < all(reach * reach)) & (mask)(b->matter[g].inverse_mass > all(0));
        for (int l = 0; any(near) && l < LANES; l++)
            if (near[l]) t->vertices[t->vertex_count++] = (uint32_t)(g * LANES + l);
    }
}

/* A triangle is within reach when the sphere round its middle that holds its corners is. */
static void reach_faces(const body *b, touch *t, real reach) {
    t->face_count = 0;
    for (int64_t k = 0; k < b->box_count; k++) {
        /* the middle of a triangle lies in its box, and no corner farther off than two thirds of the diagonal */
        const quad *box = b->boxes[k];
        quad low = box[0] - t->centre, high = t->centre - box[1], across = box[1] - box[0];
        real away = 0, span = (real)0.67 * SQRT(dot3(across, across));
        for (int c = 0; c < 3; c++) {
            real gap = low[c] > high[c] ? low[c] : high[c];
            away += gap > 0 ? gap * gap : 0;
        }
        if (SQRT(away) > reach + span) continue;
        int64_t end = (k + 1) * BLOCK < b->triangle_count ? (k + 1) * BLOCK : b->triangle_count;
        for (int64_t i = k * BLOCK; i < end; i++) {
            const uint32_t *at = b->triangles[i];
            quad x = b->records[at[0]].x, y = b->records[at[1]].x, z = b->records[at[2]].x, middle = (x + y + z) / 3;
            real most = dot3(x - middle, x - middle), second = dot3(y - middle, y - middle);
            real third = dot3(z - middle, z - middle);
            most = second > most ? second : most, most = third > most ? third : most;
            real limit = reach + SQRT(most);
            if (dot3(middle - t->centre, middle - t->centre) < limit * limit &&
                (b->inverse_mass[at[0]] > 0 || b->inverse_mass[at[1]] > 0 || b->inverse_mass[at[2]] > 0))
                memcpy(t->faces[t->face_count++], at, sizeof *t->faces);
        }
    }
    for (int64_t k = t->face_count; k % LANES; k++) memcpy(t->faces[k], t->faces[k - 1], sizeof *t->faces);
}

/* Move the fingertips by a tick, no faster than they may without skipping a skin, and find what they may meet in it.
 * t: of the tick in the motion. */
static void reach_out(body *b, const dm_motion *m, int64_t t) {
    b->skin_travel = 0, b->finger_count = 0;
    double share = m->ticks > 1 ? (double)t / (double)(m->ticks - 1) : 0;
    real speed = 0;
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        const dm_fingertip *f = m->fingertips + k;
        if (!f->down) continue;
        if (!b->finger_count) speed = greatest_speed(b), bound_boxes(b);
        touch *to = b->touches + b->finger_count++;
        double *here = b->fingers[k].centre, way[3], at[3], far = 0;
        for (int c = 0; c < 3; c++) {
            way[c] = f->first[c] + share * (f->last[c] - f->first[c]) - here[c];
            far += way[c] * way[c];
        }
        double most = FINGER_TRAVEL * f->radius, slow = sqrt(far) > most ? most / sqrt(far) : 1;
        for (int c = 0; c < 3; c++) {
            way[c] *= slow, here[c] += way[c];
            at[c] = here[c] - b->origin[c], way[c] /= m->tick;
        }
        to->finger = k, to->centre = quad_of(at), to->velocity = quad_of(way), to->radius = (real)f->contact_radius;
        real reach = (real)(f->contact_radius + 2 * slow * sqrt(far) + 2 * (double)speed * m->tick);
        reach_vertices(b, to, reach);
        reach_faces(b, to, reach);
        double travel = SKIN_TRAVEL * f->contact_radius;
        if (to->vertex_count + to->face_count > 0 && (b->skin_travel == 0 || travel < b->skin_travel))
            b->skin_travel = travel;
    }
}
