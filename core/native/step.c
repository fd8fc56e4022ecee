/* Semi-implicit Euler, then contact. Source: core/solver/semi_implicit.py, core/body/model.py forces; and what of a
 * body changes from tick to tick: its pins, where its numbers are counted from, and whether it is still whole. */
#include "body.h"
#include "profile.h"

enum { AIR_PRESSURE = 101325, LIQUID_BULK_MODULUS = 2000000 }; /* [Pa], core/base.py */
static const double AIR_EXPONENT = 1.4;

static double pressure_at(const body *b) {
    if (b->fill == DM_FILL_PAPER) return inner_pressure(b);
    if (b->fill == DM_FILL_LIQUID) return LIQUID_BULK_MODULUS * (b->rest_volume - b->volume) / b->rest_volume;
    double least = 0.01 * b->rest_volume; /* a body turned inside out has no volume left */
    return AIR_PRESSURE * (pow(b->rest_volume / (b->volume > least ? b->volume : least), AIR_EXPONENT) - 1);
}

static void follow(body *b) {
    double sums[MOMENTS];
    sum_moments(b, sums);
    fit_pose(b, sums), fit_motion(b, sums);
}

/* What the rings leave out, and then the pressure. */
static void fill_up(body *b) {
    pull_irregular(b);
    if (b->fill == DM_FILL_NONE) return;
    b->volume += add_fans(b) + add_caps(b);
    b->pressure = pressure_at(b);
}

static void move(body *b) {
    if (b->law_set == DM_LAWS_PAPER) {
        b->pressure = inner_pressure(b);
        fall(b);
        if (b->pressure != 0) spread_pressure(b);
        pull_irregular(b);
        advance_posed(b, b->pressure);
        return;
    }
    if (b->free) DM_TIMED(FITS, follow(b));
    DM_TIMED(RINGS, (b->free ? pull_fitted : pull_posed)(b));
    DM_TIMED(IRREGULAR_AND_FILL, fill_up(b));
    DM_TIMED(ADVANCE, (b->free ? advance_fitted : advance_posed)(b, b->fill != DM_FILL_NONE ? b->pressure : 0));
}

/* Lead the pins of a tick: a velocity that brings them to a share of their way, and with them the shape at rest.
 * Over the tick it stands where the substeps begin on average, so that the body neither leads nor lags. */
static void lead_pins(body *b, const dm_motion *m, double share) {
    double *rest = b->pin_room, *here = rest + 3 * b->n, *there = here + 3 * b->n;
    int64_t used = 0;
    for (int64_t k = 0; k < b->pinned_count; k++) {
        uint32_t vertex = b->pinned[k], i = b->place[vertex];
        double x[3], way[3];
        position(b, i, x);
        for (int c = 0; c < 3; c++) {
            int64_t at = c * b->pinned_count + k;
            x[c] += b->origin[c];
            way[c] = m->pins_from[at] + share * (m->pins_to[at] - m->pins_from[at]) - x[c];
        }
        if (!b->loose[vertex]) {
            for (int c = 0; c < 3; c++) {
                rest[3 * used + c] = b->rest[c * b->n + vertex];
                here[3 * used + c] = x[c], there[3 * used + c] = x[c] + way[c];
            }
            used++;
        }
        for (int c = 0; c < 3; c++) way[c] /= m->tick;
        write_vertex(b, i, b->records[i].x, quad_of(way));
    }
    b->carried = !b->free;
    if (b->free) return;
    double from[12], to[12], part = (1 - 1 / (double)m->substeps) / 2;
    fit_points(used, rest, here, from), fit_points(used, rest, there, to);
    for (int k = 0; k < 12; k++) {
        b->pose[k] = from[k] + part * (to[k] - from[k]);
        b->pose_rate[k] = (to[k] - from[k]) / m->tick;
    }
    place_pose(b);
}

/* Let pins that were led stand where they are. */
static void rest_pins(body *b) {
    for (int64_t k = 0; k < b->pinned_count; k++) {
        uint32_t i = b->place[b->pinned[k]];
        write_vertex(b, i, b->records[i].x, (quad){0, 0, 0, 0});
    }
    b->led = b->carried = 0;
    memset(b->pose_rate, 0, sizeof b->pose_rate);
    place_pose(b);
}

/* After the last tick: pins that have arrived are where they were sent to the last digit. */
static void arrive(body *b, const dm_motion *m) {
    double *rest = b->pin_room, *here = rest + 3 * b->n;
    int64_t used = 0, whole = m->pins_last >= 1;
    for (int64_t k = 0; k < b->pinned_count; k++) {
        uint32_t vertex = b->pinned[k], i = b->place[vertex];
        double x[3], local[3];
        position(b, i, x);
        for (int c = 0; c < 3; c++) {
            x[c] = whole ? m->pins_to[c * b->pinned_count + k] : x[c] + b->origin[c];
            b->pins[c * b->n + k] = x[c], local[c] = x[c] - b->origin[c];
            if (!b->loose[vertex]) rest[3 * used + c] = b->rest[c * b->n + vertex], here[3 * used + c] = x[c];
        }
        used += !b->loose[vertex];
        if (whole) write_vertex(b, i, quad_of(local), b->records[i].v);
    }
    b->led = 1;
    if (whole && !b->free) fit_points(used, rest, here, b->pose), place_pose(b);
}

/* Count positions from near the body, so that single precision does not depend on where it is. It follows in steps of
 * at least the body's size, a power of two, so that it hardly ever changes. */
static void follow_origin(body *b, const double *centre) {
    quad by = {0, 0, 0, 0};
    int far = 0;
    for (int c = 0; c < 3; c++) {
        double origin = b->middle[c] + b->cell * nearbyint((b->origin[c] + centre[c] - b->middle[c]) / b->cell);
        if (origin == b->origin[c]) continue;
        by[c] = (real)(b->origin[c] - origin), b->origin[c] = origin, far = 1;
    }
    if (!far) return;
    for (int64_t i = 0; i < b->groups * LANES; i++) write_vertex(b, (uint32_t)i, b->records[i].x + by, b->records[i].v);
    place_pose(b);
}

/* Tell whether every number is finite and the body not a hundred times as large as at rest, and find its centre. */
static int is_whole(body *b, double *centre) {
    wide sum[3] = {{0}};
    lanes part[3] = {{0}}, probe = all(0);
    three low = b->state[0].x, high = low;
    for (int64_t g = 0; g < b->groups; g++) {
        three x = b->state[g].x, v = b->state[g].v;
        lanes m = b->matter[g].mass;
        mask counts = (mask)(m > all(0));
        part[0] += m * x.x, part[1] += m * x.y, part[2] += m * x.z;
        probe += (x.x + x.y + x.z + v.x + v.y + v.z) * all(0); /* NaN where one is not finite */
        low.x = select(counts & (mask)(x.x < low.x), x.x, low.x), high.x = select(counts & (mask)(x.x > high.x), x.x, high.x);
        low.y = select(counts & (mask)(x.y < low.y), x.y, low.y), high.y = select(counts & (mask)(x.y > high.y), x.y, high.y);
        low.z = select(counts & (mask)(x.z < low.z), x.z, low.z), high.z = select(counts & (mask)(x.z > high.z), x.z, high.z);
        if (g % RUN == RUN - 1) fold(part, sum, 3);
    }
    fold(part, sum, 3);
    for (int c = 0; c < 3; c++) centre[c] = total(sum[c]) / b->mass_total;
    for (int l = 0; l < LANES; l++)
        if (!(probe[l] == 0)) return 0;
    double bottom[3] = {INFINITY, INFINITY, INFINITY}, top[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int64_t k = 0; b->any_loose && k < b->n; k++) /* what belongs to no face may be anywhere */
        for (int c = 0; c < 3 && !b->loose[k]; c++) {
            double x = b->records[b->place[k]].x[c];
            bottom[c] = x < bottom[c] ? x : bottom[c], top[c] = x > top[c] ? x : top[c];
        }
    for (int l = 0; l < LANES && !b->any_loose; l++) {
        if ((int64_t)l >= b->n) break;
        double at[2][3] = {{low.x[l], low.y[l], low.z[l]}, {high.x[l], high.y[l], high.z[l]}};
        for (int c = 0; c < 3; c++)
            bottom[c] = at[0][c] < bottom[c] ? at[0][c] : bottom[c], top[c] = at[1][c] > top[c] ? at[1][c] : top[c];
    }
    for (int c = 0; c < 3; c++)
        if (!(top[c] - bottom[c] < BLOWN_UP * b->size)) return 0;
    return 1;
}

static void measure_depths(body *b, const dm_motion *m, dm_frame *frame) {
    b->inner_force = 0;
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        if (!m->fingertips[k].down) continue;
        measure_depth(b, k, m->fingertips[k].radius, frame->pose, frame->touches + k);
        b->inner_force += frame->touches[k].law_force;
    }
}

static void begin(body *b, const dm_motion *m, dm_frame *frame) {
    memset(frame, 0, sizeof *frame);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        const dm_fingertip *f = m->fingertips + k;
        frame->touches[k].triangle = -1;
        if (!f->down || f->fresh) b->fingers[k].has_side = 0;
        if (f->down) memcpy(b->fingers[k].centre, f->from, sizeof f->from);
    }
    if (!m->pins_to && b->led && m->ticks) rest_pins(b);
    frame->finite = 1;
}

static void step(body *b, const dm_motion *m, dm_frame *frame) {
    begin(b, m, frame);
    b->dt = m->tick / (double)m->substeps;
    int needs_contact = b->law_set == DM_LAWS_PAPER || b->fill == DM_FILL_PAPER;
    double way = m->ticks > 1 ? (m->pins_last - m->pins_first) / (double)(m->ticks - 1) : 0, centre[3];
    for (int64_t t = 0; t < m->ticks && frame->finite; t++) {
        if (m->pins_to) lead_pins(b, m, m->pins_first + (double)t * way);
        if (needs_contact) fit_whole(b, frame->pose), measure_depths(b, m, frame);
        DM_TIMED(REACH, reach_out(b, m, t));
        for (int64_t s = 0; s < m->substeps; s++) {
            move(b);
            DM_TIMED(CONTACT, meet(b, frame));
        }
        frame->ticks = t + 1, frame->finite = is_whole(b, centre);
        if (frame->finite) follow_origin(b, centre);
    }
    if (m->pins_to && m->ticks) arrive(b, m);
    frame->pressure = b->pressure;
    if (!frame->finite) return;
    int known = b->law_set == DM_LAWS_CONSISTENT && b->fill != DM_FILL_NONE && frame->ticks;
    frame->volume = known ? b->volume : whole_volume(b);
    if (m->fingertips[0].down || m->fingertips[1].down || m->fingertips[2].down) {
        fit_whole(b, frame->pose);
        measure_depths(b, m, frame);
    }
}
