/* How far vertices may go before the next query: planes between pairs, and a distance for what is near nothing.
 * Source: studies/reference/bounds.py. */
#include "scene.h"

/* Grow an array to hold some things, where it holds fewer. */
static void *dm_roomy(dm_scene_state *s, void *array, uint32_t count, uint32_t *size, size_t each) {
    if (count <= *size) return array;
    dm_free(array);
    array = dm_alloc(2 * (int64_t)count, each), *size = array ? 2 * count : 0;
    if (!array) s->code = DM_MEMORY;
    return array;
}

/* List the pairs of each vertex that is near, and note how far it may go before they are looked at. */
static void dm_link_pairs(dm_scene_state *s) {
    s->pairs_of = dm_roomy(s, s->pairs_of, 4 * s->pair_count, &s->pairs_of_room, sizeof *s->pairs_of);
    if (!dm_has_room(s)) return;
    uint32_t start = 0;
    for (uint32_t k = 0; k < s->near_count; k++) {
        dm_tally *t = s->tally + k;
        const dm_neighbour *n = s->near + k;
        t->end = start, start += t->count;
        s->roam[n->vertex] = t->way < s->roam[n->vertex] ? t->way : s->roam[n->vertex];
    }
    for (uint32_t k = 0; k < 4 * s->pair_count; k++)
        s->pairs_of[s->tally[s->pairs[k / 4].at[k % 4]].end++] = k;
}

/* The pairs of a vertex that is near. */
DM_INLINE const uint32_t *dm_pairs_of(const dm_scene_state *s, const dm_neighbour *n, uint32_t *count) {
    const dm_tally *t = s->tally + (n - s->near);
    const uint32_t *mine = s->pairs_of + t->end - t->count;
    *count = t->count;
    for (uint32_t k = 0; k < t->count; k++) __builtin_prefetch(s->planes + mine[k] / 4);
    return mine;
}

/* How far a near vertex goes in a substep. */
static double dm_stride_of(const dm_scene_state *s, const dm_neighbour *n) {
    double v[3];
    dm_velocity_of(s, n, v);
    return sqrt(dm_inner3(v, v)) * s->dt;
}

/* How far a vertex may go from x before its planes are looked at: less than nothing where it may not be there. */
static __attribute__((noinline)) double dm_room_of(dm_scene_state *s, uint32_t vertex, const double *x, int *spent) {
    double way[3];
    dm_minus(x, s->before[vertex], way);
    double gone = sqrt(dm_inner3(way, way)), least = s->slack[vertex] - gone;
    if (!(least >= 0)) return -1;
    if (s->place[vertex] == DM_NO_VERTEX) return least;
    uint32_t count;
    const dm_neighbour *n = s->near + s->place[vertex];
    const uint32_t *mine = dm_pairs_of(s, n, &count);
    double stride = dm_stride_of(s, n);
    for (uint32_t k = 0; k < count; k++) {
        double left = dm_left_of(s, mine[k], x, gone, stride, spent);
        if (!(left >= 0)) return -1;
        least = left < least ? left : least;
    }
    return least;
}

static int dm_is_allowed(dm_scene_state *s, uint32_t vertex, const double *x) {
    int spent = 0;
    return dm_room_of(s, vertex, x, &spent) >= 0;
}

/* Shorten the way of a vertex since the query to a length. */
static void dm_shorten(const double *from, double *x, double most) {
    double way[3];
    dm_minus(x, from, way);
    double length = sqrt(dm_inner3(way, way));
    if (!(length > most)) return;
    for (int c = 0; c < 3; c++) x[c] = from[c] + way[c] * (most / length);
}

/* Where a near vertex was before this substep; a collider has not moved yet when it is asked. */
DM_INLINE void dm_last_of(const dm_scene_state *s, const dm_surface *f, const dm_neighbour *n, double *x) {
    for (int c = 0; c < 3; c++) x[c] = f->body ? f->body->origin[c] + (double)n->last[c] : s->here[n->vertex][c];
}

/* Bring a vertex to where it may be: onto its planes where it is beyond them, so that it still slides along; where that
 * is not enough, so far back on its way as it must. */
static void dm_hold_back(dm_scene_state *s, const dm_surface *f, uint32_t vertex, double *x) {
    const double *begin = s->before[vertex];
    double most = s->slack[vertex] * (1 - DM_ROUNDING), share = 1;
    dm_shorten(begin, x, most);
    if (s->place[vertex] == DM_NO_VERTEX) return;
    const dm_neighbour *n = s->near + s->place[vertex];
    double from[3];
    dm_last_of(s, f, n, from);
    uint32_t count;
    const uint32_t *mine = dm_pairs_of(s, n, &count);
    for (int sweep = 0; sweep < DM_TRIES; sweep++) {
        int moved = 0;
        for (uint32_t k = 0; k < count; k++) {
            const dm_plane *plane = s->planes + mine[k] / 4;
            int first = mine[k] % 4 < plane->ones;
            double short_of = plane->keep[!first] * (1 + DM_ROUNDING) - dm_side(plane, first, x);
            if (!(short_of > 0)) continue;
            double by = first ? short_of : -short_of;
            for (int c = 0; c < 3; c++) x[c] += by * plane->normal[c];
            moved = 1;
        }
        if (!moved) return;
        dm_shorten(begin, x, most);
    }
    for (uint32_t k = 0; k < count; k++) {
        const dm_plane *plane = s->planes + mine[k] / 4;
        int first = mine[k] % 4 < plane->ones;
        double there = dm_side(plane, first, x), here = dm_side(plane, first, from), keep = plane->keep[!first];
        if (there < keep && here > there) {
            double part = (here - keep) / (here - there) * (1 - DM_ROUNDING);
            share = part < share ? (part > 0 ? part : 0) : share;
        }
    }
    for (int c = 0; c < 3; c++) x[c] = from[c] + share * (x[c] - from[c]);
}

static void dm_note_held(dm_scene_state *s, uint32_t vertex) {
    if (s->place[vertex] == DM_NO_VERTEX) {
        s->due = 1; /* it wants to go farther than anybody has looked */
        return;
    }
    s->held = dm_grown(s, s->held, s->held_count, &s->held_room, sizeof *s->held);
    if (dm_has_room(s)) s->held[s->held_count++] = s->place[vertex];
    else s->due = 1;
}

/* Let a vertex go so far from where it is now, at x, before its planes are looked at, or until a query may be due. */
static void dm_set_bound(dm_scene_state *s, dm_surface *f, uint32_t vertex, const double *x, double most) {
    uint32_t i = vertex - f->first;
    double way[3];
    dm_minus(x, s->before[vertex], way);
    double fresh = s->stale[vertex] - sqrt(dm_inner3(way, way));
    if (fresh < 0) s->due = 1;
    if (f->prop) {
        s->roam[vertex] = most, memcpy(f->prop->since[i], x, sizeof way);
        return;
    }
    dm_set_lane3(&f->before[i / DM_LANES], i, f->body->records[i].x);
    most = most / 2 < fresh ? most / 2 : fresh, f->near_left = 0;
    f->bound[i / DM_LANES][i % DM_LANES] = (dm_real)(most > 0 ? most * most : -1);
}

static void dm_renew_bound(dm_scene_state *s, dm_neighbour *n) {
    dm_surface *f = s->surfaces + n->surface;
    double x[3];
    int spent = 0;
    if (!(f->body || f->prop) || n->renewed == s->renewal) return;
    n->renewed = s->renewal;
    dm_world_of(s, f, n->vertex, x);
    dm_set_bound(s, f, n->vertex, x, dm_room_of(s, n->vertex, x, &spent));
}

/* Renew the planes that what was held back, or has come near to them, has used up, where things are now: it may go on
 * from there in the next substep. What is stiff goes far in a substep: all its planes are renewed. */
static void dm_renew_planes(dm_scene_state *s) {
    s->renewal = s->renewal < UINT32_MAX ? s->renewal + 1 : 2; /* 0: as at the query */
    uint32_t count;
    for (uint32_t h = 0; h < s->held_count && !s->due; h++) {
        const dm_neighbour *n = s->near + s->held[h];
        const uint32_t *mine = dm_pairs_of(s, n, &count);
        double x[3], way[3];
        dm_world_of(s, s->surfaces + n->surface, n->vertex, x);
        dm_minus(x, s->before[n->vertex], way);
        double gone = sqrt(dm_inner3(way, way)), stride = dm_stride_of(s, n);
        for (uint32_t k = 0; k < count; k++) {
            int spent = s->planes[mine[k] / 4].stiff;
            dm_left_of(s, mine[k], x, gone, stride, &spent);
            if (spent) dm_renew_plane(s, s->pairs + mine[k] / 4);
        }
    }
    for (uint32_t h = 0; h < s->held_count && !s->due; h++) {
        const uint32_t *mine = dm_pairs_of(s, s->near + s->held[h], &count);
        dm_renew_bound(s, s->near + s->held[h]);
        for (uint32_t k = 0; k < count; k++) {
            const dm_pair *p = s->pairs + mine[k] / 4;
            int renewed = s->planes[mine[k] / 4].renewed == s->renewal;
            for (int j = 0; renewed && j < 4; j++) dm_renew_bound(s, s->near + p->at[j]);
        }
    }
    s->held_count = 0;
}

/* Hold a vertex of a body back, and take the speed with which it would go on; what of momentum that takes is counted. */
static void dm_bound_vertex(dm_scene_state *s, dm_surface *f, uint32_t i) {
    dm_state *b = f->body;
    uint32_t vertex = f->first + i;
    double x[3], at[3], back[3];
    dm_world_of(s, f, vertex, x);
    int spent = s->place[vertex] == DM_NO_VERTEX;
    double room = dm_room_of(s, vertex, x, &spent);
    if (room >= 0) { /* most have moved along their planes, and keep them */
        if (spent) dm_note_held(s, vertex);
        else dm_set_bound(s, f, vertex, x, room);
        return;
    }
    memcpy(at, x, sizeof at);
    dm_hold_back(s, f, vertex, at);
    dm_record *r = b->records + i;
    double local[3];
    dm_minus(at, b->origin, local);
    dm_quad rounded = dm_quad_of(local);
    for (int c = 0; c < 3; c++) at[c] = b->origin[c] + (double)rounded[c];
    if (!dm_is_allowed(s, vertex, at)) {
        if (s->place[vertex] != DM_NO_VERTEX) dm_last_of(s, f, s->near + s->place[vertex], at);
        else memcpy(at, s->before[vertex], sizeof at);
        dm_minus(at, b->origin, local), rounded = dm_quad_of(local);
    }
    dm_minus(at, x, back);
    double length = sqrt(dm_inner3(back, back)), against = 0;
    for (int c = 0; c < 3 && length > 0; c++) against += (double)r->v[c] * back[c] / length;
    dm_quad v = r->v;
    if (against < 0) {
        for (int c = 0; c < 3; c++) v[c] -= (dm_real)(against * back[c] / length);
        if (b->inverse_mass[i] > 0) s->out->taken -= against / (double)b->inverse_mass[i];
    }
    dm_set_vertex(b, i, rounded, v);
    b->pins_met |= !(b->inverse_mass[i] > 0);
    s->out->truncated++, dm_note_held(s, vertex);
}

/* Hold the vertices of a group to their bounds; return how far each may go before they are looked at again. */
DM_INLINE dm_lanes dm_bound_group(dm_scene_state *s, dm_surface *f, int64_t g) {
    const dm_state *b = f->body;
    dm_vec3 way = dm_sub(b->state[g].x, f->before[g]);
    dm_lanes square = dm_dot(way, way);
    dm_mask far = (dm_mask)(square > f->bound[g]);
    if (dm_any_of(far))
        for (uint32_t l = 0; l < DM_LANES; l++)
            if (far[l] && g * DM_LANES + l < b->n) dm_bound_vertex(s, f, (uint32_t)g * DM_LANES + l);
    if (dm_any_of((dm_mask)(square > f->due[g]))) s->due = 1;
    dm_lanes most = dm_vmax(-dm_vmax(-f->bound[g], -f->due[g]), dm_splat(0));
    return dm_vsqrt(most) - dm_vsqrt(square);
}

/* Hold every vertex of a body to its bounds. None is looked at while they all together cannot have used up what was left
 * when they were; what is near something has little left, and is looked at more often. */
static void dm_bound_body(dm_scene_state *s, dm_surface *f) {
    double near_way = f->body->near_way > f->met_way ? f->body->near_way : f->met_way;
    f->left -= f->body->way, f->near_left -= near_way;
    int all = !(f->left > 0) || f->body->finger_count;
    if (!all && f->near_left > 0) return;
    dm_lanes left = dm_splat(-INFINITY), near_left = left; /* negative: the least is sought */
    const uint32_t *near = f->near_groups, *end = near + f->near_group_count;
    for (int64_t g = 0; all && g < f->body->groups; g++) {
        if (near < end && *near == g) near_left = dm_vmax(near_left, -dm_bound_group(s, f, g)), near++;
        else left = dm_vmax(left, -dm_bound_group(s, f, g));
    }
    for (; near < end; near++) near_left = dm_vmax(near_left, -dm_bound_group(s, f, *near));
    f->near_left = -dm_most_of(near_left);
    if (all) f->left = -dm_most_of(left);
}

/* Move a collider on its way; where something that it presses cannot get away, it waits. */
static void dm_move_collider(dm_scene_state *s, dm_surface *f, double share) {
    for (uint32_t i = f->first; i < f->first + f->count && f->moving; i++) {
        double x[3], way[3];
        for (int c = 0; c < 3; c++) x[c] = s->here[i][c] + share * (s->aim[i][c] - s->here[i][c]);
        memcpy(way, x, sizeof x);
        if (!dm_is_allowed(s, i, x)) {
            dm_hold_back(s, f, i, x);
            if (!dm_is_allowed(s, i, x)) memcpy(x, s->here[i], sizeof x);
            if (s->place[i] != DM_NO_VERTEX) dm_note_held(s, i);
        }
        dm_minus(way, x, way);
        double late = sqrt(dm_inner3(way, way)), gone = 0;
        s->out->held_back = late > s->out->held_back ? late : s->out->held_back;
        for (int c = 0; c < 3; c++) {
            s->rate[i][c] = (x[c] - s->here[i][c]) / s->dt, s->here[i][c] = x[c];
            gone += (x[c] - s->before[i][c]) * (x[c] - s->before[i][c]);
        }
        if (gone > s->stale[i] * s->stale[i]) s->due = 1;
    }
}
