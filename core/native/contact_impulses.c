/* Contact: in each substep, impulses that keep pairs at least as far apart as they touch, with Coulomb friction. Pairs
 * that are nearer all the same are separated by a displacement, without a velocity.
 * Source: studies/reference/touching.py.
 *
 * For a pair at distance d (r: distance of touch), with relative speed u along its normal, and g = 1 / mass of both:
 *     j = max(0, (w - u) / g)   with   w = -(d - r) / h if d > r, otherwise 0
 * so that after the substep h it is not nearer than r, or no nearer than before. Every substep measures the nearest points
 * of all pairs again: a normal that is kept while a vertex slides round an edge adds energy. The pairs are resolved one
 * after the other, in an order that does not depend on the layout in memory, until they agree; with fewer sweeps, skin
 * that is squeezed from all sides trembles. Then those still too near are separated. A pair that sticks returns to an
 * anchor, the displacement at which it began to stick, so that it does not creep; if the pair slides, the anchor follows.
 *
 * Eight meetings are resolved at once, none of which moves a vertex of another. The result is that of resolving all one
 * after the other, because each waits for the earlier ones that move one of its vertices.
 */
#include "scene.h"

/* Return the two surfaces of the i-th lane of the batches; in an empty lane they are equal. */
DM_INLINE const uint32_t *dm_sides_of(const dm_scene_state *s, uint32_t i) {
    return s->sides[i / DM_LANES].surface[i % DM_LANES];
}

/* Return the number of pairs of surfaces that may touch, with repetitions; dm_both_of returns the i-th. */
DM_INLINE uint32_t dm_side_count(const dm_scene_state *s) { return DM_LANES * s->batch_count + s->support_count; }

DM_INLINE const uint32_t *dm_both_of(const dm_scene_state *s, uint32_t i) {
    uint32_t lanes = DM_LANES * s->batch_count;
    return i < lanes ? dm_sides_of(s, i) : s->supports[i - lanes].surface;
}

static int dm_any_sleeps(const dm_scene_state *s) {
    int asleep = 0;
    for (const dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) asleep |= dm_sleeps(f);
    return asleep;
}

DM_INLINE double dm_give_of(const dm_scene_state *s, const dm_neighbour *n) {
    const dm_surface *f = s->surfaces + n->surface;
    return f->body ? (double)f->body->inverse_mass[n->vertex - f->first] : 0;
}

/* Add a meeting to the first batch that has a free lane, after all batches that contain its vertices. Immovable
 * vertices may be in several lanes of one batch. */
static void dm_add_meeting(dm_scene_state *s, const dm_meeting *m) {
    uint32_t k = 0;
    for (int j = 0; j < 4; j++)
        if (s->moving[m->at[j]].v[3] > 0 && s->near[m->at[j]].batch > k) k = s->near[m->at[j]].batch;
    while (k < s->batch_count && (s->sides[k].count == DM_LANES || s->sides[k].ones != m->ones)) k++;
    for (int j = 0; j < 4; j++) s->near[m->at[j]].batch = k + 1;
    if (k == s->batch_count) {
        s->batches = dm_grown(s, s->batches, k, &s->batch_room, sizeof *s->batches);
        s->sides = dm_grown(s, s->sides, k, &s->sides_room, sizeof *s->sides);
        if (!dm_has_room(s)) return;
        dm_batch *made = s->batches + s->batch_count++;
        memset(made, 0, sizeof *made), memset(s->sides + k, 0, sizeof *s->sides);
        s->sides[k].ones = m->ones;
        for (int i = 0; i < 4 * DM_LANES; i++) made->at[i / DM_LANES][i % DM_LANES] = s->near_count * (uint32_t)sizeof(dm_record);
    }
    dm_batch *b = s->batches + k;
    dm_batch_sides *of = s->sides + k;
    uint32_t l = of->count++;
    for (int j = 0; j < 4; j++) {
        b->at[j][l] = m->at[j] * (uint32_t)sizeof(dm_record);
        of->near[l][j] = m->at[j];
    }
    b->touch[l] = (dm_real)m->touch, b->friction[l] = (dm_real)m->friction, b->share[l] = (dm_real)m->share;
    memcpy(of->surface[l], m->surface, sizeof m->surface);
}

/* Add the impulses of the meetings to those of their surfaces and vertices. */
static void dm_sum_meetings(dm_scene_state *s) {
    for (uint32_t i = 0; i < DM_LANES * s->batch_count; i++) {
        dm_batch *b = s->batches + i / DM_LANES;
        const dm_batch_sides *of = s->sides + i / DM_LANES;
        uint32_t l = i % DM_LANES;
        if (l >= of->count) continue;
        double j[3] = {(double)b->sum.x[l], (double)b->sum.y[l], (double)b->sum.z[l]}, moment[3];
        dm_cross3((double[]){of->point.x[l], of->point.y[l], of->point.z[l]}, j, moment);
        for (int k = 0; k < 4; k++)
            dm_add3(s->given[s->near[of->near[l][k]].vertex], (double)b->weight[k][l], j);
        for (int k = 0; k < 2; k++) {
            dm_surface *f = s->surfaces + of->surface[l][k];
            dm_add3(f->impulse, k ? -1 : 1, j), dm_add3(f->moment, k ? -1 : 1, moment);
        }
    }
    for (dm_batch *b = s->batches; b < s->batches + s->batch_count; b++) b->sum = dm_splat3((double[3]){0, 0, 0});
}

DM_INLINE dm_vec3 dm_plus(dm_vec3 a, dm_lanes by, dm_vec3 b) {
    return (dm_vec3){a.x + by * b.x, a.y + by * b.y, a.z + by * b.z};
}

DM_INLINE dm_lanes dm_where(dm_mask which, dm_lanes a) { return (dm_lanes)(which & (dm_mask)a); }

typedef struct { /* of one vertex of each meeting: displacement or velocity, and 1 / mass */
    dm_vec3 of;
    dm_lanes give;
} dm_moving;

/* Gather the displacements or velocities of the vertices of a batch; return the relative ones of its nearest points. */
DM_INLINE dm_vec3 dm_gather_batch(const dm_batch *b, const void *from, dm_moving *each) {
    dm_vec3 between = dm_splat3((double[3]){0, 0, 0});
    for (int j = 0; j < 4; j++) {
        each[j].of = dm_gather_quads(from, b->at[j], &each[j].give);
        between = dm_plus(between, b->weight[j], each[j].of);
    }
    return between;
}

/* Change the displacements or velocities `each` of the vertices of a batch by their shares of impulses, and store them.
 * give: 1 / mass [1/kg]; the fourth numbers stay. */
DM_INLINE void dm_scatter_batch(const dm_batch *b, const dm_moving *each, const dm_lanes *give, dm_vec3 more,
                                void *to) {
    for (int j = 0; j < 4; j++) {
        dm_quad made[DM_LANES];
        dm_quads_of(dm_plus(each[j].of, b->weight[j] * give[j], more), each[j].give, made);
        DM_UNROLLED for (int l = 0; l < DM_LANES; l++) *dm_quad_at(to, b->at[j][l]) = made[l];
    }
}

/* Change the impulses so that no pair comes nearer than allowed, or slides more than friction allows; return the squares
 * of the changes of their relative velocities u. */
DM_INLINE dm_lanes dm_resolve_batch(const dm_scene_state *s, dm_batch *b, dm_moving *v, dm_vec3 u) {
    dm_lanes none = dm_splat(0), by = dm_where(b->active, b->by), along = dm_dot(u, b->normal);
    dm_lanes push = dm_vmax(b->push + by * (b->least - along), none);
    dm_vec3 slide = dm_plus(dm_plus(u, dm_splat(1), b->back), -along, b->normal), drag = dm_plus(b->drag, -by, slide);
    dm_lanes square = dm_dot(drag, drag), most = b->friction * push;
    dm_mask slips = (dm_mask)(square > most * most);
    dm_lanes kept = dm_blend(slips, most / dm_vsqrt(dm_vmax(square, dm_splat(DM_LEAST))), dm_splat(1));
    drag = (dm_vec3){kept * drag.x, kept * drag.y, kept * drag.z};
    dm_vec3 more = dm_plus(dm_sub(drag, b->drag), push - b->push, b->normal);
    b->push = push, b->drag = drag;
    dm_scatter_batch(b, v, (dm_lanes[]){v[0].give, v[1].give, v[2].give, v[3].give}, more, &s->moving->v);
    return b->give * b->give * dm_dot(more, more);
}

/* Measure the nearest points, normals and distances of a batch as the substep began. */
static void dm_measure_batch(const dm_scene_state *s, dm_batch *b, dm_batch_sides *of) {
    const uint32_t *at[DM_LANES];
    dm_wide w[4];
    dm_wide_mask inside;
    for (uint32_t l = 0; l < DM_LANES; l++) at[l] = of->near[l < of->count ? l : 0];
    dm_wide3 way = dm_wide_measure((const double(*)[3])s->now, at, of->ones, w, &inside);
    dm_wide gap = dm_wide_root(dm_wide_dot(way, way)), by = dm_wide_of(1) / (gap + dm_wide_of(DM_TINY));
    b->normal = (dm_vec3){dm_narrow(by * way.x), dm_narrow(by * way.y), dm_narrow(by * way.z)}, b->begin = dm_narrow(gap);
    of->point = (dm_wide3){dm_wide_of(0), dm_wide_of(0), dm_wide_of(0)};
    for (uint32_t j = 0; j < 4; j++) {
        b->weight[j] = dm_narrow(w[j]);
        if (j < of->ones) of->point = dm_wide_plus(of->point, w[j], dm_wide_corner((const double(*)[3])s->now, at, (int)j));
    }
}

/* Begin the substep of a batch: activate and resolve the meetings that would come nearer than they touch; return
 * whether there are any. awake: the meetings that may be active. */
DM_INLINE int dm_begin_batch(const dm_scene_state *s, dm_batch *b, dm_mask awake) {
    dm_moving v[4], gone[4];
    dm_lanes h = dm_splat((dm_real)s->dt), none = dm_splat(0), back = dm_splat((dm_real)DM_BACK) / h;
    dm_vec3 way = dm_gather_batch(b, &s->moving->x, gone), u = dm_gather_batch(b, &s->moving->v, v);
    dm_lanes most = none;
    b->give = none;
    for (int j = 0; j < 4; j++) b->give += b->weight[j] * b->weight[j] * v[j].give, most = dm_vmax(v[j].give, most);
    /* without the least compliance, a vertex with hardly any weight beside pinned ones is thrown */
    b->by = dm_where((dm_mask)(b->give > none), b->share / dm_vmax(b->give, dm_splat((dm_real)DM_PINNED_GIVE) * most));
    b->active = awake & (dm_mask)(b->begin + h * dm_dot(u, b->normal) < b->touch);
    dm_mask moves = awake & ~b->active;
    b->anchor.x = dm_blend(moves, way.x, b->anchor.x), b->anchor.y = dm_blend(moves, way.y, b->anchor.y);
    b->anchor.z = dm_blend(moves, way.z, b->anchor.z);
    b->push = none, b->drag = (dm_vec3){none, none, none};
    if (!dm_any_of(b->active)) return 0;
    way = dm_sub(way, b->anchor), way = dm_plus(way, -dm_dot(way, b->normal), b->normal);
    b->back = (dm_vec3){back * way.x, back * way.y, back * way.z};
    b->least = -dm_vmax((b->begin - b->touch) / h, none);
    dm_resolve_batch(s, b, v, u);
    return 1;
}

/* Resolve the active meetings once more; return whether they agree: whether no speed has changed by so much that a tenth
 * of the greatest distance of touch would be covered in the substep. */
static int dm_sweep_meetings(dm_scene_state *s) {
    dm_lanes most = dm_splat(0);
    double enough = DM_BACK * s->touch / s->dt;
    for (dm_batch *b = s->batches; b < s->batches + s->batch_count; b++) {
        if (!dm_any_of(b->active)) continue;
        dm_moving v[4];
        dm_vec3 u = dm_gather_batch(b, &s->moving->v, v);
        most = dm_vmax(dm_resolve_batch(s, b, v, u), most);
    }
    return !(dm_most_of(most) > enough * enough);
}

/* Separate the meetings that would be nearer than they touch; add up their impulses, and let the anchors of those that
 * slide follow. */
DM_INLINE void dm_part_batch(const dm_scene_state *s, dm_batch *b) {
    dm_moving v[4], out[4];
    dm_lanes h = dm_splat((dm_real)s->dt);
    dm_vec3 u = dm_gather_batch(b, &s->moving->v, v), way = dm_gather_batch(b, &s->moving->x, out);
    dm_lanes short_of = b->touch - b->begin - dm_dot(dm_plus(way, h, u), b->normal);
    dm_mask near = b->active & (dm_mask)(short_of > dm_splat(0));
    dm_lanes by = dm_where(near, b->by * dm_splat((dm_real)DM_BACK) * short_of);
    dm_scatter_batch(b, out, (dm_lanes[]){v[0].give, v[1].give, v[2].give, v[3].give},
                     (dm_vec3){by * b->normal.x, by * b->normal.y, by * b->normal.z}, &s->moving->x);
    b->sum = dm_plus(dm_plus(b->sum, b->push, b->normal), dm_splat(1), b->drag);
    dm_lanes most = b->friction * b->push * dm_splat((dm_real)(1 - DM_ROUNDING));
    dm_mask slides = b->active & (dm_mask)(dm_dot(b->drag, b->drag) >= most * most);
    b->anchor = dm_plus(b->anchor, dm_where(slides, h / dm_splat((dm_real)DM_BACK)), b->back);
}

/* Resolve all meetings in a substep; return the number of those that touch. */
static int64_t dm_resolve_meetings(dm_scene_state *s) {
    int asleep = dm_any_sleeps(s), any = 0;
    for (uint32_t k = 0; k < s->batch_count; k++) {
        dm_mask awake = ~(dm_mask){0};
        for (int l = 0; asleep && l < DM_LANES; l++) {
            const uint32_t *of = s->sides[k].surface[l];
            awake[l] = dm_sleeps(s->surfaces + of[0]) || dm_sleeps(s->surfaces + of[1]) ? 0 : -1;
        }
        dm_measure_batch(s, s->batches + k, s->sides + k);
        any |= dm_begin_batch(s, s->batches + k, awake);
    }
    if (!any) return 0;
    for (const uint32_t *k = s->met; k < s->met + s->met_count; k++) s->moving[*k].x = (dm_quad){0, 0, 0, 0};
    for (int k = 0, agree = 0; k < DM_SWEEPS && !agree; k++) agree = dm_sweep_meetings(s);
    dm_mask touching = {0};
    for (dm_batch *b = s->batches; b < s->batches + s->batch_count; b++) {
        if (!dm_any_of(b->active)) continue;
        dm_part_batch(s, b);
        touching -= b->active;
    }
    int64_t count = 0;
    for (int l = 0; l < DM_LANES; l++) count += touching[l];
    return count;
}
