/* The whole core once more for DM_BITS and DM_SET: everything static but one table, so that variants never mix and
 * the compiler sees all of it. */
#include "methods.h"

#include "layout.c"
#include "loose.c"
#include "pose.c"
#include "rings.c"
#include "motion.c"
#include "paper.c"
#include "contact.c"
#include "reach.c"
#include "body.c"
#include "step.c"

#define GLUE(set, bits) dm_##set##_##bits
#define NAME(set, bits) GLUE(set, bits)

extern const methods NAME(DM_SET, DM_BITS);
const methods NAME(DM_SET, DM_BITS) = {
    create, destroy, set_springs, set_bend, set_faces, set_fill, set_matter, set_memory,
    set_world, set_state, set_contact, step, read_state, read_contact, fit_rotation,
};
