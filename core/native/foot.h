/* A sphere of a fingertip's radius on the surface at rest, and what lies round it. */
#ifndef DM_FOOT_H
#define DM_FOOT_H
#include "body.h"

enum { DM_SETTLING = 24, DM_CONE_SWEEPS = 32, DM_FOOT_STEPS = 4 };

typedef struct { /* what lies round a sphere: the way from the nearest facet to its centre, and the normals that hold it */
    const dm_facet *facet;
    double near, offset[3], normals[DM_NORMALS][3];
    int count;
} dm_round;

/* Look at the facets round a sphere at x, beginning with one that was near. */
static void dm_look_round(const dm_state *b, int64_t first, const double *x, double radius, dm_round *r);
/* Split a way into what normals push along, of which the length is returned, and the rest. */
static double dm_along_normals(const dm_round *r, const double *way, double *along, double *rest);
/* Lead a sphere over the surface by a way. */
static void dm_march(const dm_state *b, const dm_tip *f, double *x, const double *way, dm_round *r);
/* Find the foot of a fingertip that lies on the surface at rest, x in its space; return how far it is from x. */
static double dm_find_foot(const dm_state *b, dm_tip *f, const double *x, dm_round *round);
/* Find the foot of one that is clear of the surface at rest, or comes to it; return how deep it is: its gap, negative. */
static double dm_find_gap(const dm_state *b, dm_tip *f, const double *x, dm_round *round);
/* How thick the body is behind a place of a facet [m]. */
static double dm_thickness(const dm_state *b, const double *from, const double *inward);
static int dm_is_inside(const dm_state *b, const double *x);
/* How far the skin stands above the surface at rest at a place of a facet [m]. */
static double dm_skin_height(const dm_state *b, const dm_tip *f, const double *pose, const double *place);
#endif
