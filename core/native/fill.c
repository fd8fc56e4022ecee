/* The fill of a body: its pressure. Source: core/body/pressure.py. */
#include "body.h"

static double dm_pressure_at(const dm_state *b) {
    if (b->fill == DM_FILL_LIQUID)
        return DM_LIQUID_BULK_MODULUS * (b->rest_volume - b->volume) / b->rest_volume + b->rest_pressure;
    double least = 0.01 * b->rest_volume; /* a body that is turned inside out has a negative volume */
    double squeeze = pow(b->rest_volume / (b->volume > least ? b->volume : least), DM_AIR_EXPONENT);
    return DM_AIR_PRESSURE * (squeeze - 1) + b->rest_pressure * squeeze;
}

/* Add the faces that have no ring, then set the pressure. */
static void dm_apply_fill(dm_state *b) {
    dm_add_irregular_forces(b);
    if (b->fill == DM_FILL_NONE) return;
    b->volume += dm_add_fans(b) + dm_add_caps(b);
    b->pressure = dm_pressure_at(b);
}
