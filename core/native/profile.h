/* The time of each part of a step: DM_TIMED(part, call) makes the call and, in a build for tests/bench/profile.py, adds
 * up its time. Other builds have no overhead. */
#ifndef DM_PROFILE_H
#define DM_PROFILE_H

enum { DM_FITS, DM_RINGS, DM_IRREGULAR_AND_FILL, DM_ADVANCE, DM_CONTACT, DM_REACH, DM_PARTS };

#ifdef DM_PROFILE
#include <time.h>
#define DM_SECONDS_NAME(set, bits) dm_seconds_##set##_##bits
#define DM_SECONDS(set, bits) DM_SECONDS_NAME(set, bits)

extern DM_API double DM_SECONDS(DM_SET, DM_BITS)[DM_PARTS];
double DM_SECONDS(DM_SET, DM_BITS)[DM_PARTS]; /* [s] */

static double dm_now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#define DM_TIMED(part, ...)                                    \
    do {                                                       \
        double started_ = dm_now();                            \
        __VA_ARGS__;                                           \
        DM_SECONDS(DM_SET, DM_BITS)[part] += dm_now() - started_; \
    } while (0)
#else
#define DM_TIMED(part, ...) __VA_ARGS__
#endif
#endif
