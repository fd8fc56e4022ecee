/* The pairs of surfaces that may touch until they are listed again, by their nearest points.
 * Source: studies/reference/touching.py. */
#include "scene.h"

DM_INLINE int dm_nearer_towards(const dm_scene_state *s, const dm_surface *g, uint32_t vertex, const double *point,
                                const double *between) {
    double x[3], arm[3];
    dm_world_of(s, g, vertex, x);
    dm_minus(x, point, arm);
    return dm_inner3(arm, between) > 0;
}

/* Return whether the nearest point of a face is also the nearest of the surface round it. On the border of the face a
 * neighbouring face, which has a pair of its own, may be nearer. */
static int dm_is_nearest(const dm_scene_state *s, const dm_pair *p, const double *w, const double *between) {
    const dm_surface *g = dm_surface_of(s, p, 3);
    double point[3];
    int zero = 0, on = 0, off = 0;
    for (int k = 0; k < 3; k++) {
        if (w[1 + k] < -DM_EXACT) on = k;
        else zero++, off = k;
    }
    if (!zero) return 1;
    dm_minus(s->there[p->at[0]], between, point);
    if (zero == 1) { /* on the edge opposite corner `off`, which begins at the next corner */
        uint32_t triangle = p->parts[0];
        uint32_t edge = s->edges_of[triangle][(off + 1) % 3], own = s->near[p->at[1 + off]].vertex;
        uint32_t other = s->across[edge][0] == own ? s->across[edge][1] : s->across[edge][0];
        return other == DM_NO_VERTEX || !dm_nearer_towards(s, g, other, point, between);
    }
    uint32_t corner = s->near[p->at[1 + on]].vertex;
    for (uint32_t k = s->ring_start[corner]; k < s->ring_start[corner + 1]; k++)
        if (dm_nearer_towards(s, g, s->ring[k], point, between)) return 0;
    return 1;
}

/* Return how much the border of a face acts on a vertex. 1 if the surface of the vertex slopes away, or rises, on both
 * sides; 0 if it runs through, from a neighbour that is nearer to one that is farther: then another pair is nearer, and
 * this one would only stop sliding. */
static double dm_share_of_border(const dm_scene_state *s, const dm_pair *p, const double *between, double gap) {
    const dm_neighbour *n = s->near + p->at[0];
    uint32_t start = s->ring_start[n->vertex], end = s->ring_start[n->vertex + 1];
    double nearer[3] = {0}, least = 0, across = INFINITY, falls = 0;
    for (int opposite = 0; opposite < 2; opposite++)
        for (uint32_t k = start; k < end; k++) {
            double x[3], arm[3];
            dm_world_of(s, s->surfaces + n->surface, s->ring[k], x);
            dm_minus(x, s->there[p->at[0]], arm);
            double length = sqrt(dm_inner3(arm, arm));
            for (int c = 0; c < 3; c++) arm[c] = length > 0 ? arm[c] / length : 0;
            double slope = dm_inner3(arm, between) / gap, along = dm_inner3(arm, nearer);
            if (!opposite && slope < least) least = slope, memcpy(nearer, arm, sizeof arm);
            if (opposite && along < across) across = along, falls = slope;
        }
    double through = falls < -least ? falls : -least;
    return 1 - dm_share_of(through / DM_FLAT);
}

/* List a pair, whose nearest points are known, if it may touch before the pairs are listed again. */
static void dm_note_meeting(dm_scene_state *s, const dm_pair *p, double gap, const double *w, const double *between) {
    if (!(gap < p->touch + s->approach) || !(gap > 0)) return;
    if (p->ones == 1 ? !dm_is_nearest(s, p, w, between) : !(w[0] > 0 && w[1] > 0 && w[2] < 0 && w[3] < 0)) return;
    dm_meeting m = {.ones = p->ones, .touch = p->touch, .share = p->weight};
    double give = 0;
    if (p->ones == 1 && !(w[1] < -DM_EXACT && w[2] < -DM_EXACT && w[3] < -DM_EXACT))
        m.share = dm_share_of_border(s, p, between, gap);
    if (!(m.share > 0)) return;
    for (int j = 0; j < 4; j++)
        m.at[j] = p->at[j], m.weight[j] = w[j], give += (double)s->moving[p->at[j]].v[3];
    m.surface[0] = s->near[p->at[0]].surface, m.surface[1] = s->near[p->at[3]].surface;
    int soft = s->surfaces[m.surface[0]].body || s->surfaces[m.surface[1]].body;
    if (soft && !(give > 0)) return;
    m.friction = sqrt(dm_friction_of(s, p, 0, p->ones, w) * dm_friction_of(s, p, p->ones, 4, w));
    for (int c = 0; c < 3; c++) m.normal[c] = between[c] / gap;
    if (soft) dm_add_meeting(s, &m);
    else dm_add_support(s, &m);
}

/* Find the nearest points of up to eight candidates, all with a face or all of edges, and list those that may touch. */
static void dm_look_at(dm_scene_state *s, const dm_pair *const *some, uint32_t count) {
    const uint32_t *at[DM_LANES];
    dm_wide w[4];
    dm_wide_mask inside;
    for (uint32_t l = 0; l < DM_LANES; l++) at[l] = some[l < count ? l : count - 1]->at;
    dm_wide3 way = dm_wide_measure((const double(*)[3])s->there, at, some[0]->ones, w, &inside);
    dm_wide gap = dm_wide_root(dm_wide_dot(way, way));
    for (uint32_t l = 0; l < count && dm_has_room(s); l++)
        dm_note_meeting(s, some[l], gap[l], (double[]){w[0][l], w[1][l], w[2][l], w[3][l]},
                        (double[]){way.x[l], way.y[l], way.z[l]});
}

/* List the pairs that may touch again, by the nearest points of all candidates. */
static void dm_look(dm_scene_state *s) {
    double far = 0;
    dm_sum_meetings(s);
    s->batch_count = s->met_count = s->support_count = 0, s->looks = 0;
    memset(s->moving, 0, (s->near_count + 1) * sizeof *s->moving);
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        double way[3], *there = s->there[n - s->near];
        s->moving[n - s->near].v[3] = (dm_real)dm_give_of(s, n);
        dm_world_of(s, s->surfaces + n->surface, n->vertex, there);
        n->batch = 0;
        dm_minus(there, s->before[n->vertex], way);
        double square = dm_inner3(way, way);
        far = square > far ? square : far;
    }
    double travel = 2 * sqrt(far);
    const dm_pair *some[DM_LANES];
    uint32_t count = 0;
    for (uint32_t k = 0; k < s->candidate_count && dm_has_room(s); k++) {
        const dm_pair *p = s->pairs + s->candidates[k];
        if (p->gap - travel > p->touch + s->approach) continue;
        if (count == DM_LANES || (count && p->ones != some[0]->ones)) dm_look_at(s, some, count), count = 0;
        some[count++] = p;
    }
    if (count && dm_has_room(s)) dm_look_at(s, some, count);
    for (uint32_t k = 0; k < s->near_count && dm_has_room(s); k++)
        if (s->near[k].batch) s->met[s->met_count++] = k;
    s->looks = !dm_has_room(s);
}

/* Before a substep: note places and displacements of `near`, and list the pairs again if one has moved too far. */
static void dm_begin_contact(dm_scene_state *s) {
    dm_real far = 0;
    if (!dm_has_room(s)) return;
    for (uint32_t k = 0; k < s->near_count; k++) {
        dm_neighbour *n = s->near + k;
        dm_quad *to = &s->moving[k].x;
        double way[3];
        dm_world_of(s, s->surfaces + n->surface, n->vertex, s->now[k]);
        dm_minus(s->now[k], s->there[k], way), *to = dm_quad_of(way);
        dm_real square = dm_dot3(*to, *to);
        far = square > far ? square : far;
    }
    if (s->looks || (double)far > s->touch * s->touch / 4) dm_look(s), s->wakes = 1;
}

/* After bodies and colliders have moved: resolve the contacts of soft bodies. */
static void dm_resolve_touching(dm_scene_state *s) {
    if (!s->batch_count) return;
    for (const uint32_t *k = s->met; k < s->met + s->met_count; k++) {
        const dm_neighbour *n = s->near + *k;
        dm_quad *to = &s->moving[*k].v;
        dm_real give = (*to)[3];
        *to = n->body ? n->body->v : dm_quad_of(s->rate[n->vertex]), (*to)[3] = give;
    }
    int64_t touching = dm_resolve_meetings(s);
    for (const uint32_t *k = s->met; touching && k < s->met + s->met_count; k++) {
        const dm_neighbour *n = s->near + *k;
        const dm_surface *f = s->surfaces + n->surface;
        dm_quad v = s->moving[*k].v, out = s->moving[*k].x;
        v[3] = 0;
        if (!n->body || !(memcmp(&v, &n->body->v, sizeof v) || dm_dot3(out, out) > 0)) continue;
        dm_set_vertex(f->body, n->vertex - f->first, n->body->x + (dm_real)s->dt * (v - n->body->v) + out, v);
    }
    s->out->touching = touching > s->out->touching ? touching : s->out->touching;
}
