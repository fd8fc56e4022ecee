/* Threads that help whoever steps: with the bodies of a call, and with the slices of a body. What is shared out comes in
 * parts that do not depend on who runs them, so the bits are the same for any number of threads. */
#include "many.h"
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

/* Parts of one kind: `left` have no thread yet, and `undone` are not finished. */
typedef struct {
    _Alignas(64) atomic_llong left;
    atomic_llong undone;
    atomic_int taken; /* by the thread that shares it out */
    int64_t count;
    dm_part *run;
    void *of;
} dm_job;

enum { DM_JOBS = 16 }; /* at the same time; a thread that finds all of them taken works alone */

/* Helpers look here for parts. Nobody waits for a helper unless it has a part, so one that gets no core, and a process
 * that was forked, which has none, cost no time. */
static struct {
    dm_mutex lock;
    dm_condition changed;
    atomic_llong threads, workers, posted, asleep; /* wanted, with the caller; jobs so far; waiting for `changed` */
    dm_job jobs[DM_JOBS];
} dm_pool = {.lock = DM_MUTEX, .changed = DM_CONDITION, .workers = 1};

/* Run parts of a job that no thread has, in order. What a job says holds from when a part is taken until it is done. */
static void dm_run_parts(dm_job *job) {
    int64_t done = 0;
    for (int64_t part; job->left > 0 && (part = job->left--) > 0; done++) job->run(job->of, job->count - part);
    if (done) job->undone -= done;
}

static int dm_has_nothing(int64_t number, int64_t seen) { return dm_pool.posted == seen || number >= dm_pool.workers; }

/* Help, under a number that ends when fewer workers are wanted. */
static DM_THREAD_RESULT dm_help(void *as) {
    int64_t number = (intptr_t)as, seen = 0;
    dm_flush_denormals();
    for (;;) {
        for (int k = 0; k < DM_PATIENCE && dm_has_nothing(number, seen); k++) dm_yield();
        if (dm_has_nothing(number, seen)) {
            dm_lock(&dm_pool.lock);
            dm_pool.asleep++;
            while (dm_has_nothing(number, seen) && number < dm_pool.workers) dm_wait(&dm_pool.changed, &dm_pool.lock);
            dm_pool.asleep--;
            int leaves = number >= dm_pool.workers;
            dm_pool.threads -= leaves;
            dm_unlock(&dm_pool.lock);
            if (leaves) return 0;
        }
        seen = dm_pool.posted;
        for (dm_job *job = dm_pool.jobs; job < dm_pool.jobs + DM_JOBS; job++) dm_run_parts(job);
    }
}

/* Start the helpers that are missing, and wake those that sleep. */
static void dm_call_helpers(void) {
    dm_lock(&dm_pool.lock);
    while (dm_pool.threads < dm_pool.workers - 1 && dm_start(dm_help, (void *)(intptr_t)(dm_pool.threads + 1)))
        dm_pool.threads++;
    dm_signal(&dm_pool.changed);
    dm_unlock(&dm_pool.lock);
}

void dm_share_out(int64_t count, dm_part *run, void *of) {
    int64_t workers = dm_pool.workers;
    dm_job *end = dm_pool.jobs + DM_JOBS, *job = count > 1 && workers > 1 ? dm_pool.jobs : end;
    while (job < end && (job->taken || atomic_exchange(&job->taken, 1))) job++;
    if (job == end) {
        for (int64_t k = 0; k < count; k++) run(of, k);
        return;
    }
    job->count = count, job->run = run, job->of = of;
    job->undone = count, job->left = count;
    dm_pool.posted++;
    if (dm_pool.asleep || dm_pool.threads < workers - 1) dm_call_helpers();
    dm_run_parts(job);
    while (job->undone) dm_yield();
    job->taken = 0;
}

void dm_set_workers(int64_t workers) {
    dm_pool.workers = workers < DM_MAX_BODIES ? workers : DM_MAX_BODIES;
    dm_lock(&dm_pool.lock);
    dm_signal(&dm_pool.changed); /* to those that are not wanted */
    dm_unlock(&dm_pool.lock);
}

typedef struct {
    dm_body *body;
    const dm_motion *motion;
    dm_frame *frame;
    int64_t cost;
} dm_run;

static int dm_is_cheaper(const void *a, const void *b) {
    int64_t x = ((const dm_run *)a)->cost, y = ((const dm_run *)b)->cost;
    return (x < y) - (x > y);
}

static void dm_run_one(void *of, int64_t k) {
    const dm_run *r = (const dm_run *)of + k;
    dm_run_checked(r->body, r->motion, r->frame);
}

int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions, dm_frame *const *frames) {
    if (count < 0 || count > DM_MAX_BODIES) return DM_SIZE;
    if (count && (!bodies || !motions || !frames)) return DM_SIZE;
    for (int64_t k = 0; k < count; k++) {
        int32_t code = frames[k] ? dm_check_step(bodies[k], motions[k]) : DM_SIZE;
        if (code != DM_OK) return code;
        for (int64_t j = 0; j < k; j++)
            if (bodies[j] == bodies[k]) return DM_INDEX; /* it is stepped by one thread at a time */
    }
    dm_run *runs = malloc((size_t)(count + 1) * sizeof *runs);
    if (!runs) return DM_MEMORY;
    int64_t awake = 0; /* one that wakes in this call may wait for a thread */
    for (int64_t k = 0; k < count; k++) {
        runs[k] = (dm_run){bodies[k], motions[k], frames[k], dm_cost(bodies[k], motions[k])};
        awake += runs[k].cost > 0;
    }
    qsort(runs, (size_t)count, sizeof *runs, dm_is_cheaper); /* the dearest first, or it would be the last alone */
    dm_share_out(awake, dm_run_one, runs);
    for (int64_t k = awake; k < count; k++) dm_run_one(runs, k);
    free(runs);
    return DM_OK;
}
