/* Bodies at rest: they are not stepped until something wakes them, and continue from exactly the state they had.
 * Source: studies/reference/sleep.py. */
#include "body.h"

/* Return the distance of a fingertip from the box round a sleeping body, less its reach in the tick [m]. */
static double dm_clear_of(const dm_state *b, const dm_near *t) {
    double away = 0;
    for (int c = 0; c < 3; c++) {
        double x = b->fingers[t->finger].centre[c], below = b->bounds[0][c] - x, above = x - b->bounds[1][c];
        double gap = below > above ? below : above;
        away += gap > 0 ? gap * gap : 0;
    }
    return sqrt(away) - (t->reach + DM_NEAR * (double)t->radius);
}

/* Return whether a fingertip is where it was when the body fell asleep. */
static int dm_finger_rests(const dm_state *b, const dm_near *t) {
    double way = 0;
    for (int c = 0; c < 3; c++) {
        double step = b->fingers[t->finger].centre[c] - b->fingers[t->finger].rests_at[c];
        way += step * step;
    }
    return (double)t->radius == b->fingers[t->finger].rests_radius && sqrt(way) <= DM_ROUNDING * (double)t->radius;
}

/* Return whether a fingertip or a moving pin wakes a body in the tick that begins. */
static int dm_is_woken(const dm_state *b, const dm_motion *m) {
    int resting = 0;
    for (int64_t k = 0; m->pins_to && k < b->pinned_count; k++)
        for (int c = 0; c < 3; c++)
            if (m->pins_to[c * b->pinned_count + k] != b->pins[c * b->n + k]) return 1;
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        if (b->fingers[t->finger].rests && dm_finger_rests(b, t)) resting++;
        else if (dm_clear_of(b, t) < 0) return 1;
    }
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) resting -= b->fingers[k].rests;
    return resting != 0; /* one was lifted */
}

/* Put a body to sleep, with the fingertips that rest on it. */
static void dm_fall_asleep(dm_state *b, const dm_motion *m) {
    b->rested = 0;
    for (int c = 0; c < 3; c++) b->bounds[0][c] = INFINITY, b->bounds[1][c] = -INFINITY;
    for (int64_t k = 0; k < b->n; k++)
        for (int c = 0; c < 3 && !b->loose[k]; c++) {
            double x = b->origin[c] + (double)b->records[b->place[k]].x[c];
            b->bounds[0][c] = x < b->bounds[0][c] ? x : b->bounds[0][c];
            b->bounds[1][c] = x > b->bounds[1][c] ? x : b->bounds[1][c];
        }
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) b->fingers[k].rests = 0;
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        b->fingers[t->finger].rests = dm_clear_of(b, t) < 0, b->fingers[t->finger].rests_radius = (double)t->radius;
        memcpy(b->fingers[t->finger].rests_at, b->fingers[t->finger].centre, sizeof b->fingers->rests_at);
    }
    if (dm_is_woken(b, m)) return;
    dm_fit_whole(b, b->still_pose);
    b->still_volume = b->fill != DM_FILL_NONE ? b->volume : dm_volume_of_faces(b, NULL);
    b->asleep = 1;
}

/* Return whether every vertex is still close to where it was when the body became quiet. */
static int dm_stays(const dm_state *b) { return dm_greatest_way(b, b->still) <= DM_ROUNDING * b->size; }

/* After a tick: note whether a body has been in place for DM_REST_TIME. A velocity alone does not move it: contact may
 * hold it back, and a short step is lost in rounding. */
static void dm_watch_rest(dm_state *b, const dm_motion *m) {
    int goes = b->fastest > DM_REST_SPEED * b->size && b->quiet > 0 && !dm_stays(b);
    if (goes || m->pins_to || b->moving) {
        b->quiet = 0, b->rested = 0;
        return;
    }
    if (b->quiet == 0)
        for (int64_t g = 0; g < b->groups; g++) b->still[g] = b->state[g].x;
    b->quiet += m->tick;
    if (b->quiet < DM_REST_TIME) return;
    b->quiet = 0, b->rested = dm_stays(b);
}
