/* The functions of dimple.h: they check every argument and choose the best instruction set. */
#include "threads.h"
#include "methods.h"
#include "carriers.h"
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) || defined(_M_X64)
#define DM_X86
#include <cpuid.h>
#include <xmmintrin.h>
extern const dm_methods dm_avx2_32, dm_avx2_64;
#endif
extern const dm_methods dm_base_32, dm_base_64;

/* double precision is for tests; the shipped library does not have it */
#ifdef DM_DOUBLE
#define DM_OF_BITS(set) (bits == 32 ? &dm_##set##_32 : &dm_##set##_64)
#else
#define DM_OF_BITS(set) (bits == 32 ? &dm_##set##_32 : NULL)
#endif

enum { DM_MAX_COUNT = 1 << 28 };

struct dm_body {
    dm_state *state;
    const dm_methods *does;
    int64_t vertices, springs, materials; /* materials: number that its surface refers to */
    int64_t surface_vertices;
    double rest_volume;
};

#ifdef DM_X86
static int dm_has_avx2(void) {
    unsigned a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_FMA) || !(c & bit_OSXSAVE)) return 0;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0)); /* whether the operating system saves the wide registers */
    return (low & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & bit_AVX2) != 0;
}
#endif

static const dm_methods *dm_choose(int32_t bits, int32_t set) {
    if ((bits != 32 && bits != 64) || set < DM_SET_BEST || set > DM_SET_AVX2) return NULL;
#ifdef DM_X86
    if (set != DM_SET_BASE && dm_has_avx2()) return DM_OF_BITS(avx2);
#endif
    return set == DM_SET_AVX2 ? NULL : DM_OF_BITS(base);
}

/* Flush denormal numbers to 0: they cost a hundred times as much, and would slow down a body that comes to rest. */
uint64_t dm_flush_denormals(void) {
#ifdef DM_X86
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

static void dm_keep_denormals(uint64_t before) {
#ifdef DM_X86
    _mm_setcsr((unsigned)before);
#elif defined(__aarch64__)
    __asm__ volatile("msr fpcr, %0" : : "r"(before));
#else
    (void)before;
#endif
}

/* positive: 1 if the numbers must be 0 or more */
static int32_t dm_check_numbers(int64_t count, const double *a, int positive) {
    uint64_t bad = 0;
    for (int64_t k = 0; k < count; k++) {
        uint64_t word;
        memcpy(&word, a + k, sizeof word);
        bad |= (word << 1) >= UINT64_C(0xffe0000000000000); /* all bits of the exponent are set: infinite or NaN */
        bad |= (uint64_t)positive & (word > UINT64_C(0x8000000000000000));
    }
    return bad ? DM_NUMBER : DM_OK;
}

static int32_t dm_check_indices(int64_t count, const int64_t *a, int64_t from, int64_t limit) {
    for (int64_t k = 0; k < count; k++)
        if (a[k] < from || a[k] >= limit) return DM_INDEX;
    return DM_OK;
}

#define DM_CHECK(test)                     \
    do {                                   \
        int32_t code_ = (test);            \
        if (code_ != DM_OK) return code_;  \
    } while (0)
#define DM_COUNT(n) ((n) < 0 || (n) > DM_MAX_COUNT ? DM_SIZE : DM_OK)
#define DM_ARRAY(n, array) ((n) > 0 && !(array) ? DM_SIZE : DM_OK)

int32_t dm_abi(void) { return DM_ABI; }

const char *dm_instructions(int32_t set) {
    if (!dm_choose(32, set)) return "";
#ifdef DM_X86
    return set != DM_SET_BASE && dm_has_avx2() ? "AVX2" : "SSE2";
#else
    return "NEON";
#endif
}

const char *dm_message(int32_t code) {
    static const char *const words[] = {
        "done", "an array has the wrong size", "an index is out of range",
        "a number is not finite, or negative where it must not be", "the machine has no memory left",
        "an unknown option",
    };
    return code >= 0 && code <= DM_OPTION ? words[code] : "an unknown code";
}

static int32_t dm_check_starts(int64_t count, const int64_t *starts, int64_t limit) {
    if (starts[0] != 0 || starts[count] != limit) return DM_INDEX;
    for (int64_t k = 0; k < count; k++)
        if (starts[k] > starts[k + 1]) return DM_INDEX;
    return DM_OK;
}

static int32_t dm_check_binding(const dm_binding *b) {
    if (!b || b->seeds < 1 || b->seeds > UINT16_MAX + 1) return DM_SIZE;
    DM_CHECK(DM_COUNT(b->vertices) | DM_COUNT(b->entries) | DM_COUNT(b->triangles) | DM_COUNT(b->arms));
    if (!b->first || !b->followed || !b->weights || !b->places || !b->coarse_rest || !b->corners) return DM_SIZE;
    if (!b->ends || !b->starts || !b->spread || !b->upright) return DM_SIZE;
    DM_CHECK(dm_check_starts((b->vertices + 7) / 8, b->first, b->entries));
    DM_CHECK(dm_check_starts(b->seeds, b->starts, b->arms));
    DM_CHECK(dm_check_indices(3 * b->triangles, b->corners, 0, b->seeds));
    DM_CHECK(dm_check_indices(b->arms, b->ends, 0, b->seeds));
    uint16_t most = 0;
    for (int64_t k = 0; k < b->entries; k++) most = b->followed[k] > most ? b->followed[k] : most;
    return most >= b->seeds ? DM_INDEX : DM_OK;
}

int32_t dm_carry(const dm_binding *b, const double *positions, float *motions, float *skin) {
    if (!positions || !motions || !skin) return DM_SIZE;
    DM_CHECK(dm_check_binding(b));
    int32_t code = dm_find_motions(b, positions, motions);
    if (code == DM_OK) dm_choose(32, DM_SET_BEST)->carry(b, motions, skin);
    return code;
}

void dm_default_body_def(dm_body_def *def) {
    if (!def) return;
    memset(def, 0, sizeof *def);
    def->size = 1;
    def->constants.ground = -INFINITY;
    def->constants.free = 1;
}

static int32_t dm_check_law(int64_t materials, const double *laws) {
    for (const double *law = laws; law < laws + materials * DM_LAW; law += DM_LAW) {
        DM_CHECK(dm_check_numbers(DM_LAYER, law, 1) | dm_check_numbers(1, law + DM_LAYER, 0));
        if (!(law[2] > 0) || law[3] < 1) return DM_NUMBER;
    }
    return DM_OK;
}

static int32_t dm_check_constants(const dm_body *body, const dm_constants *c) {
    int64_t vertices = body->vertices, springs = body->springs;
    const double *of_vertices[] = {c->mass, c->inverse_mass, c->friction, c->compliance,
                                   c->k1,   c->k2,           c->d0,       c->drag};
    for (size_t k = 0; k < sizeof of_vertices / sizeof *of_vertices; k++) {
        DM_CHECK(DM_ARRAY(vertices, of_vertices[k]));
        DM_CHECK(dm_check_numbers(vertices, of_vertices[k], 1));
    }
    DM_CHECK(DM_ARRAY(springs, c->stiffness) | DM_ARRAY(springs, c->damping) | DM_ARRAY(springs, c->tension));
    DM_CHECK(dm_check_numbers(springs, c->stiffness, 1) | dm_check_numbers(springs, c->damping, 1));
    DM_CHECK(dm_check_numbers(springs, c->tension, 1));
    DM_CHECK(DM_COUNT(c->materials) | DM_ARRAY(c->materials, c->laws));
    if (c->materials < body->materials) return DM_INDEX;
    DM_CHECK(dm_check_law(c->materials, c->laws) | dm_check_numbers(3, c->gravity, 0));
    if (c->painted) DM_CHECK(dm_check_numbers(2 * body->surface_vertices, c->painted, 1));
    DM_CHECK(dm_check_numbers(1, &c->rest_pressure, 0) | dm_check_numbers(9, c->fill_momentum, 0));
    if (isnan(c->ground) || c->ground == INFINITY) return DM_NUMBER;
    double total = 0;
    for (int64_t k = 0; k < vertices; k++) total += c->mass[k];
    if (!(total > 0)) return DM_NUMBER;
    if (c->fill < DM_FILL_NONE || c->fill > DM_FILL_LIQUID) return DM_OPTION;
    return c->fill != DM_FILL_NONE && !(body->rest_volume > 0) ? DM_NUMBER : DM_OK;
}

static int32_t dm_check_def(const dm_body_def *d) {
    int64_t n = d->vertices, w = d->width;
    if (n < 1 || n > DM_MAX_VERTICES || w < 0 || w > DM_MAX_RING) return DM_SIZE;
    int64_t counts[] = {d->springs, d->irregular, d->triangles, d->fans, d->cap_edges, d->surface_vertices,
                        d->surface_triangles};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) DM_CHECK(DM_COUNT(counts[k]));
    DM_CHECK(DM_ARRAY(n, d->rest) | DM_ARRAY(w, d->ring) | DM_ARRAY(w, d->ring_spring));
    DM_CHECK(DM_ARRAY(d->springs, d->ends) | DM_ARRAY(d->springs, d->rest_length));
    DM_CHECK(DM_ARRAY(d->irregular, d->irregular_spring) | DM_ARRAY(d->irregular, d->irregular_end));
    DM_CHECK(DM_ARRAY(d->triangles, d->corners) | DM_ARRAY(d->fans, d->fan));
    DM_CHECK(DM_ARRAY(d->cap_edges, d->cap_edge) | DM_ARRAY(d->cap_edges, d->cap_hole));
    DM_CHECK(DM_ARRAY(d->surface_vertices, d->surface_rest));
    DM_CHECK(DM_ARRAY(d->surface_triangles, d->surface_corners) | DM_ARRAY(d->surface_triangles, d->surface_material));
    DM_CHECK(dm_check_indices(w * n, d->ring, 0, n) | dm_check_indices(w * n, d->ring_spring, -1, d->springs));
    DM_CHECK(dm_check_indices(2 * d->springs, d->ends, 0, n));
    DM_CHECK(dm_check_indices(d->irregular, d->irregular_spring, 0, d->springs));
    DM_CHECK(dm_check_indices(3 * d->triangles, d->corners, 0, n) | dm_check_indices(3 * d->fans, d->fan, 0, n));
    DM_CHECK(dm_check_indices(2 * d->cap_edges, d->cap_edge, 0, n));
    DM_CHECK(dm_check_indices(d->cap_edges, d->cap_hole, 0, d->cap_edges));
    DM_CHECK(dm_check_indices(3 * d->surface_triangles, d->surface_corners, 0, d->surface_vertices));
    DM_CHECK(dm_check_indices(d->surface_triangles, d->surface_material, 0, DM_MAX_COUNT));
    DM_CHECK(dm_check_numbers(3 * n, d->rest, 0) | dm_check_numbers(3 * d->surface_vertices, d->surface_rest, 0));
    DM_CHECK(dm_check_numbers(d->springs, d->rest_length, 1) | dm_check_numbers(1, &d->rest_area, 1));
    return dm_check_numbers(1, &d->rest_volume, 0) | dm_check_numbers(1, &d->size, 1);
}

int32_t dm_create(dm_body **body, const dm_body_def *def, int32_t bits, int32_t set) {
    if (!body || !def) return DM_SIZE;
    *body = NULL;
    const dm_methods *does = dm_choose(bits, set);
    if (!does) return DM_OPTION;
    DM_CHECK(dm_check_def(def));
    int64_t materials = 0;
    for (int64_t k = 0; k < def->surface_triangles; k++)
        materials = def->surface_material[k] >= materials ? def->surface_material[k] + 1 : materials;
    const dm_body empty = {NULL, does, def->vertices, def->springs, materials, def->surface_vertices, def->rest_volume};
    DM_CHECK(dm_check_constants(&empty, &def->constants));
    dm_body *made = malloc(sizeof *made);
    if (!made) return DM_MEMORY;
    *made = empty;
    int32_t code = does->create(&made->state, def);
    if (code != DM_OK) return free(made), code;
    *body = made;
    return DM_OK;
}

void dm_destroy(dm_body *body) {
    if (!body) return;
    body->does->destroy(body->state);
    free(body);
}

int32_t dm_set_constants(dm_body *body, const dm_constants *constants) {
    if (!body || !constants) return DM_SIZE;
    DM_CHECK(dm_check_constants(body, constants));
    return body->does->set_constants(body->state, constants);
}

int32_t dm_set_rest(dm_body *body, const double *rest, const double *surface, const double *rate, const double *gain) {
    if (!body || !rest) return DM_SIZE;
    if (!surface && body->surface_vertices != body->vertices) return DM_OPTION;
    DM_CHECK(dm_check_numbers(3 * body->vertices, rest, 0));
    if (surface) DM_CHECK(dm_check_numbers(3 * body->surface_vertices, surface, 0));
    if (rate) DM_CHECK(dm_check_numbers(3 * body->vertices, rate, 0));
    if (gain) DM_CHECK(dm_check_numbers(3 * body->vertices, gain, 0));
    body->does->set_rest(body->state, rest, surface ? surface : rest, body->surface_vertices, rate, gain);
    return DM_OK;
}

int32_t dm_wake_body(dm_body *body) {
    if (!body) return DM_SIZE;
    body->does->wake(body->state);
    return DM_OK;
}

double dm_rest_volume(const dm_body *body) { return body ? body->does->rest_volume(body->state) : 0; }

int32_t dm_set_state(dm_body *body, const double *positions, const double *velocities) {
    if (!body || !positions) return DM_SIZE;
    DM_CHECK(dm_check_numbers(3 * body->vertices, positions, 0));
    if (velocities) DM_CHECK(dm_check_numbers(3 * body->vertices, velocities, 0));
    body->does->set_state(body->state, positions, velocities);
    return DM_OK;
}

int32_t dm_get_state(const dm_body *body, double *positions, double *velocities) {
    if (!body) return DM_SIZE;
    body->does->get_state(body->state, positions, velocities);
    return DM_OK;
}

static int32_t dm_check_factors(const dm_body *body, const double *factors, double end) {
    if (!factors) return DM_OK;
    DM_CHECK(dm_check_numbers(body->materials * DM_FACTORS, factors, 1));
    return end > 0 && end < INFINITY ? DM_OK : DM_NUMBER;
}

int32_t dm_check_step(const dm_body *body, const dm_motion *m) {
    if (!body || !m) return DM_SIZE;
    if (m->ticks < 0 || m->ticks > DM_MAX_STEPS) return DM_SIZE;
    if (m->substeps < 1 || m->substeps > DM_MAX_STEPS / (m->ticks + 1)) return DM_SIZE;
    if (!isfinite(m->tick) || !(m->tick > 0)) return DM_NUMBER;
    for (const dm_fingertip *f = m->fingertips; f < m->fingertips + DM_MAX_FINGERTIPS; f++) {
        if (!f->down) continue;
        DM_CHECK(dm_check_numbers(3, f->from, 0) | dm_check_numbers(3, f->first, 0) | dm_check_numbers(3, f->last, 0));
        if (!(f->radius > 0 && isnormal(f->radius))) return DM_NUMBER; /* a denormal one is flushed to 0 */
        DM_CHECK(dm_check_numbers(1, &f->force, 1) | dm_check_numbers(3, f->inward, 0));
        DM_CHECK(dm_check_factors(body, f->factors, f->factors_end));
    }
    if (m->pins_from || m->pins_to) {
        int64_t count = 3 * body->does->pinned(body->state);
        if (!m->pins_from || !m->pins_to) return DM_SIZE;
        DM_CHECK(dm_check_numbers(count, m->pins_from, 0) | dm_check_numbers(count, m->pins_to, 0));
        DM_CHECK(dm_check_numbers(1, &m->pins_first, 1) | dm_check_numbers(1, &m->pins_last, 1));
    }
    return DM_OK;
}

int dm_is_sliced(const dm_body *body) { return body->vertices >= 2 * DM_SLICE; }

int64_t dm_cost(const dm_body *body, const dm_motion *m) {
    return body->does->asleep(body->state) ? 0 : body->vertices * m->substeps * m->ticks;
}

void dm_run_checked(dm_body *body, const dm_motion *m, dm_frame *frame) {
    uint64_t before = dm_flush_denormals();
    body->does->step(body->state, m, frame);
    dm_keep_denormals(before);
}

int32_t dm_step(dm_body *body, const dm_motion *m, dm_frame *frame) {
    if (!frame) return DM_SIZE;
    DM_CHECK(dm_check_step(body, m));
    dm_run_checked(body, m, frame);
    return DM_OK;
}

int32_t dm_get_law(const dm_body *body, int64_t fingertip, const double *factors, double factors_end, int64_t count,
                   const double *depths, double *forces) {
    if (!body) return DM_SIZE;
    DM_CHECK(DM_COUNT(count) | DM_ARRAY(count, depths) | DM_ARRAY(count, forces));
    DM_CHECK(dm_check_indices(1, &fingertip, 0, DM_MAX_FINGERTIPS) | dm_check_numbers(count, depths, 0));
    DM_CHECK(dm_check_factors(body, factors, factors_end));
    body->does->get_law(body->state, fingertip, factors, factors_end, count, depths, forces);
    return DM_OK;
}

#include "scene_door.c"
