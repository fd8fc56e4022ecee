/* Every number of the core that is not of a material or a mesh, with its unit and the reason for its value. */
#ifndef DM_NUMBERS_H
#define DM_NUMBERS_H
#include <float.h>

/* What Python must know too: `dev.py native` writes it into core/constants.py. */
#define DM_ABI 31              /* changes with anything in dimple.h */
#define DM_MAX_FINGERTIPS 3    /* thumb, index and middle finger: those of the paper's device */
#define DM_MAX_STEPS 1000000   /* in one call, so that none takes longer than minutes */
#define DM_MAX_BODIES 4096     /* in one call, and in one scene: pairs of them are looked at one by one */
#define DM_MAX_RING 12         /* neighbours in a ring: one wide fan must not widen every row */
#define DM_PASSED 11           /* numbers that a call returns of each surface of a scene */
#define DM_LANES 8             /* vertices at once: floats in a register of AVX2 */
#define DM_FOLLOWED DM_LANES   /* vertices of a proxy that a vertex of its surface follows: two rings, thinned */
#define DM_FACTORS 33          /* depths at which the force of another tip is known; linear between them */
#define DM_AIR_PRESSURE 101325.0     /* [Pa] outside every body: the standard atmosphere */
#define DM_AIR_EXPONENT 1.4          /* of air, adiabatic: a press is over before heat flows */
#define DM_LIQUID_BULK_MODULUS 2e6   /* [Pa] a thousandth of water's: kPa change the volume by under 0.5 %, in no shorter steps */
#define DM_OFFSET 0.05         /* of the mean edge: each of two surfaces holds this distance */
#define DM_TRAVEL 0.25         /* of a fingertip's radius: what goes farther in a tick, or over the surface in one part of a way,
                                * could skip over the skin; a facet that bulges by more does not bend round it */
#define DM_CREASE 0.5          /* cosine: faces that turn by more than 60 degrees meet in a crease, which a proxy must keep and
                                * not make */
#define DM_SLACK 1e-3          /* of a size: the error of a place that nobody sees */
#define DM_ROUNDING 1e-6       /* of a size: ten units in the last place of single precision */
#define DM_EXACT 1e-9          /* of a sum: a million units in the last place of double precision */
#define DM_TINY 1e-30          /* keeps a quotient finite: its square is still a number in double precision */

/* Memory. */
#define DM_MAX_VERTICES (1 << FLT_MANT_DIG) /* exact in single precision, and 32-bit offsets reach all records */
#define DM_BLOCK (2 * DM_LANES)             /* triangles that share a box, and boxes that do */

/* Threads. */
#define DM_SLICE 1024     /* vertices of a slice, at least: 6 microseconds of a pass, where to share one out takes 2. A body of one
                           * slice stays on one thread */
#define DM_MOST_SLICES 64 /* of a body, and so threads that are of use */
#define DM_LATE 20        /* looks, of half a microsecond each, after which others do what a worker has not come to; */
#define DM_PATIENCE 200   /* after which a helper sleeps: it has waited as long as waking takes */

/* A fingertip and the skin; lengths in radii of the fingertip. */
#define DM_TOO_NEAR (10 * DM_ROUNDING) /* of a size: nearer to a point, the direction away from it is rounding */
#define DM_SWEEPS 20         /* over all contacts of a substep, at most: then what is left waits for the next one */
#define DM_BACK 0.1          /* of an error that contact has left, is taken back in a substep: all of it would make facets rock,
                              * what sticks shake, and a ball that comes to rest swing */
#define DM_SEATED 1e-4       /* the error with which a sphere lies on the surface; of its size, a pin in its place */
#define DM_HELD (2 * DM_SEATED)   /* what is as near to a sphere, or to the ground, holds it; */
#define DM_SAME_WAY (1 - DM_HELD) /* so cosine: the planes of a surface turned by less hold it at one place */
#define DM_PINNED_GIVE 0.1   /* of a free vertex, that a face gives at least where pinned vertices carry the rest of it */
#define DM_MOST_GIVEN 0.5    /* as deep the skin would be infinitely hard, so that no fingertip passes it; */
#define DM_HARDEST 0.97      /* it hardens up to this share of that depth, where it is 17 times as hard */
#define DM_SUNK 0.16         /* how far a smaller facet may be inside, so that its corners bear the load */
#define DM_NEAR (DM_TRAVEL / 4) /* nearer, what is at rest may be touched within a tick; lists reach twice as far more */
#define DM_STICK (2 / 3.0)   /* of the normal stiffness, what is soft and keeps its volume has sideways. Mindlin 1949 */
#define DM_PUSH_TIME 0.02    /* [s] in which a force brings a fingertip to its depth: a tenth of a press */

/* A body's life. */
#define DM_LARGEST_GROWTH 100.0 /* times its size: farther from its place at rest, deeper or faster than that in a tick, the simulation has diverged */
#define DM_REST_SPEED 1e-3      /* sizes a second: half a pixel, of a body of 500 */
#define DM_REST_TIME 0.25       /* [s] of that: what only turns round in a swing is slow for less, and a dent has come back */

/* What meets: how far a query looks, and what may go how far until the next. */
#define DM_QUERY_REACH 5     /* reach of a query, in distances at which surfaces touch: the number of pairs grows with its
                              * square, that of queries falls with it; 4 to 6 costs least in the scenes of `dev.py contact` */
#define DM_BOUND 0.9         /* of half the distance: what two primitives may go towards each other; rounding has the rest */
#define DM_ROAM 0.99         /* of half the reach: what is near nothing may go */
#define DM_STALE 0.8         /* of the way after which something unknown might touch: a substep comes on top */
#define DM_TRIES 8           /* projections of a vertex on its planes */
#define DM_LEAST_WAY 0.005   /* of its way: what is rigid and may not go so far waits; eight halvings */

/* What touches. */
#define DM_SHARP 0.05        /* slope of the faces beside an edge above which it is one; */
#define DM_FLAT (DM_SHARP / 5) /* below which it is none, and faces do its work */
#define DM_PART 0.6          /* of what is too near, is brought apart in a substep: each of several that share a vertex does */
#define DM_ROLL_ARM 0.005    /* of its size: arm of rolling resistance, a hundredth of a ball's radius */
#endif
