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

/* List a pair as a candidate if it may touch before the next query. */
static void dm_note_candidate(dm_scene_state *s, const dm_pair *pair, double gap, const double *w,
                              const double *between) {
    const dm_surface *f = s->both[0], *g = s->both[1];
    dm_candidate made = {s->pair_count - 1, gap, dm_touch_of(f, g), 1};
    if (pair->ones == 2) made.weight = dm_weight_of_edges(s, pair, w, between, gap);
    if (f == g) {
        double weights[4], way[3];
        double far = dm_measure_pair((const double(*)[3])s->rest, pair->at, pair->ones, weights, way) / 2;
        made.touch = far < made.touch ? far : made.touch;
    }
    if (!(made.weight > 0)) return;
    s->candidates = dm_grown(s, s->candidates, s->candidate_count, &s->candidate_room, sizeof *s->candidates);
    if (dm_has_room(s)) s->candidates[s->candidate_count++] = made;
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
    s->gap = gap < s->gap ? gap : s->gap;
    if (inside) dm_note_candidate(s, made, gap, w, between);
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
static dm_ordered dm_ordered_of(const dm_scene_state *s, const dm_candidate *candidate) {
    const dm_pair *p = s->pairs + candidate->pair;
    dm_ordered made = {.ones = p->ones, .own = *candidate};
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

DM_INLINE uint32_t dm_bin_of(const dm_ordered *a, uint32_t vertices) {
    return (a->ones - 1) * vertices + a->number[0];
}

static int dm_comes_before(const dm_ordered *a, const dm_ordered *b) {
    if (a->ones != b->ones) return a->ones < b->ones;
    for (int k = 0; k < 4; k++)
        if (a->number[k] != b->number[k]) return a->number[k] < b->number[k];
    return 0;
}

/* Sort the candidates in an order that does not depend on the layout in memory: faces first, then edges, by their first
 * vertex (a bin for each), and the few of one vertex by the others. */
static void dm_order_candidates(dm_scene_state *s) {
    uint32_t count = s->candidate_count, *bins = s->bins, many = (uint32_t)s->vertex_count;
    memset(bins, 0, (size_t)(2 * many + 1) * sizeof *bins);
    if (s->sorted_room < 2 * count) {
        dm_free(s->sorted);
        s->sorted = dm_alloc(4 * count, sizeof *s->sorted), s->sorted_room = s->sorted ? 4 * count : 0;
        if (!s->sorted) s->code = DM_MEMORY;
    }
    if (!count || !dm_has_room(s)) return;
    dm_ordered *sorted = s->sorted, *plain = sorted + count;
    for (uint32_t k = 0; k < count; k++)
        plain[k] = dm_ordered_of(s, s->candidates + k), bins[dm_bin_of(plain + k, many) + 1]++;
    for (uint32_t k = 0; k < 2 * many; k++) bins[k + 1] += bins[k];
    for (uint32_t k = 0; k < count; k++) sorted[bins[dm_bin_of(plain + k, many)]++] = plain[k];
    for (uint32_t i = 0; i < count; i++) {
        dm_ordered own = sorted[i];
        uint32_t j = i;
        for (; j > 0 && dm_comes_before(&own, sorted + j - 1); j--)
            sorted[j] = sorted[j - 1];
        sorted[j] = own;
    }
    for (uint32_t k = 0; k < count; k++) s->candidates[k] = sorted[k].own;
}
