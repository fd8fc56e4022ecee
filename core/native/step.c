/* Semi-implicit Euler, then contact. Source: core/solver/semi_implicit.py, core/body/model.py forces. */
#include "body.h"
#include "spent.h"

enum { AIR_PRESSURE = 101325, LIQUID_BULK_MODULUS = 2000000 }; /* [Pa], core/base.py */
static const double AIR_EXPONENT = 1.4;

static double pressure_at(const body *b) {
    if (b->fill == DM_FILL_PAPER) return inner_pressure(b);
    if (b->fill == DM_FILL_LIQUID) return LIQUID_BULK_MODULUS * (b->rest_volume - b->volume) / b->rest_volume;
    double least = 0.01 * b->rest_volume; /* a body turned inside out has no volume left */
    return AIR_PRESSURE * (pow(b->rest_volume / (b->volume > least ? b->volume : least), AIR_EXPONENT) - 1);
}

static void follow(body *b) {
    double sums[MOMENTS];
    sum_moments(b, sums);
    fit_pose(b, sums), fit_motion(b, sums);
}

/* What the rings leave out, and then the pressure. */
static void fill_up(body *b) {
    pull_bend(b);
    pull_loose(b);
    if (b->fill == DM_FILL_NONE) return;
    b->volume += add_corners(b) + add_caps(b);
    b->pressure = pressure_at(b);
}

static void move(body *b) {
    if (b->laws == DM_LAWS_PAPER) {
        b->pressure = inner_pressure(b);
        fall(b);
        if (b->pressure != 0) spread_pressure(b);
        pull_loose(b);
        advance_posed(b, b->pressure);
        return;
    }
    if (b->fitted) SPENDS(FITS, follow(b));
    SPENDS(RINGS, (b->fitted ? pull_fitted : pull_posed)(b));
    SPENDS(LOOSE_AND_FILL, fill_up(b));
    SPENDS(ADVANCE, (b->fitted ? advance_fitted : advance_posed)(b, b->fill != DM_FILL_NONE ? b->pressure : 0));
}

static int32_t step(body *b, int64_t ticks, int64_t substeps, double tick, int64_t fingers, const double *centres,
                    const double *radii, double *impulses) {
    if (b->ready != HAS_ALL) return DM_ORDER;
    for (int64_t k = 0; k < 3 * fingers; k++) impulses[k] = 0; /* null where there are none */
    b->dt = tick / (double)substeps;
    for (int64_t t = 0; t < ticks; t++) {
        SPENDS(REACH, reach_out(b, fingers, centres + 3 * t, 3 * (ticks + 1), radii, tick));
        for (int64_t s = 0; s < substeps; s++) {
            move(b);
            SPENDS(CONTACT, meet(b, fingers, impulses));
        }
    }
    return DM_OK;
}
