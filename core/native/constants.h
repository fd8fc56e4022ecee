/* Every number of the C core that belongs to no material and no mesh, with its unit and the reason for its value. */
#ifndef DM_CONSTANTS_H
#define DM_CONSTANTS_H
#include <float.h>

/* Numbers that Python needs too: `dev.py native` writes them into core/constants.py. */
#define DM_ABI 33              /* changes with every change of dimple.h */
#define DM_MAX_FINGERTIPS 3    /* thumb, index and middle finger, as on the paper's device */
#define DM_MAX_STEPS 1000000   /* steps in one call, so that no call takes longer than minutes */
#define DM_MAX_RING 12         /* neighbours in a ring; a vertex with more is treated as irregular */
#define DM_PASSED 11           /* numbers that a call returns for each surface of a scene */
#define DM_LANES 8             /* vertices processed together: single-precision lanes of an AVX2 register */
#define DM_FOLLOWED DM_LANES   /* vertices of a proxy that each vertex of the fine surface follows */
#define DM_FACTORS 33          /* rows of the table of the force of another tip, interpolated linearly */
#define DM_AIR_PRESSURE 101325.0     /* [Pa] outside every body: the standard atmosphere */
#define DM_AIR_EXPONENT 1.4          /* of air, adiabatic: a press is over before heat flows */
#define DM_LIQUID_BULK_MODULUS 2e6   /* [Pa] a thousandth of water's: allows longer steps, and 10 kPa change a volume by 0.5 % */
#define DM_OFFSET 0.05         /* distance that a surface keeps from others, in mean edge lengths */
#define DM_TRAVEL 0.25         /* largest step of a fingertip in its radii, so that it cannot skip the skin; also the largest
                                * bulge of a facet that still bends round the fingertip */
#define DM_CREASE 0.5          /* cosine of 60 degrees: faces that turn by more form a crease, which a proxy keeps */
#define DM_SLACK 1e-3          /* of a size: an invisible error of position */
#define DM_ROUNDING 1e-6       /* of a size: ten units in the last place of single precision */
#define DM_EXACT 1e-9          /* of a sum: a million units in the last place of double precision */
#define DM_TINY 1e-30          /* keeps a quotient finite; its square is still a number in double precision */

/* Memory. */
#define DM_MAX_BODIES 4096     /* bodies in one call or scene, since all pairs of them are compared */
#define DM_MAX_VERTICES (1 << FLT_MANT_DIG) /* exact in single precision, and 32-bit offsets reach all records */
#define DM_BLOCK (2 * DM_LANES)             /* triangles in a box, and boxes in the next larger one */

/* Threads. */
#define DM_SLICE 1024     /* smallest number of vertices in a slice: 6 us of work, three times the cost of sharing it. A body of
                           * one slice stays on one thread */
#define DM_MOST_SLICES 64 /* slices of a body, and so the largest number of useful threads */
#define DM_PATIENCE 200   /* polls, of half a microsecond each, after which a helper sleeps: as long as waking up takes */

/* Contact, of fingertips and of bodies. */
#define DM_SWEEPS 20         /* sweeps of an iteration, at most; the remaining error waits for the next substep */
#define DM_BACK 0.1          /* share of a contact's error that is corrected in a substep: with all of it facets rock, sticking
                              * contacts shake, and a ball at rest swings */
#define DM_PINNED_GIVE 0.1   /* least compliance of a face with pinned vertices, in shares of that of a free vertex */

/* A fingertip and the skin; lengths in radii of the fingertip. */
#define DM_TOO_NEAR (10 * DM_ROUNDING) /* of a size: closer to a point, the direction away from it is mere rounding */
#define DM_SEATED 1e-4       /* error of a sphere that lies on the surface; in sizes of a body, of a pin in its place */
#define DM_HELD (2 * DM_SEATED) /* distance at which a facet, or the ground, still counts as in contact; also 1 minus the
                                 * cosine between two normals that count as one */
#define DM_MOST_GIVEN 0.5    /* depth at which a yielding skin would be infinitely hard, so that no fingertip passes it */
#define DM_HARDEST 0.97      /* share of that depth up to which it hardens, to 17 times its stiffness */
#define DM_SUNK 0.16         /* depth to which small facets may be inside, so that their corners carry the load */
#define DM_NEAR (DM_TRAVEL / 4) /* margin within which a surface at rest may be touched in a tick; lists have twice as much */
#define DM_STICK (2 / 3.0)   /* sideways over normal stiffness of a contact on an incompressible solid. Mindlin 1949 */
#define DM_PUSH_TIME 0.02    /* [s] time constant with which a force moves a fingertip to its depth: a tenth of a press */

/* A body's life. */
#define DM_LARGEST_GROWTH 100.0 /* sizes: farther from its place at rest, deeper, or faster in a tick, a body has diverged */
#define DM_REST_SPEED 1e-3      /* [sizes/s] half a pixel a second for a body of 500 pixels */
#define DM_REST_TIME 0.25       /* [s] below that speed, or in place, before a body sleeps: longer than the turning point of a swing */

/* Meeting bodies: the reach of a query, and the way allowed until the next one. */
#define DM_QUERY_REACH 4     /* reach of a query, in distances at which surfaces touch: the number of pairs grows with its
                              * square, that of queries falls with it; 4 to 6 cost least in the scenes of `dev.py contact` */
#define DM_BOUND 0.9         /* share of a distance, or of half the reach, that may be used up; rounding gets the rest */
#define DM_STALE 0.8         /* share of the way to a first unknown contact after which a query is due; a substep follows */
#define DM_TRIES 8           /* projections of a vertex onto its planes */
#define DM_LEAST_WAY 0.005   /* share of its way below which a rigid surface waits: eight halvings */

/* Touching bodies. */
#define DM_SHARP 0.05        /* slope of the faces at an edge above which the edge is sharp */
#define DM_FLAT (DM_SHARP / 5) /* slope below which it is flat, and its faces take the contact */
#define DM_ROLL_ARM 0.005    /* arm of the rolling resistance in sizes: a hundredth of a ball's radius */
#endif
