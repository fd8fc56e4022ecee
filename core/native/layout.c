/* The order of the vertices in memory, with neighbours close together. */
#include "body.h"

typedef struct { /* a vertex, triangle or side of a triangle, to be sorted */
    uint64_t key;
    uint32_t number;
} dm_keyed;

/* put two zeros between the 21 low bits */
static uint64_t dm_spread_bits(uint64_t a) {
    a &= 0x1fffff;
    a = (a | a << 32) & 0x1f00000000ffff;
    a = (a | a << 16) & 0x1f0000ff0000ff;
    a = (a | a << 8) & 0x100f00f00f00f00f;
    a = (a | a << 4) & 0x10c30c30c30c30c3;
    return (a | a << 2) & 0x1249249249249249;
}

static int dm_by_key(const void *a, const void *b) {
    const dm_keyed *p = a, *q = b;
    if (p->key != q->key) return p->key < q->key ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

/* Order points (3, n) along a Morton curve, so that runs are close in space. */
static void dm_order_along_curve(const double *points, int64_t n, dm_keyed *keys) {
    double low[3], span = 0;
    for (int c = 0; c < 3; c++) {
        double high = low[c] = points[c * n];
        for (int64_t i = 0; i < n; i++) {
            double x = points[c * n + i];
            low[c] = x < low[c] ? x : low[c], high = x > high ? x : high;
        }
        span = high - low[c] > span ? high - low[c] : span;
    }
    double scale = span > 0 ? 0x1fffff / span : 0;
    for (int64_t i = 0; i < n; i++) {
        uint64_t key = 0;
        for (int c = 0; c < 3; c++) {
            double cell = (points[c * n + i] - low[c]) * scale;
            key |= dm_spread_bits((uint64_t)(cell < 0x1fffff ? cell : 0x1fffff)) << c;
        }
        keys[i] = (dm_keyed){key, (uint32_t)i};
    }
    qsort(keys, (size_t)n, sizeof *keys, dm_by_key);
}

/* Order the vertices by breadth-first search: all neighbours then lie within two adjacent levels, so that a step
 * streams through memory once. Source: Cuthill and McKee 1969. */
static void dm_order_by_wave(const dm_state *b, dm_keyed *keys, uint8_t *seen, int64_t width, const int64_t *ring,
                        const int64_t *ring_spring) {
    int64_t n = b->n, done = 0, found = 0;
    uint32_t *queue = b->place;
    for (int64_t k = 0; k < n; k++) {
        if (!seen[keys[k].number]) seen[keys[k].number] = 1, queue[found++] = keys[k].number;
        for (; done < found; done++) {
            uint32_t i = queue[done];
            for (int64_t s = 0; s < width && ring_spring[s * n + i] >= 0; s++) {
                int64_t j = ring[s * n + i];
                if (!seen[j]) seen[j] = 1, queue[found++] = (uint32_t)j;
            }
        }
    }
    for (int64_t k = 0; k < n; k++) keys[k].number = queue[k];
}

/* Number the vertices by that order, then by valence within parts of the size of a slice, so that the eight of a group
 * have similar numbers of neighbours and few slots stay empty. */
static int32_t dm_lay_out(dm_state *b, int64_t width, const int64_t *ring, const int64_t *ring_spring) {
    int64_t n = b->n;
    dm_keyed *keys = dm_alloc(n, sizeof(dm_keyed));
    uint8_t *seen = dm_alloc(n, 1);
    if (!keys || !seen) return dm_free(keys), dm_free(seen), DM_MEMORY;
    dm_order_along_curve(b->rest, n, keys);
    for (int64_t k = 0; k < n; k++) b->rank[keys[k].number] = (uint32_t)k;
    dm_order_by_wave(b, keys, seen, width, ring, ring_spring);
    for (int64_t k = 0; k < n; k++) {
        uint64_t valence = 0;
        for (int64_t s = 0; s < width; s++) valence += ring_spring[s * n + keys[k].number] >= 0;
        keys[k].key = (uint64_t)(k / DM_SLICE) << 40 | valence << 32 | (uint64_t)k;
    }
    qsort(keys, (size_t)n, sizeof *keys, dm_by_key);
    for (int64_t k = 0; k < n; k++) b->place[keys[k].number] = (uint32_t)k;
    dm_free(keys), dm_free(seen);
    return DM_OK;
}

/* Store the rings lane by lane. A vertex with fewer neighbours than its group repeats its first, one without neighbours
 * repeats itself. */
static int32_t dm_lay_rings(dm_state *b, int64_t width, const int64_t *ring, const int64_t *ring_spring) {
    int64_t n = b->n, size = b->groups * DM_LANES;
    int64_t *vertex = dm_alloc(size, sizeof(int64_t));
    b->ring.start = dm_alloc(b->groups + 1, sizeof(int64_t));
    if (!vertex || !b->ring.start) return dm_free(vertex), DM_MEMORY;
    for (int64_t i = 0; i < size; i++) vertex[i] = -1;
    for (int64_t i = 0; i < n; i++) vertex[b->place[i]] = i;
    for (int64_t g = 0; g < b->groups; g++) {
        int64_t most = 0;
        for (int l = 0; l < DM_LANES; l++) {
            int64_t i = vertex[g * DM_LANES + l], valence = 0;
            while (i >= 0 && valence < width && ring_spring[valence * n + i] >= 0) valence++;
            most = valence > most ? valence : most;
        }
        b->ring.start[g + 1] = b->ring.start[g] + most;
    }
    int64_t slots = b->ring.start[b->groups];
    b->ring.slots = dm_alloc(slots, sizeof(dm_slot));
    b->ring_spring = dm_alloc(slots * DM_LANES, sizeof(int32_t));
    if (!b->ring.slots || !b->ring_spring) return dm_free(vertex), DM_MEMORY;
    for (int64_t g = 0; g < b->groups; g++)
        for (int64_t s = b->ring.start[g]; s < b->ring.start[g + 1]; s++)
            for (int l = 0; l < DM_LANES; l++) {
                int64_t i = vertex[g * DM_LANES + l], at = s - b->ring.start[g];
                int64_t spring = i >= 0 && ring_spring[i] >= 0 ? ring_spring[at * n + i] : -1;
                int64_t other = i >= 0 && ring_spring[i] >= 0 ? b->place[ring[at * n + i]] : g * DM_LANES + l;
                b->ring_spring[s * DM_LANES + l] = (int32_t)spring;
                b->ring.slots[s].at[l] = (uint32_t)((uint64_t)other * sizeof(dm_record));
            }
    dm_free(vertex);
    return DM_OK;
}
