/* The contact of a fingertip: the measured law at its depth, Eq. (1), and Coulomb friction. In numpy:
 * studies/reference/fingertip.py.
 *
 * On the surface at rest, as the body carries it, lies a sphere of the fingertip's radius which the surface keeps out
 * (the virtual proxy of Ruspini 1997). Where it would lie straight above the fingertip is its foot: the way from the
 * fingertip to the foot, along the normals that hold the foot, is the depth x, and the law gives the force. It is counted
 * from where the skin was met. Where friction holds it is its anchor: a spring pulls sideways towards it, and beyond the
 * friction the anchor is drawn along. The anchor only ever follows the fingertip along the surface, so what is thin, an
 * edge or another side does not flip it.
 * The force depends on depth and anchor alone, and neither gives more than it took: a spring that becomes stiffer under
 * load keeps its force and gives up its way (Thornton and Yin 1991). The skin is kept out of the fingertip elsewhere, in
 * contact.c; its impulses shape the dent and are not felt. */
#include "body.h"

enum { DM_SETTLING = 24, DM_CONE_SWEEPS = 32, DM_FOOT_STEPS = 4 };
#define DM_MARCH 0.25      /* of the radius: a sphere goes over the surface in such parts, so that it cannot pass a wall */
#define DM_SEATED 1e-4     /* of the radius: a sphere is laid on the surface as exactly */
#define DM_HELD 2e-4       /* of the radius: what is as near to a sphere holds it */
#define DM_STRAIGHT 1e-3   /* of the radius: a foot that is so little aside is straight above */
#define DM_SAME_WAY 0.9998 /* cosine: normals as near are one */
#define DM_INSIDE 0.75     /* of all directions: half way between a sheet and a closed body */
#define DM_STICK (2 / 3.0) /* of the normal stiffness, what is soft and keeps its volume has sideways. Mindlin 1949 */
#define DM_PUSH_TIME 0.02  /* [s] in which a force brings a fingertip to its depth: a tenth of a press */
#define DM_BACK_TIME 0.2   /* [s] in which depth is counted from the surface at rest again, when another contact that had
                              moved the skin has gone: as long as a dent takes to come back */
#define DM_BOTTOM 1e3      /* [m] a law that has not answered a force by then never does */

typedef struct { /* what lies round a sphere: the way from the nearest facet to its centre, and the normals that hold it */
    const dm_facet *facet;
    double near, offset[3], normals[DM_NORMALS][3];
    int count;
} dm_round;

/* Note a facet, at its offset from a sphere, if it is the nearest or holds the sphere. Of those that are as near the one
 * that sees the centre most squarely counts: on an edge it knows the side. */
static void dm_note_facet(dm_round *r, const dm_facet *f, const double *offset, double seat) {
    double away = sqrt(dm_inner3(offset, offset));
    int nearer = away < r->near * (1 - 1e-9);
    if (!nearer && away <= r->near * (1 + 1e-9))
        nearer = fabs(dm_inner3(offset, f->normal)) > fabs(dm_inner3(r->offset, r->facet->normal));
    if (nearer) r->near = away, r->facet = f, memcpy(r->offset, offset, sizeof r->offset);
    if (!(away < seat && away > 0) || r->count == DM_NORMALS) return;
    double *n = r->normals[r->count];
    for (int c = 0; c < 3; c++) n[c] = offset[c] / away;
    for (int k = 0; k < r->count; k++)
        if (dm_inner3(n, r->normals[k]) > DM_SAME_WAY) return;
    r->count++;
}

/* Look at the facets round a sphere at x, beginning with one that was near. */
static void dm_look_round(const dm_state *b, int64_t first, const double *x, double radius, dm_round *r) {
    double seat = radius * (1 + DM_HELD), offset[3];
    memset(r, 0, sizeof *r), r->near = DBL_MAX;
    if (!b->facet_count) return;
    r->facet = b->facets + first, dm_offset_from(r->facet, x, r->offset);
    r->near = sqrt(dm_inner3(r->offset, r->offset));
    for (int64_t k = 0; k < b->facet_box_count; k++) {
        double reach = r->near > seat ? r->near * (1 + 1e-9) : seat;
        if (k % DM_FACET_BLOCK == 0 && dm_gap_to_box(b->facet_regions[k / DM_FACET_BLOCK], x) > reach) {
            k += DM_FACET_BLOCK - 1;
            continue;
        }
        if (dm_gap_to_box(b->facet_boxes[k], x) > reach) continue;
        int64_t end = (k + 1) * DM_FACET_BLOCK < b->facet_count ? (k + 1) * DM_FACET_BLOCK : b->facet_count;
        for (int64_t i = k * DM_FACET_BLOCK; i < end; i++) {
            const dm_facet *f = b->facets + i;
            if (dm_apart(x, f->middle) > (1 + 1e-9) * (reach + f->extent)) continue;
            dm_offset_from(f, x, offset), dm_note_facet(r, f, offset, seat);
        }
    }
}

/* Split a way into what normals push along, of which the length is returned, and the rest: the projection on the cone
 * that they span, by Gauss and Seidel. */
static double dm_along_normals(const dm_round *r, const double *way, double *along, double *rest) {
    double push[DM_NORMALS] = {0}, most = sqrt(dm_inner3(way, way));
    memcpy(rest, way, 3 * sizeof *rest);
    for (int sweep = 0; sweep < DM_CONE_SWEEPS; sweep++) {
        double changed = 0;
        for (int k = 0; k < r->count; k++) {
            double more = dm_inner3(rest, r->normals[k]), least = -push[k];
            more = more > least ? more : least, push[k] += more;
            for (int c = 0; c < 3; c++) rest[c] -= more * r->normals[k][c];
            changed = fabs(more) > changed ? fabs(more) : changed;
        }
        if (changed <= 1e-12 * most) break;
    }
    for (int c = 0; c < 3; c++) along[c] = way[c] - rest[c];
    return sqrt(dm_inner3(along, along));
}

/* Lay a sphere on the surface, by the shortest way out of, or down to, what is nearest. */
static void dm_seat(const dm_state *b, const dm_tip *f, double *x, dm_round *r) {
    for (int k = 0; k < DM_SETTLING; k++) {
        dm_look_round(b, f->facet, x, f->radius, r);
        if (!r->facet || !(r->near > 0) || fabs(r->near - f->radius) <= DM_SEATED / 2 * f->radius) return;
        for (int c = 0; c < 3; c++) x[c] += (f->radius / r->near - 1) * r->offset[c];
    }
}

/* Lead a sphere over the surface by a way. */
static void dm_march(const dm_state *b, const dm_tip *f, double *x, const double *way, dm_round *r) {
    double parts = ceil(sqrt(dm_inner3(way, way)) / (DM_MARCH * f->radius));
    parts = parts < 1 ? 1 : parts < 64 ? parts : 64;
    for (int k = 0; k < (int)parts; k++) {
        for (int c = 0; c < 3; c++) x[c] += way[c] / parts;
        dm_seat(b, f, x, r);
    }
}

/* How thick the body is behind a place of a facet: to where a ray inwards comes out [m]. */
static double dm_thickness(const dm_state *b, const double *from, const double *inward) {
    double nearest = INFINITY;
    for (int64_t k = 0; k < b->facet_count; k++) {
        const dm_facet *f = b->facets + k;
        double along = dm_inner3(inward, f->normal), at[3], side[3], offset[3];
        if (!(along > 0)) continue;
        for (int c = 0; c < 3; c++) at[c] = f->corner[0][c] - from[c];
        double way = dm_inner3(at, f->normal) / along;
        if (!(way > 0 && way < nearest)) continue;
        for (int c = 0; c < 3; c++) side[c] = from[c] + way * inward[c];
        dm_offset_from(f, side, offset);
        if (dm_inner3(offset, offset) <= 1e-18 * b->size * b->size) nearest = way;
    }
    return nearest;
}

/* How many times as stiff an elastic layer that keeps its volume is under a contact of a radius as one without an end.
 * share: the radius over the thickness. Source: Dimitriadis and others 2002, bonded below. */
static double dm_layer(double share) {
    return 1 + share * (1.133 + share * (1.283 + share * (0.769 + share * 0.0975)));
}

/* The force of the law under a fingertip at a depth [m], with what is painted, and with the factor of a tip that is
 * another than the measuring one. */
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

/* The depth at which the law gives a force. */
static double dm_depth_of(const dm_state *b, const dm_tip *f, double force) {
    double low = 0, high = f->radius;
    while (dm_force_at(b, f, high) < force && high < DM_BOTTOM) high *= 2;
    for (int k = 0; k < 50; k++) {
        double middle = (low + high) / 2;
        if (dm_force_at(b, f, middle) < force) low = middle;
        else high = middle;
    }
    return high;
}

/* Take the material at the place where a fingertip's foot lies. */
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

/* How far the skin stands above the surface at rest at a place of a facet, in the space of the shape at rest [m]: another
 * contact may have pushed or bulged it. Of a proxy, the vertex counts that is the nearest at rest. */
static double dm_skin_height(const dm_state *b, const dm_tip *f, const double *pose, const double *place) {
    const dm_facet *at = b->facets + f->facet;
    double here[3] = {0}, home[3], high = 0, nearest = DBL_MAX;
    memcpy(home, place, sizeof home);
    for (int c = 0; c < 3 && b->own_surface; c++)
        for (int d = 0; d < 3; d++) here[d] += f->weight[c] * (double)b->records[b->place[at->vertex[c]]].x[d];
    for (int64_t k = 0; k < b->n && !b->own_surface; k++) {
        double rest[3] = {b->rest[k], b->rest[b->n + k], b->rest[2 * b->n + k]}, far = 0;
        for (int c = 0; c < 3; c++) far += (rest[c] - place[c]) * (rest[c] - place[c]);
        if (!(far < nearest)) continue;
        nearest = far, memcpy(home, rest, sizeof home);
        for (int c = 0; c < 3; c++) here[c] = (double)b->records[b->place[k]].x[c];
    }
    for (int c = 0; c < 3; c++) {
        const double *row = pose + 3 * c;
        double up = here[c] + b->origin[c] - dm_inner3(row, home) - pose[9 + c];
        high += dm_inner3(row, f->outward) * up;
    }
    return high;
}

/* Does anything touch the body, other than this fingertip? */
static int dm_is_beside_others(const dm_state *b, int finger) {
    int others = b->meets;
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) others |= k != finger && b->fingers[k].in_contact;
    return others;
}

/* Lead a foot on until it lies straight above x, no farther from the anchor than the most. Tell whether it does. */
static int dm_straighten(const dm_state *b, dm_tip *f, const double *x, const double *touched, double most,
                         dm_round *round) {
    double way[3], along[3], aside[3], at[3];
    if (memcmp(f->foot, f->anchor, sizeof f->foot)) dm_look_round(b, f->facet, f->foot, f->radius, round);
    for (int step = 0; step <= DM_FOOT_STEPS; step++) {
        for (int c = 0; c < 3; c++) at[c] = f->foot[c] - round->offset[c];
        if (dm_apart(touched, at) > most) return 0;
        for (int c = 0; c < 3; c++) way[c] = f->foot[c] - x[c];
        dm_along_normals(round, way, along, aside);
        double far = sqrt(dm_inner3(aside, aside));
        if (far <= DM_STRAIGHT * f->radius) return 1;
        if (step == DM_FOOT_STEPS) return 1; /* as near as it comes */
        for (int c = 0; c < 3; c++) way[c] = -(far < most ? 1 : most / far) * aside[c];
        dm_march(b, f, f->foot, way, round);
    }
    return 0;
}

/* Find the foot of a fingertip that lies on the surface at rest, x in its space: from where it was, or from its anchor. It
 * goes no farther from that than twice as it is behind: from deep in a thin part the foot of another side is nearer.
 * Return how far it is from x, 0 where no normal that holds it keeps them apart. */
static double dm_find_foot(const dm_state *b, dm_tip *f, const double *x, dm_round *round) {
    double way[3], along[3], aside[3];
    dm_look_round(b, f->facet, f->anchor, f->radius, round);
    for (int c = 0; c < 3; c++) way[c] = f->anchor[c] - x[c];
    dm_along_normals(round, way, along, aside);
    double most = 2 * sqrt(dm_inner3(aside, aside)) + DM_STRAIGHT * f->radius, touched[3];
    for (int c = 0; c < 3; c++) touched[c] = f->anchor[c] - round->offset[c];
    if (!dm_straighten(b, f, x, touched, most, round)) {
        memcpy(f->foot, f->anchor, sizeof f->foot);
        dm_look_round(b, f->facet, f->anchor, f->radius, round);
        if (!dm_straighten(b, f, x, touched, most, round)) {
            memcpy(f->foot, f->anchor, sizeof f->foot);
            for (int c = 0; c < 3; c++) way[c] = -aside[c];
            dm_march(b, f, f->foot, way, round);
        }
    }
    for (int c = 0; c < 3; c++) way[c] = f->foot[c] - x[c];
    if (!(dm_along_normals(round, way, along, aside) > 0)) return 0;
    /* what a foot that is straight above is still aside would tilt the force of a shallow press */
    int straight = sqrt(dm_inner3(aside, aside)) <= DM_STRAIGHT * f->radius;
    const double *up = straight ? along : way;
    double deep = sqrt(dm_inner3(up, up));
    if (!(deep > 1e-9 * f->radius)) return 0; /* it has no direction */
    for (int c = 0; c < 3; c++) f->outward[c] = up[c] / deep;
    return deep;
}

/* Find the foot of one that is clear of the surface at rest, or comes to it. Return how deep it is: its gap, negative. */
static double dm_find_gap(const dm_state *b, dm_tip *f, const double *x, dm_round *round) {
    dm_look_round(b, f->facet, x, f->radius, round);
    if (!round->facet) return -INFINITY;
    for (int c = 0; c < 3; c++)
        f->outward[c] = round->near > 1e-9 * f->radius ? round->offset[c] / round->near : round->facet->normal[c];
    for (int c = 0; c < 3; c++) f->foot[c] = x[c] + (f->radius - round->near) * f->outward[c];
    double gap = f->radius - round->near;
    dm_seat(b, f, f->foot, round);
    return gap;
}

/* Find where a fingertip is, at x in the space of the shape at rest, and the way from its foot to its anchor.
 * before: where it was. It gets no deeper than it goes: in a crease another foot may be farther, which would give energy. */
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
    /* while it moves the skin itself, that says nothing */
    if (!in_contact && round.facet && b->fingers[finger].kept_count == 0)
        f->height = deep > -f->radius ? dm_skin_height(b, f, pose, place) : 0;
}

/* Evaluate the contact of a fingertip whose centre is at a place, for the body in a pose.
 * seconds: since the last time, where the body is free: what holds a body between springs would ring without damping. */
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
    if (left < (1 - 1e-9) * far) { /* the anchor comes nearer */
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
        push -= up > law ? law : up < -law ? -law : up; /* no more than the law: a touch begins without a jump */
        double size = sqrt(dm_inner3(force, force)), limit = friction * push;
        for (int c = 0; c < 3; c++) force[c] *= size > limit ? limit / size : 1;
    }
    for (int c = 0; c < 3; c++) force[c] += push * f->outward[c];
    if (dm_inner3(force, force) + f->slope < INFINITY)
        for (int c = 0; c < 3; c++) f->force[c] = dm_inner3(pose + 3 * c, force);
    else f->law = f->slope = f->slides = 0, f->in_contact = 0; /* what is beyond all measure is no force */
}

/* Let the depth be counted from the surface at rest again, where what had moved the skin has gone. */
static void dm_count_anew(dm_state *b, int finger, double tick) {
    dm_tip *f = b->fingers + finger;
    if (f->in_contact && f->beside && !dm_is_beside_others(b, finger)) f->zero *= exp(-tick / DM_BACK_TIME);
}

/* Where the shape at rest is now; free: where it was fitted as the substep began. */
static void dm_pose_now(const dm_state *b, double *pose) {
    if (b->asleep) memcpy(pose, b->still_pose, sizeof b->still_pose);
    else dm_fit_whole(b, pose);
}

static void dm_fitted_pose(const dm_state *b, double *pose) {
    memcpy(pose, b->rotation, sizeof b->rotation);
    for (int c = 0; c < 3; c++)
        pose[9 + c] = b->origin[c] + b->translation[c] - dm_inner3(b->rotation + 3 * c, b->rest_centre);
}

/* Let a force push a fingertip on for a tick, towards the depth at which the law answers it. */
static void dm_push_on(const dm_state *b, dm_tip *f, const dm_fingertip *to, double tick) {
    if (!(f->depth > -f->radius)) return; /* nothing is under it */
    double pose[12], straight = 0;
    dm_pose_now(b, pose);
    for (int c = 0; c < 3; c++) straight -= to->inward[c] * dm_inner3(pose + 3 * c, f->outward);
    double way = dm_depth_of(b, f, to->force) - f->depth, most = DM_MARCH * f->radius;
    way *= (1 - exp(-tick / DM_PUSH_TIME)) / (straight > 0.5 ? straight : 0.5);
    f->way += way > most ? most : way < -most ? -most : way;
}

static void dm_lift(dm_tip *f) {
    f->met = f->in_contact = 0, f->slides = 0;
    f->way = f->zero = f->height = f->law = f->slope = f->stick = f->thickness = 0;
    memset(f->force, 0, sizeof f->force);
}

/* Is a place inside the body? Behind a sheet the facets are half of what is to be seen, inside a body with a hole most.
 * Source: the generalised winding number, Jacobson and others 2013. */
static int dm_is_inside(const dm_state *b, const double *x) {
    double seen = 0;
    for (const dm_facet *f = b->facets; f < b->facets + b->facet_count; f++) {
        double way[3][3], far[3], normal[3];
        for (int p = 0; p < 3; p++) {
            for (int c = 0; c < 3; c++) way[p][c] = f->corner[p][c] - x[c];
            far[p] = sqrt(dm_inner3(way[p], way[p]));
        }
        dm_cross3(way[1], way[2], normal);
        double beside = far[0] * far[1] * far[2] + dm_inner3(way[0], way[1]) * far[2];
        beside += dm_inner3(way[1], way[2]) * far[0] + dm_inner3(way[2], way[0]) * far[1];
        seen += atan2(dm_inner3(way[0], normal), beside);
    }
    return seen > DM_INSIDE * 2 * acos(-1);
}

/* Put a fingertip down where a motion begins. Where its centre is inside the body it comes from outside, or the skin would
 * close over it. */
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

/* Take what a motion says of a fingertip. */
static void dm_take_fingertip(dm_state *b, dm_tip *f, const dm_fingertip *to) {
    if (!to->down || to->fresh) dm_lift(f);
    if (!to->down) return;
    for (int c = 0; c < 3; c++) { /* another radius lies on the same place */
        double more = (to->radius - f->radius) * f->outward[c] * (f->met || f->in_contact);
        f->anchor[c] += more, f->foot[c] += more;
    }
    f->deep += to->radius - f->radius;
    f->radius = to->radius, f->factors = to->factors, f->factors_end = to->factors_end;
    memcpy(f->centre, to->from, sizeof f->centre);
    if (to->fresh) dm_put_down(b, f);
}

/* Evaluate the contacts of a body that is held, or sleeps, at the end of a tick. */
static void dm_press_held(dm_state *b, double tick, dm_frame *frame) {
    double pose[12], carried = tick - (tick - b->dt) / 2; /* it stands where its substeps began on average */
    dm_pose_now(b, pose);
    for (int c = 0; c < 12 && b->carried && !b->asleep; c++) pose[c] += carried * b->pose_rate[c];
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        dm_tip *f = b->fingers + t->finger;
        dm_press(b, t->finger, pose, f->centre, 0), dm_count_anew(b, t->finger, tick);
        for (int c = 0; c < 3; c++) frame->touches[t->finger].impulse[c] += tick * f->force[c];
    }
}

/* The same of one that is free, as a substep begins. */
static void dm_press_free(dm_state *b, int64_t left, dm_frame *frame) {
    double pose[12];
    dm_fitted_pose(b, pose);
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++) {
        dm_tip *f = b->fingers + t->finger;
        double centre[3];
        for (int c = 0; c < 3; c++) centre[c] = f->centre[c] - (double)(left + 1) * b->dt * (double)t->velocity[c];
        dm_press(b, t->finger, pose, centre, b->dt), dm_count_anew(b, t->finger, b->dt);
        for (int c = 0; c < 3; c++) frame->touches[t->finger].impulse[c] += b->dt * f->force[c];
    }
}

/* Show where fingertips are and what acts on them; those of a motion without a tick are evaluated where they are. */
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

/* Evaluate the law where a fingertip is down, at depths. */
static void dm_state_get_law(const dm_state *b, int64_t finger, const double *factors, double end, int64_t count,
                             const double *depths, double *forces) {
    dm_tip f = b->fingers[finger];
    f.factors = factors, f.factors_end = end;
    for (int64_t k = 0; k < count; k++) forces[k] = f.stiffer > 0 ? dm_force_at(b, &f, depths[k]) : 0;
}

/* Let the vertices of a free body take, as one, what is missing to the reaction on the fingertips: the skin's contact gave
 * them other impulses. */
static void dm_react(dm_state *b) {
    double push[6] = {0}, pose[12], sums[DM_MOMENTS];
    dm_inertia now; /* not as the substep began: nothing of the momentum may be lost */
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
    dm_rigid more = dm_rigid_part(b, &now, push, push + 3);
    dm_vec3 linear = dm_splat3(more.linear), angular = dm_splat3(more.angular);
    for (int64_t g = 0; g < b->groups; g++) {
        dm_vec3 x = b->state[g].x, v = b->state[g].v, spin = dm_cross(angular, x);
        dm_mask moves = (dm_mask)(b->matter[g].inverse_mass > dm_splat(0));
        v.x += dm_blend(moves, linear.x + spin.x, dm_splat(0)), v.y += dm_blend(moves, linear.y + spin.y, dm_splat(0));
        v.z += dm_blend(moves, linear.z + spin.z, dm_splat(0));
        b->state[g].v = v;
        dm_scatter8(x, v, b->records + g * DM_LANES);
    }
}
