/* What the door does for one body and for many, and what threads share. */
#ifndef DM_MANY_H
#define DM_MANY_H
#include "dimple.h"

typedef void dm_part(void *of, int64_t k);

/* Run parts 0 to count - 1 of something, in any order, on this thread and on helpers. */
void dm_share_out(int64_t count, dm_part *run, void *of);

int32_t dm_check_step(const dm_body *body, const dm_motion *motion);
int dm_is_sliced(const dm_body *body); /* may several threads step it? */
int64_t dm_cost(const dm_body *body, const dm_motion *motion); /* [vertices stepped], 0 at rest */
void dm_run_checked(dm_body *body, const dm_motion *motion, dm_frame *frame); /* on any thread */
uint64_t dm_flush_denormals(void); /* of this thread; return what was before */
#endif
