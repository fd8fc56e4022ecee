/* The door: every handle is looked up, every argument checked, and the best instruction set chosen. */
#include "dimple.h"
#include "methods.h"
#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <string.h>

#if defined(__x86_64__) || defined(_M_X64)
#define DM_X86 1
#include <cpuid.h>
#include <xmmintrin.h>
extern const methods dm_base_32, dm_base_64, dm_avx2_32, dm_avx2_64;
#else
extern const methods dm_base_32, dm_base_64;
#endif

enum { MAX_BODIES = 4096, MAX_COUNT = 1 << 28 };

typedef struct {
    dm_body handle; /* 0 is an empty place */
    body_ref body;
    const methods *does;
    int64_t n;
    int busy;
} entry;

static entry entries[MAX_BODIES];
static uint64_t last_handle;
static atomic_flag door = ATOMIC_FLAG_INIT;

static void lock(void) {
    while (atomic_flag_test_and_set_explicit(&door, memory_order_acquire)) {
    }
}

static void unlock(void) { atomic_flag_clear_explicit(&door, memory_order_release); }

/* Find a body and keep others out of it. */
static int32_t enter(dm_body handle, entry **found) {
    entry *e = entries + handle % MAX_BODIES;
    int32_t code = DM_OK;
    lock();
    if (!handle || e->handle != handle) code = DM_HANDLE;
    else if (e->busy) code = DM_BUSY;
    else e->busy = 1, *found = e;
    unlock();
    return code;
}

static int32_t leave(entry *e, int32_t code) {
    lock();
    e->busy = 0;
    unlock();
    return code;
}

#if DM_X86
static int has_avx2(void) {
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_FMA) || !(c & bit_OSXSAVE)) return 0;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0)); /* does the system save the wide registers? */
    return (low & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}
#endif

static const methods *choose(int32_t bits, int32_t set) {
    if ((bits != 32 && bits != 64) || set < DM_SET_BEST || set > DM_SET_AVX2) return NULL;
#if DM_X86
    if (set != DM_SET_BASE && has_avx2()) return bits == 32 ? &dm_avx2_32 : &dm_avx2_64;
#endif
    return set == DM_SET_AVX2 ? NULL : bits == 32 ? &dm_base_32 : &dm_base_64;
}

/* Numbers too small to matter cost a hundred times as much: a body coming to rest would grow slow. */
static uint64_t flush_small(void) {
#if DM_X86
    uint64_t before = _mm_getcsr();
    _mm_setcsr((unsigned)before | 0x8040);
#elif defined(__aarch64__)
    uint64_t before;
    __asm__ volatile("mrs %0, fpcr" : "=r"(before));
    __asm__ volatile("msr fpcr, %0" : : "r"(before | 1 << 24));
#else
    uint64_t before = 0;
#endif
    return before;
}

static void keep_small(uint64_t before) {
#if DM_X86
    _mm_setcsr((unsigned)before);
#elif defined(__aarch64__)
    __asm__ volatile("msr fpcr, %0" : : "r"(before));
#else
    (void)before;
#endif
}

static int32_t numbers(int64_t count, const double *a, uint64_t signless) {
    uint64_t bad = 0;
    for (int64_t k = 0; k < count; k++) {
        uint64_t word;
        memcpy(&word, a + k, sizeof word);
        bad |= (word << 1) >= UINT64_C(0xffe0000000000000); /* all of the exponent: infinite or not a number */
        bad |= signless & (word > UINT64_C(0x8000000000000000));
    }
    return bad ? DM_NUMBER : DM_OK;
}

static int32_t indices(int64_t count, const int64_t *a, int64_t from, int64_t limit) {
    for (int64_t k = 0; k < count; k++)
        if (a[k] < from || a[k] >= limit) return DM_INDEX;
    return DM_OK;
}

#define CHECK(test)                                  \
    do {                                             \
        int32_t code_ = (test);                      \
        if (code_ != DM_OK) return leave(e, code_);  \
    } while (0)
#define ENTER(body)                                  \
    entry *e = NULL;                                 \
    int32_t entered = enter(body, &e);               \
    if (entered != DM_OK) return entered
#define ENTER_SIZED(body, n)                         \
    ENTER(body);                                     \
    CHECK((n) == e->n ? DM_OK : DM_SIZE)
#define COUNT(n, array) ((n) < 0 || (n) > MAX_COUNT || ((n) > 0 && !(array)) ? DM_SIZE : DM_OK)

int32_t dm_abi(void) { return DM_ABI; }

const char *dm_instructions(int32_t set) {
    if (!choose(32, set)) return "";
#if DM_X86
    return set != DM_SET_BASE && has_avx2() ? "AVX2" : "SSE2";
#else
    return "NEON";
#endif
}

const char *dm_message(int32_t code) {
    static const char *const words[] = {
        "done", "there is no such body", "another thread is inside this body", "an array has the wrong size",
        "an index is out of range", "a number is not finite, or negative where it must not be",
        "the machine has no memory left", "the body is not complete yet", "an unknown option",
    };
    return code >= 0 && code <= DM_OPTION ? words[code] : "an unknown code";
}

int32_t dm_fit_rotation(const double *h, double *r) {
    if (!h || !r) return DM_SIZE;
    if (numbers(9, h, 0)) return DM_NUMBER;
    dm_base_64.fit_rotation(h, r);
    return DM_OK;
}

int32_t dm_create(dm_body *body, int32_t bits, int32_t set, int64_t n, const double *rest, int64_t width,
                  const int64_t *ring, const int64_t *ring_spring) {
    if (!body || !rest || n < 1 || n > DM_MAX_VERTICES || width < 0 || width > DM_MAX_NEIGHBOURS) return DM_SIZE;
    *body = 0;
    if (width && (!ring || !ring_spring)) return DM_SIZE;
    const methods *does = choose(bits, set);
    if (!does) return DM_OPTION;
    if (numbers(3 * n, rest, 0)) return DM_NUMBER;
    if (indices(width * n, ring, 0, n) || indices(width * n, ring_spring, -1, INT32_MAX)) return DM_INDEX;
    body_ref made = NULL;
    int32_t code = does->create(&made, n, rest, width, ring, ring_spring);
    if (code != DM_OK) return code;
    lock();
    for (int tries = 0; tries < MAX_BODIES && !*body; tries++) {
        entry *e = entries + ++last_handle % MAX_BODIES;
        if (e->handle || last_handle == 0) continue;
        *e = (entry){last_handle, made, does, n, 0};
        *body = last_handle;
    }
    unlock();
    if (!*body) does->destroy(made);
    return *body ? DM_OK : DM_MEMORY;
}

int32_t dm_free(dm_body body) {
    ENTER(body);
    e->does->destroy(e->body);
    lock();
    *e = (entry){0}; /* from here on another body may have the place */
    unlock();
    return DM_OK;
}

int32_t dm_set_springs(dm_body body, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                       const double *damping, int64_t l, const int64_t *loose, const uint8_t *ends) {
    ENTER(body);
    CHECK(COUNT(m, pairs) | COUNT(m, rest) | COUNT(m, stiffness) | COUNT(m, damping));
    CHECK(COUNT(l, loose) | COUNT(l, ends));
    CHECK(indices(2 * m, pairs, 0, e->n) | indices(l, loose, 0, m));
    CHECK(numbers(m, rest, 1) | numbers(m, stiffness, 1) | numbers(m, damping, 1));
    return leave(e, e->does->set_springs(e->body, m, pairs, rest, stiffness, damping, l, loose, ends));
}

int32_t dm_set_bend(dm_body body, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                    const double *damping) {
    ENTER(body);
    CHECK(COUNT(m, pairs) | COUNT(m, rest) | COUNT(m, stiffness) | COUNT(m, damping));
    CHECK(indices(2 * m, pairs, 0, e->n));
    CHECK(numbers(m, rest, 1) | numbers(m, stiffness, 1) | numbers(m, damping, 1));
    return leave(e, e->does->set_bend(e->body, m, pairs, rest, stiffness, damping));
}

int32_t dm_set_faces(dm_body body, int64_t t, const int64_t *triangles) {
    ENTER(body);
    CHECK(COUNT(t, triangles));
    CHECK(indices(3 * t, triangles, 0, e->n));
    return leave(e, e->does->set_faces(e->body, t, triangles));
}

int32_t dm_set_fill(dm_body body, int32_t fill, double rest_volume, int64_t c, const int64_t *corners, int64_t e_count,
                    const int64_t *cap_edges, const int64_t *cap_loop) {
    ENTER(body);
    CHECK(fill < DM_FILL_NONE || fill > DM_FILL_PAPER ? DM_OPTION : DM_OK);
    CHECK(COUNT(c, corners) | COUNT(e_count, cap_edges) | COUNT(e_count, cap_loop));
    CHECK(!isfinite(rest_volume) || (fill != DM_FILL_NONE && !(rest_volume > 0)) ? DM_NUMBER : DM_OK);
    CHECK(indices(3 * c, corners, 0, e->n) | indices(2 * e_count, cap_edges, 0, e->n));
    CHECK(indices(e_count, cap_loop, 0, e_count));
    return leave(e, e->does->set_fill(e->body, fill, rest_volume, c, corners, e_count, cap_edges, cap_loop));
}

int32_t dm_set_matter(dm_body body, int64_t n, const double *mass, const double *inverse_mass, const double *friction) {
    ENTER_SIZED(body, n);
    CHECK(COUNT(n, mass) | COUNT(n, inverse_mass) | COUNT(n, friction));
    CHECK(numbers(n, mass, 1) | numbers(n, inverse_mass, 1) | numbers(n, friction, 1));
    double total = 0;
    for (int64_t k = 0; k < n; k++) total += mass[k];
    CHECK(total > 0 ? DM_OK : DM_NUMBER);
    return leave(e, e->does->set_matter(e->body, mass, inverse_mass, friction));
}

int32_t dm_set_memory(dm_body body, int64_t n, const double *k1, const double *k2, const double *d0,
                      const double *damping) {
    ENTER_SIZED(body, n);
    CHECK(COUNT(n, k1) | COUNT(n, k2) | COUNT(n, d0) | COUNT(n, damping));
    CHECK(numbers(n, k1, 1) | numbers(n, k2, 1) | numbers(n, d0, 1) | numbers(n, damping, 1));
    return leave(e, e->does->set_memory(e->body, k1, k2, d0, damping));
}

int32_t dm_set_world(dm_body body, int32_t laws, double rest_area, const double *gravity, double ground) {
    ENTER(body);
    CHECK(laws < DM_LAWS_CONSISTENT || laws > DM_LAWS_PAPER ? DM_OPTION : DM_OK);
    CHECK(gravity ? numbers(3, gravity, 0) | numbers(1, &rest_area, 1) : DM_SIZE);
    CHECK(isnan(ground) || ground == INFINITY ? DM_NUMBER : DM_OK);
    return leave(e, e->does->set_world(e->body, laws, rest_area, gravity, ground));
}

int32_t dm_set_state(dm_body body, int64_t n, const double *positions, const double *velocities, const double *pose,
                     const double *pace) {
    ENTER_SIZED(body, n);
    CHECK(COUNT(n, positions) | COUNT(n, velocities));
    CHECK(numbers(3 * n, positions, 0) | numbers(3 * n, velocities, 0) | (pose ? numbers(12, pose, 0) : DM_OK));
    CHECK(pace ? numbers(12, pace, 0) : DM_OK);
    return leave(e, e->does->set_state(e->body, positions, velocities, pose, pace));
}

int32_t dm_set_contact(dm_body body, double inner_force, int64_t count, const int64_t *vertices) {
    ENTER(body);
    CHECK(COUNT(count, vertices));
    CHECK(numbers(1, &inner_force, 0));
    CHECK(indices(count, vertices, 0, e->n));
    return leave(e, e->does->set_contact(e->body, inner_force, count, vertices));
}

int32_t dm_step(dm_body body, int64_t ticks, int64_t substeps, double tick, int64_t fingers, const double *centres,
                const double *radii, double *impulses) {
    ENTER(body);
    CHECK(ticks < 0 || substeps < 1 || ticks > DM_MAX_STEPS || substeps > DM_MAX_STEPS / (ticks + 1) ? DM_SIZE : DM_OK);
    CHECK(fingers < 0 || fingers > DM_MAX_FINGERS || (fingers && !(centres && radii && impulses)) ? DM_SIZE : DM_OK);
    CHECK(isfinite(tick) && tick > 0 ? DM_OK : DM_NUMBER);
    CHECK(numbers(fingers * (ticks + 1) * 3, centres, 0) | numbers(fingers, radii, 1));
    uint64_t before = flush_small();
    int32_t code = e->does->step(e->body, ticks, substeps, tick, fingers, centres, radii, impulses);
    keep_small(before);
    return leave(e, code);
}

int32_t dm_read(dm_body body, int64_t n, double *positions, double *velocities, double *pressure) {
    ENTER_SIZED(body, n);
    return leave(e, e->does->read(e->body, positions, velocities, pressure));
}

int32_t dm_read_contact(dm_body body, int64_t n, int64_t *vertices, int64_t *count) {
    ENTER_SIZED(body, n);
    CHECK(vertices && count ? DM_OK : DM_SIZE);
    return leave(e, e->does->read_contact(e->body, vertices, count));
}
