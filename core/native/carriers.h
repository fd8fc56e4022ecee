/* The motions of a proxy's vertices, which carry the fine surface. */
#ifndef DM_CARRIERS_H
#define DM_CARRIERS_H
#include "dimple.h"

/* Set the motions (seeds, 12) of a proxy at positions (3, seeds) [m], divided by 65535 because the weights are
 * in units of 1/65535: half of a shift [m], and the columns of half of a gradient. */
int32_t dm_find_motions(const dm_binding *binding, const double *positions, float *motions);
#endif
