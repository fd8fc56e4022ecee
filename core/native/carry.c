/* A fine surface carried by a proxy. Source: core/reduction/binding.py. */
#include "lanes.h"
#include "dimple.h"

enum { DM_ABREAST = 8 }; /* vertices whose weights become numbers at once */

/* Carry some vertices; rows are read and written whole where another one follows, 12 bytes wide at the end. */
DM_INLINE void dm_carry_some(const dm_binding *of, const float *motions, float *skin, int64_t first, int count,
                             size_t row) {
    typedef float dm_eight __attribute__((vector_size(32)));
    typedef float dm_four __attribute__((vector_size(16)));
    const dm_four centre = {(float)of->centre[0], (float)of->centre[1], (float)of->centre[2], 0};
    float weights[DM_ABREAST * DM_FOLLOWED];
    for (int k = 0; k < count * DM_FOLLOWED; k++) weights[k] = of->weights[DM_FOLLOWED * first + k];
    for (int i = 0; i < count; i++) {
        const uint16_t *follows = of->followed + DM_FOLLOWED * (first + i);
        dm_eight sum[2] = {{0}, {0}};
        DM_BY_FOUR for (int k = 0; k < DM_FOLLOWED; k++) {
            dm_eight motion[2];
            memcpy(motion, motions + 16 * (int64_t)follows[k], sizeof motion);
            sum[0] += motion[0] * weights[DM_FOLLOWED * i + k], sum[1] += motion[1] * weights[DM_FOLLOWED * i + k];
        }
        /* the shift and the columns of the gradient; beside them the middle of the seeds */
        dm_four way[4], rest = {0};
        memcpy(way, sum, sizeof way), memcpy(&rest, of->rest + 3 * (first + i), row);
        dm_four lever = 2 * rest - centre - (dm_four){way[0][3], way[1][3], way[2][3], 0};
        way[0] += way[1] * lever[0];
        way[0] += way[2] * lever[1];
        way[0] += way[3] * lever[2];
        rest += way[0];
        memcpy(skin + 3 * (first + i), &rest, row);
    }
}

/* Return DM_INDEX, and carry no more, where a vertex follows one that there is not. */
static int32_t dm_carry_surface(const dm_binding *of, const float *motions, float *skin) {
    for (int64_t i = 0, count; i < of->vertices; i += count) {
        uint16_t most = 0;
        count = i + DM_ABREAST < of->vertices ? DM_ABREAST : 1;
        for (int64_t k = DM_FOLLOWED * i; k < DM_FOLLOWED * (i + count); k++)
            most = of->followed[k] > most ? of->followed[k] : most;
        if (most >= of->seeds) return DM_INDEX;
        if (count == 1) dm_carry_some(of, motions, skin, i, 1, 12);
        else dm_carry_some(of, motions, skin, i, DM_ABREAST, 16);
    }
    return DM_OK;
}
