/* Create, place, read and destroy a body. */
#include "body.h"

static void dm_state_destroy(dm_state *b) {
    void *const parts[] = {
        b->place, b->rank, b->pinned, b->loose, b->rest, b->mass, b->pins, b->records, b->state, b->matter, b->next,
        b->ring.start, b->ring.slots, b->ring_spring, b->irregular, b->ends, b->rest_length, b->stiffness,
        b->tension, b->rest_rate, b->pull_rate,
        b->fans, b->caps, b->cap_hole, b->holes, b->triangles,
        b->inverse_mass, b->friction, b->compliance, b->hits, b->before, b->still, b->listed, b->sums, b->pin_room, b->shares, b->moved,
        b->is_moved, b->facets, b->facet_boxes, b->facet_regions, b->painted, b->laws,
    };
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) dm_free(parts[k]);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        dm_free(b->touches[k].vertices), dm_free(b->touches[k].faces), dm_free(b->touches[k].noted);
        dm_free(b->fingers[k].kept), dm_free(b->fingers[k].kept_at);
        dm_free(b->touches[k].radii), dm_free(b->touches[k].listed_vertices), dm_free(b->touches[k].listed_faces);
    }
    dm_free(b);
}

/* Allocate all arrays; their sizes follow from the definition. */
static int32_t dm_allocate(dm_state *b, const dm_body_def *d) {
    int64_t n = d->vertices, size = b->groups * DM_LANES, t = d->triangles;
    int whole = (b->place = dm_alloc(n, sizeof *b->place)) && (b->rank = dm_alloc(n, sizeof *b->rank));
    whole = whole && (b->pinned = dm_alloc(n, sizeof *b->pinned)) && (b->loose = dm_alloc(n, 1));
    whole = whole && (b->rest = dm_alloc(3 * n, sizeof(double))) && (b->mass = dm_alloc(n, sizeof(double)));
    whole = whole && (b->pins = dm_alloc(3 * n, sizeof(double))) && (b->pin_room = dm_alloc(9 * size, sizeof(double)));
    whole = whole && (b->records = dm_alloc(size, sizeof(dm_record)));
    whole = whole && (b->state = dm_alloc(b->groups, sizeof(dm_group_state)));
    whole = whole && (b->matter = dm_alloc(b->groups, sizeof(dm_group_matter)));
    whole = whole && (b->sums = dm_alloc(b->slices, sizeof *b->sums));
    whole = whole && (b->still = dm_alloc(b->groups, sizeof(dm_vec3)));
    whole = whole && (b->listed = dm_alloc(b->groups, sizeof(dm_vec3)));
    whole = whole && (b->rest_rate = dm_alloc(b->groups, sizeof(dm_vec3)));
    whole = whole && (b->pull_rate = dm_alloc(b->groups, sizeof(dm_vec3)));
    whole = whole && (b->next = dm_alloc(b->groups, sizeof(dm_group_next)));
    whole = whole && (b->inverse_mass = dm_alloc(size, sizeof(dm_real)));
    whole = whole && (b->friction = dm_alloc(size, sizeof(dm_real)));
    whole = whole && (b->compliance = dm_alloc(size, sizeof(dm_real)));
    whole = whole && (b->before = dm_alloc(size, sizeof *b->before));
    whole = whole && (b->shares = dm_alloc(size, sizeof(uint32_t))) && (b->moved = dm_alloc(size, sizeof(uint32_t)));
    whole = whole && (b->is_moved = dm_alloc(size, 1));
    whole = whole && (b->irregular = dm_alloc(d->irregular, sizeof *b->irregular));
    whole = whole && (b->ends = dm_alloc(d->springs, sizeof *b->ends));
    whole = whole && (b->rest_length = dm_alloc(d->springs, sizeof(double)));
    whole = whole && (b->stiffness = dm_alloc(d->springs, sizeof(double)));
    whole = whole && (b->tension = dm_alloc(d->springs, sizeof(double)));
    whole = whole && (b->fans = dm_alloc(d->fans, sizeof *b->fans));
    whole = whole && (b->caps = dm_alloc(d->cap_edges, sizeof *b->caps));
    whole = whole && (b->cap_hole = dm_alloc(d->cap_edges, sizeof(uint32_t)));
    whole = whole && (b->holes = dm_alloc(d->cap_edges, sizeof *b->holes));
    whole = whole && (b->triangles = dm_alloc(t + DM_LANES, sizeof *b->triangles));
    whole = whole && (b->hits = dm_alloc(size + t, sizeof(dm_contact)));
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) {
        whole = whole && (b->touches[k].vertices = dm_alloc(size, sizeof(uint32_t)));
        whole = whole && (b->touches[k].faces = dm_alloc(t + DM_LANES, sizeof *b->touches[k].faces));
        whole = whole && (b->touches[k].listed_vertices = dm_alloc(size, sizeof(uint32_t)));
        whole = whole && (b->touches[k].listed_faces = dm_alloc(t + DM_LANES, sizeof *b->touches[k].listed_faces));
        whole = whole && (b->touches[k].radii = dm_alloc(t + DM_LANES, sizeof(dm_real)));
        whole = whole && (b->touches[k].noted = dm_alloc(size, sizeof(uint32_t)));
        whole = whole && (b->fingers[k].kept = dm_alloc(size + t, sizeof(dm_quad)));
        whole = whole && (b->fingers[k].kept_at = dm_alloc(size + t, sizeof(uint32_t)));
    }
    return whole ? DM_OK : DM_MEMORY;
}

/* Sort the triangles along the curve in space. */
static int32_t dm_lay_faces(dm_state *b, int64_t t, const int64_t *corners) {
    int64_t size = b->groups * DM_LANES;
    uint32_t *next = dm_alloc(size + 1, sizeof(uint32_t));
    if (!next) return DM_MEMORY;
    for (int pass = 0; pass < 2; pass++) { /* count, then place */
        for (int64_t k = 0; k < t; k++) {
            uint32_t at[4], first = UINT32_MAX;
            for (int c = 0; c < 3; c++) {
                uint32_t rank = b->rank[corners[3 * k + c]];
                at[c] = b->place[corners[3 * k + c]], first = rank < first ? rank : first;
            }
            at[3] = next[first];
            if (pass) memcpy(b->triangles[next[first]++], at, sizeof at);
            else next[first + 1]++;
        }
        for (int64_t i = 0; !pass && i < size; i++) next[i + 1] += next[i];
    }
    dm_free(next);
    b->triangle_count = t;
    return DM_OK;
}

static void dm_lay_fill(dm_state *b, const dm_body_def *d) {
    for (int64_t k = 0; k < 3 * d->fans; k++) b->fans[k / 3][k % 3] = b->place[d->fan[k]];
    for (int64_t k = 0; k < d->cap_edges; k++) {
        int64_t hole = d->cap_hole[k];
        b->caps[k][0] = b->place[d->cap_edge[2 * k]], b->caps[k][1] = b->place[d->cap_edge[2 * k + 1]];
        b->cap_hole[k] = (uint32_t)hole, b->holes[hole][6] += 1;
        b->hole_count = hole >= b->hole_count ? hole + 1 : b->hole_count;
    }
    b->fan_count = d->fans, b->cap_count = d->cap_edges, b->rest_volume = d->rest_volume;
}

static void dm_lay_springs(dm_state *b, const dm_body_def *d) {
    for (int64_t k = 0; k < 2 * d->springs; k++) b->ends[k / 2][k % 2] = b->place[d->ends[k]];
    memcpy(b->rest_length, d->rest_length, (size_t)d->springs * sizeof(double) * (d->springs > 0));
    for (int64_t k = 0; k < d->irregular; k++) {
        const uint8_t *end = d->irregular_end + 2 * k;
        b->irregular[k] = (dm_irregular_spring){.spring = d->irregular_spring[k], .on_i = end[0], .on_j = end[1]};
    }
    b->irregular_count = d->irregular, b->spring_count = d->springs;
}

static void dm_state_place(dm_state *b, const double *positions, const double *velocities) {
    int64_t n = b->n;
    for (int c = 0; c < 3; c++) {
        double way = dm_weighted_mean(b, positions + c * n) - b->middle[c];
        b->origin[c] = b->middle[c] + b->cell * nearbyint(way / b->cell);
    }
    /* the empty lanes too: a body that has diverged leaves NaN in them */
    memset(b->records, 0, (size_t)(b->groups * DM_LANES) * sizeof(dm_record));
    memset(b->state, 0, (size_t)b->groups * sizeof(dm_group_state));
    for (int64_t k = 0; k < n; k++) {
        double x[3], v[3] = {0};
        for (int c = 0; c < 3; c++) {
            x[c] = positions[c * n + k] - b->origin[c];
            if (velocities) v[c] = velocities[c * n + k];
        }
        dm_set_vertex(b, b->place[k], dm_quad_of(x), dm_quad_of(v));
    }
    for (int64_t k = 0; k < b->pinned_count; k++)
        for (int c = 0; c < 3; c++) b->pins[c * n + k] = positions[c * n + b->pinned[k]];
    for (int k = 0; k < 12; k++) b->pose[k] = k < 9 && k % 4 == 0;
    memcpy(b->turned, b->pose, sizeof b->turned);
    memset(b->pose_rate, 0, sizeof b->pose_rate);
    for (int k = 0; k < DM_MAX_FINGERTIPS; k++) dm_forget_impulses(b, k), dm_lift(b->fingers + k);
    b->led = b->carried = b->moving = 0, b->comes_back = 0;
    dm_change(b);
    b->pressure = 0;
    dm_place_pose(b);
}

static int32_t dm_state_create(dm_state **made, const dm_body_def *d) {
    dm_state *b = *made = dm_alloc(1, sizeof(dm_state));
    if (!b) return DM_MEMORY;
    int64_t n = b->n = d->vertices;
    b->groups = (n + DM_LANES - 1) / DM_LANES;
    int64_t slices = n / DM_SLICE < DM_MOST_SLICES ? n / DM_SLICE : DM_MOST_SLICES;
    b->slice = slices > 1 ? (b->groups + slices - 1) / slices : b->groups;
    b->slices = (b->groups + b->slice - 1) / b->slice;
    b->rest_area = d->rest_area, b->size = d->size;
    int32_t code = dm_allocate(b, d);
    if (code == DM_OK) {
        memcpy(b->rest, d->rest, (size_t)(3 * n) * sizeof(double));
        for (int64_t k = 0; k < n && d->loose; k++) b->loose[k] = d->loose[k] != 0;
        code = dm_lay_out(b, d->width, d->ring, d->ring_spring);
    }
    if (code == DM_OK) code = dm_lay_rings(b, d->width, d->ring, d->ring_spring);
    if (code == DM_OK) code = dm_lay_faces(b, d->triangles, d->corners);
    if (code == DM_OK) code = dm_lay_surface(b, d);
    if (code == DM_OK) {
        dm_lay_fill(b, d), dm_lay_springs(b, d);
        b->free = d->constants.free != 0;
        code = dm_state_set_constants(b, &d->constants);
    }
    if (code != DM_OK) return dm_state_destroy(b), *made = NULL, code;
    dm_state_place(b, d->rest, NULL);
    return DM_OK;
}

static void dm_state_read(const dm_state *b, double *positions, double *velocities) {
    int64_t n = b->n;
    for (int64_t k = 0; k < n; k++) {
        const dm_record *r = b->records + b->place[k];
        for (int c = 0; c < 3; c++) {
            if (positions) positions[c * n + k] = b->origin[c] + (double)r->x[c];
            if (velocities) velocities[c * n + k] = (double)r->v[c];
        }
    }
    for (int64_t k = 0; k < b->pinned_count && positions; k++)
        for (int c = 0; c < 3; c++) positions[c * n + b->pinned[k]] = b->pins[c * n + k];
}

static int64_t dm_state_pinned(const dm_state *b) { return b->pinned_count; }

static int dm_state_asleep(const dm_state *b) { return b->asleep; }
