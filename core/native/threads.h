/* Functions that one body and many bodies have in common, and work shared among threads. */
#ifndef DM_THREADS_H
#define DM_THREADS_H
#include "dimple.h"

typedef void dm_part(void *of, int64_t k);

/* Run parts 0 to count - 1 of a job, in any order, on this thread and on helper threads. */
void dm_share_out(int64_t count, dm_part *run, void *of);

int32_t dm_check_step(const dm_body *body, const dm_motion *motion);
int dm_is_sliced(const dm_body *body); /* return whether several threads may step it */
int64_t dm_cost(const dm_body *body, const dm_motion *motion); /* [vertices x substeps], 0 if it sleeps */
void dm_run_checked(dm_body *body, const dm_motion *motion, dm_frame *frame); /* on any thread */
uint64_t dm_flush_denormals(void); /* on this thread; return the previous mode */
#endif
