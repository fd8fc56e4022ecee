/* The whole core, compiled for one DM_BITS and DM_SET: everything except one table is static, so that variants never
 * mix and the compiler sees all of it. */
#include "methods.h"

#include "lanes.h"

#include "layout.c"
#include "irregular.c"
#include "slices.c"
#include "pose.c"
#include "rings.c"
#include "integrate.c"
#include "facets.c"
#include "skin_contact.c"
#include "surface.c"
#include "foot.c"
#include "fingertip.c"
#include "fingertip_reach.c"
#include "body_constants.c"
#include "body.c"
#include "moved_rest.c"
#include "sleep.c"
#include "fill.c"
#include "step.c"
#include "gaps.c"
#include "tree.c"
#include "proximity.c"
#include "contact_planes.c"
#include "keep_apart.c"
#include "contact_impulses.c"
#include "props.c"
#include "contact_points.c"
#include "body_rolling.c"
#include "contact_pairs.c"
#include "contact_query.c"
#include "crossings.c"
#include "islands.c"
#include "scene.c"
#include "carry.c"

#define DM_GLUE(set, bits) dm_##set##_##bits
#define DM_NAME(set, bits) DM_GLUE(set, bits)

extern const dm_methods DM_NAME(DM_SET, DM_BITS);
const dm_methods DM_NAME(DM_SET, DM_BITS) = {
    dm_state_create, dm_state_destroy, dm_state_set_constants, dm_state_set_rest, dm_change,
    dm_state_rest_volume, dm_state_place, dm_state_read, dm_state_pinned, dm_state_asleep, dm_state_step,
    dm_state_get_law, dm_carry_surface,
    dm_scene_state_create, dm_scene_state_destroy, dm_scene_state_find, dm_scene_state_place, dm_scene_state_read,
    dm_scene_state_step,
};
