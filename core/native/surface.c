/* How deep a fingertip is below the surface at rest: the x of Eq. (1). Source: core/mesh/depth.py. */
#include "body.h"

enum { DM_FACET_BLOCK = 16, DM_NEARBY_SHARE = 8 }; /* facets that share a bounding box; of the radius a margin has */

/* Put the facets where their vertices are (3, n), and box them in runs. */
static void dm_shape_facets(dm_state *b, const double *x, int64_t n) {
    for (int64_t k = 0; k < b->facet_count; k++) {
        dm_facet *f = b->facets + k;
        for (int p = 0; p < 3; p++)
            for (int c = 0; c < 3; c++) f->corner[p][c] = x[c * n + f->vertex[p]];
        double along[3], across[3];
        for (int c = 0; c < 3; c++)
            along[c] = f->corner[1][c] - f->corner[0][c], across[c] = f->corner[2][c] - f->corner[0][c];
        dm_cross3(along, across, f->normal);
        double size = sqrt(dm_inner3(f->normal, f->normal));
        for (int c = 0; c < 3; c++) f->normal[c] /= size > 1e-30 ? size : 1e-30;
        double *box = b->facet_boxes[k / DM_FACET_BLOCK];
        for (int p = 0; p < 3; p++)
            for (int c = 0; c < 3; c++) {
                double a = f->corner[p][c];
                int first = k % DM_FACET_BLOCK == 0 && p == 0;
                box[c] = first || a < box[c] ? a : box[c], box[3 + c] = first || a > box[3 + c] ? a : box[3 + c];
            }
    }
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) b->fingers[k].nearby.reach = 0;
}

/* Lay the facets along a curve in space. */
static int32_t dm_lay_surface(dm_state *b, const dm_body_def *d) {
    int64_t t = d->surface_triangles, n = d->surface_vertices;
    double *middles = dm_alloc(3 * t, sizeof(double));
    dm_keyed *keys = dm_alloc(t, sizeof(dm_keyed));
    b->facets = dm_alloc(t, sizeof(dm_facet));
    b->facet_box_count = (t + DM_FACET_BLOCK - 1) / DM_FACET_BLOCK;
    b->facet_boxes = dm_alloc(b->facet_box_count, sizeof *b->facet_boxes);
    int whole = middles && keys && b->facets && b->facet_boxes;
    for (int64_t k = 0; whole && k < t; k++)
        for (int c = 0; c < 3; c++) {
            const int64_t *corner = d->surface_corners + 3 * k;
            const double *x = d->surface_rest + c * n;
            middles[c * t + k] = (x[corner[0]] + x[corner[1]] + x[corner[2]]) / 3;
        }
    whole = whole && (!t || dm_order_along_curve(middles, t, keys));
    for (int64_t k = 0; whole && k < t; k++) {
        int64_t index = keys[k].vertex;
        dm_facet *f = b->facets + k;
        for (int p = 0; p < 3; p++) f->vertex[p] = (uint32_t)d->surface_corners[3 * index + p];
        f->index = index, f->material = d->surface_material[index];
    }
    dm_free(middles), dm_free(keys);
    if (!whole) return DM_MEMORY;
    b->facet_count = t;
    dm_shape_facets(b, d->surface_rest, n);
    return DM_OK;
}

/* The offset of a point from the nearest one of a triangle. Source: Ericson, Real-Time Collision Detection, 5.1.5. */
static void dm_offset_from(const dm_facet *f, const double *point, double *offset) {
    const double *a = f->corner[0], *b = f->corner[1], *c = f->corner[2];
    double ab[3], ac[3], pa[3], pb[3], pc[3], v, w;
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k], ac[k] = c[k] - a[k];
        pa[k] = point[k] - a[k], pb[k] = point[k] - b[k], pc[k] = point[k] - c[k];
    }
    double d1 = dm_inner3(ab, pa), d2 = dm_inner3(ac, pa), d3 = dm_inner3(ab, pb), d4 = dm_inner3(ac, pb);
    double d5 = dm_inner3(ab, pc), d6 = dm_inner3(ac, pc);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double whole = va + vb + vc, beside = (d4 - d3) + (d5 - d6);
    if (d1 <= 0 && d2 <= 0) v = 0, w = 0;
    else if (d3 >= 0 && d4 <= d3) v = 1, w = 0;
    else if (d6 >= 0 && d5 <= d6) v = 0, w = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0) v = fabs(d1 - d3) > 1e-30 ? d1 / (d1 - d3) : 0, w = 0;
    else if (vb <= 0 && d2 >= 0 && d6 <= 0) v = 0, w = fabs(d2 - d6) > 1e-30 ? d2 / (d2 - d6) : 0;
    else if (va <= 0 && d4 >= d3 && d5 >= d6) w = fabs(beside) > 1e-30 ? (d4 - d3) / beside : 0, v = 1 - w;
    else v = fabs(whole) > 1e-30 ? vb / whole : vb, w = fabs(whole) > 1e-30 ? vc / whole : vc;
    for (int k = 0; k < 3; k++) offset[k] = pa[k] - v * ab[k] - w * ac[k];
}

static double dm_gap_to_box(const double *box, const double *x) {
    double away = 0;
    for (int c = 0; c < 3; c++) {
        double gap = box[c] - x[c] > x[c] - box[3 + c] ? box[c] - x[c] : x[c] - box[3 + c];
        away += gap > 0 ? gap * gap : 0;
    }
    return sqrt(away);
}

/* Find the distance to the nearest facet that faces the side, DBL_MAX where none does; with a limit on it, find of the
 * facets that are as near the one that sees the point most squarely: on an edge it knows the point's side.
 * nearby: the facets to look at, NULL: all. */
static double dm_nearest_facet(const dm_state *b, const dm_nearby *nearby, const double *x, const double *side,
                               double limit, const dm_facet **best, double *offset) {
    double near = limit, height = -1;
    int64_t count = nearby ? nearby->count : b->facet_count;
    for (int64_t k = 0; k * DM_FACET_BLOCK < count; k++) {
        if (!nearby && dm_gap_to_box(b->facet_boxes[k], x) > near) continue;
        int64_t end = (k + 1) * DM_FACET_BLOCK < count ? (k + 1) * DM_FACET_BLOCK : count;
        for (int64_t i = k * DM_FACET_BLOCK; i < end; i++) {
            const dm_facet *f = b->facets + (nearby ? nearby->facets[i] : i);
            if (side && !(dm_inner3(side, f->normal) > DM_SAME_SIDE)) continue;
            double from[3];
            dm_offset_from(f, x, from);
            double away = sqrt(dm_inner3(from, from));
            if (!best) {
                near = away < near ? away : near;
                continue;
            }
            double square = fabs(dm_inner3(from, f->normal));
            if (away > limit || square < height || (square == height && (*best)->index < f->index)) continue;
            *best = f, height = square;
            memcpy(offset, from, sizeof from);
        }
    }
    return near;
}

/* Are all facets within a distance of a point listed? */
static int dm_knows(const dm_nearby *nearby, const double *x, double away) {
    double way[3];
    for (int c = 0; c < 3; c++) way[c] = x[c] - nearby->centre[c];
    return away + sqrt(dm_inner3(way, way)) < (1 - 1e-9) * nearby->reach;
}

/* List the facets near a point, so many farther than the nearest that they last for some ticks. */
static void dm_list_nearby(const dm_state *b, dm_nearby *nearby, const double *x, double near, double most) {
    double reach = near + nearby->margin;
    int64_t found = 0;
    for (int64_t k = 0; k < b->facet_box_count; k++) {
        if (dm_gap_to_box(b->facet_boxes[k], x) > reach) continue;
        int64_t end = (k + 1) * DM_FACET_BLOCK < b->facet_count ? (k + 1) * DM_FACET_BLOCK : b->facet_count;
        for (int64_t i = k * DM_FACET_BLOCK; i < end; i++) {
            double from[3];
            dm_offset_from(b->facets + i, x, from);
            if (dm_inner3(from, from) > reach * reach) continue;
            if (found < DM_NEARBY) nearby->facets[found] = (uint32_t)i;
            found++;
        }
    }
    memcpy(nearby->centre, x, sizeof nearby->centre);
    nearby->reach = found <= DM_NEARBY ? reach : 0, nearby->count = (uint32_t)found;
    if (4 * found < DM_NEARBY) nearby->margin = 2 * nearby->margin < most ? 2 * nearby->margin : most;
    if (found > DM_NEARBY) nearby->margin *= DM_NEARBY / (2.0 * (double)found);
}

/* The force of a law (K1, K2, x0, power) at a depth [m]: core/material.py says how. */
static double dm_law_force(const double *law, double x) {
    double p = law[3], slope = p * p * law[0], straight = (1 + 1 / p) * law[2], beyond = x > law[2] ? x - law[2] : 0;
    if (p == 1) return law[0] * (x < law[2] ? x : law[2]) + law[1] * beyond;
    double more = (law[1] - slope) * beyond;
    if (x < straight) return p * law[0] * straight * pow(x / straight, p) + more;
    return law[0] * law[2] + slope * beyond + more;
}

/* Measure a fingertip against the surface at rest in its pose, and remember by which side it came in. */
static void dm_measure_depth(dm_state *b, int finger, double radius, const double *pose, dm_touch *touch) {
    const double *centre = b->fingers[finger].centre;
    double local[3], offset[3] = {0}, from[3];
    for (int c = 0; c < 3; c++) from[c] = centre[c] - pose[9 + c];
    for (int c = 0; c < 3; c++) local[c] = pose[c] * from[0] + pose[3 + c] * from[1] + pose[6 + c] * from[2];
    const double *side = b->fingers[finger].has_side ? b->fingers[finger].side : NULL;
    const dm_facet *best = NULL, *last = b->facets + b->fingers[finger].last;
    double near = DBL_MAX;
    if (b->facet_count && (!side || dm_inner3(side, last->normal) > DM_SAME_SIDE)) { /* it is near that one still */
        dm_offset_from(last, local, offset);
        near = sqrt(dm_inner3(offset, offset));
    }
    dm_nearby *nearby = &b->fingers[finger].nearby;
    double listed = nearby->reach > 0 ? dm_nearest_facet(b, nearby, local, side, near, NULL, NULL) : DBL_MAX;
    if (dm_knows(nearby, local, listed * (1 + 1e-9) + 1e-12)) near = listed;
    else {
        near = dm_nearest_facet(b, NULL, local, side, near, NULL, NULL);
        if (side && near == DBL_MAX) side = NULL, near = dm_nearest_facet(b, NULL, local, NULL, DBL_MAX, NULL, NULL);
        double most = radius / DM_NEARBY_SHARE;
        if (!(nearby->margin > 0 && nearby->margin < most)) nearby->margin = most;
        if (near < DBL_MAX) dm_list_nearby(b, nearby, local, near, most);
    }
    double limit = near * (1 + 1e-9) + 1e-12;
    dm_nearest_facet(b, dm_knows(nearby, local, limit) ? nearby : NULL, local, side, limit, &best, offset);
    touch->triangle = -1, touch->depth = touch->law_force = 0;
    memcpy(touch->centre, centre, sizeof touch->centre);
    memset(touch->outward, 0, sizeof touch->outward);
    if (!best) return; /* no surface, or a fingertip that is nowhere */
    double height = sqrt(dm_inner3(offset, offset)) * (dm_inner3(offset, best->normal) >= 0 ? 1 : -1);
    int on_it = !(fabs(height) > 1e-6 * radius); /* the way the depth falls fastest; only the face knows it there */
    for (int c = 0; c < 3; c++) {
        const double *row = pose + 3 * c;
        for (int d = 0; d < 3; d++) touch->outward[c] += row[d] * (on_it ? best->normal[d] : offset[d] / height);
    }
    touch->depth = radius - height, touch->triangle = best->index, b->fingers[finger].last = best - b->facets;
    touch->law_force = dm_law_force(b->laws[best->material], touch->depth > 0 ? touch->depth : 0);
    if (touch->depth < radius) { /* its centre is still outside */
        b->fingers[finger].has_side = touch->depth > 0;
        memcpy(b->fingers[finger].side, best->normal, sizeof best->normal);
    }
}
