/* After each substep: nothing that meets may be beyond its planes. Skin is brought back, and what is rigid goes a smaller
 * share of its way where the skin has no room. Source: studies/reference/bounds.py. */
#include "scene.h"

/* Shorten the displacement of a vertex since the query to the greatest one allowed. */
static void dm_shorten(const dm_surface *f, const double *from, double *x) {
    double way[3], most = f->slack * (1 - DM_ROUNDING);
    dm_minus(x, from, way);
    double length = sqrt(dm_inner3(way, way));
    for (int c = 0; c < 3 && length > most; c++) x[c] = from[c] + way[c] * (most / length);
}

/* Bring a vertex of a body to an allowed place by some sweeps of projection on its planes, so that it can still slide
 * along them; return whether the place is allowed. */
static int dm_bring_back(dm_scene_state *s, const dm_surface *f, uint32_t vertex, double *x) {
    uint32_t count = 0;
    int near = s->place[vertex] != DM_NO_VERTEX, moved = 1;
    const uint32_t *mine = near ? dm_pairs_of(s, s->place[vertex], &count) : NULL;
    double way[3], margin = DM_ROUNDING * f->body->size; /* for rounding to single precision */
    for (int sweep = 0; sweep <= DM_TRIES && moved; sweep++) {
        double local[3];
        if (sweep) dm_shorten(f, s->before[vertex], x);
        moved = 0;
        for (uint32_t k = 0; k < count && sweep < DM_TRIES; k++) {
            const dm_plane *plane = s->planes + mine[k] / 4;
            double left = dm_left_at(s, mine[k], x), by = mine[k] % 4 < s->pairs[mine[k] / 4].ones ? 1 : -1;
            if (!(left < 0)) continue;
            for (int c = 0; c < 3; c++) x[c] += by * (margin - left) * plane->normal[c];
            moved = 1;
        }
        dm_minus(x, f->body->origin, local);
        dm_quad rounded = dm_quad_of(local);
        for (int c = 0; c < 3; c++) x[c] = f->body->origin[c] + (double)rounded[c];
    }
    dm_minus(x, s->before[vertex], way);
    int allowed = dm_inner3(way, way) <= f->slack * f->slack;
    for (uint32_t k = 0; k < count && allowed; k++) allowed = dm_left_at(s, mine[k], x) >= 0;
    return allowed;
}

DM_INLINE int dm_goes(const dm_surface *f) { return f->prop ? !f->prop->asleep : f->moving; }

/* Return the rigid surface with which the plane of a pair moves, null if both sides are soft. */
DM_INLINE dm_surface *dm_rigid_beside(const dm_scene_state *s, uint32_t which) {
    const dm_pair *p = s->pairs + which / 4;
    return p->rigid ? s->surfaces + s->near[p->at[p->rigid & 1 ? 0 : 3]].surface : NULL;
}

/* Return the rigid surface whose plane a vertex at x exceeds the most, or null; way: its displacement in this
 * substep [m]. */
static dm_surface *dm_pusher_of(const dm_scene_state *s, uint32_t near, const double *x, double *way) {
    uint32_t count, worst = DM_NO_VERTEX;
    const uint32_t *mine = dm_pairs_of(s, near, &count);
    double least = 0, at[4][3], w[4], between[3];
    for (uint32_t k = 0; k < count; k++) {
        double left = dm_left_at(s, mine[k], x);
        if (left < least && s->pairs[mine[k] / 4].rigid) least = left, worst = mine[k];
    }
    memset(way, 0, 3 * sizeof *way);
    if (worst == DM_NO_VERTEX) return NULL;
    const dm_pair *p = s->pairs + worst / 4;
    for (uint32_t j = 0; j < 4; j++) dm_corner(s, p, j, at[j]);
    dm_measure_pair((const double(*)[3])at, dm_four, p->ones, w, between);
    dm_surface *g = dm_rigid_beside(s, worst);
    for (uint32_t j = 0; j < 4 && dm_goes(g); j++) {
        const dm_neighbour *n = s->near + p->at[j];
        for (int c = 0; c < 3 && s->surfaces + n->surface == g; c++) way[c] += fabs(w[j]) * s->dt * s->rate[n->vertex][c];
    }
    return g;
}

/* Mark as stuck the moving rigid surfaces that a vertex at x, its place before this substep, cannot avoid. */
static void dm_note_stuck(dm_scene_state *s, uint32_t near, const double *x) {
    uint32_t count;
    const uint32_t *mine = dm_pairs_of(s, near, &count);
    for (uint32_t k = 0; k < count; k++) {
        dm_surface *g = dm_rigid_beside(s, mine[k]);
        if (!g || !dm_goes(g) || !(g->share > 0) || dm_left_at(s, mine[k], x) >= 0) continue;
        g->stuck = 1, memcpy(g->place, x, sizeof g->place);
    }
}

/* Move a vertex of a body from x to an allowed place. Along that correction its velocity becomes at least that of the
 * surface that pushes it, and no longer points back; the momentum of the change is counted. */
static void dm_put_vertex(dm_scene_state *s, dm_surface *f, uint32_t vertex, const double *x, const double *at,
                          dm_surface *pusher, const double *way) {
    dm_state *b = f->body;
    double back[3], local[3], j[3], moment[3], along = 0, least = 0;
    uint32_t i = vertex - f->first;
    dm_quad v = b->records[i].v;
    dm_minus(at, x, back);
    double length = sqrt(dm_inner3(back, back));
    for (int c = 0; c < 3 && length > 0; c++) {
        back[c] /= length, along += (double)v[c] * back[c], least += way[c] * back[c] / s->dt;
    }
    double change = fmax(least, 0) - along, mass = b->inverse_mass[i] > 0 ? 1 / (double)b->inverse_mass[i] : 0;
    if (change > 0) {
        for (int c = 0; c < 3; c++) v[c] += (dm_real)(change * back[c]), j[c] = mass * change * back[c];
        dm_cross3(at, j, moment);
        for (int c = 0; c < 3 && pusher; c++) {
            f->impulse[c] += j[c], f->moment[c] += moment[c], pusher->impulse[c] -= j[c], pusher->moment[c] -= moment[c];
        }
        if (pusher && pusher->prop) dm_answer_prop(pusher->prop, at, j, -1);
        s->out->taken += mass * change;
    }
    dm_minus(at, b->origin, local);
    dm_set_vertex(b, i, dm_quad_of(local), v);
    b->pins_met |= !(b->inverse_mass[i] > 0);
    s->out->truncated++;
}

/* Bring a vertex of a body to its side of its planes: by sliding along them, or else by moving with the surface that
 * pushes it, or else back to its place before this substep. If that is not allowed either, the pushing surface is
 * stuck. */
static void dm_settle(dm_scene_state *s, dm_surface *f, uint32_t vertex) {
    double x[3], at[3], last[3], way[3] = {0};
    uint32_t count = 0, near = s->place[vertex];
    const uint32_t *mine = near == DM_NO_VERTEX ? NULL : dm_pairs_of(s, near, &count);
    dm_world_of(s, f, vertex, x), memcpy(at, x, sizeof at), memcpy(last, s->before[vertex], sizeof last);
    for (uint32_t k = 0; k < count; k++) {
        const dm_pair *p = s->pairs + mine[k] / 4;
        dm_plane *plane = s->planes + mine[k] / 4;
        double along[4];
        if (p->rigid) dm_find_along(s, p, plane->normal, along), dm_move_plane(p, plane, along);
        s->next[mine[k] / 4] = 0;
    }
    dm_surface *pusher = count ? dm_pusher_of(s, near, x, way) : NULL;
    for (int c = 0; c < 3 && count; c++) last[c] = f->body->origin[c] + (double)s->near[near].last[c];
    int pinned = !(f->body->inverse_mass[vertex - f->first] > 0), allowed = dm_bring_back(s, f, vertex, at);
    if (pinned) { /* a pin may slide, but not be pushed farther than it moved itself */
        double gone[3], own[3];
        dm_minus(at, last, gone), dm_minus(x, last, own);
        allowed = allowed && dm_inner3(gone, gone) <= dm_inner3(own, own);
    }
    if (!allowed && pusher && !pinned) {
        for (int c = 0; c < 3; c++) at[c] = last[c] + way[c];
        allowed = dm_bring_back(s, f, vertex, at);
    }
    if (!allowed) {
        memcpy(at, last, sizeof at);
        if (count) dm_note_stuck(s, near, at);
    }
    if (f->body->asleep && allowed) s->wakes = f->pressed = 1;
    if (!f->body->asleep || allowed) dm_put_vertex(s, f, vertex, x, at, pusher, way);
}

static void dm_note_held(dm_scene_state *s, uint32_t near) {
    if (s->near[near].held || !s->near[near].body) return;
    s->held = dm_grown(s, s->held, s->held_count, &s->held_room, sizeof *s->held);
    if (dm_has_room(s)) s->near[near].held = 1, s->held[s->held_count++] = near;
}

/* Check whether both sides of a pair are on their own sides of its plane, and set when to check again. */
static void dm_check_pair(dm_scene_state *s, const dm_run *run, uint32_t pair) {
    const dm_pair *p = s->pairs + pair;
    dm_plane *plane = s->planes + pair;
    double along[4], least = INFINITY, left[4];
    dm_find_along(s, p, plane->normal, along);
    if (p->rigid) dm_move_plane(p, plane, along);
    else dm_centre_plane(s, p, plane, along);
    for (uint32_t j = 0; j < 4; j++) {
        left[j] = INFINITY;
        if (p->rigid & (j < p->ones ? 1 : 2) && (p->rigid != 3 || j < p->ones)) continue;
        left[j] = dm_left_of(plane, j < p->ones, along[j]);
        least = left[j] < least ? left[j] : least;
    }
    s->next[pair] = least < 0 ? 0 : run->gone + least;
    if (least < plane->keep) {
        s->spent = dm_grown(s, s->spent, s->spent_count, &s->spent_room, sizeof *s->spent);
        if (dm_has_room(s)) s->spent[s->spent_count++] = pair;
    }
    if (least >= 0) return;
    for (uint32_t j = 0; j < 4; j++)
        if (left[j] < 0 && p->rigid != 3) dm_note_held(s, p->at[j]);
    for (int k = 0; k < 2 && p->rigid == 3; k++) {
        dm_surface *f = s->surfaces + s->near[p->at[k ? 3 : 0]].surface;
        if (dm_goes(f) && f->share > 0) f->stuck = 1, dm_corner(s, p, 0, f->place);
    }
}

/* Move a collider or a prop by its share of its motion in this substep. */
static void dm_go(dm_scene_state *s, dm_surface *f) {
    double pose[12];
    f->way = f->gone = 0, f->fitted = 0;
    if (f->prop) dm_find_pose(f->prop, s->dt, f->share, pose), dm_find_places(f->prop, pose, s->rate + f->first);
    for (uint32_t i = f->first; i < f->first + f->count; i++) {
        double *here = s->here[i], *was = s->was[i], *to = s->rate[i], way[3], gone[3];
        for (int c = 0; c < 3 && !f->prop; c++) to[c] = was[c] + f->share * f->pace_now * (s->aim[i][c] - was[c]);
        if (!(f->share > 0)) memcpy(to, was, sizeof way);
        dm_minus(to, here, way), dm_minus(to, s->before[i], gone), memcpy(here, to, sizeof way);
        f->way = fmax(f->way, dm_inner3(way, way)), f->gone = fmax(f->gone, dm_inner3(gone, gone));
        for (int c = 0; c < 3; c++) to[c] = (here[c] - was[c]) / s->dt;
    }
    f->way = sqrt(f->way), f->gone = sqrt(f->gone);
}

/* Bring back vertices that have moved too far since the query, and note whether the next one is due: because of how far
 * they have moved, or because they may move too far in the next substep. */
static void dm_watch_way(dm_scene_state *s, dm_surface *f) {
    const dm_state *b = f->body;
    const dm_vec3 *noted = s->noted + f->first / DM_LANES;
    f->stuck = 0;
    if (b && (!b->asleep || f->pressed)) f->gone = dm_greatest_way(b, noted);
    if (!b && f->gone > f->slack) f->stuck = dm_goes(f) && f->share > 0;
    if (b && f->gone > f->slack) {
        for (uint32_t i = f->first; i < f->first + b->n; i++) {
            double x[3], way[3];
            dm_world_of(s, f, i, x), dm_minus(x, s->before[i], way);
            if (!(dm_inner3(way, way) <= f->slack * f->slack)) dm_settle(s, f, i);
        }
        f->gone = dm_greatest_way(b, noted);
    }
    s->due |= f->gone > f->stale || f->gone + dm_next_way(s) > f->slack;
}

/* Find how far the skin that is near something has moved in this substep, after contact has brought it back. */
static void dm_find_ways(dm_scene_state *s) {
    for (const dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        if (!n->body) continue;
        dm_quad way = n->body->x - n->last;
        double square = (double)dm_dot3(way, way), *most = &s->surfaces[n->surface].way;
        if (square > *most * *most) *most = sqrt(square);
    }
}

/* Check the pairs of two surfaces that have come far enough: towards a plane that moves with one of them, both count;
 * towards one between two bodies, each for itself. */
static void dm_check_run(dm_scene_state *s, dm_run *run) {
    const dm_surface *f = s->surfaces + run->first, *g = s->surfaces + run->second;
    double way = f->body && g->body ? fmax(f->way, g->way) : f->way + g->way;
    run->gone += way;
    for (uint32_t pair = run->start; way > 0 && pair < run->end; pair++)
        if (!(s->next[pair] > run->gone)) dm_check_pair(s, run, pair);
}

/* Halve the share of its motion that a rigid surface covers where skin cannot get away; return whether any is. */
static int dm_hold_back(dm_scene_state *s) {
    int any = 0;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        f->way = 0;
        if (!f->stuck) continue;
        f->share = f->share > DM_LEAST_WAY * f->tried ? f->share / 2 : 0;
        dm_go(s, f), any = 1;
    }
    return any;
}

/* Keep the skin ahead of everything that has moved, on its own side of its planes. Where it cannot get away, rigid
 * surfaces are held back, again and again. */
static void dm_keep_apart(dm_scene_state *s) {
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) dm_watch_way(s, f);
    dm_find_ways(s);
    for (int again = 1; again && dm_has_room(s);) {
        for (uint32_t k = 0; k < s->run_count; k++) dm_check_run(s, s->runs + k);
        for (uint32_t k = 0; k < s->held_count; k++) {
            dm_neighbour *n = s->near + s->held[k];
            dm_settle(s, s->surfaces + n->surface, n->vertex), n->held = 0;
        }
        s->held_count = 0, again = dm_hold_back(s);
        for (dm_surface *f = s->surfaces; again && f < s->surfaces + s->surface_count; f++) dm_watch_way(s, f);
    }
    for (uint32_t k = 0; k < s->spent_count; k++) dm_renew_plane(s, s->spent[k]);
    s->spent_count = 0;
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++)
        if (n->body) n->last = n->body->x;
}
