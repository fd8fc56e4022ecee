/* A sphere of a fingertip's radius on the surface at rest, and the facets near it. */
#ifndef DM_FOOT_H
#define DM_FOOT_H
#include "body.h"

enum { DM_FOOT_STEPS = 4 }; /* steps of a foot towards the place straight above its fingertip, at most */

typedef struct { /* of a sphere: vector from the nearest facet to its centre; normals and distances of others near */
    const dm_facet *facet;
    double near, offset[3], normals[DM_NORMALS][3], away[DM_NORMALS];
    int count;
} dm_round;

/* Search the facets near a sphere at x, starting from one that was near before. */
static void dm_look_round(const dm_state *b, int64_t first, const double *x, double radius, dm_round *r);
/* Split a vector into its projection on the cone of some normals, whose length is returned, and the rest. */
static double dm_along_normals(const dm_round *r, const double *way, double *along, double *rest);
/* Move a sphere over the surface by a vector. */
static void dm_march(const dm_state *b, const dm_tip *f, double *x, const double *way, dm_round *r);
/* Find the foot of a fingertip that touches the surface at rest, x in its space; return its distance from x. */
static double dm_find_foot(const dm_state *b, dm_tip *f, const double *x, dm_round *round);
/* Find the foot of a fingertip that is clear of the surface at rest or just reaches it; return minus its gap. */
static double dm_find_gap(const dm_state *b, dm_tip *f, const double *x, dm_round *round);
/* Return the thickness of the body behind a point of a facet [m]. */
static double dm_thickness(const dm_state *b, const double *from, const double *inward);
static int dm_is_inside(const dm_state *b, const double *x);
/* Return the height of the skin above the surface at rest at a point of a facet [m]. */
static double dm_skin_height(const dm_state *b, const dm_tip *f, const double *pose, const double *place);
#endif
