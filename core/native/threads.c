/* Helper threads for the stepping thread: they run bodies of a call, or slices of a body. The parts of a job do not
 * depend on which thread runs them, so the bits are the same for any number of threads. */
#include "threads.h"
#include "constants.h"
#include <stdatomic.h>
#include <stdlib.h>

#if defined(_WIN32)
#include <windows.h>
typedef SRWLOCK dm_mutex;
typedef CONDITION_VARIABLE dm_condition;
#define DM_MUTEX SRWLOCK_INIT
#define DM_CONDITION CONDITION_VARIABLE_INIT
#define DM_THREAD_RESULT DWORD WINAPI

static void dm_lock(dm_mutex *m) { AcquireSRWLockExclusive(m); }
static void dm_unlock(dm_mutex *m) { ReleaseSRWLockExclusive(m); }
static void dm_wait(dm_condition *c, dm_mutex *m) { SleepConditionVariableSRW(c, m, INFINITE, 0); }
static void dm_signal(dm_condition *c) { WakeAllConditionVariable(c); }

static void dm_yield(void) { SwitchToThread(); }

static int dm_start(DWORD (WINAPI *run)(void *), void *with) {
    HANDLE thread = CreateThread(NULL, 0, run, with, 0, NULL);
    return thread && CloseHandle(thread);
}
#else
#include <pthread.h>
#include <sched.h>
typedef pthread_mutex_t dm_mutex;
typedef pthread_cond_t dm_condition;
#define DM_MUTEX PTHREAD_MUTEX_INITIALIZER
#define DM_CONDITION PTHREAD_COND_INITIALIZER
#define DM_THREAD_RESULT void *

static void dm_lock(dm_mutex *m) { pthread_mutex_lock(m); }
static void dm_unlock(dm_mutex *m) { pthread_mutex_unlock(m); }
static void dm_wait(dm_condition *c, dm_mutex *m) { pthread_cond_wait(c, m); }
static void dm_signal(dm_condition *c) { pthread_cond_broadcast(c); }

static void dm_yield(void) { sched_yield(); }

static int dm_start(void *(*run)(void *), void *with) {
    pthread_t thread;
    return !pthread_create(&thread, NULL, run, with) && !pthread_detach(thread);
}
#endif

typedef struct {
    _Alignas(64) atomic_llong left;
} dm_range;

/* The job that is shared out. Each worker begins with a range of parts, the same in every pass, so that their memory
 * stays in its cache, and then takes those that others are late with. No thread waits for a helper that has not taken a
 * part, so a helper that gets no core, or a forked process, which has no helpers, costs hardly any time. */
static struct {
    dm_mutex lock;
    dm_condition changed;
    atomic_llong threads, workers, asleep; /* helpers; workers wanted, with the caller; helpers waiting for `changed` */
    atomic_int taken;                      /* a job is shared out */
    atomic_llong posted, undone, ranges;   /* jobs so far; parts that are not finished; workers of the job */
    dm_range range[DM_MOST_SLICES];        /* parts that no thread has taken */
    int64_t count; /* this and the next two are valid while a taken part is unfinished */
    dm_part *run;
    void *of;
} dm_pool = {.lock = DM_MUTEX, .changed = DM_CONDITION, .workers = 1};

/* Run parts of the job until none is left, first those of a worker's own range. */
static void dm_run_parts(int64_t number) {
    for (int64_t k = 0, ranges = dm_pool.ranges, left; k < ranges; k++) {
        int64_t r = (number + k) % ranges;
        for (; dm_pool.range[r].left > 0 && (left = dm_pool.range[r].left--) > 0; dm_pool.undone--)
            dm_pool.run(dm_pool.of, (r + 1) * dm_pool.count / dm_pool.ranges - left);
    }
}

static int dm_is_wanted(int64_t number) { return number < dm_pool.workers; }

/* Wait actively for a job after the `seen` ones; return whether one came soon. */
static int dm_comes_soon(int64_t number, int64_t seen) {
    for (int k = 0; k < DM_PATIENCE; k++) {
        if (dm_pool.posted != seen && dm_is_wanted(number)) return 1;
        dm_yield();
    }
    return 0;
}

/* Run the helper thread of a number; it ends when fewer workers than that are wanted. */
static DM_THREAD_RESULT dm_help(void *as) {
    int64_t number = (intptr_t)as, seen = 0;
    dm_flush_denormals();
    for (;; seen = dm_pool.posted, dm_run_parts(number)) {
        if (dm_comes_soon(number, seen)) continue;
        dm_lock(&dm_pool.lock);
        dm_pool.asleep++;
        while (dm_pool.posted == seen && dm_is_wanted(number)) dm_wait(&dm_pool.changed, &dm_pool.lock);
        dm_pool.asleep--;
        int leaves = !dm_is_wanted(number);
        dm_pool.threads -= leaves;
        dm_unlock(&dm_pool.lock);
        if (leaves) return 0;
    }
}

/* Start missing helpers, and wake sleeping ones. */
static void dm_call_helpers(void) {
    dm_lock(&dm_pool.lock);
    while (dm_is_wanted(dm_pool.threads + 1) && dm_start(dm_help, (void *)(intptr_t)(dm_pool.threads + 1)))
        dm_pool.threads++;
    dm_signal(&dm_pool.changed);
    dm_unlock(&dm_pool.lock);
}

void dm_share_out(int64_t count, dm_part *run, void *of) {
    int64_t workers = dm_pool.workers < count ? dm_pool.workers : count;
    if (workers < 2 || dm_pool.taken || atomic_exchange(&dm_pool.taken, 1)) { /* inside another job, or beside one */
        for (int64_t k = 0; k < count; k++) run(of, k);
        return;
    }
    dm_pool.count = count, dm_pool.run = run, dm_pool.of = of;
    dm_pool.ranges = workers;
    dm_pool.undone = count;
    for (int64_t r = 0; r < workers; r++)
        atomic_store_explicit(&dm_pool.range[r].left, (r + 1) * count / workers - r * count / workers, memory_order_release);
    dm_pool.posted++;
    if (dm_pool.asleep || dm_is_wanted(dm_pool.threads + 1)) dm_call_helpers();
    dm_run_parts(0);
    while (dm_pool.undone) dm_yield(); /* to the helper that has the part */
    dm_pool.taken = 0;
}

void dm_set_workers(int64_t workers) {
    dm_pool.workers = workers < 1 ? 1 : workers < DM_MOST_SLICES ? workers : DM_MOST_SLICES;
    dm_lock(&dm_pool.lock);
    dm_signal(&dm_pool.changed); /* for the helpers that must end */
    dm_unlock(&dm_pool.lock);
}

typedef struct {
    dm_body *body;
    const dm_motion *motion;
    dm_frame *frame;
    int64_t cost;
} dm_body_step;

static int dm_is_cheaper(const void *a, const void *b) {
    int64_t x = ((const dm_body_step *)a)->cost, y = ((const dm_body_step *)b)->cost;
    return (x < y) - (x > y);
}

static void dm_run_step(void *of, int64_t k) {
    const dm_body_step *r = (const dm_body_step *)of + k;
    dm_run_checked(r->body, r->motion, r->frame);
}

int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions, dm_frame *const *frames) {
    if (count < 0 || count > DM_MAX_BODIES) return DM_SIZE;
    if (count && (!bodies || !motions || !frames)) return DM_SIZE;
    for (int64_t k = 0; k < count; k++) {
        int32_t code = frames[k] ? dm_check_step(bodies[k], motions[k]) : DM_SIZE;
        if (code != DM_OK) return code;
        for (int64_t j = 0; j < k; j++)
            if (bodies[j] == bodies[k]) return DM_INDEX; /* only one thread may step a body */
    }
    dm_body_step *steps = malloc((size_t)(count + 1) * sizeof *steps);
    if (!steps) return DM_MEMORY;
    int64_t left = 0, workers = dm_pool.workers;
    for (int64_t k = 0; k < count; k++) {
        steps[k] = (dm_body_step){bodies[k], motions[k], frames[k], dm_cost(bodies[k], motions[k])};
        left += steps[k].cost;
    }
    qsort(steps, (size_t)count, sizeof *steps, dm_is_cheaper); /* the most expensive first: last, it would run alone */
    for (int64_t k = 0, next; k < count; k = next) {
        int sliced = dm_is_sliced(steps[k].body);
        /* a body that costs more than a worker's share of the rest gets all workers, in slices; one asleep, none */
        if (!steps[k].cost || (sliced && steps[k].cost * workers > left)) next = k + 1;
        else next = sliced ? count - (count - k) % workers : count;
        dm_share_out(next - k, dm_run_step, steps + k);
        for (; k < next; k++) left -= steps[k].cost;
    }
    free(steps);
    return DM_OK;
}
