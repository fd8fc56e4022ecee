/* Several bodies stepped in one call, on a few threads that wait for the next call after it: each body is stepped by one
 * thread at a time, so the bits are the same for any number of them. */
#include "methods.h"
#include "many.h"
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

static int dm_start(DWORD (WINAPI *run)(void *)) {
    HANDLE thread = CreateThread(NULL, 0, run, NULL, 0, NULL);
    return thread && CloseHandle(thread);
}
#else
#include <pthread.h>
typedef pthread_mutex_t dm_mutex;
typedef pthread_cond_t dm_condition;
#define DM_MUTEX PTHREAD_MUTEX_INITIALIZER
#define DM_CONDITION PTHREAD_COND_INITIALIZER
#define DM_THREAD_RESULT void *

static void dm_lock(dm_mutex *m) { pthread_mutex_lock(m); }
static void dm_unlock(dm_mutex *m) { pthread_mutex_unlock(m); }
static void dm_wait(dm_condition *c, dm_mutex *m) { pthread_cond_wait(c, m); }
static void dm_signal(dm_condition *c) { pthread_cond_broadcast(c); }

static int dm_start(void *(*run)(void *)) {
    pthread_t thread;
    return !pthread_create(&thread, NULL, run, NULL) && !pthread_detach(thread);
}
#endif

typedef struct {
    dm_body *body;
    const dm_motion *motion;
    dm_frame *frame;
    int64_t done, cost; /* ticks; of each */
    int taken; /* a thread has it, or it is done */
} dm_run;

typedef struct {
    dm_mutex lock;
    dm_run *runs;
    int64_t count, threads;
    atomic_llong left, dearest; /* of all that is to be done; of what no thread has */
} dm_batch;

/* Threads wait here from call to call: where other programs run too, a new one gets a core late, and one that has slept
 * soon. Whoever comes when all is done is not waited for, so a process that was forked, which has none, goes on alone. */
static struct {
    dm_mutex lock;
    dm_condition changed;
    dm_batch *batch; /* of the call under way; another call at the same time has no thread but its own */
    int64_t threads, wanted, busy;
} dm_pool = {.lock = DM_MUTEX, .changed = DM_CONDITION};

static int64_t dm_left_of(const dm_run *r) { return r ? r->cost * (r->motion->ticks - r->done) : 0; }

/* Return the dearest run that no thread has, after putting one back. */
static dm_run *dm_take(dm_batch *batch, dm_run *back) {
    dm_run *found = NULL, *next = NULL;
    dm_lock(&batch->lock);
    if (back) back->taken = 0;
    for (dm_run *r = batch->runs; r < batch->runs + batch->count; r++) {
        if (r->taken) continue;
        if (!found || dm_left_of(r) > dm_left_of(found)) next = found, found = r;
        else if (dm_left_of(r) > dm_left_of(next)) next = r;
    }
    if (found) found->taken = 1;
    batch->dearest = dm_left_of(next);
    dm_unlock(&batch->lock);
    return found;
}

/* Run bodies, each to its end, unless one that no thread has would then be the last, beside threads that have nothing to
 * do: from where what is left of it is no less than a thread's share of all that is left, one of them goes on with it.
 * Source: McNaughton 1959, Scheduling with deadlines and loss functions. */
static void dm_run_bodies(dm_batch *batch) {
    for (dm_run *r = dm_take(batch, NULL); r;) {
        int64_t from = r->done, ticks = r->motion->ticks, to = r->cost && from + 1 < ticks ? from + 1 : ticks;
        dm_run_checked(r->body, r->motion, from, to, r->frame);
        r->done = to;
        int64_t left = batch->left -= r->cost * (to - from), dearest = batch->dearest;
        if (to == ticks) r = dm_take(batch, NULL);
        else if (dearest > dm_left_of(r) && dearest * batch->threads >= left) r = dm_take(batch, r);
    }
}

static DM_THREAD_RESULT dm_work(void *unused) {
    (void)unused;
    dm_lock(&dm_pool.lock);
    for (;;) {
        while (!dm_pool.wanted) dm_wait(&dm_pool.changed, &dm_pool.lock);
        dm_pool.wanted--, dm_pool.busy++;
        dm_batch *batch = dm_pool.batch;
        dm_unlock(&dm_pool.lock);
        dm_run_bodies(batch);
        dm_lock(&dm_pool.lock);
        if (!--dm_pool.busy) dm_signal(&dm_pool.changed);
    }
    return 0;
}

/* Run a batch on the thread of the caller and on others. */
static void dm_run_batch(dm_batch *batch) {
    int others = 0;
    if (batch->threads > 1) {
        dm_lock(&dm_pool.lock);
        others = !dm_pool.batch;
        while (others && dm_pool.threads < batch->threads - 1 && dm_start(dm_work)) dm_pool.threads++;
        if (others) dm_pool.batch = batch, dm_pool.wanted = batch->threads - 1, dm_signal(&dm_pool.changed);
        dm_unlock(&dm_pool.lock);
    }
    dm_run_bodies(batch);
    if (!others) return;
    dm_lock(&dm_pool.lock);
    dm_pool.wanted = 0;
    while (dm_pool.busy) dm_wait(&dm_pool.changed, &dm_pool.lock);
    dm_pool.batch = NULL;
    dm_unlock(&dm_pool.lock);
}

int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions, dm_frame *const *frames,
                     int64_t workers) {
    if (count < 0 || count > DM_MAX_BODIES || workers < 1 || workers > DM_MAX_BODIES) return DM_SIZE;
    if (count && (!bodies || !motions || !frames)) return DM_SIZE;
    for (int64_t k = 0; k < count; k++) {
        int32_t code = frames[k] ? dm_check_step(bodies[k], motions[k]) : DM_SIZE;
        if (code != DM_OK) return code;
        for (int64_t j = 0; j < k; j++)
            if (bodies[j] == bodies[k]) return DM_INDEX; /* it is stepped by one thread at a time */
    }
    dm_batch batch = {.lock = DM_MUTEX, .runs = malloc((size_t)(count + 1) * sizeof *batch.runs), .count = count};
    if (!batch.runs) return DM_MEMORY;
    int64_t awake = 0; /* one that wakes in this call may wait for a thread */
    for (int64_t k = 0; k < count; k++) {
        batch.runs[k] = (dm_run){bodies[k], motions[k], frames[k], 0, dm_cost(bodies[k], motions[k]), 0};
        awake += batch.runs[k].cost > 0, batch.left += dm_left_of(batch.runs + k);
    }
    batch.threads = workers < awake ? workers : awake;
    dm_run_batch(&batch);
    free(batch.runs);
    return DM_OK;
}
