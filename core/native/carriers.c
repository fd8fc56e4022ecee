/* The affine motions of the vertices of a proxy, which carry the fine surface. Source: core/reduction/binding.py.
 * Compiled once. */
#include "carriers.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef double dm_point __attribute__((vector_size(32), aligned(8))); /* x y z, the fourth unused */
typedef float dm_single __attribute__((vector_size(16), aligned(4), may_alias));
#define DM_POINT(x, stride) ((dm_point){(x)[0], (x)[stride], (x)[2 * (stride)]})

/* Set unit normals (seeds,), 0 where undefined. */
static void dm_find_normals(const dm_binding *b, const dm_point *x, dm_point *normal) {
    memset(normal, 0, (size_t)b->seeds * sizeof *normal);
    for (int64_t t = 0; t < b->triangles; t++) {
        const int64_t *corner = b->corners + 3 * t;
        dm_point a = x[corner[1]] - x[corner[0]], c = x[corner[2]] - x[corner[0]];
        dm_point area = {a[1] * c[2] - a[2] * c[1], a[2] * c[0] - a[0] * c[2], a[0] * c[1] - a[1] * c[0]};
        for (int k = 0; k < 3; k++) normal[corner[k]] += area;
    }
    for (int64_t i = 0; i < b->seeds; i++) {
        dm_point square = normal[i] * normal[i];
        normal[i] /= fmax(sqrt(square[0] + square[1] + square[2]), 1e-30);
    }
}

int32_t dm_find_motions(const dm_binding *b, const double *positions, float *motions) {
    dm_point *x = malloc(4 * (size_t)b->seeds * sizeof *x), *rest = x + b->seeds;
    dm_point *normal = rest + b->seeds, *before = normal + b->seeds;
    if (!x) return DM_MEMORY;
    for (int64_t i = 0; i < b->seeds; i++) {
        x[i] = DM_POINT(positions + i, b->seeds);
        rest[i] = DM_POINT(b->coarse_rest + 3 * i, 1);
    }
    dm_find_normals(b, rest, before); /* computed as those of x, so that at rest the rotation is exactly none */
    dm_find_normals(b, x, normal);
    for (int64_t i = 0; i < b->seeds; i++) x[i] -= rest[i], normal[i] -= before[i];
    for (int64_t i = 0; i < b->seeds; i++) {
        const double *upright = b->upright + 3 * i;
        dm_point half[4], arm = (rest[i] - DM_POINT(b->centre, 1)) / 2; /* the displacement, and the columns of the gradient */
        half[0] = x[i];
        for (int d = 0; d < 3; d++) half[1 + d] = upright[d] * normal[i];
        for (int64_t k = b->starts[i]; k < b->starts[i + 1]; k++) {
            const double *spread = b->spread + 3 * k;
            dm_point way = x[b->ends[k]] - x[i];
            half[1] += spread[0] * way, half[2] += spread[1] * way, half[3] += spread[2] * way;
        }
        for (int d = 0; d < 3; d++) half[0] -= half[1 + d] * arm[d], half[1 + d] /= 2;
        for (int k = 0; k < 12; k++) motions[12 * i + k] = (float)(half[k / 3][k % 3] / UINT16_MAX);
    }
    free(x);
    return DM_OK;
}

int32_t dm_carry_by_nodes(int64_t vertices, int64_t nodes, const uint16_t *by, const float *shares, const float *values,
                          float *carried) {
    if (vertices < 0 || vertices > DM_MAX_VERTICES || !by || !shares || !values || !carried) return DM_SIZE;
    for (int64_t v = 0; v < vertices; v++) {
        dm_single sum = {0};
        for (const uint16_t *node = by + 8 * v; node < by + 8 * v + 8; node++) {
            if (*node >= nodes) return DM_INDEX;
            sum += shares[node - by] * *(const dm_single *)(values + 4 * *node);
        }
        memcpy(carried + 3 * v, &sum, 3 * sizeof *carried);
    }
    return DM_OK;
}
