/* Rigid bodies that fall, and their supports. Compiled once, in double precision. Source:
 * studies/reference/falling.py. */
#ifndef DM_FALLING_H
#define DM_FALLING_H
#include "body.h"

#define DM_NO_VERTEX UINT32_MAX

enum { DM_SIDES = 8, DM_CORNERS = 1 + DM_SIDES }; /* contacts with the ground: lowest corner, farthest to each side */

typedef struct { /* a prop */
    double mass, damping, skin, radius, inverse[9]; /* skin: distance that it keeps from rigid surfaces [m] */
    int64_t count;
    double (*arms)[3], (*seen)[3];   /* vertices from the centre, unrotated [m]: that touch; that are seen */
    dm_prop now;
    double turned[9], spin[3];       /* inverse inertia [1/(kg m2)] and angular velocity [1/s] in its pose now */
    double answer[6];                /* impulse [N s] of soft bodies in a substep, and its moment about the centre */
    double apart[6];                 /* displacement [m] and rotation that separate it in this substep */
    double quiet, still[12];         /* [s] for which it has been slow, and its pose when that began */
    uint8_t asleep, rested, placed;
} dm_falling;

typedef struct { /* a contact of a prop with the ground, a collider or another prop, kept until the next update */
    dm_falling *of[2];               /* null: not a prop that is awake */
    uint32_t at[4], surface[2];      /* DM_NO_VERTEX: the ground */
    double weight[4], normal[3], touch, friction, share; /* as in dm_meeting */
    double anchor[3];                /* displacement where it stuck last [m] */
    double point[3], arms[2][3], led[3]; /* point of contact [m], from the centres; colliders' velocity [m/s] */
    double begin, least, back[3];    /* in a substep, as in dm_batch */
    double push, drag[3], give[2];   /* give: 1 / mass along the normal, and its bound tangentially */
} dm_support;

static inline int dm_is_awake(const dm_support *c) { return c->of[0] || c->of[1]; }

void dm_let_fall(dm_falling *f, double h);
/* Note an impulse [N s] that a soft body gives a prop at a point [m]. */
void dm_answer_prop(dm_falling *f, const double *point, const double *impulse, double sign);
int dm_find_ground(dm_falling *f, dm_support *to, double h); /* return the number of contacts */
/* ends: the contact points of both sides [m]. */
void dm_begin_support(dm_support *c, const double (*ends)[3], double h);
void dm_resolve_supports(dm_support *c, uint32_t count, double h);
/* Set the pose (12,), centre and rotation, after a share of its motion in a substep of h seconds. */
void dm_find_pose(const dm_falling *f, double h, double share, double *pose);
void dm_find_places(const dm_falling *f, const double *pose, double (*x)[3]);
void dm_watch_prop(dm_falling *f, double tick);
double dm_speed_of_prop(const dm_falling *f);
#endif
