/* Several bodies stepped in one call, on a few threads that last as long as the call: each body is stepped by one
 * thread, so the bits are the same for any number of them. */
#include "methods.h"
#include "many.h"
#include <stdatomic.h>

#if defined(_WIN32)
#include <windows.h>
typedef HANDLE dm_thread;
#define DM_THREAD_RESULT DWORD WINAPI
#else
#include <pthread.h>
typedef pthread_t dm_thread;
#define DM_THREAD_RESULT void *
#endif

typedef struct {
    int64_t count;
    dm_body *const *bodies;
    const dm_motion *const *motions;
    dm_frame *const *frames;
    atomic_llong next; /* body that no thread has taken */
} dm_batch;

static DM_THREAD_RESULT dm_take_bodies(void *of) {
    dm_batch *batch = of;
    for (int64_t k; (k = atomic_fetch_add(&batch->next, 1)) < batch->count;)
        dm_run_checked(batch->bodies[k], batch->motions[k], batch->frames[k]);
    return 0;
}

#if defined(_WIN32)
static int dm_start(dm_thread *thread, dm_batch *batch) {
    *thread = CreateThread(NULL, 0, dm_take_bodies, batch, 0, NULL);
    return *thread != NULL;
}

static void dm_join(dm_thread thread) { WaitForSingleObject(thread, INFINITE), CloseHandle(thread); }
#else
static int dm_start(dm_thread *thread, dm_batch *batch) { return !pthread_create(thread, NULL, dm_take_bodies, batch); }

static void dm_join(dm_thread thread) { pthread_join(thread, NULL); }
#endif

int32_t dm_step_many(int64_t count, dm_body *const *bodies, const dm_motion *const *motions, dm_frame *const *frames,
                     int64_t workers) {
    if (count < 0 || count > DM_MAX_BODIES || workers < 1 || workers > DM_MAX_WORKERS) return DM_SIZE;
    if (count && (!bodies || !motions || !frames)) return DM_SIZE;
    for (int64_t k = 0; k < count; k++) {
        int32_t code = frames[k] ? dm_check_step(bodies[k], motions[k]) : DM_SIZE;
        if (code != DM_OK) return code;
        for (int64_t j = 0; j < k; j++)
            if (bodies[j] == bodies[k]) return DM_INDEX; /* it is stepped by one thread at a time */
    }
    dm_batch batch = {count, bodies, motions, frames, 0};
    dm_thread threads[DM_MAX_WORKERS];
    int64_t started = 0, awake = 0; /* one that wakes in this call may wait for a thread */
    for (int64_t k = 0; k < count; k++) awake += !dm_is_asleep(bodies[k]);
    int64_t most = workers < awake ? workers : awake;
    while (started < most - 1 && dm_start(threads + started, &batch)) started++; /* the caller is one of them */
    dm_take_bodies(&batch);
    for (int64_t k = 0; k < started; k++) dm_join(threads[k]);
    return DM_OK;
}
