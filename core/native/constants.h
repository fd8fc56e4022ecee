/* Every number of the core that is not of a material or a mesh, with its unit and the reason for its value. */
#ifndef DM_NUMBERS_H
#define DM_NUMBERS_H

/* What Python must know too: `dev.py native` writes it into core/constants.py. */
#define DM_ABI 27              /* changes with anything in dimple.h */
#define DM_MAX_FINGERTIPS 3    /* thumb, index and middle finger: those of the paper's device */
#define DM_MAX_STEPS 1000000   /* in one call, so that none takes longer than minutes */
#define DM_MAX_BODIES 4096     /* in one call, and in one scene: pairs of them are looked at one by one */
#define DM_MAX_RING 12         /* neighbours in a ring: one wide fan must not widen every row */
#define DM_LANES 8             /* vertices at once: floats in a register of AVX2 */
#define DM_FOLLOWED 8          /* vertices of a proxy that a vertex of its surface follows: two rings, thinned */
#define DM_FACTORS 33          /* depths at which the force of another tip is known; linear between them */
#define DM_AIR_PRESSURE 101325.0     /* [Pa] outside every body: the standard atmosphere */
#define DM_AIR_EXPONENT 1.4          /* of air, adiabatic: a press is over before heat flows */
#define DM_LIQUID_BULK_MODULUS 2e6   /* [Pa] a thousandth of water's: kPa change the volume by under 0.5 %, in no shorter steps */
#define DM_OFFSET 0.05         /* of the mean edge: each of two surfaces holds this distance, and a query finds what is near in some multiples of it */
#define DM_ROUNDING 1e-6       /* of a size: ten units in the last place of single precision */
#define DM_TRAVEL 0.25         /* of a fingertip's radius, in a tick: farther, it could skip over the skin */

/* Memory. */
#define DM_MAX_VERTICES (1 << 24) /* exact in single precision, and 32-bit offsets reach all records */
#define DM_BLOCK 16               /* triangles that share a box, and boxes that do: twice as many as are looked at at once */
#define DM_LEAF 4                 /* triangles in a leaf of a tree; only speed depends on it */
#define DM_BIN_POINTS 10          /* points in a bin where bins fill a cube: some hundred where they lie on a surface */

/* Rounding of single precision. */
#define DM_TINY ((dm_real)1e-30) /* keeps a quotient finite: its square is still a number */
#define DM_TOO_NEAR 1e-5         /* of a size: nearer to a point, the direction away from it is rounding */
#define DM_PUSH_FLOOR 1e-8       /* of the radius: an impulse that moves its point less far in a substep is rounding */

/* A fingertip and the skin. */
#define DM_SWEEPS 16         /* over all contacts of a substep, at most: then what is left waits for the next one */
#define DM_HELD_PART 0.1     /* of its gap or depth, that what was held loses in a substep; all of it would make facets rock */
#define DM_PLACE_SLACK 1e-3  /* of the radius: no deeper, nobody sees it */
#define DM_PINNED_GIVE 0.1   /* of a free vertex, that a face gives at least where pinned vertices carry the rest of it */
#define DM_YIELDS 2          /* times the compliance at a vertex: half of the skin is that of vertices, half that of twice as
                                many faces */
#define DM_MOST_GIVEN 0.5    /* of the radius: as deep the skin would be infinitely hard, so that no fingertip passes it; */
#define DM_HARDEST 0.97      /* it hardens up to this share of that depth, where it is 17 times as hard */
#define DM_NO_WAY 0.1        /* of the radius: so near to the point behind its centre there is no way from that */
#define DM_STIFF 0.25        /* of the radius: a facet that bulges by more is too large to bend round it, and is met whole */
#define DM_SUNK 0.16         /* of the radius: how far a smaller facet may be inside, so that its corners bear the load */
#define DM_NEAR 0.0625       /* of the radius: nearer, what is at rest may be touched within a tick; lists reach twice as far more */

/* The foot of a fingertip on the surface at rest, and its force. */
#define DM_MARCH 0.25      /* of the radius: a sphere goes over the surface in such parts, so that it cannot pass a wall */
#define DM_SEATED 1e-4     /* of the radius: a sphere is laid on the surface as exactly */
#define DM_HELD 2e-4       /* of the radius: what is as near to a sphere holds it */
#define DM_STRAIGHT 1e-3   /* of the radius: a foot that is so little aside is straight above */
#define DM_SAME_WAY 0.9998 /* cosine: normals as near are one */
#define DM_INSIDE 0.75     /* of all directions: half way between a sheet and a closed body */
#define DM_STICK (2 / 3.0) /* of the normal stiffness, what is soft and keeps its volume has sideways. Mindlin 1949 */
#define DM_PUSH_TIME 0.02  /* [s] in which a force brings a fingertip to its depth: a tenth of a press */
#define DM_BACK_TIME 0.2   /* [s] in which depth is counted from rest again, once what had moved the skin is gone: a dent's return */
#define DM_BOTTOM 1e3      /* [m] a law that has not answered a force by then never does */

/* Edges of a proxy. */
#define DM_AS_FLAT 0.5  /* cosine: the two new triangles must face nearly as the old ones did */
#define DM_BLUNT 1e-9   /* of a cotangent: what is no more negative is rounding */

/* A body's life. */
#define DM_LARGEST_GROWTH 100.0 /* times its size at rest: larger, or faster than that in a tick, the simulation has diverged */
#define DM_PIN_BEHIND 1e-4      /* of the size: a pin that is farther from its place was held back */
#define DM_REST_SPEED 1e-3      /* sizes a second: half a pixel, of a body of 500 */
#define DM_REST_TIME 0.25       /* [s] of that: what only turns round in a swing is slow for less */

/* What meets: how far a query looks, and what may go how far until the next. */
#define DM_REACH_EDGE 0.3    /* of the mean edge: the farthest a query looks; pairs grow with its square */
#define DM_LEAST_REACH 2.5   /* of the distance at which surfaces touch: the least */
#define DM_REACH_TIME 1.5    /* ticks that a query is to last */
#define DM_WIDE 3.0          /* of the reach: how far a search looks, of which several queries live */
#define DM_BOUND 0.9         /* of half the distance: what two primitives may go towards each other; rounding has the rest */
#define DM_ROAM 0.99         /* of half the reach: what is near nothing may go */
#define DM_STALE 0.8         /* of the way after which something unknown might touch: a substep comes on top */
#define DM_LEAST_SHARE 0.1   /* of the distance, that a side gets at least; more the faster it comes; */
#define DM_SOFT_SHARE 0.3    /* where both are soft: they come and go, and a side that is slow now is soon fast */
#define DM_SLOW 1e-3         /* [m/s] below this, both sides count as equally fast */
#define DM_QUICK 0.05        /* of its way: what goes farther in a substep gets its planes by all it has gone */
#define DM_PROJECTIONS 4     /* on the planes of a vertex, before its way is cut short */
#define DM_HALVINGS 8        /* of the way of a prop that is held back: to half a percent of it */

/* What touches. */
#define DM_FLAT 0.01         /* slope of the faces beside an edge below which it is none, and faces do its work, */
#define DM_SHARP 0.05        /* and above which it is one */
#define DM_ON_BORDER 1e-9    /* weight of a corner below which a point of a face lies on the border opposite it: rounding */
#define DM_BACK 0.2          /* of what it has slipped, what sticks goes back in a substep; all of it would shake */
#define DM_PART 0.6          /* of what is too near, is brought apart in a substep: each of several that share a vertex does */
#define DM_ROLL_ARM 0.005    /* of its size: arm of rolling resistance, a hundredth of a ball's radius */
#define DM_ROLL_PART 0.1     /* of what would stop it, that resists in a substep; a quarter of its square is kept: critical */
#define DM_FALL_SWEEPS 20    /* over all that props touch, at most, and */
#define DM_FALL_SETTLED 1e-7 /* of all impulses, what a sweep may still change: with 16 and 1e-6 a pile of four sinks by a millimeter */
#define DM_FALL_LEVEL 2e-4   /* of a prop's radius: what is no higher above its lowest vertex lies on the ground with it */
#endif
