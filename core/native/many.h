/* What the door does for one body and for many. */
#ifndef DM_MANY_H
#define DM_MANY_H
#include "dimple.h"

int32_t dm_check_step(const dm_body *body, const dm_motion *motion);
int64_t dm_cost(const dm_body *body, const dm_motion *motion); /* of a tick [vertices stepped], 0 at rest */
/* Run the ticks from one to before another, on any thread; all of them in turn, each once. */
void dm_run_checked(dm_body *body, const dm_motion *motion, int64_t from, int64_t to, dm_frame *frame);
#endif
