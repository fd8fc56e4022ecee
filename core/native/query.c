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
    f->slack = f->stale = INFINITY, f->left = f->near_left = 0;
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
        if (f->prop && !f->prop->asleep) {
            const double *pull = f->prop->now.gravity;
            fastest = dm_speed_of_prop(f->prop) + sqrt(dm_inner3(pull, pull)) * s->tick;
        }
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

DM_INLINE int dm_may_touch(const dm_surface *f, const dm_surface *g) { return f == g ? f->self : f->body || g->body || f->prop || g->prop; }

/* Find all that is close, so widely that some queries can live of it. */
static void dm_search(dm_scene_state *s) {
    s->wide = DM_QUERY_REACH * s->reach, s->close_count[0] = s->close_count[1] = s->run_count = 0;
    s->waiting_count[0] = s->waiting_count[1] = 0;
    memcpy(s->searched, s->before, (size_t)s->vertex_count * sizeof *s->searched);
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) dm_fit_boxes(s, f);
    for (uint32_t i = 0; i < s->surface_count; i++)
        for (uint32_t j = i; j < s->surface_count && dm_has_room(s); j++) {
            const dm_surface *f = s->surfaces + i, *g = s->surfaces + j;
            if (!dm_may_touch(f, g) || (f != g && dm_boxes_apart(f->low, f->high, g->low, g->high) > s->wide)) continue;
            s->within = f == g;
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

static void dm_set_bounds(dm_scene_state *s, dm_surface *f) {
    f->near_group_count = 0;
    if (f->prop) memcpy(f->prop->since, s->before + f->first, f->count * sizeof *s->before);
    for (int64_t g = 0; f->body && g < f->body->groups; g++) {
        int near = 0;
        for (int l = 0; l < DM_LANES; l++) {
            uint32_t i = f->first + (uint32_t)(g * DM_LANES + l);
            double way = s->roam[i] / 2, due = s->stale[i];
            f->bound[g][l] = (dm_real)(way < 1e18 ? way * way : 1e36);
            f->due[g][l] = (dm_real)(due < 1e18 ? due * due : 1e36);
            near |= s->place[i] != DM_NO_VERTEX;
        }
        if (near) f->near_groups[f->near_group_count++] = (uint32_t)g;
    }
}

static void dm_query(dm_scene_state *s) {
    dm_sum_meetings(s), s->batch_count = s->support_count = 0;
    for (int64_t i = 0; i < s->vertex_count; i++) s->place[i] = DM_NO_VERTEX;
    s->near_count = s->pair_count = s->candidate_count = s->held_count = 0, s->due = 0, s->gap = INFINITY;
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
    if (dm_has_room(s)) dm_number_near(s);
    if (dm_has_room(s)) dm_link_pairs(s);
    if (dm_has_room(s)) dm_order_candidates(s);
    s->moving = dm_roomy(s, s->moving, s->near_count + 1, &s->moving_room, sizeof *s->moving); /* the last: of empty lanes */
    s->there = dm_roomy(s, s->there, s->near_count, &s->there_room, sizeof *s->there);
    s->met = dm_roomy(s, s->met, s->near_count, &s->met_room, sizeof *s->met);
    s->looks = 1;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) dm_set_bounds(s, f);
    s->out->queries++, s->out->pairs = s->pair_count > s->out->pairs ? s->pair_count : s->out->pairs;
    s->out->gap = s->gap < s->out->gap ? s->gap : s->out->gap;
}
