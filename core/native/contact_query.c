/* The proximity query: places, nearby pairs, and how far each surface may move until the next query. */
#include "scene.h"

static void dm_note_rest(dm_scene_state *s, const dm_surface *f) {
    const dm_state *b = f->body;
    for (int64_t k = 0; k < b->n; k++)
        for (int c = 0; c < 3; c++) s->rest[f->first + b->place[k]][c] = b->rest[c * b->n + k];
}

/* Find how far the vertices of a surface have moved since the last query: their mean displacement, and the greatest
 * difference from it. */
static void dm_find_moved(const dm_scene_state *s, dm_surface *f) {
    double way[3], most = 0;
    uint32_t count = f->body ? (uint32_t)f->body->n : f->count;
    memset(f->moved, 0, sizeof f->moved);
    for (uint32_t i = f->first; i < f->first + count; i++)
        dm_world_of(s, f, i, way), dm_minus(way, s->before[i], way), dm_add3(f->moved, 1.0 / count, way);
    for (uint32_t i = f->first; i < f->first + count; i++) {
        dm_world_of(s, f, i, way), dm_minus(way, s->before[i], way), dm_minus(way, f->moved, way);
        most = fmax(most, dm_inner3(way, way));
    }
    f->bent = sqrt(most);
}

/* Note the places of a surface's vertices, and their bounding box. */
static void dm_note_surface(dm_scene_state *s, dm_surface *f) {
    dm_find_moved(s, f);
    for (int c = 0; c < 3; c++) f->low[c] = INFINITY, f->high[c] = -INFINITY;
    for (uint32_t i = f->first; i < f->first + f->count; i++) {
        dm_world_of(s, f, i, s->before[i]);
        if (f->body && i - f->first >= f->body->n) continue; /* an empty lane */
        for (int c = 0; c < 3; c++) {
            double x = s->before[i][c];
            f->low[c] = x < f->low[c] ? x : f->low[c], f->high[c] = x > f->high[c] ? x : f->high[c];
        }
    }
    f->slack = f->stale = INFINITY, f->gone = 0;
    if (!f->body) return;
    for (int64_t g = 0; g < f->body->groups; g++) s->noted[f->first / DM_LANES + g] = f->body->state[g].x;
    f->fitted = 0;
    if (f->self && f->body->moving) dm_note_rest(s, f);
    if (f->changes != f->body->changes) memset(f->resisting, 0, sizeof f->resisting), f->placed = 1;
    f->changes = f->body->changes;
    memcpy(f->origin, f->body->origin, sizeof f->origin);
}

/* Return the greatest speed of any surface as a tick begins [m/s]. */
static double dm_fastest_of(dm_scene_state *s) {
    double speed = 0;
    s->fastest_rigid = 0;
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
        if (!f->body && fastest > s->fastest_rigid) s->fastest_rigid = fastest;
    }
    return speed;
}

/* As a tick begins: set how much farther than their distance of touch pairs are still considered, because they may come
 * nearer before the next update. */
static void dm_set_approach(dm_scene_state *s) {
    s->fastest = dm_fastest_of(s);
    double least = s->touch + 3 * s->fastest * s->dt;
    if (least <= s->approach && s->approach <= 4 * least) return;
    s->approach = s->touch + 6 * s->fastest * s->dt, s->looks = 1;
}

static void dm_bring_near(dm_surface *f, double slack, double stale) {
    f->slack = slack < f->slack ? slack : f->slack, f->stale = stale < f->stale ? stale : f->stale;
}

/* Return whether the skin of f has been released from the collider g. */
DM_INLINE int dm_is_released(const dm_scene_state *s, const dm_surface *f, const dm_surface *g) {
    for (uint32_t k = 0; k < s->released_count; k++)
        if (s->released[k][0] == f - s->surfaces && s->released[k][1] == g - s->surfaces) return 1;
    return 0;
}

DM_INLINE int dm_may_touch(const dm_scene_state *s, const dm_surface *f, const dm_surface *g) {
    return f == g ? f->self : (f->body || g->body || f->prop || g->prop) && !dm_is_released(s, f, g);
}

/* Return how far a vertex of a body is pulled from its place at rest along the motion of a collider [m]. */
static double dm_pulled(const dm_state *b, uint32_t i, const double *rate) {
    double along = 0, speed = sqrt(dm_inner3(rate, rate)), rest[3];
    dm_vec3 lanes = b->matter[i / DM_LANES].rest;
    rest[0] = (double)lanes.x[i % DM_LANES], rest[1] = (double)lanes.y[i % DM_LANES], rest[2] = (double)lanes.z[i % DM_LANES];
    for (int c = 0; c < 3 && speed > 0; c++)
        along += rate[c] / speed * ((double)b->records[i].x[c] - dm_inner3(b->rotation + 3 * c, rest) - b->translation[c]);
    return along;
}

/* Release skin from colliders that have pulled it farther than the body's size; once they are apart, they collide
 * again. */
static void dm_release(dm_scene_state *s) {
    for (uint32_t k = 0; k < s->released_count; k++) {
        const dm_surface *f = s->surfaces + s->released[k][0], *g = s->surfaces + s->released[k][1];
        if (!(dm_boxes_apart(f->low, f->high, g->low, g->high) > s->reach)) continue;
        s->released_count--;
        for (int c = 0; c < 2; c++) s->released[k][c] = s->released[s->released_count][c];
        k--;
    }
    for (uint32_t k = 0; k < s->pair_count; k++) {
        const dm_pair *p = s->pairs + k;
        if (p->rigid != 1 && p->rigid != 2) continue;
        uint32_t soft = p->rigid & 1 ? 3 : 0;
        const dm_neighbour *n = s->near + p->at[soft], *other = s->near + p->at[3 - soft];
        dm_surface *f = s->surfaces + n->surface, *g = s->surfaces + other->surface;
        if (!g->moving || g->torn || dm_is_released(s, f, g)) continue;
        if (!(dm_pulled(f->body, n->vertex - f->first, s->rate[other->vertex]) > f->body->size)) continue;
        s->released = dm_grown(s, s->released, s->released_count, &s->released_room, sizeof *s->released);
        if (!dm_has_room(s)) return;
        s->released[s->released_count][0] = n->surface, s->released[s->released_count++][1] = other->surface;
        g->torn = 1, dm_world_of(s, f, n->vertex, g->place);
    }
}

/* Return how far pairs of two surfaces are searched [m]: so far that rigid surfaces need not stop. */
static double dm_reach_of(const dm_scene_state *s, const dm_surface *f, const dm_surface *g) {
    return f->body && g->body ? s->least_reach : fmax(s->least_reach, s->touch + 3 * s->fastest_rigid * s->dt);
}

static int dm_by_start(const void *a, const void *b) {
    const dm_run *p = a, *q = b;
    return p->start < q->start ? -1 : p->start > q->start;
}

static int dm_by_surfaces(const void *a, const void *b) {
    const dm_run *p = a, *q = b;
    uint64_t one = (uint64_t)p->first << 32 | p->second, other = (uint64_t)q->first << 32 | q->second;
    return one < other ? -1 : one > other;
}

/* Keep the pairs of two surfaces, from now on at `start`, if the surfaces have used up less than half of the relative
 * displacement after which unknown pairs may touch; return whether they are kept. */
static int dm_keep_run(dm_scene_state *s, dm_run *run, uint32_t start) {
    const dm_surface *f = s->surfaces + run->first, *g = s->surfaces + run->second;
    uint32_t count = run->end - run->start;
    double apart[3];
    dm_minus(f->moved, g->moved, apart);
    double way = f->bent + g->bent + sqrt(dm_inner3(apart, apart));
    run->used += way, run->gone += way; /* pins may have moved after the last substep */
    if (f->placed || g->placed || !dm_may_touch(s, f, g) || run->reach < dm_reach_of(s, f, g)) return 0;
    if (!(run->used < DM_STALE * (run->reach - s->touch) / 2)) return 0;
    if (DM_BOUND * (run->reach - run->used) / 2 < dm_next_way(s)) return 0;
    for (uint32_t k = 0; k < count; k++) {
        s->pairs[start + k] = s->pairs[run->start + k], s->planes[start + k] = s->planes[run->start + k];
        s->next[start + k] = s->next[run->start + k];
    }
    run->start = start, run->end = start + count;
    for (dm_pair *p = s->pairs + start; p < s->pairs + run->end; p++) {
        p->gap -= way;
        for (int k = 0; k < 4; k++) p->at[k] = s->near[p->at[k]].vertex, s->place[p->at[k]] = 0;
    }
    return 1;
}

static void dm_keep_runs(dm_scene_state *s) {
    uint32_t count = s->run_count;
    s->kept_count = 0;
    if (!s->runs) return;
    qsort(s->runs, count, sizeof *s->runs, dm_by_start);
    s->run_count = s->pair_count = 0;
    for (uint32_t k = 0; k < count; k++) {
        dm_run run = s->runs[k];
        if (!dm_keep_run(s, &run, s->pair_count)) continue;
        s->pair_count = run.end, s->runs[s->run_count++] = run;
    }
    qsort(s->runs, s->kept_count = s->run_count, sizeof *s->runs, dm_by_surfaces);
}

/* List the nearby pairs of two surfaces, or limit their motion by the distance between them. */
static void dm_query_pair(dm_scene_state *s, uint32_t i, uint32_t j) {
    dm_surface *f = s->both[0] = s->surfaces + i, *g = s->both[1] = s->surfaces + j;
    if (!dm_may_touch(s, f, g)) return;
    double apart = f == g ? -1 : dm_boxes_apart(f->low, f->high, g->low, g->high);
    s->reach = dm_reach_of(s, f, g);
    if (apart > s->reach) {
        dm_bring_near(f, DM_BOUND * apart / 2, apart / 4), dm_bring_near(g, DM_BOUND * apart / 2, apart / 4);
        return;
    }
    for (int k = 0; k < 2; k++)
        if (!s->both[k]->fitted) dm_fit_boxes(s, s->both[k]), s->both[k]->fitted = 1;
    dm_run run = {.first = i, .second = j, .start = s->pair_count, .reach = s->reach};
    dm_visit_pairs(s, f, g, s->reach, dm_pair_leaves);
    dm_note_waiting(s, 1), dm_note_waiting(s, 2);
    run.end = s->pair_count;
    s->runs = dm_grown(s, s->runs, s->run_count, &s->run_room, sizeof *s->runs);
    if (dm_has_room(s)) s->runs[s->run_count++] = run;
}

/* Find the nearby pairs of all surfaces, those apart that have hardly moved relative to each other since they were
 * searched. */
static void dm_search(dm_scene_state *s) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->surface_count; i++)
        for (uint32_t j = i; j < s->surface_count && dm_has_room(s); j++) {
            const dm_run *next = s->runs + kept;
            if (kept < s->kept_count && next->first == i && next->second == j) kept++;
            else dm_query_pair(s, i, j);
        }
    if (!dm_has_room(s)) return;
    for (const dm_run *run = s->runs; run < s->runs + s->run_count; run++)
        for (int k = 0; k < 2; k++) {
            double left = run->reach - run->used;
            dm_bring_near(s->surfaces + (k ? run->second : run->first), DM_BOUND * left / 2, DM_STALE * (left - s->touch) / 2);
        }
}

static void dm_query(dm_scene_state *s) {
    dm_sum_meetings(s), s->batch_count = s->support_count = 0;
    s->reach = s->least_reach;
    for (int64_t k = 0; k < s->surface_count; k++) dm_note_surface(s, s->surfaces + k);
    dm_release(s);
    for (int64_t i = 0; i < s->vertex_count; i++) s->place[i] = DM_NO_VERTEX;
    dm_keep_runs(s);
    s->near_count = s->candidate_count = 0, s->due = 0;
    dm_search(s);
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) f->placed = 0;
    if (dm_has_room(s)) dm_number_near(s);
    if (dm_has_room(s)) dm_link_pairs(s);
    if (dm_has_room(s)) dm_order_candidates(s);
    s->moving = dm_roomy(s, s->moving, s->near_count + 1, &s->moving_room, sizeof *s->moving); /* last: empty lanes */
    s->there = dm_roomy(s, s->there, s->near_count, &s->there_room, sizeof *s->there);
    s->now = dm_roomy(s, s->now, s->near_count, &s->now_room, sizeof *s->now);
    s->met = dm_roomy(s, s->met, s->near_count, &s->met_room, sizeof *s->met);
    s->looks = 1;
    if (!dm_has_room(s)) s->near_count = s->pair_count = s->candidate_count = s->run_count = 0, s->due = 1;
    s->out->queries++;
}
