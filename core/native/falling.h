/* Rigid bodies that fall, and what they stand on. Compiled once, in double precision. Source: studies/reference/falling.py. */
#ifndef DM_FALLING_H
#define DM_FALLING_H
#include "body.h"

#define DM_NO_VERTEX UINT32_MAX

enum { DM_SIDES = 8, DM_CORNERS = 1 + DM_SIDES }; /* of what lies on the ground: the lowest corner, and the farthest to each side */

typedef struct { /* a prop */
    double mass, damping, skin, radius, inverse[9]; /* skin: from what does not give it keeps so far [m] */
    int64_t count;
    double (*arms)[3], (*seen)[3];   /* of its vertices from the centre, as it lies at the start [m]: of what touches; as seen */
    dm_prop now;
    double turned[9], spin[3];       /* inverse inertia [1/kg m2], and rate [1/s], as it lies now */
    double answer[6];                /* impulse [N s], and moment about the centre, that soft bodies gave it in a substep */
    double apart[6];                 /* way [m] and turn by which it is brought apart in this substep */
    double quiet, still[12];         /* [s] since it was slow last, and where it was then */
    uint8_t asleep, rested, placed;
} dm_falling;

typedef struct { /* a prop and the ground, a collider, or another prop, that may touch: kept until the next look */
    dm_falling *of[2];               /* null: it goes where it is led */
    uint32_t at[4], surface[2];      /* DM_NO_VERTEX: the ground */
    double weight[4], normal[3], touch, friction, share; /* as in dm_meeting */
    double anchor[3];                /* where on its way it stuck last [m] */
    double point[3], arms[2][3], led[3]; /* where they meet [m]; velocity of what is led [m/s] */
    double begin, least, back[3];    /* of a substep, as in dm_batch */
    double push, drag[3], give[2];   /* give: 1 / mass, along the normal, and at most square to it */
} dm_support;

static inline int dm_is_awake(const dm_support *c) { return c->of[0] || c->of[1]; }

void dm_let_fall(dm_falling *f, double h);
/* Note an impulse [N s] that a soft body gives a prop at a point [m]. */
void dm_answer_prop(dm_falling *f, const double *point, const double *impulse, double sign);
int dm_find_ground(dm_falling *f, dm_support *to, double h); /* return how many there are */
/* ends: where the points of both are [m]. */
void dm_begin_support(dm_support *c, const double (*ends)[3], double h);
void dm_resolve_supports(dm_support *c, uint32_t count, double h);
/* Set where it is (12,) after so much of its way in a substep. */
void dm_find_pose(const dm_falling *f, double h, double share, double *pose);
void dm_find_places(const dm_falling *f, const double *pose, double (*x)[3]);
void dm_watch_prop(dm_falling *f, double tick);
double dm_speed_of_prop(const dm_falling *f);
#endif
