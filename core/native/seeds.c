/* Farthest-point sampling of seeds. Source: core/reduction/cells.py. Points are sorted into bins of a grid. A new
 * seed is nearer than the earlier ones only to points of a few bins; the boxes of the other bins exclude them. The
 * result is bit for bit that of a search over all points. */
#include "dimple.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double low[6], high[6]; /* bounds of the points in it */
    double most;            /* largest `near` of its points, and the first point with it */
    int64_t farthest;
    int64_t begin, end; /* in the list of points */
} dm_bin;

typedef struct {
    dm_bin *bins;
    int64_t count, *points; /* the points, bin by bin and in order within each */
    double *near;           /* square of the distance of each point from the nearest seed [m2] */
} dm_grid;

static void dm_find_farthest(dm_bin *bin, const int64_t *points, const double *near) {
    bin->farthest = points[bin->begin], bin->most = near[bin->farthest];
    for (int64_t k = bin->begin + 1; k < bin->end; k++)
        if (near[points[k]] > bin->most) bin->farthest = points[k], bin->most = near[points[k]];
}

static void dm_bound_bin(dm_bin *bin, const int64_t *points, const double *place) {
    memcpy(bin->low, place + 6 * points[bin->begin], sizeof bin->low);
    memcpy(bin->high, bin->low, sizeof bin->high);
    for (int64_t k = bin->begin + 1; k < bin->end; k++)
        for (int c = 0; c < 6; c++) {
            double x = place[6 * points[k] + c];
            bin->low[c] = x < bin->low[c] ? x : bin->low[c];
            bin->high[c] = x > bin->high[c] ? x : bin->high[c];
        }
}

/* Return the bin of a point among side^3. */
static int64_t dm_bin_of(const double *x, const double *low, double width, int64_t side) {
    int64_t at = 0;
    for (int c = 0; c < 3; c++) {
        double step = (x[c] - low[c]) / width;
        int64_t along = step > 0 ? (step < (double)side ? (int64_t)step : side - 1) : 0;
        at = at * side + along;
    }
    return at;
}

/* Sort points into bins by counting, without empty bins. Return 0 if memory runs out. */
static int dm_sort_points(dm_grid *g, int64_t n, const double *place) {
    double low[3], high[3], width = 0;
    memcpy(low, place, sizeof low), memcpy(high, place, sizeof high);
    for (int64_t k = 1; k < n; k++)
        for (int c = 0; c < 3; c++) {
            double x = place[6 * k + c];
            low[c] = x < low[c] ? x : low[c], high[c] = x > high[c] ? x : high[c];
        }
    int64_t side = 1 + (int64_t)cbrt((double)n / DM_LANES);
    for (int c = 0; c < 3; c++) width = fmax(width, (high[c] - low[c]) / (double)side);
    int64_t all = side * side * side, *start = calloc((size_t)all + 2, sizeof *start);
    g->points = malloc((size_t)n * sizeof *g->points), g->bins = malloc((size_t)all * sizeof *g->bins);
    g->near = malloc((size_t)n * sizeof *g->near);
    if (!start || !g->points || !g->bins || !g->near) return free(start), 0;
    for (int64_t k = 0; k < n; k++) g->near[k] = INFINITY;
    width = fmax(width, 1e-30);
    for (int64_t k = 0; k < n; k++) start[dm_bin_of(place + 6 * k, low, width, side) + 2]++;
    for (int64_t k = 2; k < all + 2; k++) start[k] += start[k - 1];
    for (int64_t k = 0; k < n; k++) g->points[start[dm_bin_of(place + 6 * k, low, width, side) + 1]++] = k;
    for (int64_t k = 0; k < all; k++) {
        if (start[k] == start[k + 1]) continue;
        dm_bin *bin = g->bins + g->count++;
        bin->begin = start[k], bin->end = start[k + 1];
        dm_bound_bin(bin, g->points, place);
        dm_find_farthest(bin, g->points, g->near);
    }
    free(start);
    return 1;
}

static double dm_apart(const double *a, const double *b) {
    double sum = 0;
    for (int c = 0; c < 6; c++) sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sum;
}

static int dm_may_reach(const dm_bin *bin, const double *from) {
    double sum = 0;
    for (int c = 0; c < 6; c++) {
        double gap = fmax(fmax(bin->low[c] - from[c], from[c] - bin->high[c]), 0);
        sum += gap * gap;
    }
    return !(sum * (1 - 1e-9) > bin->most); /* rounding must not exclude a point */
}

static void dm_take_seed(dm_grid *g, const double *place, const double *from) {
    for (dm_bin *bin = g->bins; bin < g->bins + g->count; bin++) {
        if (!dm_may_reach(bin, from)) continue;
        for (int64_t k = bin->begin; k < bin->end; k++) {
            int64_t i = g->points[k];
            double d = dm_apart(place + 6 * i, from), *near = g->near + i;
            *near = d < *near ? d : *near;
        }
        dm_find_farthest(bin, g->points, g->near);
    }
}

int64_t dm_farthest_first(int64_t points, const double *place, int64_t taken, double least, int64_t most,
                          int64_t *chosen) {
    if (points < 1 || points > DM_MAX_VERTICES || taken < 0 || taken > points || !place || !chosen) return 0;
    dm_grid g = {0};
    int64_t count = 0;
    int sorted = dm_sort_points(&g, points, place);
    for (int64_t k = 0; sorted && k < taken; k++) dm_take_seed(&g, place, place + 6 * k);
    while (sorted && count < most) {
        const dm_bin *best = g.bins;
        for (const dm_bin *bin = best + 1; bin < g.bins + g.count; bin++)
            if (bin->most > best->most || (bin->most == best->most && bin->farthest < best->farthest)) best = bin;
        if (!(best->most > least)) break;
        chosen[count++] = best->farthest;
        dm_take_seed(&g, place, place + 6 * best->farthest);
    }
    free(g.bins), free(g.points), free(g.near);
    return count;
}
