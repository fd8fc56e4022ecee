/* What the parts of a step cost: SPENDS(part, call) makes the call, and in a build for tests/bench/profile.py notes the
 * time. Nothing else pays for it. */
#ifndef DM_SPENT_H
#define DM_SPENT_H

enum { FITS, RINGS, LOOSE_AND_FILL, ADVANCE, CONTACT, REACH, PARTS };

#ifdef DM_PROFILE
#include <time.h>
#define SPENT_NAME(set, bits) dm_spent_##set##_##bits
#define SPENT(set, bits) SPENT_NAME(set, bits)

extern DM_API double SPENT(DM_SET, DM_BITS)[PARTS];
double SPENT(DM_SET, DM_BITS)[PARTS]; /* [s] */

static double now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#define SPENDS(part, ...)                                    \
    do {                                                     \
        double started_ = now();                             \
        __VA_ARGS__;                                         \
        SPENT(DM_SET, DM_BITS)[part] += now() - started_;    \
    } while (0)
#else
#define SPENDS(part, ...) __VA_ARGS__
#endif
#endif
