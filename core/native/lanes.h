/* Eight vertices at once, as the compiler's own vectors: the same source and the same sums on every machine. */
#ifndef DM_LANES_H
#define DM_LANES_H
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" /* vectors go by value between static functions only */
#endif

#define LANES 8
#define TINY ((real)1e-30)

#if DM_BITS == 32
typedef float real;
typedef int32_t bits;
#define SQRT sqrtf
#else
typedef double real;
typedef int64_t bits;
#define SQRT sqrt
#endif

typedef real lanes __attribute__((vector_size(LANES * sizeof(real))));
typedef bits mask __attribute__((vector_size(LANES * sizeof(real))));
typedef double wide __attribute__((vector_size(LANES * sizeof(double))));
typedef real quad __attribute__((vector_size(4 * sizeof(real)))); /* x y z and nothing */

typedef struct { /* one vertex, in one or two loads: what its neighbours gather */
    quad x, v;
} record;

typedef struct { /* a vector in each lane */
    lanes x, y, z;
} three;

static inline lanes all(real a) { return (lanes){a, a, a, a, a, a, a, a}; }

static inline lanes select(mask which, lanes yes, lanes no) {
    return (lanes)((which & (mask)yes) | (~which & (mask)no));
}

static inline lanes larger(lanes a, lanes b) { return select((mask)(a > b), a, b); }

static inline lanes root(lanes a) {
#if defined(__clang__)
    return __builtin_elementwise_sqrt(a);
#else
    lanes r;
    for (int i = 0; i < LANES; i++) r[i] = SQRT(a[i]);
    return r;
#endif
}

static inline int any(mask a) {
#if defined(__clang__)
    return __builtin_reduce_or(a) != 0;
#else
    bits r = 0;
    for (int i = 0; i < LANES; i++) r |= a[i];
    return r != 0;
#endif
}

static inline wide widen(lanes a) { return __builtin_convertvector(a, wide); }

/* always the same tree, so that a sum is the same everywhere */
static inline double total(wide a) { return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7])); }

static inline lanes dot(three a, three b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline three minus(three a, three b) { return (three){a.x - b.x, a.y - b.y, a.z - b.z}; }

static inline three cross(three a, three b) {
    return (three){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline real dot3(quad a, quad b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline quad quad_of(const double *a) { return (quad){(real)a[0], (real)a[1], (real)a[2], 0}; }

/* sums in single precision for a few groups only, then in double */
enum { RUN = 8 };

static inline void fold(lanes *part, wide *sum, int count) {
    for (int k = 0; k < count; k++) sum[k] += widen(part[k]), part[k] = all(0);
}

static inline three splat3(const double *a) { return (three){all((real)a[0]), all((real)a[1]), all((real)a[2])}; }

#define LOW(a) __builtin_shufflevector(a, a, 0, 1, 2, 3)
#define HIGH(a) __builtin_shufflevector(a, a, 4, 5, 6, 7)
#define BEFORE(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define AFTER(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)
#define ZIP_LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define ZIP_HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define PAIR_LOW(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define PAIR_HIGH(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)

/* the positions and velocities of the eight records at these offsets, in lanes */
static inline void lanes_of(const void *records, const uint32_t *at, three *x, three *v) {
    lanes r[8];
    for (int l = 0; l < LANES; l++) memcpy(r + l, (const char *)records + at[l], sizeof *r);
    lanes xy0 = ZIP_LOW(r[0], r[1]), xy2 = ZIP_LOW(r[2], r[3]), xy4 = ZIP_LOW(r[4], r[5]), xy6 = ZIP_LOW(r[6], r[7]);
    lanes z0 = ZIP_HIGH(r[0], r[1]), z2 = ZIP_HIGH(r[2], r[3]), z4 = ZIP_HIGH(r[4], r[5]), z6 = ZIP_HIGH(r[6], r[7]);
    lanes low[3] = {PAIR_LOW(xy0, xy2), PAIR_HIGH(xy0, xy2), PAIR_LOW(z0, z2)};
    lanes high[3] = {PAIR_LOW(xy4, xy6), PAIR_HIGH(xy4, xy6), PAIR_LOW(z4, z6)};
    *x = (three){BEFORE(low[0], high[0]), BEFORE(low[1], high[1]), BEFORE(low[2], high[2])};
    *v = (three){AFTER(low[0], high[0]), AFTER(low[1], high[1]), AFTER(low[2], high[2])};
}

/* and back, into the x or v of eight records in a row */
static inline void quads_of(three a, quad *to) {
    const int stride = sizeof(record) / sizeof(quad);
    lanes none = all(0);
    lanes t0 = ZIP_LOW(a.x, a.y), t1 = ZIP_LOW(a.z, none), t2 = ZIP_HIGH(a.x, a.y), t3 = ZIP_HIGH(a.z, none);
    lanes r0 = PAIR_LOW(t0, t1), r1 = PAIR_HIGH(t0, t1), r2 = PAIR_LOW(t2, t3), r3 = PAIR_HIGH(t2, t3);
    to[0] = LOW(r0), to[stride] = LOW(r1), to[2 * stride] = LOW(r2), to[3 * stride] = LOW(r3);
    to[4 * stride] = HIGH(r0), to[5 * stride] = HIGH(r1), to[6 * stride] = HIGH(r2), to[7 * stride] = HIGH(r3);
}
#endif
