/* The query: where everything is, who is near whom, and how far each may go until the next one. */
#include "scene.h"

static void dm_note_rest(dm_scene_state *s, const dm_surface *f) {
    const dm_state *b = f->body;
    for (int64_t k = 0; k < b->n; k++)
        for (int c = 0; c < 3; c++) s->rest[f->first + b->place[k]][c] = b->rest[c * b->n + k];
}

/* Note where the vertices of a surface are. */
static void dm_note_surface(dm_scene_state *s, dm_surface *f) {
    for (int c = 0; c < 3; c++) f->low[c] = INFINITY, f->high[c] = -INFINITY;
    for (uint32_t i = f->first; i < f->first + f->count; i++) {
        dm_world_of(s, f, i, s->before[i]);
        if (f->body && i - f->first >= f->body->n) continue; /* an empty lane */
        for (int c = 0; c < 3; c++) {
            double x = s->before[i][c];
            f->low[c] = x < f->low[c] ? x : f->low[c], f->high[c] = x > f->high[c] ? x : f->high[c];
        }
    }
    f->slack = f->stale = INFINITY;
    if (!f->body) return;
    if (f->self && f->body->moving) dm_note_rest(s, f);
    if (f->changes != f->body->changes) memset(f->resisting, 0, sizeof f->resisting);
    f->changes = f->body->changes;
    memcpy(f->origin, f->body->origin, sizeof f->origin);
    for (int64_t g = 0; g < f->body->groups; g++) f->before[g] = f->body->state[g].x;
}

/* The greatest speed of anything as a tick begins. */
static double dm_fastest_of(const dm_scene_state *s) {
    double speed = 0;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        double fastest = f->body ? dm_greatest_speed(f->body) : 0;
        for (uint32_t i = f->first; !f->body && f->moving && i < f->first + f->count; i++) {
            double way[3];
            dm_minus(s->aim[i], s->here[i], way);
            double v = sqrt(dm_inner3(way, way)) / s->tick;
            fastest = v > fastest ? v : fastest;
        }
        speed = fastest > speed ? fastest : speed;
    }
    return speed;
}

/* How far a query looks: so far that it lasts some ticks at the speeds there are. */
static double dm_reach_of(const dm_scene_state *s) {
    double least = DM_LEAST_REACH * s->touch, most = DM_REACH_EDGE * s->edge;
    double wanted = s->touch + 2 * DM_REACH_TIME * s->fastest * s->tick;
    most = most > least ? most : least;
    return wanted < least ? least : wanted < most ? wanted : most;
}

/* As a tick begins: how much farther than they touch things are looked at, for they come nearer before the next look. */
static void dm_set_approach(dm_scene_state *s) {
    s->fastest = dm_fastest_of(s);
    double least = s->touch + 3 * s->fastest * s->dt;
    if (least <= s->approach && s->approach <= 4 * least) return;
    s->approach = s->touch + 6 * s->fastest * s->dt, s->looks = 1;
}

static void dm_bring_near(dm_surface *f, double slack, double stale) {
    f->slack = slack < f->slack ? slack : f->slack, f->stale = stale < f->stale ? stale : f->stale;
}

/* Between two surfaces stands a slab, square to the mean normal of their pairs: what is farther than the reach from the
 * other's side of it, and its neighbours with it, may go farther. Where one is all round the other there is none.
 * normal: sum of theirs towards f, 0 where f is g. */
static void dm_free_behind(dm_scene_state *s, const dm_surface *f, const dm_surface *g, double *normal) {
    const dm_surface *both[2] = {f, g};
    double edge[2] = {INFINITY, -INFINITY};
    double size = sqrt(dm_inner3(normal, normal));
    for (int c = 0; c < 3 && size > 0; c++) normal[c] /= size;
    for (int k = 0; k < 2; k++)
        for (uint32_t i = both[k]->first; i < both[k]->first + both[k]->count; i++) {
            if (both[k]->body && i - both[k]->first >= both[k]->body->n) continue; /* an empty lane */
            double along = dm_inner3(normal, s->before[i]);
            edge[k] = (k ? along > edge[k] : along < edge[k]) ? along : edge[k];
        }
    double *away = s->roam; /* set later */
    for (int k = 0; k < 2; k++)
        for (uint32_t i = both[k]->first; i < both[k]->first + both[k]->count; i++) {
            double along = dm_inner3(normal, s->before[i]);
            away[i] = k ? edge[0] - along : along - edge[1];
        }
    for (int k = 0; k < 2; k++)
        for (uint32_t i = both[k]->first; i < both[k]->first + both[k]->count; i++) {
            double free_way = away[i];
            for (uint32_t j = s->ring_start[i]; j < s->ring_start[i + 1]; j++)
                free_way = away[s->ring[j]] < free_way ? away[s->ring[j]] : free_way;
            free_way = free_way > s->reach ? free_way : s->reach;
            double slack = DM_ROAM * free_way / 2, stale = DM_STALE * (free_way - s->touch) / 2;
            s->slack[i] = slack < s->slack[i] ? slack : s->slack[i];
            s->stale[i] = stale < s->stale[i] ? stale : s->stale[i];
        }
}

DM_INLINE int dm_may_touch(const dm_surface *f, const dm_surface *g) { return f == g ? f->self : f->body || g->body; }

/* Find all that is close, so widely that some queries can live of it. */
static void dm_search(dm_scene_state *s) {
    s->wide = DM_WIDE * s->reach, s->close_count[0] = s->close_count[1] = s->run_count = 0;
    s->waiting_count[0] = s->waiting_count[1] = 0;
    memcpy(s->searched, s->before, (size_t)s->vertex_count * sizeof *s->searched);
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) dm_fit_boxes(s, f);
    for (uint32_t i = 0; i < s->surface_count; i++)
        for (uint32_t j = i; j < s->surface_count && dm_has_room(s); j++) {
            const dm_surface *f = s->surfaces + i, *g = s->surfaces + j;
            if (!dm_may_touch(f, g) || (f != g && dm_boxes_apart(f->low, f->high, g->low, g->high) > s->wide)) continue;
            dm_visit_pairs(s, f, g, s->wide, dm_keep_triangles);
            dm_keep_waiting(s, 1), dm_keep_waiting(s, 2);
            s->runs = dm_grown(s, s->runs, s->run_count, &s->run_room, sizeof *s->runs);
            if (dm_has_room(s)) s->runs[s->run_count++] = (dm_run){i, j, {s->close_count[0], s->close_count[1]}};
        }
}

/* May anything that is near now not have been close at the search? Two have come nearer by no more than both their ways
 * from any one place: here the middle of all ways, so that what goes together outdates nothing. */
static int dm_is_outdated(const dm_scene_state *s) {
    double left = (s->wide - s->reach) / 2, low[3] = {INFINITY, INFINITY, INFINITY}, high[3];
    for (int c = 0; c < 3; c++) high[c] = -INFINITY;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        for (uint32_t i = f->first; i < f->first + (f->body ? (uint32_t)f->body->n : f->count); i++)
            for (int c = 0; c < 3; c++) {
                double way = s->before[i][c] - s->searched[i][c];
                low[c] = way < low[c] ? way : low[c], high[c] = way > high[c] ? way : high[c];
            }
    double square = 0;
    for (int c = 0; c < 3; c++) square += (high[c] - low[c]) * (high[c] - low[c]) / 4;
    return !(left > 0 && square < left * left);
}

/* How much two edges stick out towards each other. */
static double dm_weight_of_edges(const dm_scene_state *s, const dm_close *close) {
    const double *x[4];
    double w[4], between[3], point[3], other[3], back[3];
    for (int j = 0; j < 4; j++) x[j] = s->before[close->at[j]];
    double gap = dm_measure_pair(x, 2, w, between);
    for (int c = 0; c < 3; c++) {
        point[c] = w[0] * x[0][c] + w[1] * x[1][c], other[c] = -w[2] * x[2][c] - w[3] * x[3][c];
        between[c] = gap > 0 ? between[c] / gap : 0, back[c] = -between[c];
    }
    double one = dm_sharpness(s, close->parts[0], point, back);
    return one > 0 ? one * dm_sharpness(s, close->parts[1], other, between) : 0;
}

/* Note a pair as a candidate where it may touch before the next query. */
static void dm_note_candidate(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t pair, double gap) {
    const dm_pair *p = s->pairs + pair;
    const dm_close *close = s->close[p->ones - 1] + p->close;
    dm_candidate made = {pair, gap, f->offset + g->offset, p->ones == 1 ? 1 : dm_weight_of_edges(s, close)};
    if (f == g) {
        const double *rest[4];
        double w[4], between[3];
        for (int j = 0; j < 4; j++) rest[j] = s->rest[close->at[j]];
        double far = DM_SELF_SHARE * dm_measure_pair(rest, p->ones, w, between);
        made.touch = far < made.touch ? far : made.touch;
    }
    if (!(made.weight > 0) || gap > made.touch + DM_STALE * (s->reach - s->touch) * 1.5) return;
    s->candidates = dm_grown(s, s->candidates, s->candidate_count, &s->candidate_room, sizeof *s->candidates);
    if (dm_has_room(s)) s->candidates[s->candidate_count++] = made;
}

/* Note a pair that is near. */
static void dm_note_pair(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t ones, uint32_t close,
                         double gap) {
    const uint32_t *at = s->close[ones - 1][close].at;
    dm_pair p = {.close = close, .ones = ones};
    p.way = gap / 2 - dm_keep_of(gap / 2, gap, dm_closest_of(f, g));
    s->pairs = dm_grown(s, s->pairs, s->pair_count, &s->pair_room, sizeof *s->pairs);
    for (uint32_t k = 0; k < 4 && dm_has_room(s); k++) {
        p.at[k] = dm_note_near(s, at[k] - f->first < f->count ? f : g, at[k]);
        if (!dm_has_room(s)) return;
        dm_tally *t = s->tally + p.at[k];
        t->count++, t->way = p.way < t->way ? p.way : t->way;
    }
    if (dm_has_room(s)) s->pairs[s->pair_count++] = p;
}

/* Note the faces, or the edges, of a run that are near, and add up the normals between them, towards f. */
static void dm_note_run(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t ones, uint32_t from,
                        uint32_t end, double *normal) {
    const dm_close *close = s->close[ones - 1];
    for (uint32_t k = from; k < end && dm_has_room(s); k += DM_LANES) {
        uint32_t many = end - k < DM_LANES ? end - k : DM_LANES;
        dm_wide_mask inside;
        dm_wide3 way = dm_wide_between((const double(*)[3])s->before, close + k, many, ones, &inside);
        dm_wide gap = dm_wide_root(dm_wide_dot(way, way));
        for (uint32_t l = 0; l < many && dm_has_room(s); l++) {
            if (!(gap[l] < s->reach)) continue;
            double by = gap[l] > 0 && f != g ? (close[k + l].at[0] < g->first ? 1 : -1) / gap[l] : 0;
            normal[0] += by * way.x[l], normal[1] += by * way.y[l], normal[2] += by * way.z[l];
            s->gap = gap[l] < s->gap ? gap[l] : s->gap;
            dm_note_pair(s, f, g, ones, k + l, gap[l]);
            if (inside[l] && dm_has_room(s)) dm_note_candidate(s, f, g, s->pair_count - 1, gap[l]);
        }
    }
}

/* Note which of two surfaces are near each other, or how far they are apart. run: where theirs may be. */
static void dm_query_pair(dm_scene_state *s, uint32_t i, uint32_t j, uint32_t *run) {
    dm_surface *f = s->surfaces + i, *g = s->surfaces + j;
    if (!dm_may_touch(f, g)) return;
    const dm_run *r = s->runs + *run;
    int close = *run < s->run_count && r->first == i && r->second == j, first = *run == 0;
    *run += (uint32_t)close;
    double apart = f == g ? -1 : dm_boxes_apart(f->low, f->high, g->low, g->high), normal[3] = {0};
    if (apart > s->reach) {
        double way = apart / 2;
        dm_bring_near(f, DM_ROAM * way, way / 2), dm_bring_near(g, DM_ROAM * way, way / 2);
        return;
    }
    for (uint32_t k = 0; close && k < 2; k++)
        dm_note_run(s, f, g, k + 1, first ? 0 : r[-1].end[k], r->end[k], normal);
    if (dm_has_room(s)) dm_free_behind(s, f, g, normal);
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

static int dm_comes_before(const dm_ordered *a, const dm_ordered *b) {
    if (a->ones != b->ones) return a->ones < b->ones;
    for (int k = 1; k < 4; k++)
        if (a->number[k] != b->number[k]) return a->number[k] < b->number[k];
    return 0;
}

/* Put the candidates into an order that does not depend on where anything lies in memory: by their first vertex, and
 * the few of one vertex by the others. */
static void dm_order_candidates(dm_scene_state *s) {
    uint32_t count = s->candidate_count, *bins = s->bins;
    memset(bins, 0, (size_t)(s->vertex_count + 1) * sizeof *bins);
    if (s->sorted_room < 2 * count) {
        dm_free(s->sorted);
        s->sorted = dm_alloc(4 * count, sizeof *s->sorted), s->sorted_room = s->sorted ? 4 * count : 0;
        if (!s->sorted) s->code = DM_MEMORY;
    }
    if (!count || !dm_has_room(s)) return;
    dm_ordered *sorted = s->sorted, *plain = sorted + count;
    for (uint32_t k = 0; k < count; k++)
        plain[k] = dm_ordered_of(s, s->candidates + k), bins[plain[k].number[0] + 1]++;
    for (int64_t k = 0; k < s->vertex_count; k++) bins[k + 1] += bins[k];
    for (uint32_t k = 0; k < count; k++) sorted[bins[plain[k].number[0]]++] = plain[k];
    for (uint32_t i = 0; i < count; i++) {
        dm_ordered own = sorted[i];
        uint32_t j = i;
        for (; j > 0 && sorted[j - 1].number[0] == own.number[0] && dm_comes_before(&own, sorted + j - 1); j--)
            sorted[j] = sorted[j - 1];
        sorted[j] = own;
    }
    for (uint32_t k = 0; k < count; k++) s->candidates[k] = sorted[k].own;
}

static void dm_set_bounds(dm_scene_state *s, const dm_surface *f) {
    for (int64_t g = 0; f->body && g < f->body->groups; g++)
        for (int l = 0; l < DM_LANES; l++) {
            uint32_t i = f->first + (uint32_t)(g * DM_LANES + l);
            double way = s->roam[i] * DM_ALERT, due = s->stale[i];
            f->bound[g][l] = (dm_real)(way < 1e18 ? way * way : 1e36);
            f->due[g][l] = (dm_real)(due < 1e18 ? due * due : 1e36);
        }
}

static void dm_query(dm_scene_state *s) {
    dm_sum_meetings(s), s->batch_count = 0;
    for (const dm_neighbour *n = s->near; n < s->near + s->near_count; n++) s->place[n->vertex] = DM_NO_VERTEX;
    s->near_count = s->pair_count = s->candidate_count = s->held_count = 0, s->due = 0, s->gap = INFINITY;
    s->reach = dm_reach_of(s);
    for (int64_t k = 0; k < s->surface_count; k++) dm_note_surface(s, s->surfaces + k);
    for (int64_t i = 0; i < s->vertex_count; i++) s->slack[i] = s->stale[i] = INFINITY;
    if (dm_is_outdated(s)) dm_search(s);
    for (uint32_t i = 0, run = 0; i < s->surface_count; i++)
        for (uint32_t j = i; j < s->surface_count; j++) dm_query_pair(s, i, j, &run);
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        for (uint32_t i = f->first; i < f->first + f->count; i++) {
            s->slack[i] = f->slack < s->slack[i] ? f->slack : s->slack[i];
            s->stale[i] = f->stale < s->stale[i] ? f->stale : s->stale[i], s->roam[i] = s->slack[i];
        }
    if (dm_has_room(s)) dm_link_pairs(s);
    if (dm_has_room(s)) dm_order_candidates(s);
    s->moving = dm_roomy(s, s->moving, s->near_count + 1, &s->moving_room, sizeof *s->moving); /* the last: of empty lanes */
    s->looks = 1;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) dm_set_bounds(s, f);
    s->out->queries++, s->out->pairs = s->pair_count > s->out->pairs ? s->pair_count : s->out->pairs;
    s->out->gap = s->gap < s->out->gap ? s->gap : s->out->gap;
}

/* Does the segment ab pass through a triangle? Source: signs of volumes. */
static int dm_passes(const double *a, const double *b, const double *const *t) {
    double u[3], v[3], n[3], from[3], way[3], across[3];
    dm_minus(t[1], t[0], u), dm_minus(t[2], t[0], v), dm_cross3(u, v, n);
    dm_minus(a, t[0], from), dm_minus(b, a, way);
    double here = dm_inner3(from, n), slope = dm_inner3(way, n);
    if (slope == 0) return 0;
    double share = -here / slope;
    if (!(share >= 0 && share <= 1)) return 0;
    for (int k = 0; k < 3; k++) {
        double x[3], edge[3];
        for (int c = 0; c < 3; c++) x[c] = a[c] + share * way[c] - t[k][c];
        dm_minus(t[(k + 1) % 3], t[k], edge), dm_cross3(edge, x, across);
        if (dm_inner3(across, n) < 0) return 0;
    }
    return 1;
}

static void dm_note_crossing(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j) {
    const uint32_t *a = s->corners[i], *b = s->corners[j];
    if (dm_share_a_vertex(a, 3, b, 3)) return;
    const double *x[3] = {s->before[a[0]], s->before[a[1]], s->before[a[2]]};
    const double *y[3] = {s->before[b[0]], s->before[b[1]], s->before[b[2]]};
    for (int k = 0; k < 3; k++) {
        if (!dm_passes(x[k], x[(k + 1) % 3], y) && !dm_passes(y[k], y[(k + 1) % 3], x)) continue;
        dm_crossings *found = s->found;
        if (!found->count++) {
            found->surfaces[0] = f - s->surfaces, found->surfaces[1] = g - s->surfaces;
            for (int c = 0; c < 3; c++)
                found->place[c] = (x[0][c] + x[1][c] + x[2][c] + y[0][c] + y[1][c] + y[2][c]) / 6;
        }
        return;
    }
}

/* Count the pairs of triangles that pass through each other, and say where the first is. */
static void dm_scene_state_find(dm_scene_state *s, dm_crossings *found) {
    memset(found, 0, sizeof *found);
    s->found = found;
    for (int64_t k = 0; k < s->surface_count; k++)
        dm_note_surface(s, s->surfaces + k), dm_fit_boxes(s, s->surfaces + k);
    for (int64_t i = 0; i < s->surface_count; i++)
        for (int64_t j = i; j < s->surface_count; j++) {
            const dm_surface *f = s->surfaces + i, *g = s->surfaces + j;
            if (dm_may_touch(f, g)) dm_visit_pairs(s, f, g, 0, dm_note_crossing);
        }
    s->due = 1;
}
