/* Regions: parts of a pinned body that are stepped only while something moves in them or beside. Where nothing has gone
 * farther than the slack for DM_REGION_TIME, a region rests where it is, without a speed, and it goes on from there.
 * Source: studies/reference/regions.py. */
#include "body.h"

enum { DM_SLEEPS, DM_BORDERS, DM_STEPS };

static int32_t dm_lay_regions(dm_state *b, const dm_body_def *d) {
    dm_regions *r = &b->regions;
    int64_t count = d->regions, n = count ? b->groups : 0, entries = count ? d->beside_start[count] : 0;
    for (int64_t g = 0; g < b->groups; g++) b->stepped[g] = (uint32_t)g;
    b->stepped_count = b->groups;
    int whole = (r->beside_start = dm_alloc(count + 1, sizeof(int64_t))) && (r->beside = dm_alloc(entries, sizeof(int64_t)));
    whole = whole && (r->of = dm_alloc(n, sizeof *r->of)) && (r->awake = dm_alloc(count, 1));
    whole = whole && (r->wanted = dm_alloc(count, 1)) && (r->role = dm_alloc(n, 1));
    whole = whole && (r->settled = dm_alloc(n, sizeof *r->settled)) && (r->moved = dm_alloc(count, sizeof(double)));
    whole = whole && (r->volume = dm_alloc(n, sizeof(double)));
    if (!whole) return DM_MEMORY;
    for (int64_t k = 0; count && k < b->n; k++) r->of[b->place[k] / DM_LANES] = (uint32_t)d->region[k];
    for (int64_t k = 0; count && k <= count; k++) r->beside_start[k] = d->beside_start[k];
    for (int64_t k = 0; k < entries; k++) r->beside[k] = d->beside[k];
    memset(r->awake, 1, (size_t)count), memset(r->role, DM_STEPS, (size_t)n);
    for (int64_t k = 0; k < count; k++) r->moved[k] = -INFINITY;
    r->count = count, r->slack = d->slack;
    return DM_OK;
}

static void dm_note_moved(dm_state *b, uint32_t i) { b->regions.moved[b->regions.of[i / DM_LANES]] = b->regions.clock; }

/* Which vertices of a group are farther than the slack from `from`? */
DM_INLINE dm_mask dm_beyond(const dm_state *b, int64_t g, dm_vec3 from) {
    dm_vec3 way = dm_sub(b->state[g].x, from);
    dm_mask far = (dm_mask)(dm_dot(way, way) > dm_splat((dm_real)(b->regions.slack * b->regions.slack)));
    return far & (dm_mask)(b->matter[g].mass > dm_splat(0)); /* lanes may be empty */
}

/* Wake what a change may move: all of it, or what is not where it would be at rest. */
static void dm_wake_displaced(dm_state *b, int all) {
    dm_vec3 offset = dm_splat3(b->translation);
    dm_vec3 rows[3] = {dm_splat3(b->rotation), dm_splat3(b->rotation + 3), dm_splat3(b->rotation + 6)};
    for (int64_t g = 0; g < b->groups; g++)
        if (all || dm_any_of(dm_beyond(b, g, dm_rotated(rows, b->matter[g].rest, offset))))
            dm_note_moved(b, (uint32_t)g * DM_LANES);
    b->regions.changed = 0;
    if (all) b->regions.pressure = b->pressure;
}

/* Let a group rest where it is. */
static void dm_settle_group(dm_state *b, int64_t g) {
    dm_vec3 way = dm_sub(b->state[g].x, b->listed[g]), none = {dm_splat(0), dm_splat(0), dm_splat(0)};
    double gone = sqrt(dm_most_of(dm_dot(way, way)));
    b->regions.gone = gone > b->regions.gone ? gone : b->regions.gone;
    b->state[g].v = none;
    for (uint32_t i = 0; i < DM_LANES; i++) b->records[g * DM_LANES + i].v = (dm_quad){0, 0, 0, 0};
}

/* Is a group that rests beside one that is stepped? */
static int dm_is_border(const dm_state *b, int64_t g) {
    for (int64_t s = b->ring.start[g]; s < b->ring.start[g + 1]; s++)
        for (int l = 0; l < DM_LANES; l++)
            if (b->regions.wanted[b->regions.of[b->ring.slots[s].at[l] / sizeof(dm_record) / DM_LANES]]) return 1;
    return 0;
}

/* List what is stepped from now on. */
static void dm_list_stepped(dm_state *b) {
    dm_regions *r = &b->regions;
    b->stepped_count = b->border_count = 0, r->resting = 0;
    for (int64_t g = 0; g < b->groups; g++) {
        int step = r->wanted[r->of[g]], before = r->role[g];
        int role = step ? DM_STEPS : dm_is_border(b, g) ? DM_BORDERS : DM_SLEEPS;
        if (role == DM_STEPS && before != DM_STEPS) r->settled[g] = b->state[g].x;
        if (role != DM_STEPS && before == DM_STEPS) dm_settle_group(b, g);
        if (role == DM_SLEEPS && before != DM_SLEEPS) r->volume[g] = dm_sum_of(dm_pass_pinned(b, g)) / 18;
        if (role == DM_STEPS) b->stepped[b->stepped_count++] = (uint32_t)g;
        if (role == DM_BORDERS) b->border[b->border_count++] = (uint32_t)g;
        if (role == DM_SLEEPS) r->resting += r->volume[g];
        r->role[g] = (uint8_t)role;
    }
    memcpy(r->awake, r->wanted, (size_t)r->count);
}

/* Choose what is stepped in the tick that begins, once it is known what the fingertips may meet. */
static void dm_choose_stepped(dm_state *b, const dm_motion *m) {
    dm_regions *r = &b->regions;
    if (!r->count) return;
    double bulge = b->fill == DM_FILL_NONE ? 0 : fabs(b->pressure - r->pressure) * b->rest_area / b->k1_total;
    int pushed = r->changed && (b->rest_pressure != 0 || dm_inner3(b->gravity, b->gravity) > 0);
    int all = pushed || bulge > r->slack || !b->any_k1 || b->free || b->meets || b->moving || m->pins_to;
    all |= b->ground > -INFINITY;
    if (all || r->changed) dm_wake_displaced(b, all);
    for (const dm_near *t = b->touches; t < b->touches + b->finger_count; t++)
        for (int64_t k = 0; k < t->noted_count; k++) dm_note_moved(b, t->noted[k]);
    memset(r->wanted, 0, (size_t)r->count);
    for (int64_t k = 0; k < r->count; k++)
        for (int64_t j = r->beside_start[k]; r->clock - r->moved[k] < DM_REGION_TIME && j < r->beside_start[k + 1]; j++)
            r->wanted[r->beside[j]] = 1;
    if (memcmp(r->wanted, r->awake, (size_t)r->count)) dm_list_stepped(b);
}

/* After a tick: note which regions have gone beyond the slack. */
static void dm_watch_regions(dm_state *b, double tick) {
    dm_regions *r = &b->regions;
    for (int64_t k = 0; r->count && k < b->stepped_count; k++) {
        uint32_t g = b->stepped[k];
        dm_vec3 x = b->state[g].x, *before = r->settled + g;
        dm_mask far = dm_beyond(b, g, *before);
        if (!dm_any_of(far)) continue;
        *before = (dm_vec3){dm_blend(far, x.x, before->x), dm_blend(far, x.y, before->y), dm_blend(far, x.z, before->z)};
        dm_note_moved(b, g * DM_LANES);
    }
    r->clock += tick;
}
