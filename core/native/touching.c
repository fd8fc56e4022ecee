/* What touches: in each substep, impulses that let nothing go nearer than the distance at which it touches, with Coulomb
 * friction; and what is nearer all the same is brought apart, without a speed. Source: core/body/touching.py.
 *
 * For a pair at distance d (r: where it touches), with relative speed u along its normal, and g = 1 / mass of the two:
 *     j = max(0, (w - u) / g)   with   w = -(d - r) / h where d > r, and 0 where it is nearer
 * so that after the substep h it is not nearer than r, or no nearer than before. Its nearest points and its normal are
 * kept until what is near has moved by a part of r. The pairs are taken one after the other, in an order that does not
 * depend on where they lie in memory. What sticks goes back to where it stuck first, so that it does not creep: an
 * anchor, which follows where it slides.
 */
#include "scene.h"

/* Where a near vertex has gone since the last look. */
DM_INLINE dm_quad dm_way_of(const dm_scene_state *s, const dm_surface *f, const dm_neighbour *n) {
    if (f->body) return f->body->records[n->vertex - f->first].x - n->from;
    double way[3];
    dm_minus(s->here[n->vertex], n->there, way);
    return dm_quad_of(way);
}

DM_INLINE int dm_nearer_towards(const dm_scene_state *s, const dm_surface *g, uint32_t vertex, const double *point,
                                const double *between) {
    double x[3], arm[3];
    dm_world_of(s, g, vertex, x);
    dm_minus(x, point, arm);
    return dm_inner3(arm, between) > 0;
}

/* Is the nearest point of this face the nearest of the surface round it? On its border, a face beside it may be nearer,
 * and has a pair of its own. */
static int dm_is_nearest(const dm_scene_state *s, const dm_pair *p, const double *w, const double *between) {
    const dm_surface *g = dm_surface_of(s, p, 3);
    double point[3];
    int zero = 0, on = 0, off = 0;
    for (int k = 0; k < 3; k++) {
        if (w[1 + k] < 0) on = k;
        else zero++, off = k;
    }
    if (!zero) return 1;
    dm_minus(s->near[p->at[0]].there, between, point);
    if (zero == 1) { /* on the edge opposite corner `off`, which begins at the next corner */
        uint32_t triangle = s->close[0][p->close].parts[0];
        uint32_t edge = s->edges_of[triangle][(off + 1) % 3], own = s->near[p->at[1 + off]].vertex;
        uint32_t other = s->across[edge][0] == own ? s->across[edge][1] : s->across[edge][0];
        return other == DM_NO_VERTEX || !dm_nearer_towards(s, g, other, point, between);
    }
    uint32_t corner = s->near[p->at[1 + on]].vertex;
    for (uint32_t k = s->ring_start[corner]; k < s->ring_start[corner + 1]; k++)
        if (dm_nearer_towards(s, g, s->ring[k], point, between)) return 0;
    return 1;
}

/* Add what the meetings passed on to what their surfaces got. */
static void dm_sum_meetings(dm_scene_state *s) {
    for (dm_meeting *m = s->meetings; m < s->meetings + s->meeting_count; m++) {
        double impulse[3] = {m->sum[0], m->sum[1], m->sum[2]}, moment[3];
        dm_cross3(m->point, impulse, moment);
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 3; c++) {
                s->surfaces[m->surface[k]].impulse[c] += k ? -impulse[c] : impulse[c];
                s->surfaces[m->surface[k]].moment[c] += k ? -moment[c] : moment[c];
            }
        m->sum = (dm_quad){0, 0, 0, 0};
    }
}

/* Note where the nearest points of a pair are; return 0 where it cannot touch before the next look. */
static int dm_look_at(const dm_scene_state *s, const dm_candidate *candidate, dm_meeting *m) {
    const dm_pair *p = s->pairs + candidate->pair;
    const double *x[4];
    double w[4], between[3], give = 0, most = candidate->touch + s->approach;
    for (int j = 0; j < 4; j++) x[j] = s->near[p->at[j]].there;
    double gap = dm_measure_pair(x, p->ones, w, between);
    if (!(gap < most) || !(gap > 0)) return 0;
    if (p->ones == 1 ? !dm_is_nearest(s, p, w, between) : !(w[0] > 0 && w[1] > 0 && w[2] < 0 && w[3] < 0)) return 0;
    for (int j = 0; j < 4; j++) give += w[j] * w[j] * (double)s->near[p->at[j]].v[3];
    if (!(give > 0)) return 0;
    double mu = sqrt(dm_friction_of(s, p, 0, p->ones, w) * dm_friction_of(s, p, p->ones, 4, w));
    *m = (dm_meeting){.gap = (dm_real)gap, .touch = (dm_real)candidate->touch, .friction = (dm_real)mu,
                      .give = (dm_real)give, .share = (dm_real)candidate->weight};
    for (int c = 0; c < 3; c++) {
        m->normal[c] = (dm_real)(between[c] / gap);
        for (uint32_t j = 0; j < p->ones; j++) m->point[c] += w[j] * x[j][c];
    }
    for (int j = 0; j < 4; j++) m->at[j] = p->at[j], m->weight[j] = (dm_real)w[j];
    m->surface[0] = s->near[p->at[0]].surface, m->surface[1] = s->near[p->at[3]].surface;
    return 1;
}

/* Look where the nearest points are of all pairs that may touch. */
static void dm_look(dm_scene_state *s) {
    double far = 0;
    dm_sum_meetings(s);
    s->meeting_count = 0, s->looks = 0;
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        double way[3];
        dm_world_of(s, f, n->vertex, n->there);
        if (f->body) n->from = f->body->records[n->vertex - f->first].x;
        n->way = (dm_quad){0, 0, 0, 0};
        n->v[3] = f->body ? f->body->inverse_mass[n->vertex - f->first] : 0;
        dm_minus(n->there, s->before[n->vertex], way);
        double square = dm_inner3(way, way);
        far = square > far ? square : far;
    }
    double travel = 2 * sqrt(far);
    for (uint32_t k = 0; k < s->candidate_count; k++) {
        const dm_candidate *c = s->candidates + k;
        if (c->gap - travel > c->touch + s->approach) continue;
        s->meetings = dm_grown(s, s->meetings, s->meeting_count, &s->meeting_room, sizeof *s->meetings);
        if (!dm_has_room(s)) return;
        s->meeting_count += dm_look_at(s, c, s->meetings + s->meeting_count);
    }
    if (s->active_room < s->meeting_room) {
        dm_free(s->active);
        s->active = dm_alloc(s->meeting_room, sizeof *s->active), s->active_room = s->active ? s->meeting_room : 0;
        if (!s->active) s->code = DM_MEMORY, s->meeting_count = 0;
    }
}

/* Before a substep: note where everything near is, and look again where that has moved. */
static void dm_begin_contact(dm_scene_state *s) {
    dm_real far = 0;
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        if (f->body) n->last = f->body->records[n->vertex - f->first].x;
        n->way = dm_way_of(s, f, n);
        dm_real square = dm_dot3(n->way, n->way);
        far = square > far ? square : far;
    }
    if (s->looks || (double)far > DM_LOOK * DM_LOOK * s->touch * s->touch) dm_look(s), s->wakes = 1;
}

DM_INLINE dm_quad dm_speed_of(const dm_scene_state *s, const dm_meeting *m) {
    const dm_neighbour *n = s->near;
    return m->weight[0] * n[m->at[0]].v + m->weight[1] * n[m->at[1]].v + m->weight[2] * n[m->at[2]].v +
           m->weight[3] * n[m->at[3]].v;
}

/* Add to the impulse of a meeting so much that it goes no nearer than it may, and slides no more than friction lets it. */
DM_INLINE void dm_resolve_meeting(dm_scene_state *s, dm_meeting *m, dm_quad u) {
    dm_real along = dm_dot3(u, m->normal), by = m->share / m->give;
    dm_real push = m->push + by * (m->least - along);
    push = push > 0 ? push : 0;
    dm_quad drag = m->drag - by * (u - along * m->normal + m->back);
    dm_real square = dm_dot3(drag, drag), most = m->friction * push;
    if (square > most * most) drag *= most / DM_SQRT(square);
    dm_quad more = (push - m->push) * m->normal + drag - m->drag;
    more[3] = 0;
    m->push = push, m->drag = drag;
    for (int j = 0; j < 4; j++) {
        dm_neighbour *n = s->near + m->at[j];
        n->v += m->weight[j] * n->v[3] * more;
    }
}

/* Where a meeting would go nearer than it touches within the substep: begin with it. */
static void dm_begin_meeting(dm_scene_state *s, uint32_t k) {
    dm_meeting *m = s->meetings + k;
    dm_quad u = dm_speed_of(s, m), way = {0, 0, 0, 0};
    for (int j = 0; j < 4; j++) way += m->weight[j] * s->near[m->at[j]].way;
    dm_real h = (dm_real)s->dt;
    dm_real towards = dm_dot3(way, m->normal);
    way -= towards * m->normal, m->begin = m->gap + towards;
    if (!(m->begin + h * dm_dot3(u, m->normal) < m->touch)) {
        m->anchor = way;
        return;
    }
    m->back = (dm_real)DM_BACK / h * (way - m->anchor);
    m->least = m->begin > m->touch ? (m->touch - m->begin) / h : 0;
    m->push = 0, m->drag = (dm_quad){0, 0, 0, 0};
    for (int j = 0; j < 4; j++) s->near[m->at[j]].met = 1;
    s->active[s->active_count++] = k;
    dm_resolve_meeting(s, m, u);
}

/* Bring apart what is nearer than it touches. */
static void dm_part_meeting(dm_scene_state *s, dm_meeting *m) {
    dm_quad way = (dm_real)s->dt * dm_speed_of(s, m);
    for (int j = 0; j < 4; j++) way += m->weight[j] * s->near[m->at[j]].out;
    dm_real short_of = m->touch - m->begin - dm_dot3(way, m->normal);
    if (short_of > 0) {
        dm_real by = m->share * (dm_real)DM_PART * short_of / m->give;
        for (int j = 0; j < 4; j++) {
            dm_neighbour *n = s->near + m->at[j];
            n->out += m->weight[j] * n->v[3] * by * m->normal;
        }
    }
    m->sum += m->push * m->normal + m->drag;
    dm_real most = m->friction * m->push * (dm_real)(1 - DM_ROUNDING);
    if (dm_dot3(m->drag, m->drag) >= most * most) m->anchor += (dm_real)s->dt / (dm_real)DM_BACK * m->back;
}

/* After bodies and colliders have moved: resolve what touches. */
static void dm_resolve_touching(dm_scene_state *s) {
    s->active_count = 0;
    if (!s->meeting_count) return;
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        dm_real inverse_mass = n->v[3];
        n->v = f->body ? f->body->records[n->vertex - f->first].v : dm_quad_of(s->rate[n->vertex]);
        n->v[3] = inverse_mass;
        n->out = (dm_quad){0, 0, 0, 0}, n->met = 0;
    }
    int asleep = 0;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) asleep |= dm_sleeps(f);
    for (uint32_t k = 0; k < s->meeting_count; k++) {
        const uint32_t *of = s->meetings[k].surface;
        if (!asleep || !(dm_sleeps(s->surfaces + of[0]) || dm_sleeps(s->surfaces + of[1]))) dm_begin_meeting(s, k);
    }
    for (int sweep = 1; sweep < DM_CONTACT_SWEEPS; sweep++)
        for (uint32_t k = 0; k < s->active_count; k++) {
            dm_meeting *m = s->meetings + s->active[k];
            dm_resolve_meeting(s, m, dm_speed_of(s, m));
        }
    for (uint32_t k = 0; k < s->active_count; k++) dm_part_meeting(s, s->meetings + s->active[k]);
    for (const dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        if (!n->met || !(n->v[3] > 0)) continue;
        uint32_t i = n->vertex - f->first;
        const dm_record *r = f->body->records + i;
        dm_quad v = n->v;
        v[3] = 0;
        dm_set_vertex(f->body, i, r->x + (dm_real)s->dt * (v - r->v) + n->out, v);
    }
    s->out->touching = s->active_count > s->out->touching ? s->active_count : s->out->touching;
}
