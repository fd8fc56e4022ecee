/* Edge flips towards a Delaunay triangulation.
 *
 * If the angles opposite an edge sum to more than a half turn, its cotangent weight is negative: shape matching
 * would lose its tension there, and slivers tilt a dent. Then the edge is replaced by the other diagonal. Source:
 * Lawson 1977. */
#include "dimple.h"
#include <math.h>
#include <stdlib.h>

enum { DM_LOOKS = 20 }; /* visits of an edge on average, at most: rounding could flip it back and forth for ever */

typedef struct { /* an edge and its triangles; the second is -1 if there is only one */
    int64_t edge, beside[2];
} dm_side;

typedef struct {
    int64_t n, *corners;
    const double *points;
    dm_side *side; /* hash table by edge, low x n + high, -1 if free; twice as long as there can be edges */
    uint64_t last;
    int64_t *waiting, count, room;
} dm_flips;

static uint64_t dm_home_of(const dm_flips *f, int64_t edge) {
    return ((uint64_t)edge * 0x9E3779B97F4A7C15u >> 32) & f->last; /* Knuth's multiplicative hash */
}

static dm_side *dm_find_side(const dm_flips *f, int64_t edge) {
    uint64_t at = dm_home_of(f, edge);
    while (f->side[at].edge >= 0 && f->side[at].edge != edge) at = (at + 1) & f->last;
    return f->side + at;
}

/* Remove an edge from the table; later entries that could not be found any more move up. */
static void dm_drop_side(dm_flips *f, int64_t edge) {
    uint64_t hole = (uint64_t)(dm_find_side(f, edge) - f->side);
    for (uint64_t at = (hole + 1) & f->last; f->side[at].edge >= 0; at = (at + 1) & f->last) {
        uint64_t home = dm_home_of(f, f->side[at].edge);
        if (((at - home) & f->last) >= ((at - hole) & f->last)) f->side[hole] = f->side[at], hole = at;
    }
    f->side[hole].edge = -1;
}

static int64_t dm_edge_of(const dm_flips *f, int64_t p, int64_t q) {
    return p < q ? p * f->n + q : q * f->n + p;
}

static int dm_wait(dm_flips *f, int64_t edge) {
    if (f->count == f->room) {
        int64_t *more = realloc(f->waiting, (size_t)(f->room *= 2) * sizeof *more);
        if (!more) return 0;
        f->waiting = more;
    }
    f->waiting[f->count++] = edge;
    return 1;
}

static void dm_way(const dm_flips *f, int64_t from, int64_t to, double *way) {
    for (int c = 0; c < 3; c++) way[c] = f->points[3 * to + c] - f->points[3 * from + c];
}

static double dm_inner(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void dm_normal_of(const dm_flips *f, int64_t a, int64_t b, int64_t c, double *normal) {
    double p[3], q[3];
    dm_way(f, a, b, p), dm_way(f, a, c, q);
    for (int k = 0; k < 3; k++) normal[k] = p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3];
}

static double dm_cotangent(const dm_flips *f, int64_t at, int64_t p, int64_t q, const double *normal) {
    double one[3], other[3];
    dm_way(f, at, p, one), dm_way(f, at, q, other);
    return dm_inner(one, other) / fmax(sqrt(dm_inner(normal, normal)), 1e-30);
}

/* Return whether triangles k i m and m j k are better than i j k and j i m: smaller angles, and equally flat. */
static int dm_is_better(const dm_flips *f, int64_t i, int64_t j, int64_t k, int64_t m) {
    double near[3], far[3], old[3], one[3], other[3];
    dm_normal_of(f, i, j, k, near), dm_normal_of(f, j, i, m, far);
    if (dm_cotangent(f, k, i, j, near) + dm_cotangent(f, m, i, j, far) >= -DM_EXACT) return 0;
    for (int c = 0; c < 3; c++) old[c] = near[c] + far[c];
    dm_normal_of(f, k, i, m, one), dm_normal_of(f, m, j, k, other);
    double flat = DM_CREASE * sqrt(dm_inner(old, old));
    return dm_inner(one, old) > flat * sqrt(dm_inner(one, one)) &&
           dm_inner(other, old) > flat * sqrt(dm_inner(other, other));
}

static int64_t dm_third(const int64_t *corner, int64_t i, int64_t j) {
    for (int c = 0; c < 2; c++)
        if (corner[c] != i && corner[c] != j) return corner[c];
    return corner[2];
}

static void dm_replace(dm_flips *f, int64_t edge, int64_t before, int64_t now) {
    dm_side *side = dm_find_side(f, edge);
    for (int k = 0; k < 2; k++)
        if (side->beside[k] == before) { side->beside[k] = now; return; }
}

/* Flip an edge if that is better; return 0 if memory runs out. */
static int dm_look_at(dm_flips *f, int64_t edge) {
    const dm_side *side = dm_find_side(f, edge);
    if (side->edge != edge || side->beside[1] < 0) return 1;
    int64_t a = side->beside[0], b = side->beside[1], i = edge / f->n, j = edge % f->n, *one = f->corners + 3 * a;
    for (int c = 0; c < 3; c++)
        if (one[c] == i && one[(c + 1) % 3] != j) { b = a, a = side->beside[1]; break; }
    int64_t k = dm_third(f->corners + 3 * a, i, j), m = dm_third(f->corners + 3 * b, i, j);
    int64_t other = dm_edge_of(f, k, m);
    if (k == m || dm_find_side(f, other)->edge == other || !dm_is_better(f, i, j, k, m)) return 1;
    int64_t now[2][3] = {{k, i, m}, {m, j, k}};
    for (int c = 0; c < 3; c++) f->corners[3 * a + c] = now[0][c], f->corners[3 * b + c] = now[1][c];
    dm_drop_side(f, edge);
    *dm_find_side(f, other) = (dm_side){other, {a, b}};
    dm_replace(f, dm_edge_of(f, i, m), b, a), dm_replace(f, dm_edge_of(f, j, k), a, b);
    int64_t low = k < m ? k : m, high = k < m ? m : k;
    return dm_wait(f, dm_edge_of(f, i, low)) && dm_wait(f, dm_edge_of(f, i, high)) &&
           dm_wait(f, dm_edge_of(f, j, low)) && dm_wait(f, dm_edge_of(f, j, high));
}

/* Store the triangles of each edge, and put all edges on the stack. */
static void dm_note_sides(dm_flips *f, int64_t triangles) {
    for (uint64_t k = 0; k <= f->last; k++) f->side[k].edge = -1;
    for (int64_t half = 0; half < 3 * triangles; half++) {
        int64_t t = half / 3, edge = dm_edge_of(f, f->corners[half], f->corners[3 * t + (half + 1) % 3]);
        dm_side *side = dm_find_side(f, edge);
        if (side->edge < 0) *side = (dm_side){edge, {t, -1}}, f->waiting[f->count++] = edge;
        else if (side->beside[0] < 0 || side->beside[1] >= 0) side->beside[0] = side->beside[1] = -1; /* a third */
        else side->beside[1] = t;
    }
}

static int dm_by_number(const void *a, const void *b) {
    int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

int32_t dm_flip_edges(int64_t vertices, const double *points, int64_t triangles, int64_t *corners) {
    if (vertices < 1 || vertices > DM_MAX_VERTICES || triangles < 0 || triangles > 2 * (int64_t)DM_MAX_VERTICES)
        return DM_SIZE;
    if (!points || !corners) return DM_SIZE;
    for (int64_t k = 0; k < 3 * triangles; k++)
        if (corners[k] < 0 || corners[k] >= vertices || corners[k] == corners[k - k % 3 + (k + 1) % 3]) return DM_INDEX;
    dm_flips f = {.n = vertices, .points = points, .corners = corners, .room = 3 * triangles + 4};
    uint64_t room = 1;
    while (room < 6 * (uint64_t)triangles + 2) room *= 2;
    f.last = room - 1, f.side = malloc(room * sizeof *f.side), f.waiting = malloc((size_t)f.room * sizeof *f.waiting);
    int there = f.side && f.waiting;
    if (there) {
        dm_note_sides(&f, triangles);
        qsort(f.waiting, (size_t)f.count, sizeof *f.waiting, dm_by_number);
    }
    for (int64_t looks = DM_LOOKS * f.count; there && f.count && looks; looks--)
        there = dm_look_at(&f, f.waiting[--f.count]);
    free(f.side), free(f.waiting);
    return there ? DM_OK : DM_MEMORY;
}
