/* The cells of seeds on a fine surface, and the seeds that each vertex follows. Source: core/reduction/cells.py and
 * binding.py. Compiled without fused multiply-add, for the same bits as numpy: a bake depends on which seed is
 * nearest. */
#include "dimple.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double dm_apart(const double *a, const double *b) {
    double sum = 0;
    for (int c = 0; c < 6; c++) sum += (a[c] - b[c]) * (a[c] - b[c]);
    return sum;
}

static int32_t dm_check_cells(const dm_cells *s) {
    if (!s || s->vertices < 1 || s->vertices > DM_MAX_VERTICES || s->seeds < 1 || s->seeds > UINT16_MAX + 1)
        return DM_SIZE;
    if (s->edges < 0 || s->edges > 8 * (int64_t)DM_MAX_VERTICES || (s->edges && !s->ends) || !s->place || !s->seed)
        return DM_SIZE;
    for (int64_t k = 0; k < s->seeds; k++)
        if (s->seed[k] < 0 || s->seed[k] >= s->vertices) return DM_INDEX;
    for (int64_t k = 0; k < 2 * s->edges; k++)
        if (s->ends[k] < 0 || s->ends[k] >= s->vertices) return DM_INDEX;
    return DM_OK;
}

/* The state of growing cells. */
typedef struct {
    int64_t *first, *beside; /* (vertices + 1,), (2 edges,) neighbours of each vertex, vertex by vertex */
    int64_t *offered;        /* (vertices,) the best seed offered in this round, -1 for none */
    int64_t *front, *next;   /* (vertices,) vertices that changed in the last round, and in this one */
    double *away;            /* (vertices,) square of the distance from the seed [m2] */
} dm_growth;

static void dm_free_growth(dm_growth *g) {
    free(g->first), free(g->beside), free(g->offered), free(g->front), free(g->next), free(g->away);
}

static int32_t dm_start_growth(dm_growth *g, const dm_cells *s) {
    size_t n = (size_t)s->vertices;
    g->first = calloc(n + 2, sizeof *g->first), g->beside = malloc(((size_t)s->edges * 2 + 1) * sizeof *g->beside);
    g->offered = malloc(n * sizeof *g->offered), g->away = malloc(n * sizeof *g->away);
    g->front = malloc(n * sizeof *g->front), g->next = malloc(n * sizeof *g->next);
    if (!g->first || !g->beside || !g->offered || !g->away || !g->front || !g->next) return DM_MEMORY;
    /* counts are stored two places ahead, so that first[i] is the start of vertex i once all are filled */
    for (int64_t k = 0; k < 2 * s->edges; k++) g->first[s->ends[k] + 2]++;
    for (size_t i = 2; i < n + 2; i++) g->first[i] += g->first[i - 1];
    for (int64_t k = 0; k < 2 * s->edges; k++) g->beside[g->first[s->ends[k] + 1]++] = s->ends[k ^ 1];
    return DM_OK;
}

/* Offer the cells of the vertices that changed to their neighbours; return how many take one. */
static int64_t dm_offer_cells(const dm_growth *g, const dm_cells *s, const int64_t *cells, int64_t waiting) {
    int64_t found = 0;
    for (int64_t at = 0; at < waiting; at++) {
        int64_t i = g->front[at], cell = cells[i];
        for (int64_t k = g->first[i]; k < g->first[i + 1]; k++) {
            int64_t end = g->beside[k];
            if (cells[end] == cell || g->offered[end] == cell) continue;
            double d = dm_apart(s->place + 6 * end, s->place + 6 * s->seed[cell]);
            if (!(d < g->away[end] || (d == g->away[end] && g->offered[end] > cell))) continue;
            if (g->offered[end] < 0) g->next[found++] = end;
            g->offered[end] = cell, g->away[end] = d;
        }
    }
    return found;
}

/* Grow each cell from its seed. */
static void dm_join_cells(const dm_growth *g, const dm_cells *s, const int64_t *cells, uint8_t *joined) {
    int64_t count = 0;
    memset(joined, 0, (size_t)s->vertices);
    for (int64_t k = 0; k < s->seeds; k++) {
        if (!joined[s->seed[k]]) g->front[count++] = s->seed[k];
        joined[s->seed[k]] = 1;
    }
    for (int64_t at = 0; at < count; at++)
        for (int64_t k = g->first[g->front[at]]; k < g->first[g->front[at] + 1]; k++) {
            int64_t end = g->beside[k];
            if (joined[end] || cells[end] != cells[g->front[at]]) continue;
            joined[end] = 1, g->front[count++] = end;
        }
}

int32_t dm_grow_cells(const dm_cells *s, int64_t *cells, uint8_t *joined) {
    int32_t code = dm_check_cells(s);
    if (code != DM_OK || !cells || !joined) return code != DM_OK ? code : DM_SIZE;
    dm_growth g = {0};
    if ((code = dm_start_growth(&g, s)) != DM_OK) return dm_free_growth(&g), code;
    int64_t waiting = 0;
    for (int64_t i = 0; i < s->vertices; i++) cells[i] = g.offered[i] = -1, g.away[i] = INFINITY;
    for (int64_t k = 0; k < s->seeds; k++) {
        if (cells[s->seed[k]] < 0) g.front[waiting++] = s->seed[k];
        cells[s->seed[k]] = k, g.away[s->seed[k]] = 0;
    }
    while ((waiting = dm_offer_cells(&g, s, cells, waiting)) != 0) {
        for (int64_t k = 0; k < waiting; k++) cells[g.next[k]] = g.offered[g.next[k]], g.offered[g.next[k]] = -1;
        int64_t *before = g.front;
        g.front = g.next, g.next = before;
    }
    dm_join_cells(&g, s, cells, joined);
    dm_free_growth(&g);
    return DM_OK;
}

/* Find the nearest of the seeds near a cell and one more, in order of distance; return their number. */
static int64_t dm_nearest_seeds(const dm_cells *s, const double *place, int64_t width, const int64_t *ring,
                                int64_t *near, double *away) {
    int64_t count = 0;
    for (int64_t k = 0; k < width && ring[k] >= 0; k++) {
        double d = dm_apart(place, s->place + 6 * s->seed[ring[k]]);
        if (count > DM_FOLLOWED && !(d < away[DM_FOLLOWED])) continue;
        int64_t at = count > DM_FOLLOWED ? DM_FOLLOWED : count++;
        for (; at && d < away[at - 1]; at--) away[at] = away[at - 1], near[at] = near[at - 1];
        away[at] = d, near[at] = ring[k];
    }
    return count;
}

/* Insert a vertex and its weight into the ordered list of its group of eight; return the new length. */
static int64_t dm_list(int64_t count, uint16_t *followed, uint16_t (*weights)[8], uint16_t seed, int64_t lane,
                       uint16_t weight) {
    int64_t at = count;
    while (at && followed[at - 1] > seed) at--;
    if (!at || followed[at - 1] != seed) {
        memmove(followed + at + 1, followed + at, (size_t)(count - at) * sizeof *followed);
        memmove(weights + at + 1, weights + at, (size_t)(count - at) * sizeof *weights);
        followed[at] = seed, count++;
        memset(weights + at++, 0, sizeof *weights);
    }
    weights[at - 1][lane] = (uint16_t)(weights[at - 1][lane] + weight);
    return count;
}

int32_t dm_follow_cells(const dm_cells *s, const int64_t *cells, int64_t width, const int64_t *around, int64_t *first,
                        uint16_t *followed, uint16_t *weights) {
    int32_t code = dm_check_cells(s);
    if (code != DM_OK) return code;
    if (!cells || !around || !first || !followed || !weights || width < 1 || width > UINT16_MAX) return DM_SIZE;
    for (int64_t i = 0; i < s->vertices; i++)
        if (cells[i] < 0 || cells[i] >= s->seeds) return DM_INDEX;
    for (int64_t k = 0; k < width * s->seeds; k++)
        if (around[k] < -1 || around[k] >= s->seeds) return DM_INDEX;
    first[0] = 0;
    for (int64_t i = 0; i < s->vertices; i++) {
        double away[DM_FOLLOWED + 1], share[DM_FOLLOWED], total = 0;
        int64_t near[DM_FOLLOWED + 1], begin = first[i / 8], length = i % 8 ? first[i / 8 + 1] - begin : 0;
        int64_t count = dm_nearest_seeds(s, s->place + 6 * i, width, around + width * cells[i], near, away);
        double bound = count ? away[count - 1] * (1 + 1e-9) : 0;
        for (int64_t k = 0; k < DM_FOLLOWED; k++) {
            double part = k < count ? 1 - away[k] / (bound > 1e-30 ? bound : 1e-30) : 0;
            share[k] = (part > 0 ? part * part : 0) + (k == 0 ? 1e-30 : 0);
            total += share[k];
        }
        uint16_t parts[DM_FOLLOWED], left = UINT16_MAX;
        for (int64_t k = 0; k < DM_FOLLOWED; k++) {
            parts[k] = (uint16_t)(share[k] / total * UINT16_MAX);
            left = (uint16_t)(left - parts[k]);
        }
        parts[0] = (uint16_t)(parts[0] + left); /* the sum is exact */
        for (int64_t k = 0; k < DM_FOLLOWED && k < count; k++)
            length = dm_list(length, followed + begin, (uint16_t(*)[8])weights + begin, (uint16_t)near[k], i % 8,
                             parts[k]);
        first[i / 8 + 1] = begin + length;
    }
    return DM_OK;
}
