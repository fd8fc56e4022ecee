/* Several bodies and colliders stepped together. */
#include "scene.h"

static void dm_scene_state_destroy(dm_scene_state *s) {
    for (int64_t k = 0; s->surfaces && k < s->surface_count; k++)
        dm_free_prop(s->surfaces[k].prop);
    void *const parts[] = {s->surfaces, s->before, s->rest, s->here, s->aim, s->rate, s->was, s->corners, s->edges_of,
                           s->edges, s->across, s->listed, s->ring_start, s->ring, s->place, s->nodes, s->vertex_start, s->edge_start,
                           s->number, s->bins, s->left_out, s->given, s->noted};
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) dm_free(parts[k]);
    for (int c = 0; c < 3; c++)
        dm_free(s->boxes.low[c]), dm_free(s->boxes.high[c]), dm_free(s->edge_boxes.low[c]), dm_free(s->edge_boxes.high[c]);
    void *const lists[] = {s->near, s->pairs, s->pairs_of, s->batches, s->moving, s->candidates, s->sorted, s->held,
                           s->spent, s->runs, s->planes, s->next, s->tally, s->sides, s->there, s->now, s->met, s->supports,
                           s->released};
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) dm_free(lists[k]);
    dm_free(s);
}

static int32_t dm_allocate_scene(dm_scene_state *s) {
    int64_t n = s->vertex_count, t = s->triangle_count;
    int whole = (s->before = dm_alloc(n, sizeof *s->before)) && (s->rest = dm_alloc(n, sizeof *s->rest));
    whole = whole && (s->here = dm_alloc(n, sizeof *s->here)) && (s->aim = dm_alloc(n, sizeof *s->aim));
    whole = whole && (s->noted = dm_alloc(n / DM_LANES + 1, sizeof *s->noted));
    whole = whole && (s->rate = dm_alloc(n, sizeof *s->rate)) && (s->was = dm_alloc(n, sizeof *s->was));
    whole = whole && (s->corners = dm_alloc(t, sizeof *s->corners)) && (s->edges_of = dm_alloc(t, sizeof *s->edges_of));
    whole = whole && (s->edges = dm_alloc(3 * t, sizeof *s->edges)) && (s->across = dm_alloc(3 * t, sizeof *s->across));
    whole = whole && (s->vertex_start = dm_alloc(t + 1, sizeof(uint32_t))) && (s->edge_start = dm_alloc(t + 1, sizeof(uint32_t)));
    whole = whole && (s->listed = dm_alloc(n, sizeof(uint32_t))) && (s->place = dm_alloc(n, sizeof(uint32_t)));
    for (int c = 0; c < 3; c++) { /* eight are read at once, also from the last one on */
        whole = whole && (s->boxes.low[c] = dm_alloc(t + DM_LANES, sizeof(double)));
        whole = whole && (s->boxes.high[c] = dm_alloc(t + DM_LANES, sizeof(double)));
        whole = whole && (s->edge_boxes.low[c] = dm_alloc(3 * t + DM_LANES, sizeof(double)));
        whole = whole && (s->edge_boxes.high[c] = dm_alloc(3 * t + DM_LANES, sizeof(double)));
    }
    whole = whole && (s->nodes = dm_alloc(2 * t + s->surface_count, sizeof *s->nodes));
    whole = whole && (s->left_out = dm_alloc(n, 1)) && (s->given = dm_alloc(n, sizeof *s->given));
    whole = whole && (s->number = dm_alloc(n, sizeof(uint32_t))) && (s->bins = dm_alloc(2 * n + 1, sizeof(uint32_t)));
    for (int64_t i = 0; whole && i < n; i++) s->place[i] = DM_NO_VERTEX;
    return whole ? DM_OK : DM_MEMORY;
}

static void dm_lay_body(dm_scene_state *s, dm_surface *f) {
    const dm_state *b = f->body;
    dm_note_rest(s, f);
    for (uint32_t k = 0; k < b->n; k++) s->number[f->first + b->place[k]] = f->first + k;
    for (int64_t k = 0; k < 3 * b->triangle_count; k++)
        s->corners[f->first_triangle + k / 3][k % 3] = f->first + b->triangles[k / 3][k % 3];
    f->closest = DM_TOO_NEAR * b->size;
}

static void dm_place_collider(dm_scene_state *s, int64_t which, const double *positions) {
    const dm_surface *f = s->surfaces + which;
    for (uint32_t k = 0; k < f->count; k++)
        for (int c = 0; c < 3; c++) {
            s->here[f->first + k][c] = s->aim[f->first + k][c] = positions[(uint32_t)c * f->count + k];
            s->rate[f->first + k][c] = 0;
        }
    s->surfaces[which].fitted = 0, s->surfaces[which].placed = 1;
}

static int32_t dm_lay_collider(dm_scene_state *s, dm_surface *f, const dm_collider_def *d) {
    dm_place_collider(s, f - s->surfaces, d->positions);
    memcpy(s->rest[f->first], s->here[f->first], f->count * sizeof *s->rest);
    for (int64_t k = 0; k < 3 * d->triangles; k++)
        s->corners[f->first_triangle + k / 3][k % 3] = f->first + (uint32_t)d->corners[k];
    for (uint32_t k = f->first; k < f->first + f->count; k++) s->number[k] = k;
    f->friction = d->friction;
    s->prop_count += d->mass > 0;
    return d->mass > 0 ? dm_lay_prop(f, d) : DM_OK;
}

/* Set up the surfaces one after the other: first the bodies, then the colliders. */
static int32_t dm_lay_surfaces(dm_scene_state *s, int64_t bodies, const dm_collider_def *colliders) {
    int32_t code = DM_OK;
    uint32_t node = 0;
    for (int64_t k = 0; k < s->surface_count && code == DM_OK; k++) {
        dm_surface *f = s->surfaces + k;
        if (f->body) dm_lay_body(s, f);
        else code = dm_lay_collider(s, f, colliders + (k - bodies));
        if (code == DM_OK) code = dm_order_triangles(s, f);
        if (code == DM_OK) code = dm_lay_edges(s, f);
        if (code != DM_OK || !f->triangle_count) continue;
        f->first_node = node;
        node = dm_lay_tree(s, node, f->first_triangle, f->first_triangle + f->triangle_count);
        f->node_count = node - f->first_node;
        if (f->body && (s->edge == 0 || f->edge < s->edge)) s->edge = f->edge;
    }
    double least = INFINITY;
    for (int64_t k = 0; k < s->surface_count; k++) {
        dm_surface *f = s->surfaces + k;
        if (!f->body) f->offset = least < INFINITY ? least : 0; /* they come last */
        else if (!(f->offset > 0)) f->offset = DM_OFFSET * f->edge;
        if (f->body && f->offset > 0 && f->offset < least) least = f->offset;
        double most = f->offset + (f->body ? f->offset : 0);
        s->touch = most > s->touch ? most : s->touch;
    }
    for (int64_t k = 0; k < s->surface_count; k++)
        for (int64_t j = 0; j < k; j++) {
            double most = dm_touch_of(s->surfaces + j, s->surfaces + k);
            s->touch = most > s->touch ? most : s->touch;
        }
    s->least_reach = DM_QUERY_REACH * fmax(s->touch, 2 * DM_OFFSET * s->edge);
    return code == DM_OK ? dm_lay_neighbours(s) : code;
}

static int32_t dm_scene_state_create(dm_scene_state **made, int64_t bodies, dm_state *const *body, const uint8_t *self,
                                     const double *offset, int64_t colliders, const dm_collider_def *collider,
                                     dm_crossings *left_out) {
    dm_scene_state *s = *made = dm_alloc(1, sizeof *s);
    if (!s) return DM_MEMORY;
    s->surfaces = dm_alloc(bodies + colliders, sizeof *s->surfaces);
    if (!s->surfaces) return dm_free(s), *made = NULL, DM_MEMORY;
    s->surface_count = bodies + colliders;
    for (int64_t k = 0; k < s->surface_count; k++) {
        dm_surface *f = s->surfaces + k;
        int64_t count, triangles;
        if (k < bodies) {
            f->body = body[k], f->self = self[k], f->offset = offset[k];
            count = f->body->groups * DM_LANES, triangles = f->body->triangle_count;
        } else count = collider[k - bodies].vertices, triangles = collider[k - bodies].triangles;
        f->first = (uint32_t)s->vertex_count, f->count = (uint32_t)count;
        f->first_triangle = (uint32_t)s->triangle_count, f->triangle_count = (uint32_t)triangles;
        s->vertex_count += count, s->triangle_count += triangles;
    }
    s->due = 1;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) f->share = 1;
    int32_t code = dm_allocate_scene(s);
    if (code == DM_OK) code = dm_lay_surfaces(s, bodies, collider);
    if (code == DM_OK) dm_leave_out(s, left_out);
    if (code != DM_OK) dm_scene_state_destroy(s), *made = NULL;
    return code;
}

static void dm_scene_state_place(dm_scene_state *s, int64_t collider, const double *positions) {
    int64_t which = 0;
    while (s->surfaces[which].body) which++;
    dm_place_collider(s, which + collider, positions);
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) /* it may have stood on that collider */
        if (f->prop) f->prop->asleep = 0, f->prop->quiet = 0;
    if (s->surfaces[which + collider].prop) s->surfaces[which + collider].prop->placed = 0;
    s->due = 1;
}

static void dm_scene_state_read(const dm_scene_state *s, int64_t collider, double *positions) {
    const dm_surface *f = s->surfaces;
    while (f->body) f++;
    f += collider;
    for (uint32_t k = 0; k < f->count; k++)
        for (uint32_t c = 0; c < 3; c++) positions[c * f->count + k] = s->here[f->first + k][c];
}

/* Set the target places of the colliders at the end of a tick. A collider that was held back catches up with the
 * time constant DM_PUSH_TIME, in addition to its keyframed motion. */
static void dm_aim_colliders(dm_scene_state *s, const dm_collider_motion *to, double share) {
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        if (f->body) continue;
        double led = 0, late = 0, left = 0, way[3];
        for (uint32_t k = 0; !f->prop && (to->to || f->late > 0) && k < f->count; k++) {
            double before[3], *aim = s->aim[f->first + k], *here = s->here[f->first + k];
            memcpy(before, aim, sizeof before);
            for (uint32_t c = 0; to->to && c < 3; c++) {
                double from = to->from[c * f->count + k], end = to->to[c * f->count + k];
                aim[c] = share >= 1 ? end : from + share * (end - from);
            }
            dm_minus(aim, before, way), led = fmax(led, dm_inner3(way, way));
            dm_minus(before, here, way), late = fmax(late, dm_inner3(way, way));
            dm_minus(aim, here, way), left = fmax(left, dm_inner3(way, way));
        }
        to++;
        if (f->prop) continue;
        f->moving = left > 0;
        f->pace = late > 0 && left > 0 ? fmin(1, (sqrt(led) + sqrt(late) * s->tick / DM_PUSH_TIME) / sqrt(left)) : 1;
        if (!f->moving) memset(s->rate[f->first], 0, f->count * sizeof *s->rate);
    }
}

/* Move the colliders in a substep. left: substeps left in the tick, including this one. A collider that was held back
 * tries twice the share that it covered before. */
static void dm_lead_colliders(dm_scene_state *s, double left) {
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        if (f->body || !dm_goes(f)) continue;
        memcpy(s->was[f->first], s->here[f->first], f->count * sizeof *s->was);
        if (f->prop) continue;
        f->share = f->tried = fmin(1, 2 * fmax(f->share, DM_LEAST_WAY));
        f->pace_now = f->pace / (s->substeps - f->pace * (s->substeps - left));
        dm_go(s, f);
    }
}

/* Return whether the origin of a body has moved since the last query, or the body was changed. */
static int dm_is_changed(const dm_scene_state *s) {
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        if (f->body && (f->changes != f->body->changes || memcmp(f->origin, f->body->origin, sizeof f->origin)))
            return 1;
    return 0;
}

static void dm_run_scene_substep(dm_scene_state *s, const dm_motion *motions, int64_t t, dm_frame *frames, int64_t left) {
    if (s->due) dm_query(s);
    dm_begin_contact(s);
    if (!dm_has_room(s)) return;
    if (s->wakes) dm_wake_touched(s, motions, t, frames);
    dm_begin_props(s);
    int64_t bodies = 0;
    while (bodies < s->surface_count && s->surfaces[bodies].body) bodies++;
    for (int64_t i = 0; i < bodies; i++) {
        int64_t k = s->backwards ? bodies - 1 - i : i;
        dm_surface *f = s->surfaces + k;
        if (f->body->asleep) continue;
        dm_run_substep(f->body, left, frames + k);
    }
    s->backwards = !s->backwards;
    dm_lead_colliders(s, (double)left + 1);
    dm_move_props(s);
    dm_resolve_touching(s);
    dm_note_answers(s);
    dm_resist_rolling(s);
    dm_keep_apart(s);
    for (dm_surface *f = s->surfaces + bodies; f < s->surfaces + s->surface_count; f++)
        if (f->prop && !f->prop->asleep) dm_leave_prop(s, f);
}

/* After a tick: note how far colliders lag behind their paths. */
static void dm_note_late(dm_scene_state *s) {
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        f->late = 0;
        for (uint32_t i = f->first; !f->body && !f->prop && f->moving && i < f->first + f->count; i++) {
            double way[3];
            dm_minus(s->aim[i], s->here[i], way), f->late = fmax(f->late, sqrt(dm_inner3(way, way)));
        }
    }
}

/* Return whether a surface has released skin, and passes through it. */
static int dm_has_released(const dm_scene_state *s, int64_t which) {
    for (uint32_t k = 0; k < s->released_count; k++)
        if (s->released[k][1] == which) return 1;
    return s->surfaces[which].torn;
}

static int32_t dm_scene_state_step(dm_scene_state *s, const dm_motion *motions, const dm_collider_motion *colliders,
                             double first, double last, dm_frame *frames, dm_scene_frame *out, double *passed, double *given) {
    int64_t bodies = 0, substeps = motions->substeps, ticks = motions->ticks;
    memset(out, 0, sizeof *out), memset(s->given, 0, (size_t)s->vertex_count * sizeof *s->given);
    s->out = out, s->code = DM_OK, s->tick = motions->tick, s->substeps = (double)substeps, s->dt = s->tick / (double)substeps;
    for (; bodies < s->surface_count && s->surfaces[bodies].body; bodies++)
        dm_begin_motion(s->surfaces[bodies].body, motions + bodies, frames + bodies), s->surfaces[bodies].body->meets = 1;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        memset(f->impulse, 0, sizeof f->impulse), memset(f->moment, 0, sizeof f->moment);
        f->torn = 0;
    }
    for (int64_t k = bodies; k < s->surface_count; k++)
        if (s->surfaces[k].prop && colliders[k - bodies].prop) dm_take_prop(s, s->surfaces + k, colliders[k - bodies].prop);
    int finite = 1;
    for (int64_t t = 0; t < ticks && finite && s->code == DM_OK; t++) {
        double share = ticks > 1 ? first + (double)t / (double)(ticks - 1) * (last - first) : first;
        if (ticks > 1 && t == ticks - 1) share = last;
        int awake = 0;
        dm_aim_colliders(s, colliders, share);
        for (int64_t k = 0; k < bodies; k++) dm_begin_tick(s->surfaces[k].body, motions + k, t, frames + k);
        for (int64_t k = 0; k < s->surface_count; k++) awake |= dm_moves(s->surfaces + k);
        if (awake) dm_set_approach(s), s->wakes = 1;
        if (dm_is_changed(s) || s->released_count) s->due = 1; /* a query finds what is apart again */
        for (int64_t i = 0; i < substeps && awake && s->code == DM_OK; i++)
            dm_run_scene_substep(s, motions, t, frames, substeps - 1 - i);
        dm_note_late(s);
        for (int64_t k = 0; k < bodies; k++) {
            dm_end_tick(s->surfaces[k].body, motions + k, t, frames + k);
            finite = finite && frames[k].finite;
        }
        for (const dm_surface *f = s->surfaces + bodies; f < s->surfaces + s->surface_count; f++)
            if (f->prop && !f->prop->asleep) dm_watch_prop(f->prop, s->tick);
        if (finite) dm_let_sleep(s, motions);
        out->ticks = t + 1;
    }
    dm_sum_meetings(s);
    for (int64_t k = bodies; k < s->surface_count; k++)
        if (s->surfaces[k].prop && colliders[k - bodies].prop) *colliders[k - bodies].prop = s->surfaces[k].prop->now;
    for (int64_t k = 0; k < bodies; k++) dm_end_motion(s->surfaces[k].body, motions + k, frames + k);
    for (int64_t k = 0; k < s->surface_count; k++)
        memcpy(passed, s->surfaces[k].impulse, 3 * sizeof *passed), memcpy(passed + 3, s->surfaces[k].moment, 3 * sizeof *passed),
            passed[6] = s->surfaces[k].late, passed[7] = dm_has_released(s, k),
            memcpy(passed + 8, s->surfaces[k].place, 3 * sizeof *passed), passed += DM_PASSED;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + bodies; f++)
        for (uint32_t k = 0; k < f->body->n; k++, given += 3)
            memcpy(given, s->given[f->first + f->body->place[k]], sizeof *s->given);
    return s->code;
}
