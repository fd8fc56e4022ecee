/* Bounds on the motion of nearby surfaces until the next query: planes between pairs, which move with a rigid side.
 * Source: studies/reference/bounds.py. */
#include "scene.h"

/* Return an array that holds at least `count` items: the old one, or a new one without its contents. */
static void *dm_roomy(dm_scene_state *s, void *array, uint32_t count, uint32_t *size, size_t each) {
    if (count <= *size) return array;
    dm_free(array);
    array = dm_alloc(2 * (int64_t)count, each), *size = array ? 2 * count : 0;
    if (!array) s->code = DM_MEMORY;
    return array;
}

/* Find the place of a vertex of a pair. */
DM_INLINE void dm_corner(const dm_scene_state *s, const dm_pair *p, uint32_t corner, double *x) {
    const dm_neighbour *n = s->near + p->at[corner];
    for (int c = 0; c < 3; c++)
        x[c] = n->body ? s->surfaces[n->surface].origin[c] + (double)n->body->x[c] : s->here[n->vertex][c];
}

/* Return the distance below which two surfaces come no nearer [m]. */
DM_INLINE double dm_closest_of(const dm_surface *f, const dm_surface *g) {
    return f->closest > g->closest ? f->closest : g->closest;
}

/* Set the plane of a pair from its nearest points and distance; return how far a side may move. Beside a rigid side the
 * skin keeps a part of the whole distance; of two soft sides, each keeps a part of half of it. */
static double dm_set_plane(dm_plane *plane, const dm_pair *p, const double (*x)[3], const uint32_t *at, const double *w,
                           const double *between, double gap, double closest) {
    double whole = p->rigid ? gap : gap / 2, least = (whole < closest ? whole : closest) / 2;
    plane->level = 0;
    plane->keep = gap > closest ? least + (1 - DM_BOUND) * (whole - least) : whole * (1 - DM_ROUNDING);
    for (int c = 0; c < 3; c++) {
        double other = 0;
        plane->normal[c] = gap > 0 ? between[c] / gap : 0;
        for (uint32_t k = p->ones; k < 4; k++) other -= w[k] * x[at[k]][c];
        plane->level += plane->normal[c] * (other + between[c] / 2);
    }
    return whole - plane->keep;
}

/* Set the plane of a pair from its present places. */
static void dm_renew_plane(dm_scene_state *s, uint32_t pair) {
    double x[4][3], w[4], between[3];
    const dm_pair *p = s->pairs + pair;
    for (uint32_t j = 0; j < 4; j++) dm_corner(s, p, j, x[j]);
    double gap = dm_measure_pair((const double(*)[3])x, dm_four, p->ones, w, between);
    double closest = dm_closest_of(dm_surface_of(s, p, 0), dm_surface_of(s, p, 3));
    if (gap > 0) dm_set_plane(s->planes + pair, p, (const double(*)[3])x, dm_four, w, between, gap, closest);
    s->next[pair] = 0;
}

/* Find how far the vertices of a pair are along its normal. */
DM_INLINE void dm_find_along(const dm_scene_state *s, const dm_pair *p, const double *normal, double *along) {
    for (uint32_t j = 0; j < 4; j++) {
        double x[3];
        dm_corner(s, p, j, x), along[j] = dm_inner3(normal, x);
    }
}

/* Move the plane between two soft sides to the middle between them, within the range in which both were on their own
 * sides of it before this substep. */
static void dm_centre_plane(const dm_scene_state *s, const dm_pair *p, dm_plane *plane, const double *along) {
    double now[2] = {INFINITY, INFINITY}, last[2] = {INFINITY, INFINITY}; /* least along each side's direction */
    for (uint32_t j = 0; j < 4; j++) {
        const dm_neighbour *n = s->near + p->at[j];
        int second = j >= p->ones;
        double was = 0, here = second ? -along[j] : along[j];
        for (int c = 0; c < 3; c++) was += plane->normal[c] * (s->surfaces[n->surface].origin[c] + (double)n->last[c]);
        was = second ? -was : was;
        now[second] = here < now[second] ? here : now[second], last[second] = was < last[second] ? was : last[second];
    }
    double low = plane->keep - last[1], high = last[0] - plane->keep, middle = (now[0] - now[1]) / 2;
    if (low <= high) plane->level = middle < low ? low : middle > high ? high : middle;
}

/* Move the plane of a pair with its rigid side: to the point of that side nearest to the other. */
DM_INLINE void dm_move_plane(const dm_pair *p, dm_plane *plane, const double *along) {
    double level = -INFINITY, sign = p->rigid & 1 ? -1 : 1;
    for (uint32_t k = p->rigid & 1 ? 0 : p->ones, end = p->rigid & 1 ? p->ones : 4; k < end; k++)
        level = sign * along[k] > level ? sign * along[k] : level;
    plane->level = sign * level;
}

/* Return the distance of a vertex from the limit that a pair sets it [m], negative beyond the limit. */
DM_INLINE double dm_left_of(const dm_plane *plane, int first, double along) {
    return (first ? along - plane->level : plane->level - along) - plane->keep;
}

/* List the pairs of each vertex that is near. */
static void dm_link_pairs(dm_scene_state *s) {
    s->pairs_of = dm_roomy(s, s->pairs_of, 4 * s->pair_count, &s->pairs_of_room, sizeof *s->pairs_of);
    if (!dm_has_room(s)) return;
    uint32_t start = 0;
    for (dm_tally *t = s->tally; t < s->tally + s->near_count; t++) t->end = start, start += t->count;
    for (uint32_t k = 0; k < 4 * s->pair_count; k++)
        s->pairs_of[s->tally[s->pairs[k / 4].at[k % 4]].end++] = k;
}

/* Return the pairs of a vertex in `near`, each as 4 x the pair's number + the vertex's place in the pair. */
DM_INLINE const uint32_t *dm_pairs_of(const dm_scene_state *s, uint32_t near, uint32_t *count) {
    *count = s->tally[near].count;
    return s->pairs_of + s->tally[near].end - *count;
}

DM_INLINE double dm_left_at(const dm_scene_state *s, uint32_t which, const double *x) {
    const dm_plane *plane = s->planes + which / 4;
    return dm_left_of(plane, which % 4 < s->pairs[which / 4].ones, dm_inner3(plane->normal, x));
}
