/* The contact force on a fingertip: the measured law at its depth, Eq. (1), and Coulomb friction. Reference in numpy:
 * studies/reference/fingertip.py.
 *
 * The depth x is the distance from the fingertip to its foot (foot.c), along the normals that hold the foot, counted
 * from where the tip met the skin; the law gives the force. Friction holds the tip at its anchor: a spring pulls it
 * tangentially towards the anchor, and beyond the friction limit the anchor is dragged along.
 * The force depends on depth and anchor alone, and neither returns more energy than it took: when the tangential
 * spring becomes stiffer under load, it keeps its force and shortens its elongation (Thornton and Yin 1991). The skin
 * is kept out of the fingertip separately, in skin_contact.c; the impulses of that shape the dent and are no part of
 * the contact force. */
#include "body.h"

/* Return the stiffness of an incompressible elastic layer under a round contact, relative to a half-space.
 * share: radius of the contact over thickness. Source: Dimitriadis and others 2002, layer bonded below. */
static double dm_layer(double share) {
    return 1 + share * (1.133 + share * (1.283 + share * (0.769 + share * 0.0975)));
}

/* Return the force of the law on a fingertip at a depth x [m], with the painted factors, and with the factor of a tip
 * other than the measuring one [N]. */
static double dm_force_at(const dm_state *b, const dm_tip *f, double x) {
    if (!(x > 0)) return 0;
    const double *law = b->laws[f->material];
    double times = f->stiffer;
    if (f->factors) {
        const double *row = f->factors + f->material * DM_FACTORS;
        double at = sqrt(x / f->factors_end) * (DM_FACTORS - 1), share;
        int k = at < DM_FACTORS - 2 ? (int)at : DM_FACTORS - 2;
        share = at - k < 1 ? at - k : 1;
        times *= row[k] + share * (row[k + 1] - row[k]);
        double other = law[DM_LAYER];
        if (other != 0 && f->thickness < INFINITY) {
            double own = sqrt(f->radius * x), measured = other > 0 ? sqrt(other * x) : -other;
            times *= dm_layer(own / f->thickness) / dm_layer(measured / f->thickness);
        }
    }
    return times * dm_law_force((double[]){law[0], law[1], law[2] * f->deeper, law[3]}, x);
}

/* Return the depth at which the law gives a force [m]. */
static double dm_depth_of(const dm_state *b, const dm_tip *f, double force) {
    double low = 0, high = f->radius;
    while (dm_force_at(b, f, high) < force && high < DM_LARGEST_GROWTH * b->size) high *= 2;
    for (int k = 0; k < 50; k++) {
        double middle = (low + high) / 2;
        if (dm_force_at(b, f, middle) < force) low = middle;
        else high = middle;
    }
    return high;
}

/* Take the material, the painted factors and the thickness at the place below a fingertip's foot. */
static void dm_take_place(const dm_state *b, dm_tip *f, const dm_round *r) {
    const dm_facet *at = r->facet;
    double place[3], gone = 0, inward[3];
    for (int c = 0; c < 3; c++) place[c] = f->foot[c] - r->offset[c], inward[c] = -f->outward[c];
    dm_weights_at(at, place, f->weight);
    f->facet = at - b->facets, f->material = at->material, f->stiffer = f->deeper = 0;
    for (int c = 0; c < 3; c++) {
        const double *painted = b->painted[at->vertex[c]];
        f->stiffer += f->weight[c] * painted[0], f->deeper += f->weight[c] * painted[1];
        gone += (place[c] - f->thick_at[c]) * (place[c] - f->thick_at[c]);
    }
    if (!f->factors || b->laws[at->material][DM_LAYER] == 0) return;
    if (f->thickness > 0 && gone < f->radius * f->radius) return;
    f->thickness = dm_thickness(b, place, inward), memcpy(f->thick_at, place, sizeof place);
}

/* Return whether anything other than this fingertip may touch the body. */
static int dm_is_beside_others(const dm_state *b, int finger) {
    int others = b->meets;
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) others |= k != finger && b->fingers[k].in_contact;
    return others;
}

/* Find the foot and depth of a fingertip at x in the space of the shape at rest, and `aside`, the tangential vector
 * from its foot to its anchor. before: its last x. The depth grows by no more than the tip has moved: in a crease
 * the foot may jump to a farther one, which would create energy. */
static void dm_place_tip(dm_state *b, int finger, const double *pose, const double *before, const double *x,
                         double *aside) {
    dm_tip *f = b->fingers + finger;
    dm_round round;
    double along[3], place[3], deep = f->met ? dm_find_foot(b, f, x, &round) : 0;
    double most = f->deep + dm_apart(before, x);
    f->met = deep > 0, deep = deep > most ? most : deep;
    if (!f->met) deep = dm_find_gap(b, f, x, &round), f->met = deep > 0;
    if (round.facet) dm_take_place(b, f, &round);
    if (!f->in_contact) f->zero = -f->height, f->stick = 0, f->beside = b->comes_back > 0 || dm_is_beside_others(b, finger);
    f->deep = deep, f->depth = deep - f->zero;
    int in_contact = f->depth > 0;
    if (!f->in_contact) memcpy(f->anchor, f->foot, sizeof f->anchor);
    f->in_contact = in_contact;
    for (int c = 0; c < 3; c++) aside[c] = f->anchor[c] - f->foot[c];
    if (f->met) {
        for (int c = 0; c < 3; c++) along[c] = f->anchor[c] - x[c];
        dm_along_normals(&round, along, place, aside);
    }
    double up = dm_inner3(aside, f->outward);
    for (int c = 0; c < 3; c++) aside[c] -= up * f->outward[c], place[c] = f->foot[c] - f->radius * f->outward[c];
    /* while the tip itself moves the skin, the skin's height is no reference */
    if (!in_contact && round.facet && b->fingers[finger].kept_count == 0)
        f->height = deep > -f->radius ? dm_skin_height(b, f, pose, place) : 0;
}

/* Evaluate the contact of a fingertip with its centre at a place, for the body in a pose. seconds: since the last
 * evaluation of a free body, otherwise 0; it adds damping, without which a free body on the contact springs would
 * ring. */
static void dm_press(dm_state *b, int finger, const double *pose, const double *centre, double seconds) {
    dm_tip *f = b->fingers + finger;
    double from[3], x[3], aside[3], force[3], before[3];
    for (int c = 0; c < 3; c++) from[c] = centre[c] - pose[9 + c];
    for (int c = 0; c < 3; c++) x[c] = pose[c] * from[0] + pose[3 + c] * from[1] + pose[6 + c] * from[2];
    int was = f->in_contact;
    memcpy(before, f->local, sizeof before), memcpy(f->local, x, sizeof x);
    dm_place_tip(b, finger, pose, before, x, aside);
    memset(f->force, 0, sizeof f->force);
    f->law = f->slope = f->slides = 0;
    if (!f->in_contact) return;
    double law = dm_force_at(b, f, f->depth), step = 1e-4 * f->depth + 1e-9 * f->radius;
    double slope = (law - dm_force_at(b, f, f->depth - step)) / step;
    f->slope = slope > 0 ? slope : 0, f->law = law;
    double stick = DM_STICK * law / f->depth, friction = b->laws[f->material][DM_FRICTION];
    double far = sqrt(dm_inner3(aside, aside)), most = stick > 0 ? friction * law / stick : 0, left = far;
    if (was && stick > f->stick && f->stick > 0) left *= f->stick / stick;
    left = left < most ? left : most, f->slides = most > 0 ? left / most : 1, f->stick = stick;
    if (left < (1 - 1e-9) * far) { /* the anchor moves nearer */
        dm_round round;
        for (int c = 0; c < 3; c++) aside[c] *= left / far;
        memcpy(f->anchor, f->foot, sizeof f->anchor);
        dm_march(b, f, f->anchor, aside, &round);
    }
    for (int c = 0; c < 3; c++) force[c] = stick * aside[c];
    double push = law;
    if (seconds > 0 && was) {
        double drag = 2 * b->laws[f->material][DM_DAMPING] * sqrt(f->slope * b->mass_total) / seconds, up = 0;
        for (int c = 0; c < 3; c++) up += drag * (x[c] - before[c]) * f->outward[c];
        for (int c = 0; c < 3; c++) force[c] -= drag * (x[c] - before[c]) - up * f->outward[c];
        push -= up > law ? law : up < -law ? -law : up; /* at most the law's force: contact begins without a jump */
        double size = sqrt(dm_inner3(force, force)), limit = friction * push;
        for (int c = 0; c < 3; c++) force[c] *= size > limit ? limit / size : 1;
    }
    for (int c = 0; c < 3; c++) force[c] += push * f->outward[c];
    if (dm_inner3(force, force) + f->slope < INFINITY)
        for (int c = 0; c < 3; c++) f->force[c] = dm_inner3(pose + 3 * c, force);
    else f->law = f->slope = f->slides = 0, f->in_contact = 0; /* an infinite force is discarded */
}

/* Let the zero of the depth return to the surface at rest once nothing else moves the skin. */
static void dm_return_zero(dm_state *b, int finger, double tick) {
    dm_tip *f = b->fingers + finger;
    if (f->in_contact && f->beside && !dm_is_beside_others(b, finger)) f->zero *= exp(-tick / DM_REST_TIME);
}

/* Let the given force push a fingertip for a tick, towards the depth at which the law gives that force. */
static void dm_push_on(const dm_state *b, dm_tip *f, const dm_fingertip *to, double tick) {
    if (!(f->depth > -f->radius)) return; /* nothing is under it */
    double pose[12], straight = 0;
    dm_pose_now(b, pose);
    for (int c = 0; c < 3; c++) straight -= to->inward[c] * dm_inner3(pose + 3 * c, f->outward);
    double way = dm_depth_of(b, f, to->force) - f->depth, most = DM_TRAVEL * f->radius;
    way *= (1 - exp(-tick / DM_PUSH_TIME)) / (straight > 0.5 ? straight : 0.5);
    f->way += way > most ? most : way < -most ? -most : way;
}

static void dm_lift(dm_tip *f) {
    f->met = f->in_contact = 0, f->slides = 0;
    f->way = f->zero = f->height = f->law = f->slope = f->stick = f->thickness = 0;
    memset(f->force, 0, sizeof f->force);
}

/* Put a fingertip down where a motion begins. If its centre is inside the body, it is first moved outside, or the skin
 * would close over it. */
static void dm_put_down(dm_state *b, dm_tip *f) {
    double pose[12], from[3], x[3], place[3];
    dm_round round;
    dm_pose_now(b, pose);
    for (int c = 0; c < 3; c++) from[c] = f->centre[c] - pose[9 + c];
    for (int c = 0; c < 3; c++) x[c] = pose[c] * from[0] + pose[3 + c] * from[1] + pose[6 + c] * from[2];
    dm_look_round(b, 0, x, f->radius, &round);
    if (!round.facet) return;
    if (round.near > 0 && dm_is_inside(b, x)) {
        for (int c = 0; c < 3; c++) x[c] -= (1 + f->radius / round.near) * round.offset[c];
        for (int c = 0; c < 3; c++) f->centre[c] = dm_inner3(pose + 3 * c, x) + pose[9 + c];
    }
    memcpy(f->local, x, sizeof x);
    f->facet = round.facet - b->facets;
    f->deep = f->depth = dm_find_gap(b, f, x, &round), f->met = f->depth > 0;
    memcpy(f->anchor, f->foot, sizeof f->anchor);
    dm_take_place(b, f, &round);
    for (int c = 0; c < 3; c++) place[c] = f->foot[c] - f->radius * f->outward[c];
    f->height = dm_skin_height(b, f, pose, place);
}

/* Take over the data of a fingertip from a motion. */
static void dm_take_fingertip(dm_state *b, dm_tip *f, const dm_fingertip *to) {
    if (!to->down || to->fresh) dm_lift(f);
    if (!to->down) return;
    for (int c = 0; c < 3; c++) { /* with another radius the foot still rests on the same place */
        double more = (to->radius - f->radius) * f->outward[c] * (f->met || f->in_contact);
        f->anchor[c] += more, f->foot[c] += more;
    }
    f->deep += to->radius - f->radius;
    f->radius = to->radius, f->factors = to->factors, f->factors_end = to->factors_end;
    memcpy(f->centre, to->from, sizeof f->centre);
    if (to->fresh) dm_put_down(b, f);
}

/* Evaluate the contacts of a body that is not free, or sleeps, at the end of a tick. */
static void dm_press_held(dm_state *b, double tick, dm_frame *frame) {
    double pose[12], carried = tick - (tick - b->dt) / 2; /* [s] from the mean of its substeps to the end of the tick */
    dm_pose_now(b, pose);
    for (int c = 0; c < 12 && b->carried && !b->asleep; c++) pose[c] += carried * b->pose_rate[c];
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        dm_tip *f = b->fingers + t->finger;
        dm_press(b, t->finger, pose, f->centre, 0), dm_return_zero(b, t->finger, tick);
        for (int c = 0; c < 3; c++) frame->touches[t->finger].impulse[c] += tick * f->force[c];
    }
}

/* Evaluate the contacts of a free body as a substep begins. */
static void dm_press_free(dm_state *b, int64_t left, dm_frame *frame) {
    double pose[12];
    dm_fitted_pose(b, pose);
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        dm_tip *f = b->fingers + t->finger;
        double centre[3];
        for (int c = 0; c < 3; c++) centre[c] = f->centre[c] - (double)(left + 1) * b->dt * (double)t->velocity[c];
        dm_press(b, t->finger, pose, centre, b->dt), dm_return_zero(b, t->finger, b->dt);
        for (int c = 0; c < 3; c++) frame->touches[t->finger].impulse[c] += b->dt * f->force[c];
    }
}

/* Write the fingertips' places and forces to the frame; in a motion without a tick they are evaluated first. */
static void dm_show_fingertips(dm_state *b, const dm_motion *m, dm_frame *frame) {
    double pose[12];
    if (!m->fingertips[0].down && !m->fingertips[1].down && !m->fingertips[2].down) return;
    dm_pose_now(b, pose);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        dm_tip *f = b->fingers + k;
        dm_touch *to = frame->touches + k;
        if (!m->fingertips[k].down || !b->facet_count) continue;
        if (!m->ticks) dm_press(b, k, pose, f->centre, 0);
        const double *law = b->laws[f->material];
        double plain = dm_law_force((double[]){law[0], law[1], law[2] * f->deeper, law[3]}, f->depth > 0 ? f->depth : 0);
        double times = f->law > 0 && plain > 0 ? f->law / plain : f->stiffer;
        to->depth = f->depth, to->slope = f->slope, to->friction = law[DM_FRICTION];
        to->law[0] = times * law[0], to->law[1] = times * law[1], to->law[2] = f->deeper * law[2], to->law[3] = law[3];
        to->triangle = b->facets[f->facet].index;
        memcpy(to->centre, f->centre, sizeof to->centre), memcpy(to->force, f->force, sizeof to->force);
        for (int c = 0; c < 3; c++) to->outward[c] = dm_inner3(pose + 3 * c, f->outward);
    }
}

/* Evaluate the law at given depths at the place where a fingertip is down. */
static void dm_state_get_law(const dm_state *b, int64_t finger, const double *factors, double end, int64_t count,
                             const double *depths, double *forces) {
    dm_tip f = b->fingers[finger];
    f.factors = factors, f.factors_end = end;
    for (int64_t k = 0; k < count; k++) forces[k] = f.stiffer > 0 ? dm_force_at(b, &f, depths[k]) : 0;
}

/* Add the drift to the velocities. */
static void dm_pass_reaction(dm_state *b, int64_t from, int64_t to, double *unused) {
    dm_vec3 linear = dm_splat3(b->drift.linear), angular = dm_splat3(b->drift.angular);
    (void)unused;
    for (int64_t g = from; g < to; g++) {
        dm_vec3 x = b->state[g].x, v = b->state[g].v, spin = dm_cross(angular, x);
        dm_mask moves = (dm_mask)(b->matter[g].inverse_mass > dm_splat(0));
        v.x += dm_blend(moves, linear.x + spin.x, dm_splat(0)), v.y += dm_blend(moves, linear.y + spin.y, dm_splat(0));
        v.z += dm_blend(moves, linear.z + spin.z, dm_splat(0));
        b->state[g].v = v;
        dm_scatter8(x, v, b->records + g * DM_LANES);
    }
}

/* Give the vertices of a free body, as a rigid motion, the reaction to the fingertips' forces minus the impulses
 * that the skin contact has already given them. */
static void dm_react(dm_state *b) {
    double push[6] = {0}, pose[12], sums[DM_MOMENTS];
    dm_inertia now; /* of the present state, not of the substep's beginning: the momentum must be exact */
    dm_fitted_pose(b, pose);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        const dm_tip *f = b->fingers + k;
        double at[3], local[3], turn[3];
        for (int c = 0; c < 3; c++) local[c] = f->foot[c] - f->radius * f->outward[c];
        for (int c = 0; c < 3; c++) at[c] = dm_inner3(pose + 3 * c, local) + pose[9 + c] - b->origin[c];
        dm_cross3(at, f->force, turn);
        for (int c = 0; c < 3; c++) push[c] -= b->dt * f->force[c], push[3 + c] -= b->dt * turn[c];
    }
    for (int c = 0; c < 6; c++) push[c] -= b->skin_push[c];
    if (!(dm_inner3(push, push) + dm_inner3(push + 3, push + 3) > 0)) return;
    dm_sum_moments(b, sums), dm_find_inertia(b, sums, &now);
    b->drift = dm_rigid_part(b, &now, push, push + 3);
    dm_run_pass(b, dm_pass_reaction);
}
