/* What the parts of a step cost: DM_TIMED(part, call) makes the call, and in a build for tests/bench/profile.py notes the
 * time. Nothing else pays for it. */
#ifndef DM_PROFILE_H
#define DM_PROFILE_H

enum { FITS, RINGS, IRREGULAR_AND_FILL, ADVANCE, CONTACT, REACH, PARTS };

#ifdef DM_PROFILE
#include <time.h>
#define DM_SECONDS_NAME(set, bits) dm_seconds_##set##_##bits
#define DM_SECONDS(set, bits) DM_SECONDS_NAME(set, bits)

extern DM_API double DM_SECONDS(DM_SET, DM_BITS)[PARTS];
double DM_SECONDS(DM_SET, DM_BITS)[PARTS]; /* [s] */

static double now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#define DM_TIMED(part, ...)                                    \
    do {                                                     \
        double started_ = now();                             \
        __VA_ARGS__;                                         \
        DM_SECONDS(DM_SET, DM_BITS)[part] += now() - started_;    \
    } while (0)
#else
#define DM_TIMED(part, ...) __VA_ARGS__
#endif
#endif
