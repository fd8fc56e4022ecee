/* Eight vertices at once, as the compiler's own vectors: the same source and the same sums on every machine. */
#ifndef DM_LANES_H
#define DM_LANES_H
#include <math.h>
#include <stdint.h>

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

#define JOIN(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7)
#define LOW(a) __builtin_shufflevector(a, a, 0, 1, 2, 3)
#define HIGH(a) __builtin_shufflevector(a, a, 4, 5, 6, 7)
#define ZIP_LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define ZIP_HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define PAIR_LOW(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define PAIR_HIGH(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)

/* transpose eight quads into lanes */
static inline three lanes_of(quad q0, quad q1, quad q2, quad q3, quad q4, quad q5, quad q6, quad q7) {
    lanes r0 = JOIN(q0, q4), r1 = JOIN(q1, q5), r2 = JOIN(q2, q6), r3 = JOIN(q3, q7);
    lanes t0 = ZIP_LOW(r0, r1), t1 = ZIP_LOW(r2, r3), t2 = ZIP_HIGH(r0, r1), t3 = ZIP_HIGH(r2, r3);
    return (three){PAIR_LOW(t0, t1), PAIR_HIGH(t0, t1), PAIR_LOW(t2, t3)};
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
