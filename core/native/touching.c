/* What touches pushes back: a stiff penalty with Coulomb friction in each substep. Source: core/body/touching.py.
 *
 * For a pair at distance d < r (touch), with relative speed u along its normal, and an impulse j whose effect is within
 * the substep h already: d' = d + h j g, u' = u + j g, where g is what the pair gives, 1/mass. From
 *     j = h (k (r - d') - c u'),   k = K / (h^2 g) r / d,   c = C / (h g)
 * follows j = (K r/d (r - d) / h - C u) / ((1 + K r/d + C) g): stable for any K, and the harder the nearer.
 * It leaves the pair no faster apart than r/d (r - d) in 5 ms: so what starts too near is not flung off.
 * A vertex in several pairs is shared between them, each taking an equal part of its mass, so pairs are independent.
 */
#include "scene.h"

static void dm_gather_near(dm_scene_state *s) {
    double far = 0;
    for (dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        double way[3];
        dm_world_of(s, f, n->vertex, n->x);
        if (f->body) {
            dm_velocity(f->body, n->vertex - f->first, n->v);
            n->inverse_mass = (double)f->body->inverse_mass[n->vertex - f->first];
        } else memcpy(n->v, s->rate[n->vertex], sizeof n->v);
        dm_minus(n->x, s->before[n->vertex], way);
        double square = dm_inner3(way, way);
        far = square > far ? square : far;
        n->shares = 0;
        memset(n->push, 0, sizeof n->push);
    }
    s->travel = sqrt(far);
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
static int dm_is_nearest(const dm_scene_state *s, const dm_meeting *m) {
    const dm_pair *p = m->pair;
    const dm_surface *g = s->surfaces + p->surface[1];
    double between[3], point[3];
    int zero = 0, on = 0, off = 0;
    for (int k = 0; k < 3; k++) {
        if (m->weight[1 + k] < 0) on = k;
        else zero++, off = k;
    }
    if (!zero) return 1;
    for (int c = 0; c < 3; c++)
        between[c] = m->normal[c] * m->gap, point[c] = s->near[p->at[0]].x[c] - between[c];
    if (zero == 1) { /* on the edge opposite corner `off`, which begins at the next corner */
        uint32_t edge = s->edges_of[p->triangle][(off + 1) % 3], own = s->near[p->at[1 + off]].vertex;
        uint32_t other = s->across[edge][0] == own ? s->across[edge][1] : s->across[edge][0];
        return other == DM_NO_VERTEX || !dm_nearer_towards(s, g, other, point, between);
    }
    uint32_t corner = s->near[p->at[1 + on]].vertex;
    for (uint32_t k = s->ring_start[corner]; k < s->ring_start[corner + 1]; k++)
        if (dm_nearer_towards(s, g, s->ring[k], point, between)) return 0;
    return 1;
}

static void dm_find_meetings(dm_scene_state *s) {
    s->meeting_count = 0;
    for (uint32_t k = 0; k < s->candidate_count; k++) {
        const dm_pair *p = s->pairs + s->candidates[k];
        if (p->gap - 2 * s->travel > p->touch) continue;
        s->meetings = dm_grown(s, s->meetings, s->meeting_count, &s->meeting_room, sizeof *s->meetings);
        if (!dm_has_room(s)) return;
        dm_meeting *m = s->meetings + s->meeting_count;
        const double *x[4];
        for (int j = 0; j < 4; j++) x[j] = s->near[p->at[j]].x;
        m->pair = p, m->gap = dm_measure_pair(x, p->ones, m->weight, m->normal);
        if (!(m->gap < p->touch) || !(m->gap > 0)) continue;
        for (int c = 0; c < 3; c++) m->normal[c] /= m->gap;
        if (p->ones == 1 ? !dm_is_nearest(s, m)
                         : !(m->weight[0] > 0 && m->weight[1] > 0 && m->weight[2] < 0 && m->weight[3] < 0))
            continue;
        for (int j = 0; j < 4; j++) s->near[p->at[j]].shares += fabs(m->weight[j]) > DM_WEIGHT_FLOOR;
        s->meeting_count++;
    }
}

static void dm_resolve_meeting(dm_scene_state *s, const dm_meeting *m) {
    const dm_pair *p = m->pair;
    double give = 0, u[3] = {0};
    for (int j = 0; j < 4; j++) {
        const dm_neighbour *n = s->near + p->at[j];
        give += m->weight[j] * m->weight[j] * n->inverse_mass * n->shares;
        for (int c = 0; c < 3; c++) u[c] += m->weight[j] * n->v[c];
    }
    if (!(give > 0)) return;
    double along = dm_inner3(u, m->normal);
    double least = DM_LEAST_GAP * p->touch, near = p->touch / (m->gap > least ? m->gap : least);
    double hard = DM_CONTACT_STIFFNESS * near, apart = near * (p->touch - m->gap) / DM_PART_TIME;
    double most = (apart - along) / give; /* what is too near parts slowly, and gains no energy */
    double push = hard * (p->touch - m->gap) / s->dt - DM_CONTACT_DAMPING * along;
    push = push / ((1 + hard + DM_CONTACT_DAMPING) * give);
    push = push < most ? push : most;
    push = push > 0 ? p->weight * push : 0;
    for (int c = 0; c < 3; c++) u[c] -= along * m->normal[c];
    double slide = sqrt(dm_inner3(u, u)), drag = p->friction * push, stop = p->weight * slide / give;
    drag = slide > 0 ? (drag < stop ? drag : stop) / slide : 0;
    double impulse[3], point[3] = {0}, moment[3];
    for (int c = 0; c < 3; c++) {
        impulse[c] = push * m->normal[c] - drag * u[c];
        for (int j = 0; j < 4; j++) {
            dm_neighbour *n = s->near + p->at[j];
            n->push[c] += m->weight[j] * n->inverse_mass * impulse[c];
            if (j < (int)p->ones) point[c] += m->weight[j] * n->x[c];
        }
        s->surfaces[p->surface[0]].impulse[c] += impulse[c], s->surfaces[p->surface[1]].impulse[c] -= impulse[c];
    }
    dm_cross3(point, impulse, moment);
    for (int c = 0; c < 3; c++)
        s->surfaces[p->surface[0]].moment[c] += moment[c], s->surfaces[p->surface[1]].moment[c] -= moment[c];
}

/* Resolve what touches, all from the same state. */
static void dm_resolve_touching(dm_scene_state *s) {
    if (!s->candidate_count) return;
    dm_gather_near(s);
    dm_find_meetings(s);
    for (uint32_t k = 0; k < s->meeting_count; k++) dm_resolve_meeting(s, s->meetings + k);
    for (const dm_neighbour *n = s->near; n < s->near + s->near_count; n++) {
        const dm_surface *f = s->surfaces + n->surface;
        if (!n->shares || !(n->inverse_mass > 0)) continue;
        uint32_t i = n->vertex - f->first;
        const dm_record *r = f->body->records + i;
        dm_quad push = dm_quad_of(n->push);
        dm_set_vertex(f->body, i, r->x + (dm_real)s->dt * push, r->v + push);
    }
    s->out->touching = s->meeting_count > s->out->touching ? s->meeting_count : s->out->touching;
}
