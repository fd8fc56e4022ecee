/* The surfaces of a scene: a tree of boxes over the triangles, and the neighbours of each triangle. */
#include "scene.h"

static int dm_by_word(const void *a, const void *b) {
    const uint64_t *p = a, *q = b;
    return p[0] != q[0] ? (p[0] < q[0] ? -1 : 1) : p[1] < q[1] ? -1 : p[1] > q[1];
}

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
        for (int64_t k = 0; k < t; k++) memcpy(sorted[k], mine[keys[k].vertex], sizeof *sorted);
        memcpy(mine, sorted, (size_t)t * sizeof *sorted);
    } else s->code = DM_MEMORY;
    free(middles), free(keys), free(sorted);
    return s->code;
}

/* Number the edges of a surface, and assign each vertex and edge to one triangle. */
static int32_t dm_lay_edges(dm_scene_state *s, dm_surface *f) {
    int64_t t = f->triangle_count;
    uint64_t(*words)[2] = malloc((size_t)(3 * t + 1) * sizeof *words);
    uint8_t *seen = calloc(f->count + 1, 1);
    if (!words || !seen) return free(words), free(seen), s->code = DM_MEMORY;
    for (int64_t k = 0; k < 3 * t; k++) {
        const uint32_t *at = s->corners[f->first_triangle + k / 3];
        uint64_t a = at[k % 3], b = at[(k + 1) % 3];
        words[k][0] = a < b ? a << 32 | b : b << 32 | a, words[k][1] = (uint64_t)k;
        if (!seen[a - f->first]) seen[a - f->first] = 1, s->owns[f->first_triangle + k / 3] |= (uint8_t)(1 << k % 3);
    }
    qsort(words, (size_t)(3 * t), sizeof *words, dm_by_word);
    f->first_edge = (uint32_t)s->edge_count;
    double length = 0;
    for (int64_t k = 0; k < 3 * t; k++) {
        uint32_t triangle = f->first_triangle + (uint32_t)words[k][1] / 3, side = (uint32_t)words[k][1] % 3;
        uint32_t opposite = s->corners[triangle][(side + 2) % 3];
        if (!k || words[k][0] != words[k - 1][0]) {
            uint32_t e = (uint32_t)s->edge_count++, a = (uint32_t)(words[k][0] >> 32), b = (uint32_t)words[k][0];
            s->edges[e][0] = a, s->edges[e][1] = b, s->across[e][0] = opposite, s->across[e][1] = DM_NO_VERTEX;
            s->owns[triangle] |= (uint8_t)(8 << side);
            double square = 0;
            for (int c = 0; c < 3; c++) square += (s->rest[a][c] - s->rest[b][c]) * (s->rest[a][c] - s->rest[b][c]);
            length += sqrt(square);
        } else s->across[s->edge_count - 1][1] = opposite;
        s->edges_of[triangle][side] = (uint32_t)s->edge_count - 1;
    }
    f->edge_count = (uint32_t)s->edge_count - f->first_edge;
    f->edge = f->edge_count ? length / f->edge_count : 0;
    free(words), free(seen);
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
    if (end - start > 1) {
        node = dm_lay_tree(s, node, start, start + (end - start) / 2);
        n->next = node;
        node = dm_lay_tree(s, node, start + (end - start) / 2, end);
    }
    return node;
}

/* Fit the boxes of a surface to its vertices at the query; children come after their parent. */
static void dm_fit_boxes(dm_scene_state *s, const dm_surface *f) {
    for (uint32_t k = f->first_node + f->node_count; k-- > f->first_node;) {
        dm_node *n = s->nodes + k;
        if (n->next) {
            const dm_node *a = n + 1, *b = s->nodes + n->next;
            for (int c = 0; c < 3; c++) {
                n->low[c] = a->low[c] < b->low[c] ? a->low[c] : b->low[c];
                n->high[c] = a->high[c] > b->high[c] ? a->high[c] : b->high[c];
            }
            continue;
        }
        const uint32_t *at = s->corners[n->start];
        for (int c = 0; c < 3; c++) {
            double a = s->before[at[0]][c], b = s->before[at[1]][c], d = s->before[at[2]][c];
            n->low[c] = a < b ? a : b, n->high[c] = a < b ? b : a;
            n->low[c] = d < n->low[c] ? d : n->low[c], n->high[c] = d > n->high[c] ? d : n->high[c];
        }
    }
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

typedef void (*dm_visit)(dm_scene_state *s, const dm_surface *f, const dm_surface *g, uint32_t i, uint32_t j);

/* Visit each pair of triangles, of two surfaces or of one, whose boxes are nearer than a distance. */
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
            if (i != j) visit(s, f, g, a->start, b->start);
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
