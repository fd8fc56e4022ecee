/* A substep: semi-implicit Euler, then contact. Source: studies/reference/semi_implicit.py, laws.py. A tick: the
 * pins, the origin of the positions, and the test for divergence. */
#include "body.h"

static void dm_fit_body(dm_state *b) {
    double sums[DM_MOMENTS];
    dm_sum_moments(b, sums);
    dm_fit_pose(b, sums), dm_fit_motion(b, sums);
}

/* Let the fill turn with the skin: the body has the inertia of both. Find the moment that this takes from the skin. */
static void dm_turn_fill(dm_state *b, double *taken) {
    double by[9], share[9], more[9], back[9];
    dm_transpose3x3(b->rotation, back);
    dm_multiply3x3(b->rotation, b->fill_share, by), dm_multiply3x3(by, back, share);
    dm_multiply3x3(share, b->moments.tensor, more);
    for (int c = 0; c < 3; c++) {
        double now = dm_inner3(more + 3 * c, b->moments.spin);
        taken[c] = b->fill_turns ? (now - b->fill_momentum[c]) / b->dt : 0, b->fill_momentum[c] = now;
    }
    for (int k = 0; k < 9; k++) b->moments.tensor[k] += more[k];
    b->fill_turns = 1;
}

/* Apply the moments of the fill, and of the rolling resistance of the surfaces that a body touches, as part of the
 * drift, which is subtracted. */
static void dm_take_moments(dm_state *b) {
    double a[3], m[3], moved[3];
    dm_turn_fill(b, m);
    for (int c = 0; c < 3; c++) m[c] += b->resisted[c];
    for (int c = 0; c < 3; c++) a[c] = dm_inner3(b->moments.inverse + 3 * c, m), b->drift.angular[c] += a[c];
    dm_cross3(a, b->moments.centre, moved), dm_add3(b->drift.linear, -1, moved);
}

static void dm_substep(dm_state *b, int64_t left, dm_frame *frame) {
    if (b->free) {
        dm_fit_body(b);
        dm_press_free(b, left, frame);
    }
    dm_run_rings(b);
    if (b->free) dm_take_moments(b);
    dm_apply_fill(b);
    dm_run_pass(b, dm_pass_advance);
}

enum { DM_PINS_AHEAD = 8 };

/* Prefetch a later pin: pins are scattered in memory. */
DM_INLINE void dm_fetch_pin(const dm_state *b, int64_t k) {
    if (k >= b->pinned_count) return;
    uint32_t i = b->place[b->pinned[k]];
    __builtin_prefetch(b->records + i, 1);
    for (int j = 0; j < 3; j++) __builtin_prefetch((char *)(b->state + i / DM_LANES) + 64 * j, 1);
}

/* Move the pins of a tick: set velocities that take them to a share of their path, and the shape at rest with them.
 * During the tick that shape stays at the mean of its poses as the substeps begin, so that the body neither leads nor
 * lags. */
static void dm_drive_pins(dm_state *b, const dm_motion *m, double share) {
    int64_t used = 0, count = b->pinned_count, n = b->n, stride = b->groups * DM_LANES;
    double *rest = b->pin_room, *here = rest + 3 * stride, *there = here + 3 * stride, rate = 1 / m->tick;
    for (int64_t k = 0; k < count; k++) {
        uint32_t vertex = b->pinned[k], i = b->place[vertex];
        double v[3];
        dm_fetch_pin(b, k + DM_PINS_AHEAD);
        for (int c = 0; c < 3; c++) {
            double from = m->pins_from[c * count + k], x = (double)b->records[i].x[c] + b->origin[c];
            double way = from + share * (m->pins_to[c * count + k] - from) - x;
            rest[c * stride + used] = b->rest[c * n + vertex];
            here[c * stride + used] = x, there[c * stride + used] = x + way, v[c] = way * rate;
        }
        used += !b->loose[vertex];
        dm_set_vertex(b, i, b->records[i].x, dm_quad_of(v));
    }
    b->carried = !b->free && !b->rigged;
    if (!b->carried) return;
    double from[12], to[12], part = (1 - 1 / (double)m->substeps) / 2;
    dm_fit_points(used, stride, rest, here, from), dm_fit_points(used, stride, rest, there, to);
    for (int k = 0; k < 12; k++) {
        b->pose[k] = from[k] + part * (to[k] - from[k]);
        b->pose_rate[k] = (to[k] - from[k]) * rate;
    }
    dm_place_pose(b);
}

/* Stop pins that were moved. */
static void dm_rest_pins(dm_state *b) {
    for (int64_t k = 0; k < b->pinned_count; k++) {
        uint32_t i = b->place[b->pinned[k]];
        dm_set_vertex(b, i, b->records[i].x, (dm_quad){0, 0, 0, 0});
    }
    b->led = b->carried = 0;
    memset(b->pose_rate, 0, sizeof b->pose_rate);
    dm_place_pose(b);
}

/* After the last tick: put the pins that have arrived exactly at the end of their paths. */
static void dm_finish_pins(dm_state *b, const dm_motion *m) {
    int64_t used = 0, whole = m->pins_last >= 1, count = b->pinned_count, n = b->n, stride = b->groups * DM_LANES;
    double *rest = b->pin_room, *here = rest + 3 * stride;
    for (int64_t k = 0; k < count; k++) {
        uint32_t vertex = b->pinned[k], i = b->place[vertex];
        double x[3], local[3], behind = 0;
        dm_fetch_pin(b, k + DM_PINS_AHEAD);
        for (int c = 0; c < 3; c++) {
            x[c] = (double)b->records[i].x[c] + b->origin[c];
            double late = fabs(m->pins_to[c * count + k] - x[c]);
            behind = late > behind ? late : behind;
        }
        int there = whole && !(b->pins_met && behind > DM_SEATED * b->size);
        for (int c = 0; c < 3; c++) {
            x[c] = there ? m->pins_to[c * count + k] : x[c];
            b->pins[c * n + k] = x[c], local[c] = x[c] - b->origin[c];
            rest[c * stride + used] = b->rest[c * n + vertex], here[c * stride + used] = x[c];
        }
        used += !b->loose[vertex];
        if (there) dm_set_vertex(b, i, dm_quad_of(local), b->records[i].v);
    }
    b->led = 1;
    if (whole && !b->free && !b->rigged) dm_fit_points(used, stride, rest, here, b->pose), dm_place_pose(b);
}

/* Keep the origin of the positions near the body, so that the error of single precision does not depend on where the
 * body is. The origin moves in steps of a power of two, at least the body's size, and so hardly ever. */
static void dm_move_origin(dm_state *b, const double *centre) {
    dm_quad by = {0, 0, 0, 0};
    int far = 0;
    for (int c = 0; c < 3; c++) {
        double origin = b->middle[c] + b->cell * nearbyint((b->origin[c] + centre[c] - b->middle[c]) / b->cell);
        if (origin == b->origin[c]) continue;
        by[c] = (dm_real)(b->origin[c] - origin), b->origin[c] = origin, far = 1;
    }
    if (!far) return;
    for (uint32_t i = 0; i < b->groups * DM_LANES; i++) dm_set_vertex(b, i, b->records[i].x + by, b->records[i].v);
    dm_place_pose(b);
}

/* Find the three first moments of mass; NaN if a number is not finite, otherwise 0; the greatest speed; and the
 * greatest distance from the place at rest. */
static void dm_pass_looks(dm_state *b, int64_t from, int64_t to, double *found) {
    dm_wide sum[3] = {{0}};
    dm_lanes part[3] = {{0}}, probe = dm_splat(0), fastest = probe, farthest = probe;
    dm_vec3 rows[3] = {dm_splat3(b->rotation), dm_splat3(b->rotation + 3), dm_splat3(b->rotation + 6)};
    dm_vec3 offset = dm_splat3(b->translation);
    for (int64_t g = from; g < to; g++) {
        dm_vec3 x = b->state[g].x, v = b->state[g].v, way = dm_sub(x, dm_rotated(rows, b->matter[g].rest, offset));
        dm_lanes m = b->matter[g].mass;
        part[0] += m * x.x, part[1] += m * x.y, part[2] += m * x.z;
        probe += (x.x + x.y + x.z + v.x + v.y + v.z) * dm_splat(0);
        dm_mask held = (dm_mask)(b->matter[g].k1 > dm_splat(0)); /* loose vertices may be anywhere */
        fastest = dm_vmax(dm_dot(v, v), fastest);
        farthest = dm_vmax(dm_blend(held, dm_dot(way, way), dm_splat(0)), farthest);
        if (g % DM_RUN == DM_RUN - 1) dm_fold(part, sum, 3);
    }
    dm_fold(part, sum, 3);
    for (int c = 0; c < 3; c++) found[c] = dm_sum_of(sum[c]);
    found[3] = dm_sum_of(dm_widen(probe)), found[4] = sqrt(dm_most_of(fastest)), found[5] = sqrt(dm_most_of(farthest));
}

/* Return whether every number is finite, and no vertex is far too fast or too far from its place at rest; find the
 * centre of mass. */
static int dm_is_finite(dm_state *b, double tick, double *centre) {
    double most = DM_LARGEST_GROWTH * b->size;
    dm_run_pass(b, dm_pass_looks);
    for (int c = 0; c < 3; c++) centre[c] = dm_sum_of_slices(b, c) / b->mass_total;
    b->fastest = dm_most_of_slices(b, 4);
    return dm_sum_of_slices(b, 3) == 0 && b->fastest * tick < most && dm_most_of_slices(b, 5) < most;
}

static void dm_begin_motion(dm_state *b, const dm_motion *m, dm_frame *frame) {
    b->pins_met = 0;
    memset(frame, 0, sizeof *frame);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        const dm_fingertip *f = m->fingertips + k;
        frame->touches[k].triangle = -1;
        if (!f->down || f->fresh) dm_forget_impulses(b, k);
        dm_take_fingertip(b, b->fingers + k, f);
    }
    if (!m->pins_to && b->led && m->ticks) dm_rest_pins(b);
    frame->finite = 1;
}

/* Begin a tick of a body that is awake. */
static void dm_enter_tick(dm_state *b, const dm_motion *m, int64_t t, dm_frame *frame) {
    double way = m->ticks > 1 ? (m->pins_last - m->pins_first) / (double)(m->ticks - 1) : 0;
    frame->moved = 1;
    if (b->moving) dm_move_places(b, t ? 1 : (1 - 1 / (double)m->substeps) / 2 - (double)m->ticks, m->tick);
    if (m->pins_to) dm_drive_pins(b, m, m->pins_first + (double)t * way);
    dm_find_near(b, m);
}

static void dm_begin_tick(dm_state *b, const dm_motion *m, int64_t t, dm_frame *frame) {
    b->dt = m->tick / (double)m->substeps;
    dm_carry_fingertips(b, m, t);
    if (b->asleep && dm_is_woken(b, m)) dm_wake(b);
    if (!b->asleep) dm_enter_tick(b, m, t, frame);
}

/* Run a substep. left: number of substeps that follow it in the tick. */
static void dm_run_substep(dm_state *b, int64_t left, dm_frame *frame) {
    dm_substep(b, left, frame);
    dm_resolve_contact(b, (double)left * b->dt);
    if (b->free && b->finger_count) dm_react(b);
}

static void dm_end_tick(dm_state *b, const dm_motion *m, int64_t t, dm_frame *frame) {
    double centre[3];
    frame->ticks = t + 1;
    if (!b->free || b->asleep) dm_press_held(b, m->tick, frame);
    b->comes_back = dm_is_beside_others(b, -1) ? DM_REST_TIME : b->comes_back - m->tick;
    if (b->asleep) return;
    frame->finite = dm_is_finite(b, m->tick, centre);
    if (!frame->finite) return;
    dm_move_origin(b, centre), dm_watch_rest(b, m);
}

static void dm_end_motion(dm_state *b, const dm_motion *m, dm_frame *frame) {
    if (b->moving && m->ticks) dm_finish_places(b, m);
    if (m->pins_to && frame->moved) dm_finish_pins(b, m);
    frame->pressure = b->pressure;
    if (!frame->finite) return;
    int known = b->fill != DM_FILL_NONE && frame->ticks;
    frame->volume = b->asleep ? b->still_volume : known ? b->volume : dm_volume_of_faces(b, NULL);
    dm_show_fingertips(b, m, frame);
}

static void dm_state_step(dm_state *b, const dm_motion *m, dm_frame *frame) {
    dm_begin_motion(b, m, frame);
    memset(b->resisted, 0, sizeof b->resisted), b->meets = 0, b->changes++;
    for (int64_t t = 0; t < m->ticks && frame->finite; t++) {
        dm_begin_tick(b, m, t, frame);
        for (int64_t s = 0; s < m->substeps && !b->asleep; s++) dm_run_substep(b, m->substeps - 1 - s, frame);
        dm_end_tick(b, m, t, frame);
        if (b->rested) dm_fall_asleep(b, m);
    }
    dm_end_motion(b, m, frame);
}
