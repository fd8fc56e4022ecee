/* Eight vertices at once, in the compiler's vector types: the same source and the same sums on every machine. */
#ifndef DM_LANES_H
#define DM_LANES_H
#include "constants.h"
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" /* it concerns vectors passed by value between objects: none are */
#endif
#define DM_INLINE static inline __attribute__((always_inline))
#if defined(__clang__)
#define DM_UNROLLED _Pragma("clang loop unroll(full)") /* other loops are not unrolled: the library would be larger */
#else
#define DM_UNROLLED
#endif
#if defined(__clang__) && defined(__AVX2__) /* full unrolling adds 2 kB to the zip and is no faster */
#define DM_BY_FOUR _Pragma("clang loop unroll_count(4)")
#else
#define DM_BY_FOUR
#endif
#define DM_LEAST ((dm_real)DM_TINY)

#if DM_BITS == 32
typedef float dm_real;
typedef int32_t dm_int;
#define DM_SQRT sqrtf
#else
typedef double dm_real;
typedef int64_t dm_int;
#define DM_SQRT sqrt
#endif

typedef dm_real dm_lanes __attribute__((vector_size(DM_LANES * sizeof(dm_real))));
typedef dm_int dm_mask __attribute__((vector_size(DM_LANES * sizeof(dm_real))));
typedef double dm_wide __attribute__((vector_size(DM_LANES * sizeof(double))));
typedef dm_real dm_quad __attribute__((vector_size(4 * sizeof(dm_real)))); /* x, y, z, and a fourth number or 0 */

typedef struct { /* one vertex, as its neighbours gather it: in one or two loads */
    dm_quad x, v;
} dm_record;

typedef struct { /* a vector in each lane */
    dm_lanes x, y, z;
} dm_vec3;

typedef struct { /* the same in double precision */
    dm_wide x, y, z;
} dm_wide3;

DM_INLINE dm_lanes dm_splat(dm_real a) { return (dm_lanes){a, a, a, a, a, a, a, a}; }

DM_INLINE dm_lanes dm_blend(dm_mask which, dm_lanes yes, dm_lanes no) {
    return (dm_lanes)((which & (dm_mask)yes) | (~which & (dm_mask)no));
}

DM_INLINE dm_lanes dm_vmax(dm_lanes a, dm_lanes b) { return dm_blend((dm_mask)(a > b), a, b); }

DM_INLINE dm_lanes dm_vsqrt(dm_lanes a) {
#if defined(__clang__)
    return __builtin_elementwise_sqrt(a);
#else
    dm_lanes r = a;
    for (int i = 0; i < DM_LANES; i++) r[i] = DM_SQRT(a[i]);
    return r;
#endif
}

DM_INLINE int dm_any_of(dm_mask a) {
#if defined(__clang__)
    return __builtin_reduce_or(a) != 0;
#else
    dm_int r = 0;
    for (int i = 0; i < DM_LANES; i++) r |= a[i];
    return r != 0;
#endif
}

DM_INLINE dm_wide dm_widen(dm_lanes a) { return __builtin_convertvector(a, dm_wide); }

DM_INLINE dm_lanes dm_narrow(dm_wide a) { return __builtin_convertvector(a, dm_lanes); }

/* Return the sum of the lanes, always in the same order, so that it is the same on every machine. */
DM_INLINE double dm_sum_of(dm_wide a) { return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7])); }

DM_INLINE double dm_most_of(dm_lanes a) {
    dm_real most = a[0];
    for (int l = 1; l < DM_LANES; l++) most = a[l] > most ? a[l] : most;
    return (double)most;
}

DM_INLINE dm_lanes dm_dot(dm_vec3 a, dm_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

DM_INLINE dm_vec3 dm_sub(dm_vec3 a, dm_vec3 b) { return (dm_vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }

DM_INLINE dm_vec3 dm_rotated(const dm_vec3 *rows, dm_vec3 q, dm_vec3 offset) {
    return (dm_vec3){dm_dot(rows[0], q) + offset.x, dm_dot(rows[1], q) + offset.y, dm_dot(rows[2], q) + offset.z};
}

DM_INLINE dm_vec3 dm_cross(dm_vec3 a, dm_vec3 b) {
    return (dm_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

DM_INLINE dm_real dm_dot3(dm_quad a, dm_quad b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

DM_INLINE dm_quad dm_quad_of(const double *a) { return (dm_quad){(dm_real)a[0], (dm_real)a[1], (dm_real)a[2], 0}; }

enum { DM_RUN = 8 }; /* groups over which a sum is in single precision before it is added in double */

DM_INLINE void dm_fold(dm_lanes *part, dm_wide *sum, int count) {
    for (int k = 0; k < count; k++) sum[k] += dm_widen(part[k]), part[k] = dm_splat(0);
}

DM_INLINE dm_vec3 dm_splat3(const double *a) {
    return (dm_vec3){dm_splat((dm_real)a[0]), dm_splat((dm_real)a[1]), dm_splat((dm_real)a[2])};
}

#define DM_LOW(a) __builtin_shufflevector(a, a, 0, 1, 2, 3)
#define DM_HIGH(a) __builtin_shufflevector(a, a, 4, 5, 6, 7)
#define DM_JOINED(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7)
#define DM_BEFORE(a, b) __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define DM_AFTER(a, b) __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15)
#define DM_ZIP_LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define DM_ZIP_HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define DM_PAIR_LOW(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define DM_PAIR_HIGH(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)

/* Gather the positions and velocities of the eight records at these byte offsets, in lanes. */
DM_INLINE void dm_gather8(const void *records, const uint32_t *at, dm_vec3 *x, dm_vec3 *v) {
    dm_lanes r[8];
    DM_UNROLLED for (int l = 0; l < DM_LANES; l++) memcpy(r + l, (const char *)records + at[l], sizeof *r);
    dm_lanes xy0 = DM_ZIP_LOW(r[0], r[1]), xy2 = DM_ZIP_LOW(r[2], r[3]);
    dm_lanes xy4 = DM_ZIP_LOW(r[4], r[5]), xy6 = DM_ZIP_LOW(r[6], r[7]);
    dm_lanes z0 = DM_ZIP_HIGH(r[0], r[1]), z2 = DM_ZIP_HIGH(r[2], r[3]);
    dm_lanes z4 = DM_ZIP_HIGH(r[4], r[5]), z6 = DM_ZIP_HIGH(r[6], r[7]);
    dm_lanes low[3] = {DM_PAIR_LOW(xy0, xy2), DM_PAIR_HIGH(xy0, xy2), DM_PAIR_LOW(z0, z2)};
    dm_lanes high[3] = {DM_PAIR_LOW(xy4, xy6), DM_PAIR_HIGH(xy4, xy6), DM_PAIR_LOW(z4, z6)};
    *x = (dm_vec3){DM_BEFORE(low[0], high[0]), DM_BEFORE(low[1], high[1]), DM_BEFORE(low[2], high[2])};
    *v = (dm_vec3){DM_AFTER(low[0], high[0]), DM_AFTER(low[1], high[1]), DM_AFTER(low[2], high[2])};
}

DM_INLINE dm_quad *dm_quad_at(const void *from, uint32_t at) { return (dm_quad *)((char *)from + at); }

/* Gather the quads at eight byte offsets: return their vectors in lanes, and set the fourth numbers. */
DM_INLINE dm_vec3 dm_gather_quads(const void *from, const uint32_t *at, dm_lanes *fourth) {
    dm_lanes r0 = DM_JOINED(*dm_quad_at(from, at[0]), *dm_quad_at(from, at[4]));
    dm_lanes r1 = DM_JOINED(*dm_quad_at(from, at[1]), *dm_quad_at(from, at[5]));
    dm_lanes r2 = DM_JOINED(*dm_quad_at(from, at[2]), *dm_quad_at(from, at[6]));
    dm_lanes r3 = DM_JOINED(*dm_quad_at(from, at[3]), *dm_quad_at(from, at[7]));
    dm_lanes xy0 = DM_ZIP_LOW(r0, r1), xy2 = DM_ZIP_LOW(r2, r3), z0 = DM_ZIP_HIGH(r0, r1), z2 = DM_ZIP_HIGH(r2, r3);
    *fourth = DM_PAIR_HIGH(z0, z2);
    return (dm_vec3){DM_PAIR_LOW(xy0, xy2), DM_PAIR_HIGH(xy0, xy2), DM_PAIR_LOW(z0, z2)};
}

/* Set eight quads to the vectors of the lanes, each with its fourth number. */
DM_INLINE void dm_quads_of(dm_vec3 a, dm_lanes fourth, dm_quad *to) {
    dm_lanes t0 = DM_ZIP_LOW(a.x, a.y), t1 = DM_ZIP_LOW(a.z, fourth);
    dm_lanes t2 = DM_ZIP_HIGH(a.x, a.y), t3 = DM_ZIP_HIGH(a.z, fourth);
    dm_lanes r0 = DM_PAIR_LOW(t0, t1), r1 = DM_PAIR_HIGH(t0, t1), r2 = DM_PAIR_LOW(t2, t3), r3 = DM_PAIR_HIGH(t2, t3);
    to[0] = DM_LOW(r0), to[1] = DM_LOW(r1), to[2] = DM_LOW(r2), to[3] = DM_LOW(r3);
    to[4] = DM_HIGH(r0), to[5] = DM_HIGH(r1), to[6] = DM_HIGH(r2), to[7] = DM_HIGH(r3);
}

/* Scatter eight lanes to consecutive records. */
DM_INLINE void dm_scatter8(dm_vec3 x, dm_vec3 v, dm_record *to) {
    dm_quad at[DM_LANES], speed[DM_LANES];
    dm_quads_of(x, dm_splat(0), at), dm_quads_of(v, dm_splat(0), speed);
    DM_UNROLLED for (int l = 0; l < DM_LANES; l++) to[l] = (dm_record){at[l], speed[l]};
}
#endif
