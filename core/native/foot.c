/* The foot of a fingertip on the surface at rest. In numpy: studies/reference/fingertip.py.
 *
 * A sphere of the fingertip's radius lies on the surface at rest, which it cannot enter (the virtual proxy of
 * Ruspini 1997). Its place straight above the fingertip is the foot. The foot follows the fingertip continuously
 * along the surface, so that it does not jump to another side at thin parts and edges. */
#include "body.h"

enum { DM_NORMALS = 8 };    /* of facets that a sphere touches: a fingertip never touches more at once */
enum { DM_FOOT_STEPS = 4 }; /* steps of a foot towards the place straight above its fingertip, at most */

typedef struct { /* of a sphere: vector from the nearest facet to its centre; normals and distances of those that it touches */
    const dm_facet *facet;
    double near, offset[3], normals[DM_NORMALS][3], away[DM_NORMALS];
    int count;
} dm_round;

/* Note a facet, given its offset from a sphere, if it is the nearest or touches the sphere. Of equally near facets
 * the one whose normal points most towards the centre counts: on an edge it decides the side. Of normals that count as
 * one the nearest facet's is kept: those of farther facets of the same plane lean. */
static void dm_note_facet(dm_round *r, const dm_facet *f, const double *offset, double seat) {
    double away = sqrt(dm_inner3(offset, offset));
    int nearer = away < r->near * (1 - DM_EXACT);
    if (!nearer && away <= r->near * (1 + DM_EXACT))
        nearer = fabs(dm_inner3(offset, f->normal)) > fabs(dm_inner3(r->offset, r->facet->normal));
    if (nearer) r->near = away, r->facet = f, memcpy(r->offset, offset, sizeof r->offset);
    if (!(away < seat && away > 0)) return;
    double n[3];
    int k = 0;
    for (int c = 0; c < 3; c++) n[c] = offset[c] / away;
    while (k < r->count && !(dm_inner3(n, r->normals[k]) > 1 - DM_HELD)) k++; /* the same way */
    if (k == DM_NORMALS || (k < r->count && away >= r->away[k])) return;
    r->away[k] = away, r->count += k == r->count, memcpy(r->normals[k], n, sizeof n);
}

/* Search the facets near a sphere at x, starting from one that was near before. */
static void dm_look_round(const dm_state *b, int64_t first, const double *x, double radius, dm_round *r) {
    double seat = radius * (1 + DM_HELD), offset[3];
    memset(r, 0, sizeof *r), r->near = DBL_MAX;
    if (!b->facet_count) return;
    r->facet = b->facets + first, dm_offset_from(r->facet, x, r->offset);
    r->near = sqrt(dm_inner3(r->offset, r->offset));
    for (int64_t k = 0; k < b->facet_box_count; k++) {
        double reach = r->near > seat ? r->near * (1 + DM_EXACT) : seat;
        if (k % DM_BLOCK == 0 && dm_gap_to_box(b->facet_regions[k / DM_BLOCK], x) > reach) {
            k += DM_BLOCK - 1;
            continue;
        }
        if (dm_gap_to_box(b->facet_boxes[k], x) > reach) continue;
        int64_t end = (k + 1) * DM_BLOCK < b->facet_count ? (k + 1) * DM_BLOCK : b->facet_count;
        for (int64_t i = k * DM_BLOCK; i < end; i++) {
            const dm_facet *f = b->facets + i;
            if (dm_apart(x, f->middle) > (1 + DM_EXACT) * (reach + f->extent)) continue;
            dm_offset_from(f, x, offset), dm_note_facet(r, f, offset, seat);
        }
    }
}

/* Split a vector into its projection on the cone of some normals, whose length is returned, and the rest. Gauss-Seidel
 * iteration. */
static double dm_along_normals(const dm_round *r, const double *way, double *along, double *rest) {
    double push[DM_NORMALS] = {0}, most = sqrt(dm_inner3(way, way));
    memcpy(rest, way, 3 * sizeof *rest);
    for (int sweep = 0; sweep < DM_SWEEPS; sweep++) {
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

/* Move a sphere onto the surface, along the shortest way to the nearest facet. */
static void dm_seat(const dm_state *b, const dm_tip *f, double *x, dm_round *r) {
    for (int k = 0; k < DM_SWEEPS; k++) {
        dm_look_round(b, f->facet, x, f->radius, r);
        if (!r->facet || !(r->near > 0) || fabs(r->near - f->radius) <= DM_SEATED / 2 * f->radius) return;
        for (int c = 0; c < 3; c++) x[c] += (f->radius / r->near - 1) * r->offset[c];
    }
}

/* Move a sphere over the surface by a vector. */
static void dm_march(const dm_state *b, const dm_tip *f, double *x, const double *way, dm_round *r) {
    double parts = ceil(sqrt(dm_inner3(way, way)) / (DM_TRAVEL * f->radius));
    parts = parts < 1 ? 1 : parts < 64 ? parts : 64;
    for (int k = 0; k < (int)parts; k++) {
        for (int c = 0; c < 3; c++) x[c] += way[c] / parts;
        dm_seat(b, f, x, r);
    }
}

/* Move a foot until it lies straight above x, at most `most` from the anchor. Return whether it does. */
static int dm_straighten(const dm_state *b, dm_tip *f, const double *x, const double *touched, double most,
                         dm_round *round) {
    double way[3], along[3], aside[3], at[3];
    if (memcmp(f->foot, f->anchor, sizeof f->foot)) dm_look_round(b, f->facet, f->foot, f->radius, round);
    for (int step = 0;; step++) {
        for (int c = 0; c < 3; c++) at[c] = f->foot[c] - round->offset[c];
        if (dm_apart(touched, at) > most) return 0;
        for (int c = 0; c < 3; c++) way[c] = f->foot[c] - x[c];
        dm_along_normals(round, way, along, aside);
        double far = sqrt(dm_inner3(aside, aside));
        if (far <= DM_SLACK * f->radius || step == DM_FOOT_STEPS) return 1; /* or comes no nearer */
        for (int c = 0; c < 3; c++) way[c] = -(far < most ? 1 : most / far) * aside[c];
        dm_march(b, f, f->foot, way, round);
    }
}

/* Find the foot of a fingertip that touches the surface at rest, x in its space, starting from its last place or its
 * anchor. It moves at most twice its distance to x, because deep in a thin part the foot on the other side is nearer.
 * Return its distance from x, 0 if no normal separates them. */
static double dm_find_foot(const dm_state *b, dm_tip *f, const double *x, dm_round *round) {
    double way[3], along[3], aside[3];
    dm_look_round(b, f->facet, f->anchor, f->radius, round);
    for (int c = 0; c < 3; c++) way[c] = f->anchor[c] - x[c];
    dm_along_normals(round, way, along, aside);
    double most = 2 * sqrt(dm_inner3(aside, aside)) + DM_SLACK * f->radius, touched[3];
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
    /* a remaining sideways offset would tilt the force of a shallow press */
    int straight = sqrt(dm_inner3(aside, aside)) <= DM_SLACK * f->radius;
    const double *up = straight ? along : way;
    double deep = sqrt(dm_inner3(up, up));
    if (!(deep > DM_EXACT * f->radius)) return 0; /* too shallow to have a direction */
    for (int c = 0; c < 3; c++) f->outward[c] = up[c] / deep;
    return deep;
}

/* Find the foot of a fingertip that is clear of the surface at rest or just reaches it. Return minus its gap. */
static double dm_find_gap(const dm_state *b, dm_tip *f, const double *x, dm_round *round) {
    dm_look_round(b, f->facet, x, f->radius, round);
    if (!round->facet) return -INFINITY;
    for (int c = 0; c < 3; c++)
        f->outward[c] = round->near > DM_EXACT * f->radius ? round->offset[c] / round->near : round->facet->normal[c];
    for (int c = 0; c < 3; c++) f->foot[c] = x[c] + (f->radius - round->near) * f->outward[c];
    double gap = f->radius - round->near;
    dm_seat(b, f, f->foot, round);
    return gap;
}

/* Return the thickness of the body behind a point of a facet: the length of an inward ray [m]. */
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

/* Return whether a point is inside the body. From behind a sheet the facets cover half of the solid angle, from
 * inside a body with a hole most of it. Source: the generalised winding number, Jacobson and others 2013. */
static int dm_is_inside(const dm_state *b, const double *x) {
    double seen = 0, sheet = acos(-1), closed = 2 * sheet; /* half of the solid angle of a sheet and of a closed surface */
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
    return seen > (sheet + closed) / 2;
}

/* Return the height of the skin above the surface at rest at a point of a facet [m]: another contact may have moved it.
 * Of a proxy the vertex counts that is nearest at rest. */
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
