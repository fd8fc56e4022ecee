/* The surface at rest, from which the depth of a fingertip is measured: its facets, and the search for those near a
 * point. */
#include "body.h"

static double dm_apart(const double *from, const double *to) {
    double way[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    return sqrt(dm_inner3(way, way));
}

/* Set the facets for vertices at (3, n), and the boxes round runs of them. */
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
        f->extent = 0;
        for (int c = 0; c < 3; c++) f->middle[c] = (f->corner[0][c] + f->corner[1][c] + f->corner[2][c]) / 3;
        for (int p = 0; p < 3; p++) {
            double away = dm_apart(f->corner[p], f->middle);
            f->extent = away > f->extent ? away : f->extent;
        }
        double *box = b->facet_boxes[k / DM_BLOCK];
        for (int p = 0; p < 3; p++)
            for (int c = 0; c < 3; c++) {
                double a = f->corner[p][c];
                int first = k % DM_BLOCK == 0 && p == 0;
                box[c] = first || a < box[c] ? a : box[c], box[3 + c] = first || a > box[3 + c] ? a : box[3 + c];
            }
    }
    for (int64_t k = 0; k < b->facet_box_count; k++) {
        double *whole = b->facet_regions[k / DM_BLOCK], *box = b->facet_boxes[k];
        if (k % DM_BLOCK == 0) memcpy(whole, box, sizeof *b->facet_regions);
        for (int c = 0; c < 3; c++) {
            whole[c] = box[c] < whole[c] ? box[c] : whole[c];
            whole[3 + c] = box[3 + c] > whole[3 + c] ? box[3 + c] : whole[3 + c];
        }
    }
}

/* Move the feet of fingertips with the surface when it changes. */
static void dm_reshape_facets(dm_state *b, const double *x, int64_t n) {
    double places[DM_MAX_FINGERTIPS][3] = {{0}};
    for (int k = 0; k < 2 * DM_MAX_FINGERTIPS; k++) {
        dm_tip *f = b->fingers + k % DM_MAX_FINGERTIPS;
        const dm_facet *at = b->facets + f->facet;
        for (int c = 0; c < 3 && f->met; c++) {
            double place = 0;
            for (int p = 0; p < 3; p++) place += f->weight[p] * at->corner[p][c];
            if (k < DM_MAX_FINGERTIPS) places[k][c] = place;
            else {
                double way = place - places[k - DM_MAX_FINGERTIPS][c];
                f->anchor[c] += way, f->foot[c] += way, f->local[c] += way;
            }
        }
        if (k == DM_MAX_FINGERTIPS - 1) dm_shape_facets(b, x, n);
        if (k >= DM_MAX_FINGERTIPS) f->thickness = 0;
    }
}

/* Order the facets along a Morton curve. */
static int32_t dm_lay_surface(dm_state *b, const dm_body_def *d) {
    int64_t t = d->surface_triangles, n = d->surface_vertices;
    double *middles = dm_alloc(3 * t, sizeof(double));
    dm_keyed *keys = dm_alloc(t, sizeof(dm_keyed));
    b->facets = dm_alloc(t, sizeof(dm_facet));
    b->facet_box_count = (t + DM_BLOCK - 1) / DM_BLOCK;
    b->facet_boxes = dm_alloc(b->facet_box_count, sizeof *b->facet_boxes);
    b->facet_regions = dm_alloc(b->facet_box_count / DM_BLOCK + 1, sizeof *b->facet_regions);
    b->painted = dm_alloc(n, sizeof *b->painted);
    int whole = middles && keys && b->facets && b->facet_boxes && b->facet_regions && b->painted;
    for (int64_t k = 0; whole && k < t; k++)
        for (int c = 0; c < 3; c++) {
            const int64_t *corner = d->surface_corners + 3 * k;
            const double *x = d->surface_rest + c * n;
            middles[c * t + k] = (x[corner[0]] + x[corner[1]] + x[corner[2]]) / 3;
        }
    if (whole && t) dm_order_along_curve(middles, t, keys);
    for (int64_t k = 0; whole && k < t; k++) {
        int64_t index = keys[k].number;
        dm_facet *f = b->facets + k;
        for (int p = 0; p < 3; p++) f->vertex[p] = (uint32_t)d->surface_corners[3 * index + p];
        f->index = index, f->material = d->surface_material[index];
    }
    dm_free(middles), dm_free(keys);
    if (!whole) return DM_MEMORY;
    b->facet_count = t, b->surface_count = n;
    b->own_surface = n == d->vertices && t == d->triangles && !memcmp(d->rest, d->surface_rest, (size_t)(3 * n) * sizeof(double));
    dm_shape_facets(b, d->surface_rest, n);
    return DM_OK;
}

/* Find the weights of the corners for the point of a facet that is nearest to p. Source: Ericson, Real-Time Collision
 * Detection, 5.1.5. */
static void dm_weights_at(const dm_facet *f, const double *p, double *w) {
    const double *a = f->corner[0], *b = f->corner[1], *c = f->corner[2];
    double ab[3], ac[3], ap[3], bp[3], cp[3], v, u;
    for (int k = 0; k < 3; k++) {
        ab[k] = b[k] - a[k], ac[k] = c[k] - a[k];
        ap[k] = p[k] - a[k], bp[k] = p[k] - b[k], cp[k] = p[k] - c[k];
    }
    double d1 = dm_inner3(ab, ap), d2 = dm_inner3(ac, ap), d3 = dm_inner3(ab, bp), d4 = dm_inner3(ac, bp);
    double d5 = dm_inner3(ab, cp), d6 = dm_inner3(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    double whole = va + vb + vc, beside = (d4 - d3) + (d5 - d6);
    if (d1 <= 0 && d2 <= 0) v = 0, u = 0;
    else if (d3 >= 0 && d4 <= d3) v = 1, u = 0;
    else if (d6 >= 0 && d5 <= d6) v = 0, u = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0) v = fabs(d1 - d3) > 1e-30 ? d1 / (d1 - d3) : 0, u = 0;
    else if (vb <= 0 && d2 >= 0 && d6 <= 0) v = 0, u = fabs(d2 - d6) > 1e-30 ? d2 / (d2 - d6) : 0;
    else if (va <= 0 && d4 >= d3 && d5 >= d6) u = fabs(beside) > 1e-30 ? (d4 - d3) / beside : 0, v = 1 - u;
    else v = fabs(whole) > 1e-30 ? vb / whole : vb, u = fabs(whole) > 1e-30 ? vc / whole : vc;
    w[0] = 1 - v - u, w[1] = v, w[2] = u;
}

/* Find the vector from the nearest point of a triangle to a point. */
static void dm_offset_from(const dm_facet *f, const double *point, double *offset) {
    double w[3];
    dm_weights_at(f, point, w);
    for (int k = 0; k < 3; k++)
        offset[k] = point[k] - w[0] * f->corner[0][k] - w[1] * f->corner[1][k] - w[2] * f->corner[2][k];
}

static double dm_gap_to_box(const double *box, const double *x) {
    double away = 0;
    for (int c = 0; c < 3; c++) {
        double gap = box[c] - x[c] > x[c] - box[3 + c] ? box[c] - x[c] : x[c] - box[3 + c];
        away += gap > 0 ? gap * gap : 0;
    }
    return sqrt(away);
}

/* Return the force of a law (K1, K2, x0, power) at a depth [m], as core/material.py does. */
static double dm_law_force(const double *law, double x) {
    double p = law[3], slope = p * p * law[0], straight = (1 + 1 / p) * law[2], beyond = x > law[2] ? x - law[2] : 0;
    if (p == 1) return law[0] * (x < law[2] ? x : law[2]) + law[1] * beyond;
    double more = (law[1] - slope) * beyond;
    if (x < straight) return p * law[0] * straight * pow(x / straight, p) + more;
    return law[0] * law[2] + slope * beyond + more;
}
