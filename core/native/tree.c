/* The surfaces of a scene: a tree of boxes over the triangles, and the neighbours of each triangle. */
#include "scene.h"

/* Order the triangles of a surface along a Morton curve. */
static int32_t dm_order_triangles(dm_scene_state *s, const dm_surface *f) {
    int64_t t = f->triangle_count;
    uint32_t(*mine)[3] = s->corners + f->first_triangle;
    double *middles = malloc((size_t)(3 * t + 1) * sizeof(double));
    dm_keyed *keys = malloc((size_t)(t + 1) * sizeof(dm_keyed));
    uint32_t(*sorted)[3] = malloc((size_t)(t + 1) * sizeof *sorted);
    int whole = middles && keys && sorted;
    for (int64_t k = 0; whole && k < t; k++)
        for (int c = 0; c < 3; c++)
            middles[c * t + k] = s->rest[mine[k][0]][c] + s->rest[mine[k][1]][c] + s->rest[mine[k][2]][c];
    if (whole) {
        dm_order_along_curve(middles, t, keys);
        for (int64_t k = 0; k < t; k++) memcpy(sorted[k], mine[keys[k].number], sizeof *sorted);
        memcpy(mine, sorted, (size_t)t * sizeof *sorted);
    } else s->code = DM_MEMORY;
    free(middles), free(keys), free(sorted);
    return s->code;
}

/* Number the edges of a surface; each edge and each vertex belongs to the first triangle that has it. */
static int32_t dm_lay_edges(dm_scene_state *s, dm_surface *f) {
    int64_t t = f->triangle_count;
    dm_keyed *sides = malloc((size_t)(3 * t + 1) * sizeof *sides); /* each with its edge as the key */
    uint32_t *same = malloc((size_t)(3 * t + 1) * sizeof *same); /* the first side that is the same edge */
    uint8_t *seen = calloc(f->count + 1, 1);
    if (!sides || !same || !seen) return free(sides), free(same), free(seen), s->code = DM_MEMORY;
    for (int64_t k = 0; k < 3 * t; k++) {
        const uint32_t *at = s->corners[f->first_triangle + k / 3];
        uint64_t a = at[k % 3], b = at[(k + 1) % 3];
        sides[k] = (dm_keyed){a < b ? a << 32 | b : b << 32 | a, (uint32_t)k};
    }
    qsort(sides, (size_t)(3 * t), sizeof *sides, dm_by_key);
    double length = 0;
    for (int64_t k = 0; k < 3 * t; k++) {
        int first = !k || sides[k].key != sides[k - 1].key;
        same[sides[k].number] = first ? sides[k].number : same[sides[k - 1].number];
        double way[3], *a = s->rest[sides[k].key >> 32], *b = s->rest[(uint32_t)sides[k].key];
        dm_minus(a, b, way), length += first ? sqrt(dm_inner3(way, way)) : 0;
    }
    f->first_edge = (uint32_t)s->edge_count;
    uint32_t vertex = f->first_triangle ? s->vertex_start[f->first_triangle] : 0;
    for (uint32_t k = 0; k < 3 * t; k++) {
        uint32_t triangle = f->first_triangle + k / 3, side = k % 3, *at = s->corners[triangle], a = at[side], b = at[(side + 1) % 3];
        uint32_t e = same[k] < k ? s->edges_of[f->first_triangle + same[k] / 3][same[k] % 3] : (uint32_t)s->edge_count++;
        s->edges_of[triangle][side] = e, s->across[e][same[k] < k] = at[(side + 2) % 3];
        if (same[k] == k) s->edges[e][0] = a < b ? a : b, s->edges[e][1] = a < b ? b : a, s->across[e][1] = DM_NO_VERTEX;
        if (!seen[a - f->first]) seen[a - f->first] = 1, s->listed[vertex++] = a;
        s->vertex_start[triangle + 1] = vertex, s->edge_start[triangle + 1] = (uint32_t)s->edge_count;
    }
    f->edge_count = (uint32_t)s->edge_count - f->first_edge;
    f->edge = f->edge_count ? length / f->edge_count : 0;
    free(sides), free(same), free(seen);
    return DM_OK;
}

static int32_t dm_lay_neighbours(dm_scene_state *s) {
    uint32_t *start = s->ring_start = dm_alloc(s->vertex_count + 2, sizeof *start);
    s->ring = dm_alloc(2 * s->edge_count, sizeof *s->ring);
    if (!start || !s->ring) return DM_MEMORY;
    for (int64_t e = 0; e < s->edge_count; e++) start[s->edges[e][0] + 2]++, start[s->edges[e][1] + 2]++;
    for (int64_t i = 2; i < s->vertex_count + 2; i++) start[i] += start[i - 1];
    for (int64_t e = 0; e < s->edge_count; e++)
        for (int k = 0; k < 2; k++) s->ring[start[s->edges[e][k] + 1]++] = s->edges[e][1 - k];
    return DM_OK;
}

/* Build the tree over a run of triangles; return the index after its last node. */
static uint32_t dm_lay_tree(dm_scene_state *s, uint32_t node, uint32_t start, uint32_t end) {
    dm_node *n = s->nodes + node++;
    n->start = start, n->end = end;
    if (end - start > DM_LANES) {
        uint32_t middle = start + ((end - start) / 2 + DM_LANES - 1) / DM_LANES * DM_LANES;
        node = dm_lay_tree(s, node, start, middle);
        n->next = node;
        node = dm_lay_tree(s, node, middle, end);
    }
    return node;
}

/* Fit the boxes of parts with some corners each to their places at the query. */
static void dm_fit_parts(const dm_scene_state *s, const uint32_t *at, uint32_t corners, uint32_t start, uint32_t end, dm_boxes *to) {
    for (uint32_t k = start; k < end; k++)
        for (int c = 0; c < 3; c++) {
            double low = s->before[at[corners * k]][c], high = low;
            for (uint32_t j = 1; j < corners; j++) {
                double x = s->before[at[corners * k + j]][c];
                low = x < low ? x : low, high = x > high ? x : high;
            }
            to->low[c][k] = low, to->high[c][k] = high;
        }
}

/* Fit the boxes of a surface to its vertices at the query; children come after their parent. */
static void dm_fit_boxes(dm_scene_state *s, const dm_surface *f) {
    dm_fit_parts(s, s->corners[0], 3, f->first_triangle, f->first_triangle + (uint32_t)f->triangle_count, &s->boxes);
    dm_fit_parts(s, s->edges[0], 2, f->first_edge, f->first_edge + f->edge_count, &s->edge_boxes);
    for (uint32_t k = f->first_node + f->node_count; k-- > f->first_node;) {
        dm_node *n = s->nodes + k;
        const dm_node *a = n + 1, *b = s->nodes + n->next;
        for (int c = 0; c < 3; c++) {
            n->low[c] = n->next ? fmin(a->low[c], b->low[c]) : INFINITY;
            n->high[c] = n->next ? fmax(a->high[c], b->high[c]) : -INFINITY;
            for (uint32_t i = n->start; !n->next && i < n->end; i++)
                n->low[c] = fmin(n->low[c], s->boxes.low[c][i]), n->high[c] = fmax(n->high[c], s->boxes.high[c][i]);
        }
    }
}

/* Return which of up to eight boxes from a number on are not farther from a box than a distance along any axis, a bit
 * for each. */
DM_INLINE uint32_t dm_near_boxes(const dm_boxes *of, uint32_t from, uint32_t end, const double *low, const double *high,
                                 double distance) {
    dm_wide_mask near = ~(dm_wide_mask){0};
    dm_wide most = dm_wide_of(distance);
    for (int c = 0; c < 3; c++) {
        dm_wide lower, higher;
        memcpy(&lower, of->low[c] + from, sizeof lower), memcpy(&higher, of->high[c] + from, sizeof higher);
        near &= (dm_wide_mask)(lower - dm_wide_of(high[c]) <= most) & (dm_wide_mask)(dm_wide_of(low[c]) - higher <= most);
    }
    const dm_wide_mask bit = {1, 2, 4, 8, 16, 32, 64, 128};
    dm_wide_mask bits = near & bit;
    uint32_t all = (uint32_t)((bits[0] | bits[1] | bits[2] | bits[3]) | (bits[4] | bits[5] | bits[6] | bits[7]));
    return end - from < DM_LANES ? all & ((1u << (end - from)) - 1) : all;
}

/* Return the gap between two boxes along the axis on which it is largest; negative if they overlap. */
DM_INLINE double dm_boxes_apart(const double *low, const double *high, const double *lower, const double *higher) {
    double apart = -INFINITY;
    for (int c = 0; c < 3; c++) {
        double a = lower[c] - high[c], b = low[c] - higher[c], most = a > b ? a : b;
        apart = most > apart ? most : apart;
    }
    return apart;
}

typedef void (*dm_visit)(dm_scene_state *s, const dm_surface *f, const dm_surface *g, const dm_node *a, const dm_node *b);

/* Visit each pair of leaves, of two surfaces or of one, whose boxes are not farther apart than a distance, and each leaf
 * of one surface with itself. */
static void dm_visit_pairs(dm_scene_state *s, const dm_surface *f, const dm_surface *g, double distance,
                           dm_visit visit) {
    enum { DM_DEEPEST = 128 }; /* pairs of nodes on the stack: two trees of 2^25 leaves are 26 deep, and each step adds two */
    uint32_t wait[DM_DEEPEST][2], count = 0;
    if (!f->node_count || !g->node_count) return;
    wait[count][0] = f->first_node, wait[count++][1] = g->first_node;
    while (count && dm_has_room(s)) {
        uint32_t i = wait[--count][0], j = wait[count][1];
        const dm_node *a = s->nodes + i, *b = s->nodes + j;
        if (i != j && dm_boxes_apart(a->low, a->high, b->low, b->high) > distance) continue;
        if (!a->next && !b->next) {
            visit(s, f, g, a, b);
        } else if (i == j) {
            wait[count][0] = i + 1, wait[count++][1] = i + 1;
            wait[count][0] = a->next, wait[count++][1] = a->next;
            wait[count][0] = i + 1, wait[count++][1] = a->next;
        } else if (a->next && (!b->next || a->end - a->start >= b->end - b->start)) {
            wait[count][0] = i + 1, wait[count++][1] = j;
            wait[count][0] = a->next, wait[count++][1] = j;
        } else {
            wait[count][0] = i, wait[count++][1] = j + 1;
            wait[count][0] = i, wait[count++][1] = b->next;
        }
    }
}
