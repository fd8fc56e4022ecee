/* What a query finds near: pairs of a vertex and a face, or of two edges, and which of them may touch before the next one,
 * in an order that does not depend on where anything lies in memory. */
#include "scene.h"

/* How much two edges stick out towards each other. */
static double dm_weight_of_edges(const dm_scene_state *s, const dm_close *close, int rigid) {
    const double *x[4];
    double w[4], between[3], point[3], other[3], back[3];
    for (int j = 0; j < 4; j++) x[j] = s->before[close->at[j]];
    double gap = dm_measure_pair(x, 2, w, between);
    for (int c = 0; c < 3; c++) {
        point[c] = w[0] * x[0][c] + w[1] * x[1][c], other[c] = -w[2] * x[2][c] - w[3] * x[3][c];
        between[c] = gap > 0 ? between[c] / gap : 0, back[c] = -between[c];
    }
    double one = dm_sharpness(s, close->parts[0], point, back, rigid);
    return one > 0 ? one * dm_sharpness(s, close->parts[1], other, between, rigid) : 0;
}

/* Note a pair as a candidate where it may touch before the next query. */
static void dm_note_candidate(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t pair, double gap) {
    const dm_pair *p = s->pairs + pair;
    const dm_close *close = s->close[p->ones - 1] + p->close;
    dm_candidate made = {pair, gap, dm_touch_of(f, g), p->ones == 1 ? 1 : dm_weight_of_edges(s, close, !f->body && !g->body)};
    if (f == g) {
        const double *rest[4];
        double w[4], between[3];
        for (int j = 0; j < 4; j++) rest[j] = s->rest[close->at[j]];
        double far = dm_measure_pair(rest, p->ones, w, between) / 2;
        made.touch = far < made.touch ? far : made.touch;
    }
    if (!(made.weight > 0) || gap > made.touch + DM_STALE * (s->reach - s->touch) * 1.5) return;
    s->candidates = dm_grown(s, s->candidates, s->candidate_count, &s->candidate_room, sizeof *s->candidates);
    if (dm_has_room(s)) s->candidates[s->candidate_count++] = made;
}

/* Note a pair that is near, for now with its vertices as they are numbered in the scene, and set its plane in the middle
 * between the two. w, between: of their nearest points, as dm_measure_pair finds them. */
static void dm_note_pair(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t ones, uint32_t close,
                         double gap, const double *w, const double *between) {
    const uint32_t *at = s->close[ones - 1][close].at;
    s->pairs = dm_grown(s, s->pairs, s->pair_count, &s->pair_room, sizeof *s->pairs);
    s->planes = dm_grown(s, s->planes, s->pair_count, &s->plane_room, sizeof *s->planes);
    if (!dm_has_room(s)) return;
    const double *x[4] = {s->before[at[0]], s->before[at[1]], s->before[at[2]], s->before[at[3]]};
    dm_plane *plane = s->planes + s->pair_count;
    dm_set_plane(plane, ones, x, w, between, gap, dm_closest_of(f, g), 0.5);
    plane->way = gap / 2 - plane->keep[0], plane->renewed = 0;
    plane->ones = (uint16_t)ones, plane->stiff = !(f->body && g->body);
    s->pairs[s->pair_count++] = (dm_pair){{at[0], at[1], at[2], at[3]}, close, ones};
    for (uint32_t k = 0; k < 4; k++) s->place[at[k]] = 0;
}

/* Note the faces, or the edges, of a run that are near, and add up the normals between them, towards f. */
static void dm_note_run(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t ones, uint32_t from,
                        uint32_t end, double *normal) {
    const dm_close *close = s->close[ones - 1];
    for (uint32_t k = from; k < end && dm_has_room(s); k += DM_LANES) {
        uint32_t many = end - k < DM_LANES ? end - k : DM_LANES;
        dm_wide_mask inside;
        dm_wide w[4];
        dm_wide3 way = dm_wide_between((const double(*)[3])s->before, close + k, many, ones, w, &inside);
        dm_wide gap = dm_wide_root(dm_wide_dot(way, way));
        for (uint32_t l = 0; l < many && dm_has_room(s); l++) {
            if (!(gap[l] < s->reach)) continue;
            double by = gap[l] > 0 && f != g ? (close[k + l].at[0] < g->first ? 1 : -1) / gap[l] : 0;
            normal[0] += by * way.x[l], normal[1] += by * way.y[l], normal[2] += by * way.z[l];
            s->gap = gap[l] < s->gap ? gap[l] : s->gap;
            dm_note_pair(s, f, g, ones, k + l, gap[l], (double[]){w[0][l], w[1][l], w[2][l], w[3][l]},
                         (double[]){way.x[l], way.y[l], way.z[l]});
            if (inside[l] && dm_has_room(s)) dm_note_candidate(s, f, g, s->pair_count - 1, gap[l]);
        }
    }
}

/* List the vertices of the pairs that are near, in the order in which they lie in memory, and what each pair asks of them. */
static void dm_number_near(dm_scene_state *s) {
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        for (uint32_t i = f->first; i < f->first + f->count && dm_has_room(s); i++)
            if (s->place[i] != DM_NO_VERTEX) dm_note_near(s, f, i);
    for (uint32_t i = 0; i < s->pair_count && dm_has_room(s); i++)
        for (int k = 0; k < 4; k++) {
            double way = s->planes[i].way;
            dm_tally *t = s->tally + (s->pairs[i].at[k] = s->place[s->pairs[i].at[k]]);
            t->count++, t->way = way < t->way ? way : t->way;
        }
}

/* A candidate with its vertices in the order of the caller, each side from the lowest. */
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

/* Put the candidates into an order that does not depend on where anything lies in memory: faces first, then edges, by
 * their first vertex, and the few of one vertex by the others. */
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
