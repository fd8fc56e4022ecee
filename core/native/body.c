/* A body's life: made, given its laws, filled with a state, read. */
#include "body.h"

static void destroy(body *b) {
    void *all[] = {b->place, b->rank, b->rest, b->mass, b->records, b->state, b->matter, b->next, b->ring.start, b->ring.slots,
                   b->bend.start, b->bend.slots, b->ring_spring, b->loose, b->corners, b->caps, b->cap_hole, b->holes,
                   b->triangles, b->box_start, b->box_vertex, b->boxes, b->inverse_mass, b->friction, b->hits,
                   b->shares, b->moved, b->is_moved, b->touching};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) give_back(all[k]);
    for (int k = 0; k < DM_MAX_FINGERS; k++) give_back(b->touches[k].vertices), give_back(b->touches[k].faces);
    give_back(b);
}

static int32_t create(body **made, int64_t n, const double *rest, int64_t width, const int64_t *ring,
                      const int64_t *ring_spring) {
    body *b = *made = room(1, sizeof(body));
    if (!b) return DM_MEMORY;
    b->n = n, b->groups = (n + LANES - 1) / LANES;
    int64_t size = b->groups * LANES;
    int whole = (b->place = room(n, sizeof *b->place)) && (b->rest = room(3 * n, sizeof(double)));
    whole = whole && (b->rank = room(n, sizeof *b->rank)) && (b->mass = room(n, sizeof(double)));
    whole = whole && (b->records = room(size, sizeof(record))) && (b->state = room(b->groups, sizeof(group_state)));
    whole = whole && (b->matter = room(b->groups, sizeof(group_matter)));
    whole = whole && (b->next = room(b->groups, sizeof(group_next)));
    whole = whole && (b->inverse_mass = room(size, sizeof(real))) && (b->friction = room(size, sizeof(real)));
    whole = whole && (b->shares = room(size, sizeof(uint32_t))) && (b->moved = room(size, sizeof(uint32_t)));
    whole = whole && (b->is_moved = room(size, 1)) && (b->touching = room(size, 1));
    for (int k = 0; k < DM_MAX_FINGERS; k++) whole = whole && (b->touches[k].vertices = room(size, sizeof(uint32_t)));
    int32_t code = DM_MEMORY;
    if (whole) {
        memcpy(b->rest, rest, (size_t)(3 * n) * sizeof(double));
        code = lay_out(b, width, ring, ring_spring);
        if (code == DM_OK) code = lay_rings(b, width, ring, ring_spring);
    }
    if (code != DM_OK) destroy(b), *made = NULL;
    return code;
}

static int32_t set_springs(body *b, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                           const double *damping, int64_t l, const int64_t *loose, const uint8_t *ends) {
    int64_t slots = b->ring.start[b->groups];
    for (int64_t k = 0; k < slots * LANES; k++)
        if (b->ring_spring[k] >= m) return DM_INDEX;
    loose_spring *list = room(l, sizeof(loose_spring));
    if (!list) return DM_MEMORY;
    for (int64_t k = 0; k < slots * LANES; k++) {
        int32_t e = b->ring_spring[k];
        slot *s = b->ring.slots + k / LANES;
        s->stiffness[k % LANES] = e < 0 ? 0 : (real)stiffness[e];
        s->pull[k % LANES] = e < 0 ? 0 : (real)(stiffness[e] * rest[e]);
        s->damping[k % LANES] = e < 0 ? 0 : (real)damping[e];
    }
    for (int64_t k = 0; k < l; k++) {
        int64_t e = loose[k];
        list[k] = (loose_spring){(int32_t)b->place[pairs[2 * e]], (int32_t)b->place[pairs[2 * e + 1]],
                                 ends[2 * k], ends[2 * k + 1], rest[e], stiffness[e], damping[e]};
    }
    give_back(b->loose);
    b->loose = list, b->loose_count = l, b->ready |= HAS_SPRINGS;
    return DM_OK;
}

/* Order the triangles along the curve in space, and box them in runs. */
static int32_t set_faces(body *b, int64_t t, const int64_t *triangles) {
    void *old[] = {b->triangles, b->box_start, b->box_vertex, b->boxes, b->hits};
    for (size_t k = 0; k < sizeof old / sizeof *old; k++) give_back(old[k]);
    for (int k = 0; k < DM_MAX_FINGERS; k++) give_back(b->touches[k].faces), b->touches[k].faces = NULL;
    b->ready &= ~(uint32_t)HAS_FACES, b->triangle_count = 0, b->box_count = (t + BLOCK - 1) / BLOCK;
    b->triangles = room(t, sizeof *b->triangles), b->hits = room(t, sizeof(hit));
    b->box_start = room(b->box_count + 1, sizeof(uint32_t)), b->box_vertex = room(3 * t, sizeof(uint32_t));
    b->boxes = room(b->box_count, sizeof *b->boxes);
    int whole = b->triangles && b->hits && b->box_start && b->box_vertex && b->boxes;
    for (int k = 0; k < DM_MAX_FINGERS; k++)
        whole = whole && (b->touches[k].faces = room(t + LANES, sizeof *b->touches[k].faces));
    int64_t size = b->groups * LANES;
    uint32_t *seen = room(size, sizeof(uint32_t)), *next = room(size + 1, sizeof(uint32_t));
    if (!whole || !seen || !next) return give_back(seen), give_back(next), DM_MEMORY;
    for (int pass = 0; pass < 2; pass++) { /* count, then place */
        for (int64_t k = 0; k < t; k++) {
            uint32_t at[3], first = UINT32_MAX;
            for (int c = 0; c < 3; c++) {
                uint32_t rank = b->rank[triangles[3 * k + c]];
                at[c] = b->place[triangles[3 * k + c]], first = rank < first ? rank : first;
            }
            if (pass) memcpy(b->triangles[next[first]++], at, sizeof at);
            else next[first + 1]++;
        }
        for (int64_t i = 0; !pass && i < size; i++) next[i + 1] += next[i];
    }
    uint32_t count = 0;
    for (int64_t k = 0; k < 3 * t; k++) {
        uint32_t i = b->triangles[k / 3][k % 3], box = (uint32_t)(k / 3 / BLOCK) + 1;
        if (seen[i] != box) seen[i] = box, b->box_vertex[count++] = i;
        b->box_start[box] = count;
    }
    give_back(seen), give_back(next);
    b->triangle_count = t, b->ready |= HAS_FACES;
    return DM_OK;
}

static int32_t set_fill(body *b, int32_t fill, double rest_volume, int64_t c, const int64_t *corners, int64_t e,
                        const int64_t *cap_edges, const int64_t *cap_loop) {
    give_back(b->corners), give_back(b->caps), give_back(b->cap_hole), give_back(b->holes);
    b->ready &= ~(uint32_t)HAS_FILL, b->corner_count = b->cap_count = b->hole_count = 0;
    b->corners = room(c, sizeof *b->corners), b->caps = room(e, sizeof *b->caps);
    b->cap_hole = room(e, sizeof(uint32_t)), b->holes = room(e, sizeof *b->holes);
    if (!b->corners || !b->caps || !b->cap_hole || !b->holes) return DM_MEMORY;
    for (int64_t k = 0; k < 3 * c; k++) b->corners[k / 3][k % 3] = b->place[corners[k]];
    for (int64_t k = 0; k < e; k++) {
        b->caps[k][0] = b->place[cap_edges[2 * k]], b->caps[k][1] = b->place[cap_edges[2 * k + 1]];
        b->cap_hole[k] = (uint32_t)cap_loop[k], b->holes[cap_loop[k]][6] += 1;
        b->hole_count = cap_loop[k] >= b->hole_count ? cap_loop[k] + 1 : b->hole_count;
    }
    b->fill = fill, b->rest_volume = rest_volume, b->corner_count = c, b->cap_count = e, b->ready |= HAS_FILL;
    return DM_OK;
}

static double weighted_mean(const body *b, const double *a) {
    double sum = 0;
    for (int64_t k = 0; k < b->n; k++) sum += b->mass[k] * a[k];
    return sum / b->mass_total;
}

static int32_t set_matter(body *b, const double *mass, const double *inverse_mass, const double *friction) {
    b->mass_total = 0;
    for (int64_t k = 0; k < b->n; k++) {
        uint32_t i = b->place[k];
        b->mass[k] = mass[k], b->mass_total += mass[k];
        *lane(&b->matter[i / LANES].mass, i) = (real)mass[k];
        *lane(&b->matter[i / LANES].inverse_mass, i) = b->inverse_mass[i] = (real)inverse_mass[k];
        b->friction[i] = (real)friction[k];
    }
    double spread = 0;
    for (int c = 0; c < 3; c++) {
        const double *x = b->rest + c * b->n;
        b->middle[c] = weighted_mean(b, x);
        for (int64_t k = 0; k < b->n; k++) spread += mass[k] * (x[k] - b->middle[c]) * (x[k] - b->middle[c]);
    }
    b->cell = spread > 0 ? exp2(ceil(log2(4 * sqrt(spread / b->mass_total)))) : 1;
    b->ready |= HAS_MATTER;
    return DM_OK;
}

static int32_t set_memory(body *b, const double *k1, const double *k2, const double *d0, const double *damping) {
    double sum[4] = {0};
    for (int64_t k = 0; k < b->n; k++) {
        for (int c = 0; c < 3; c++) sum[c] += k1[k] * b->rest[c * b->n + k];
        sum[3] += k1[k];
    }
    b->k1_total = sum[3] > 0 ? sum[3] : 1;
    for (int c = 0; c < 3; c++) b->rest_centre[c] = sum[c] / b->k1_total;
    for (int64_t k = 0; k < b->n; k++) {
        uint32_t i = b->place[k];
        group_matter *m = b->matter + i / LANES;
        *lane(&m->k1, i) = (real)k1[k], *lane(&m->k_more, i) = (real)(k2[k] - k1[k]);
        *lane(&m->d0, i) = (real)d0[k], *lane(&m->damping, i) = (real)damping[k];
        *lane(&m->rest.x, i) = (real)(b->rest[k] - b->rest_centre[0]);
        *lane(&m->rest.y, i) = (real)(b->rest[b->n + k] - b->rest_centre[1]);
        *lane(&m->rest.z, i) = (real)(b->rest[2 * b->n + k] - b->rest_centre[2]);
    }
    b->ready |= HAS_MEMORY;
    return DM_OK;
}

static int32_t set_world(body *b, int32_t laws, double rest_area, const double *gravity, double ground) {
    b->laws = laws, b->rest_area = rest_area, b->ground = ground;
    memcpy(b->gravity, gravity, sizeof b->gravity);
    b->ready |= HAS_WORLD;
    return DM_OK;
}

/* Positions are kept from an origin near the body, so that single precision does not depend on where it is. It
 * follows in steps of at least the body's size, a power of two, so that it hardly ever changes. */
static void choose_origin(body *b, const double *positions) {
    for (int c = 0; c < 3; c++) {
        double way = weighted_mean(b, positions + c * b->n) - b->middle[c];
        b->origin[c] = b->middle[c] + b->cell * nearbyint(way / b->cell);
    }
}

static int32_t set_state(body *b, const double *positions, const double *velocities, const double *pose,
                         const double *pace) {
    static const double upright[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if ((b->ready | HAS_STATE) != HAS_ALL) return DM_ORDER;
    choose_origin(b, positions);
    for (int64_t k = 0; k < b->n; k++) {
        uint32_t i = b->place[k];
        record *r = b->records + i;
        for (int c = 0; c < 3; c++) {
            r->x[c] = (real)(positions[c * b->n + k] - b->origin[c]), r->v[c] = (real)velocities[c * b->n + k];
            *lane(&b->state[i / LANES].x.x + c, i) = r->x[c], *lane(&b->state[i / LANES].v.x + c, i) = r->v[c];
        }
    }
    memcpy(b->turned, upright, sizeof upright);
    memcpy(b->rotation, pose ? pose : upright, sizeof upright);
    for (int c = 0; pose && c < 3; c++) {
        const double *row = pose + 3 * c, *q = b->rest_centre;
        b->translation[c] = pose[9 + c] + row[0] * q[0] + row[1] * q[1] + row[2] * q[2] - b->origin[c];
    }
    b->fitted = !pose, b->carried = pose && pace, b->ready |= HAS_STATE;
    if (b->carried) memcpy(b->pace, pace, sizeof b->pace);
    for (int c = 0; b->carried && c < 3; c++) {
        const double *row = pace + 3 * c, *q = b->rest_centre;
        b->pace[9 + c] += row[0] * q[0] + row[1] * q[1] + row[2] * q[2];
    }
    return DM_OK;
}

static int32_t set_contact(body *b, double inner_force, int64_t count, const int64_t *vertices) {
    memset(b->touching, 0, (size_t)(b->groups * LANES));
    for (int64_t k = 0; k < count; k++) b->touching[b->place[vertices[k]]] = 1;
    b->inner_force = inner_force;
    return DM_OK;
}

/* What is held without a velocity has not moved: the caller's own digits stay. */
static int32_t read_state(body *b, double *positions, double *velocities, double *pressure) {
    if (b->ready != HAS_ALL) return DM_ORDER;
    for (int64_t k = 0; k < b->n; k++) {
        const record *r = b->records + b->place[k];
        if (!(b->inverse_mass[b->place[k]] > 0) && dot3(r->v, r->v) == 0) continue;
        for (int c = 0; c < 3; c++) {
            if (positions) positions[c * b->n + k] = b->origin[c] + (double)r->x[c];
            if (velocities) velocities[c * b->n + k] = (double)r->v[c];
        }
    }
    if (pressure) *pressure = b->pressure;
    return DM_OK;
}

static int32_t read_contact(body *b, int64_t *vertices, int64_t *count) {
    *count = 0;
    for (int64_t k = 0; k < b->n; k++)
        if (b->touching[b->place[k]]) vertices[(*count)++] = k;
    return DM_OK;
}
