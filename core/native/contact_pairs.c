/* The results of a query: nearby pairs of a vertex and a face, or of two edges, and those of them that may touch before
 * the next query, in an order that does not depend on the layout in memory. */
#include "scene.h"

/* Return how much two edges stick out towards each other, 0 to 1. A sharp rigid edge presses skin that is flat or
 * folded round it, so beside a rigid edge the skin's own edge does not count. */
static double dm_weight_of_edges(const dm_scene_state *s, const dm_pair *pair, const double *w, const double *between,
                                 double gap) {
    double point[2][3], normal[2][3], weight = 1;
    for (int c = 0; c < 3; c++) {
        point[0][c] = w[0] * s->before[pair->at[0]][c] + w[1] * s->before[pair->at[1]][c];
        point[1][c] = -w[2] * s->before[pair->at[2]][c] - w[3] * s->before[pair->at[3]][c];
        normal[1][c] = gap > 0 ? between[c] / gap : 0, normal[0][c] = -normal[1][c];
    }
    for (uint32_t k = 0; k < 2; k++)
        if (!pair->rigid || pair->rigid >> k & 1)
            weight *= dm_sharpness(s, pair->parts[k], point[k], normal[k], pair->rigid != 0);
    return weight;
}

/* Set at which distance a pair touches, and how much of its impulse acts. */
static void dm_set_touch(dm_scene_state *s, dm_pair *p, const double *w, const double *between) {
    const dm_surface *f = s->both[0], *g = s->both[1];
    p->touch = dm_touch_of(f, g), p->weight = p->ones == 2 ? dm_weight_of_edges(s, p, w, between, p->gap) : 1;
    if (f != g) return;
    double weights[4], way[3];
    p->touch = fmin(p->touch, dm_measure_pair((const double(*)[3])s->rest, p->at, p->ones, weights, way) / 2);
}

/* List a pair of the two surfaces that are being searched, for now with its vertices' numbers in the scene.
 * w, between: of its nearest points, from dm_measure_pair. */
static void dm_note_pair(dm_scene_state *s, const dm_pair *pair, double gap, const double *w, const double *between,
                         int inside) {
    const uint32_t *at = pair->at;
    s->pairs = dm_grown(s, s->pairs, s->pair_count, &s->pair_room, sizeof *s->pairs);
    s->planes = dm_grown(s, s->planes, s->pair_count, &s->plane_room, sizeof *s->planes);
    s->next = dm_grown(s, s->next, s->pair_count, &s->next_room, sizeof *s->next);
    if (!dm_has_room(s)) return;
    dm_pair *made = s->pairs + s->pair_count;
    *made = *pair;
    for (uint32_t k = 0; k < 2; k++) {
        uint32_t vertex = at[k ? 3 : 0];
        const dm_surface *f = s->both[0], *g = s->both[1];
        const dm_surface *own = vertex - f->first < f->count ? f : g;
        made->rigid |= (uint32_t)!own->body << k;
    }
    s->next[s->pair_count] = dm_set_plane(s->planes + s->pair_count, made, (const double(*)[3])s->before, at, w, between,
                                          gap, dm_closest_of(s->both[0], s->both[1]));
    s->pair_count++;
    for (uint32_t k = 0; k < 4; k++) s->place[at[k]] = 0;
    made->gap = gap, made->weight = 0;
    if (inside) dm_set_touch(s, made, w, between);
}

/* List the vertices of the pairs, in the order in which they lie in memory, and count the pairs of each. */
static void dm_number_near(dm_scene_state *s) {
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        for (uint32_t i = f->first; i < f->first + f->count && dm_has_room(s); i++)
            if (s->place[i] != DM_NO_VERTEX) dm_note_near(s, f, i);
    for (uint32_t i = 0; i < s->pair_count && dm_has_room(s); i++)
        for (int k = 0; k < 4; k++) s->tally[s->pairs[i].at[k] = s->place[s->pairs[i].at[k]]].count++;
}

/* Return a candidate with the caller's vertex numbers, in ascending order on each side. */
static dm_ordered dm_ordered_of(const dm_scene_state *s, uint32_t pair) {
    const dm_pair *p = s->pairs + pair;
    dm_ordered made = {.pair = pair};
    uint32_t *number = made.number, start = p->ones == 1 ? 1 : 0, end = p->ones == 1 ? 4 : 2;
    for (int k = 0; k < 4; k++) number[k] = s->number[s->near[p->at[k]].vertex];
    for (; start < 4; start = end, end = 4)
        for (uint32_t i = start; i < end; i++)
            for (uint32_t j = i; j > start && number[j] < number[j - 1]; j--) {
                uint32_t other = number[j];
                number[j] = number[j - 1], number[j - 1] = other;
            }
    if (p->ones == 2 && s->near[p->at[0]].surface == s->near[p->at[3]].surface && number[2] < number[0]) {
        uint32_t edge[2] = {number[0], number[1]};
        memcpy(number, number + 2, sizeof edge), memcpy(number + 2, edge, sizeof edge);
    }
    return made;
}

DM_INLINE uint32_t dm_bin_of(const dm_scene_state *s, const dm_ordered *a) {
    return (s->pairs[a->pair].ones - 1) * (uint32_t)s->vertex_count + a->number[0];
}

static int dm_comes_before(const dm_ordered *a, const dm_ordered *b) {
    for (int k = 0; k < 4; k++)
        if (a->number[k] != b->number[k]) return a->number[k] < b->number[k];
    return 0;
}

/* List the pairs that may touch in an order that does not depend on the layout in memory: faces first, then edges, by
 * their first vertex (a bin for each), and the few of one vertex by the others. */
static void dm_order_candidates(dm_scene_state *s) {
    uint32_t count = 0, *bins = s->bins, many = (uint32_t)s->vertex_count;
    for (const dm_pair *p = s->pairs; p < s->pairs + s->pair_count; p++) count += p->weight > 0;
    memset(bins, 0, (size_t)(2 * many + 1) * sizeof *bins);
    s->candidates = dm_roomy(s, s->candidates, count, &s->candidate_room, sizeof *s->candidates);
    s->sorted = dm_roomy(s, s->sorted, 2 * count, &s->sorted_room, sizeof *s->sorted);
    if (!count || !dm_has_room(s)) return;
    dm_ordered *sorted = s->sorted, *plain = sorted + count, *end = plain;
    for (uint32_t k = 0; k < s->pair_count; k++)
        if (s->pairs[k].weight > 0) *end = dm_ordered_of(s, k), bins[dm_bin_of(s, end++) + 1]++;
    for (uint32_t k = 0; k < 2 * many; k++) bins[k + 1] += bins[k];
    for (uint32_t k = 0; k < count; k++) sorted[bins[dm_bin_of(s, plain + k)]++] = plain[k];
    for (uint32_t i = 0; i < count; i++) {
        dm_ordered own = sorted[i];
        uint32_t j = i, bin = dm_bin_of(s, &own);
        for (; j > 0 && dm_bin_of(s, sorted + j - 1) == bin && dm_comes_before(&own, sorted + j - 1); j--)
            sorted[j] = sorted[j - 1];
        sorted[j] = own;
    }
    for (uint32_t k = 0; k < count; k++) s->candidates[k] = sorted[k].pair;
    s->candidate_count = count;
}
