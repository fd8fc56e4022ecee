/* A fine surface carried by a proxy. Source: core/reduction/binding.py. */
#include "lanes.h"
#include "dimple.h"

static void dm_carry_surface(const dm_binding *b, const float *motions, float *skin) {
    typedef float dm_eight __attribute__((vector_size(32)));
    typedef float dm_four __attribute__((vector_size(16)));
    for (int64_t i = 0; i < b->vertices; i++) {
        const uint16_t *follows = b->followed + i * b->each;
        const float *weights = b->weights + i * b->each, *l = b->lever + 3 * i, *rest = b->rest + 3 * i;
        dm_eight head = {0};
        dm_four tail = {0};
        for (int64_t k = 0; k < b->each; k++) {
            const float *motion = motions + 12 * (int64_t)follows[k];
            dm_eight first;
            dm_four last;
            memcpy(&first, motion, sizeof first), memcpy(&last, motion + 8, sizeof last);
            head += first * weights[k], tail += last * weights[k];
        }
        skin[3 * i] = rest[0] + (head[0] + (head[3] * l[0] + head[4] * l[1] + head[5] * l[2]));
        skin[3 * i + 1] = rest[1] + (head[1] + (head[6] * l[0] + head[7] * l[1] + tail[0] * l[2]));
        skin[3 * i + 2] = rest[2] + (head[2] + (tail[1] * l[0] + tail[2] * l[1] + tail[3] * l[2]));
    }
}
