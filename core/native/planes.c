/* The planes between pairs: neither of two goes beyond its side of theirs. Source: studies/reference/bounds.py.
 *
 * A plane holds until it is replaced, wherever the two have gone meanwhile on their sides of it. So what has moved along
 * its planes, or together with what is beyond them, keeps them, and they are only measured again; a plane is replaced when
 * a vertex is nearer to it than a quarter of the distance of the two. That is done when all are where they may be: they are
 * apart then, the new plane stands between their nearest points, and each is on its side of that too.
 */
#include "scene.h"

/* Nearer than this, nothing of two surfaces goes nearer still. */
DM_INLINE double dm_closest_of(const dm_surface *f, const dm_surface *g) {
    return f->closest > g->closest ? f->closest : g->closest;
}

/* How near one of two may come to the plane between them, where its part of the distance is `whole`. */
DM_INLINE double dm_keep_of(double whole, double gap, double closest) {
    double least = whole / 2 < closest / 2 ? whole / 2 : closest / 2;
    return gap > closest ? least + (1 - DM_BOUND) * (whole - least) : whole * (1 - DM_ROUNDING);
}

/* Set the plane between the nearest points of a pair at positions x, and how near each may come to it. share: of the
 * distance, that the first has. */
static void dm_set_plane(dm_plane *p, uint32_t ones, const double *const *x, const double *w, const double *between,
                         double gap, double closest, double share) {
    p->level = 0;
    for (int c = 0; c < 3; c++) {
        double other = 0;
        p->normal[c] = gap > 0 ? between[c] / gap : 0;
        for (uint32_t k = ones; k < 4; k++) other -= w[k] * x[k][c];
        p->level += p->normal[c] * (other + (1 - share) * between[c]);
    }
    p->keep[0] = dm_keep_of(share * gap, gap, closest), p->keep[1] = dm_keep_of((1 - share) * gap, gap, closest);
}

/* The velocity of a vertex that is near. */
DM_INLINE void dm_velocity_of(const dm_scene_state *s, const dm_neighbour *n, double *v) {
    const dm_surface *f = s->surfaces + n->surface;
    if (f->body) dm_velocity(f->body, n->vertex - f->first, v);
    else memcpy(v, s->rate[n->vertex], 3 * sizeof *v);
}

DM_INLINE double dm_approach(const dm_scene_state *s, const dm_pair *p, uint32_t from, uint32_t to, const double *w,
                             const double *normal) {
    double speed = 0;
    for (uint32_t k = from; k < to; k++) {
        double v[3];
        dm_velocity_of(s, s->near + p->at[k], v);
        speed -= w[k] * dm_inner3(normal, v);
    }
    return speed > 0 ? speed : 0;
}

/* Set the plane of a pair where things are now: the faster a side comes towards the other, the larger its part. Two that
 * are soft come and go, and a side that is slow now is soon fast. */
static void dm_renew_plane(dm_scene_state *s, dm_pair *p) {
    double x[4][3], w[4], between[3], normal[3], share = 0.5;
    dm_plane *plane = s->planes + (p - s->pairs);
    if (plane->renewed == s->renewal) return;
    plane->renewed = s->renewal;
    const dm_surface *f = dm_surface_of(s, p, 0), *g = dm_surface_of(s, p, 3);
    for (int j = 0; j < 4; j++) {
        const dm_neighbour *m = s->near + p->at[j];
        dm_world_of(s, s->surfaces + m->surface, m->vertex, x[j]);
    }
    const double *at[4] = {x[0], x[1], x[2], x[3]};
    double gap = dm_measure_pair(at, p->ones, w, between);
    double closest = dm_closest_of(f, g), least = f->body && g->body ? DM_SOFT_SHARE : DM_LEAST_SHARE;
    if (gap > closest) {
        double slow = gap / DM_REST_TIME; /* [m/s] below this both count as equally fast */
        for (int c = 0; c < 3; c++) normal[c] = between[c] / gap;
        double u = dm_approach(s, p, 0, p->ones, w, normal) + slow;
        double v = dm_approach(s, p, p->ones, 4, w, normal) + slow;
        share = u / (u + v);
        share = share < least ? least : share > 1 - least ? 1 - least : share;
    }
    dm_set_plane(plane, p->ones, at, w, between, gap, closest, share);
}

/* How far a vertex is on its own side of a plane. */
DM_INLINE double dm_side(const dm_plane *plane, int first, const double *x) {
    double along = dm_inner3(plane->normal, x) - plane->level;
    return first ? along : -along;
}

/* How far a vertex at x, a way `gone` from where it was at the query, is from what a pair lets it reach: less than nothing
 * beyond that. spent: set where a new plane is due. stride: how far it goes in a substep. */
DM_INLINE double dm_left_of(const dm_scene_state *s, uint32_t which, const double *x, double gone, double stride,
                            int *spent) {
    const dm_plane *plane = s->planes + which / 4;
    int first = which % 4 < plane->ones;
    double side = dm_side(plane, first, x), left = side - plane->keep[!first];
    double used = stride > DM_QUICK * plane->way ? gone : plane->way - left;
    *spent |= plane->renewed ? side * (1 - DM_BOUND) < (plane->keep[0] + plane->keep[1]) / 4
                             : used > plane->way / 4;
    return left;
}
