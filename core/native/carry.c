/* A fine surface carried by a proxy. Source: core/reduction/binding.py. */
#include "lanes.h"
#include "dimple.h"

static void dm_carry_surface(const dm_binding *of, const float *motions, float *skin) {
    typedef uint16_t dm_shares __attribute__((vector_size(16)));
    typedef float dm_eight __attribute__((vector_size(32)));
    typedef float dm_four __attribute__((vector_size(16)));
    const float centre[3] = {(float)of->centre[0], (float)of->centre[1], (float)of->centre[2]};
    for (int64_t i = 0; i < of->vertices; i++) {
        const uint16_t *follows = of->followed + DM_FOLLOWED * i;
        const float *rest = of->rest + 3 * i;
        dm_shares shares;
        memcpy(&shares, of->weights + DM_FOLLOWED * i, sizeof shares);
        dm_eight weights = __builtin_convertvector(shares, dm_eight), a = {0}, b = {0};
        for (int k = 0; k < DM_FOLLOWED; k++) {
            dm_eight motion[2];
            memcpy(motion, motions + 16 * (int64_t)follows[k], sizeof motion);
            a += motion[0] * weights[k], b += motion[1] * weights[k];
        }
        /* the shift and the columns of the gradient; beside them the middle of the seeds */
        dm_four way = {a[0], a[1], a[2], 0}, x = {a[4], a[5], a[6], 0}, y = {b[0], b[1], b[2], 0};
        dm_four z = {b[4], b[5], b[6], 0};
        way += x * (2 * rest[0] - centre[0] - a[3]);
        way += y * (2 * rest[1] - centre[1] - a[7]);
        way += z * (2 * rest[2] - centre[2] - b[3]);
        for (int c = 0; c < 3; c++) skin[3 * i + c] = rest[c] + way[c];
    }
}
