/* Sleep of bodies in contact: bodies that may touch fall asleep together, and wake before a moving one can touch them.
 * Source: studies/reference/islands.py. */
#include "scene.h"

DM_INLINE int dm_moves(const dm_surface *f) { return f->body ? !dm_sleeps(f) : dm_goes(f); }

/* Wake the bodies and props that may touch something moving before the next update, and those that they may touch. */
static void dm_wake_touched(dm_scene_state *s, const dm_motion *motions, int64_t t, dm_frame *frames) {
    s->wakes = 0;
    for (int64_t k = 0; k < s->surface_count; k++) {
        dm_surface *f = s->surfaces + k;
        if (f->pressed && f->body->asleep) dm_wake(f->body), dm_enter_tick(f->body, motions + k, t, frames + k);
        f->pressed = 0;
    }
    for (int more = dm_any_sleeps(s); more;) {
        more = 0;
        for (uint32_t i = 0; i < dm_side_count(s); i++)
            for (int j = 0; j < 2; j++) {
                const uint32_t *of = dm_both_of(s, i);
                dm_surface *f = s->surfaces + of[j];
                int64_t k = of[j];
                if (!dm_sleeps(f) || !dm_moves(s->surfaces + of[1 - j])) continue;
                if (f->prop) f->prop->asleep = 0, f->prop->quiet = 0;
                else dm_wake(f->body), dm_enter_tick(f->body, motions + k, t, frames + k);
                more = 1;
            }
    }
}

DM_INLINE int dm_has_rested(const dm_surface *f) { return f->body ? f->body->rested : f->prop && f->prop->rested; }

/* After a tick: put to sleep the bodies and props that are at rest, as is everything that they may touch. */
static void dm_let_sleep(dm_scene_state *s, const dm_motion *motions) {
    int rested = 0;
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++) {
        f->kept = (uint8_t)(dm_moves(f) && !dm_has_rested(f));
        rested |= dm_has_rested(f);
    }
    for (int more = rested; more;) {
        more = 0;
        for (uint32_t i = 0; i < dm_side_count(s); i++)
            for (int j = 0; j < 2; j++) {
                const uint32_t *of = dm_both_of(s, i);
                dm_surface *f = s->surfaces + of[j];
                if ((f->body || f->prop) && !f->kept && s->surfaces[of[1 - j]].kept) f->kept = 1, more = 1;
            }
    }
    for (dm_surface *f = s->surfaces; f < s->surfaces + s->surface_count; f++)
        if (dm_has_rested(f) && !f->kept) {
            if (f->prop) f->prop->asleep = 1, f->prop->rested = 0;
            else dm_fall_asleep(f->body, motions + (f - s->surfaces));
        }
}
