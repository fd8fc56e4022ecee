/* A fine surface carried by a proxy, eight vertices at once. Source: core/reduction/binding.py. */
#include "dimple.h"
#include "lanes.h"

typedef float dm_eight __attribute__((vector_size(32)));
typedef int32_t dm_eight_int __attribute__((vector_size(32)));
typedef uint16_t dm_eight_short __attribute__((vector_size(16)));

DM_INLINE dm_eight dm_all_eight(float a) { return (dm_eight){a, a, a, a, a, a, a, a}; }

static void dm_carry_surface(const dm_binding *of, const float *motions, float *skin) {
    for (int64_t g = 0; 8 * g < of->vertices; g++) {
        dm_eight shift[3] = {{0}}, gradient[3][3] = {{{0}}}, place[6];
        for (int64_t k = of->first[g]; k < of->first[g + 1]; k++) {
            const float *motion = motions + 12 * (int64_t)of->followed[k];
            dm_eight_short share;
            memcpy(&share, of->weights + 8 * k, sizeof share);
            dm_eight weight = __builtin_convertvector(__builtin_convertvector(share, dm_eight_int), dm_eight);
            DM_UNROLLED for (int c = 0; c < 3; c++) {
                shift[c] += weight * dm_all_eight(motion[c]);
                DM_UNROLLED for (int d = 0; d < 3; d++) gradient[d][c] += weight * dm_all_eight(motion[3 + 3 * d + c]);
            }
        }
        memcpy(place, of->places + 48 * g, sizeof place);
        float to[8][3];
        DM_UNROLLED for (int c = 0; c < 3; c++) {
            DM_UNROLLED for (int d = 0; d < 3; d++) shift[c] += gradient[d][c] * place[3 + d];
            shift[c] += place[c];
            DM_UNROLLED for (int i = 0; i < 8; i++) to[i][c] = shift[c][i];
        }
        int64_t left = of->vertices - 8 * g;
        if (left >= 8) memcpy(skin + 24 * g, to, sizeof to);
        else memcpy(skin + 24 * g, to, (size_t)left * sizeof *to);
    }
}
