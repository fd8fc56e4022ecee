/* What carries a surface, found before it is carried. */
#ifndef DM_MOTIONS_H
#define DM_MOTIONS_H
#include "dimple.h"

/* Set the motions (seeds, 12) of a proxy at positions (3, seeds) [m], over 65535: half of a shift [m], and the columns
 * of half of a gradient. */
int32_t dm_find_motions(const dm_binding *binding, const double *positions, float *motions);
#endif
