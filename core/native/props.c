/* Props in a scene: their supports, how far they may move, and the reaction of soft bodies. To a soft body a prop is a
 * collider with the prop's velocity; the reaction acts on the prop in the next substep. Source:
 * studies/reference/twin_scene.py. */
#include "scene.h"

static int32_t dm_lay_prop(dm_surface *f, const dm_collider_def *d) {
    dm_falling *p = f->prop = dm_alloc(1, sizeof *p);
    if (!p) return DM_MEMORY;
    p->mass = d->mass, p->damping = d->damping, p->skin = d->skin, p->count = d->vertices;
    memcpy(p->inverse, d->inverse_inertia, sizeof p->inverse);
    p->arms = dm_alloc(p->count, sizeof *p->arms), p->seen = dm_alloc(p->count, sizeof *p->seen);
    if (!p->arms || !p->seen) return DM_MEMORY;
    for (int64_t k = 0; k < p->count; k++) {
        for (int64_t c = 0; c < 3; c++)
            p->arms[k][c] = d->arms[c * p->count + k], p->seen[k][c] = d->seen[c * p->count + k];
        p->radius = fmax(p->radius, sqrt(dm_inner3(p->seen[k], p->seen[k])));
    }
    f->closest = 2 * DM_TOO_NEAR * p->radius;
    return DM_OK;
}

static void dm_free_prop(dm_falling *p) {
    if (p) dm_free(p->arms), dm_free(p->seen), dm_free(p);
}

/* Take over the state of a prop if the caller has changed it. */
static void dm_take_prop(dm_scene_state *s, dm_surface *f, const dm_prop *to) {
    dm_falling *p = f->prop;
    if (p->placed && !memcmp(to, &p->now, sizeof *to)) return;
    int goes_on = p->placed && !memcmp(to, &p->now, offsetof(dm_prop, gravity)); /* only gravity and ground differ */
    p->now = *to, p->asleep = 0, p->placed = 1, p->quiet = 0;
    if (goes_on) return;
    double pose[12];
    memcpy(pose, to->centre, 3 * sizeof(double)), memcpy(pose + 3, to->turn, 9 * sizeof(double));
    dm_find_places(p, pose, s->here + f->first);
    memset(p->answer, 0, sizeof p->answer), memset(p->spin, 0, sizeof p->spin);
    memset(s->rate[f->first], 0, f->count * sizeof *s->rate);
    f->placed = 1, f->fitted = 0, s->due = 1;
}

/* List a pair of which neither side is a soft body. */
static void dm_add_support(dm_scene_state *s, const dm_meeting *m) {
    s->supports = dm_grown(s, s->supports, s->support_count, &s->support_room, sizeof *s->supports);
    if (!dm_has_room(s)) return;
    dm_support *c = s->supports + s->support_count++;
    *c = (dm_support){.touch = m->touch, .friction = m->friction, .share = m->share};
    memcpy(c->at, m->at, sizeof c->at), memcpy(c->surface, m->surface, sizeof c->surface);
    memcpy(c->weight, m->weight, sizeof c->weight), memcpy(c->normal, m->normal, sizeof c->normal);
}

/* Begin a substep of the supports, and list the contacts of props with the ground. */
static void dm_begin_supports(dm_scene_state *s) {
    for (dm_support *c = s->supports; c < s->supports + s->support_count; c++) {
        double ends[2][3] = {{0}};
        for (int j = 0; j < 2; j++) {
            dm_falling *p = s->surfaces[c->surface[j]].prop;
            c->of[j] = p && !p->asleep ? p : NULL;
        }
        for (int k = 0; k < 4; k++)
            for (int d = 0; d < 3; d++)
                ends[c->weight[k] < 0][d] += fabs(c->weight[k]) * s->here[s->near[c->at[k]].vertex][d];
        if (!dm_is_awake(c)) c->push = 0, memset(c->drag, 0, sizeof c->drag);
        else dm_begin_support(c, (const double(*)[3])ends, s->dt);
    }
    s->standing = s->support_count;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        if (!f->prop || f->prop->asleep || !(f->prop->now.ground > -INFINITY)) continue;
        for (uint32_t room = 0; room < DM_CORNERS; room++)
            s->supports = dm_grown(s, s->supports, s->standing + room, &s->support_room, sizeof *s->supports);
        if (!dm_has_room(s)) return;
        int count = dm_find_ground(f->prop, s->supports + s->standing, s->dt);
        for (; count > 0; count--, s->standing++) {
            dm_support *c = s->supports + s->standing;
            c->friction = f->friction, c->surface[0] = (uint32_t)(f - s->surfaces), c->surface[1] = DM_NO_VERTEX;
        }
    }
}

/* Before anything moves in a substep: let the props fall. */
static void dm_begin_props(dm_scene_state *s) {
    if (!s->prop_count) return;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        if (f->prop && !f->prop->asleep) dm_let_fall(f->prop, s->dt);
    dm_begin_supports(s);
}

/* Take over the pose at which a prop's motion has ended; if that was a share of its motion only, its velocity is
 * reduced to that share. */
static void dm_leave_prop(dm_scene_state *s, dm_surface *f) {
    double pose[12];
    dm_falling *p = f->prop;
    dm_find_pose(p, s->dt, f->share, pose);
    if (f->share > 0) memcpy(p->now.centre, pose, 3 * sizeof(double)), memcpy(p->now.turn, pose + 3, 9 * sizeof(double));
    if (f->share == 1) return;
    s->out->truncated++, s->out->taken += (1 - f->share) * p->mass * sqrt(dm_inner3(p->now.velocity, p->now.velocity));
    for (int c = 0; c < 3; c++)
        p->now.velocity[c] *= f->share, p->now.momentum[c] *= f->share, p->spin[c] *= f->share;
}

/* After the colliders have moved: resolve the contacts of props with everything except soft bodies, and move the
 * props. */
static void dm_move_props(dm_scene_state *s) {
    if (!s->prop_count) return;
    for (dm_support *c = s->supports; c < s->supports + s->standing; c++) {
        memset(c->led, 0, sizeof c->led);
        for (int k = 0; c < s->supports + s->support_count && k < 4; k++)
            for (int d = 0; d < 3 && !c->of[c->weight[k] < 0]; d++)
                c->led[d] += c->weight[k] * s->rate[s->near[c->at[k]].vertex][d];
    }
    dm_resolve_supports(s->supports, s->standing, s->dt);
    int64_t touching = 0;
    for (dm_support *c = s->supports; c < s->supports + s->standing; c++) {
        double j[3], moment[3];
        if (!(c->push > 0)) continue;
        for (int d = 0; d < 3; d++) j[d] = c->push * c->normal[d] + c->drag[d];
        dm_cross3(c->point, j, moment), touching++;
        for (int side = 0; side < 2; side++)
            for (int d = 0; d < 3 && c->surface[side] != DM_NO_VERTEX; d++) {
                dm_surface *f = s->surfaces + c->surface[side];
                f->impulse[d] += side ? -j[d] : j[d], f->moment[d] += side ? -moment[d] : moment[d];
            }
    }
    s->out->touching = touching > s->out->touching ? touching : s->out->touching;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        if (f->prop && !f->prop->asleep) f->share = f->tried = 1, dm_go(s, f);
}

/* After a substep: note the reactions of soft bodies on props. */
static void dm_note_answers(dm_scene_state *s) {
    for (dm_surface *f = s->surfaces; s->prop_count && f < s->surfaces + s->surface_count; f++)
        if (f->prop && !f->prop->asleep) memset(f->prop->answer, 0, sizeof f->prop->answer);
    for (uint32_t i = 0; s->prop_count && i < DM_LANES * s->batch_count; i++) {
        const dm_batch *b = s->batches + i / DM_LANES;
        const dm_batch_sides *of = s->sides + i / DM_LANES;
        uint32_t l = i % DM_LANES;
        double push = (double)b->push[l];
        if (!(push > 0)) continue;
        double j[3] = {push * (double)b->normal.x[l] + (double)b->drag.x[l], push * (double)b->normal.y[l] + (double)b->drag.y[l],
                       push * (double)b->normal.z[l] + (double)b->drag.z[l]};
        double at[3] = {of->point.x[l], of->point.y[l], of->point.z[l]};
        for (int side = 0; side < 2; side++) {
            dm_falling *p = s->surfaces[of->surface[l][side]].prop;
            if (p && !p->asleep) dm_answer_prop(p, at, j, side ? -1 : 1);
        }
    }
}
