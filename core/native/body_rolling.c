/* Rolling resistance: a body turns against its support only by a moment above a small arm times its load, so that a
 * ball comes to rest. Source: studies/reference/rolling.py. */
#include "scene.h"

static void dm_limit3(double *a, double most) {
    double size = sqrt(dm_inner3(a, a));
    for (int c = 0; c < 3 && size > most; c++) a[c] *= most / size;
}

DM_INLINE int dm_rolls(const dm_surface *f) { return f->body && f->body->free && !f->body->asleep; }

/* Find the moment that resists the rolling of a body, from the impulses that press on it. */
static void dm_resist_body(const dm_scene_state *s, dm_surface *f) {
    if (f->load == 0) {
        memset(f->resisting, 0, sizeof f->resisting);
        return;
    }
    const double *row = f->body->moments.tensor, *spin = f->body->moments.spin;
    double way[3], most = DM_ROLL_ARM * f->body->size * f->load / s->dt;
    for (int c = 0; c < 3; c++) way[c] = spin[c] - f->spin_beside[c] / f->load;
    for (int c = 0; c < 3; c++, row += 3) {
        double stop = dm_inner3(row, way) / s->dt;
        f->moment_of[c] = f->resisting[c] + DM_BACK * stop;
        f->resisting[c] += DM_BACK * DM_BACK / 4 * stop; /* critical damping */
    }
    dm_limit3(f->moment_of, most), dm_limit3(f->resisting, most);
    for (int c = 0; c < 3; c++) f->body->resisted[c] += f->moment_of[c];
}

/* After a substep: find the moments of the next one, on bodies, and the opposite ones on the bodies that they press. */
static void dm_resist_rolling(dm_scene_state *s) {
    int rolling = 0;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        if (!dm_rolls(f)) continue;
        memset(f->body->resisted, 0, sizeof f->body->resisted), memset(f->spin_beside, 0, sizeof f->spin_beside);
        f->load = 0, rolling++;
    }
    for (uint32_t i = 0; rolling && i < DM_LANES * s->batch_count; i++) {
        double push = (double)s->batches[i / DM_LANES].push[i % DM_LANES];
        if (!(push > 0)) continue;
        const uint32_t *of = dm_sides_of(s, i);
        for (int j = 0; j < 2 && of[0] != of[1]; j++) {
            dm_surface *f = s->surfaces + of[j];
            const dm_surface *g = s->surfaces + of[1 - j];
            f->load += push;
            for (int c = 0; c < 3 && dm_rolls(g); c++) f->spin_beside[c] += push * g->body->moments.spin[c];
        }
    }
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        if (dm_rolls(f)) dm_resist_body(s, f);
    for (uint32_t i = 0; rolling > 1 && i < DM_LANES * s->batch_count; i++) {
        double push = (double)s->batches[i / DM_LANES].push[i % DM_LANES];
        if (!(push > 0)) continue;
        const uint32_t *of = dm_sides_of(s, i);
        for (int j = 0; j < 2 && of[0] != of[1]; j++) {
            const dm_surface *f = s->surfaces + of[j];
            dm_surface *g = s->surfaces + of[1 - j];
            if (!dm_rolls(f) || !dm_rolls(g) || f->load == 0) continue;
            for (int c = 0; c < 3; c++) g->body->resisted[c] -= push / f->load * f->moment_of[c];
        }
    }
}
