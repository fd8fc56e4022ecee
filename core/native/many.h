/* What the door does for one body and for many. */
#ifndef DM_MANY_H
#define DM_MANY_H
#include "dimple.h"

int32_t dm_check_step(const dm_body *body, const dm_motion *motion);
int dm_is_asleep(const dm_body *body);
void dm_run_checked(dm_body *body, const dm_motion *motion, dm_frame *frame); /* on any thread */
#endif
