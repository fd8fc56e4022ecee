/* Rigid bodies that fall, and their supports. Source: studies/reference/falling.py. */
#include "falling.h"

static void dm_times(const double *a, const double *x, double *r) {
    for (int c = 0; c < 3; c++) r[c] = dm_inner3(a + 3 * c, x);
}

static double dm_length3(const double *a) { return sqrt(dm_inner3(a, a)); }

/* Apply an impulse at an arm from a prop's centre, and an angular impulse in addition, times `by`. */
static void dm_push_prop(dm_falling *f, double by, const double *impulse, const double *arm, const double *moment) {
    double about[3], turn[3];
    dm_cross3(arm, impulse, about);
    dm_add3(about, 1, moment), dm_times(f->turned, about, turn);
    dm_add3(f->now.velocity, by / f->mass, impulse), dm_add3(f->now.momentum, by, about), dm_add3(f->spin, by, turn);
}

/* Begin a substep: apply gravity, and the reaction of soft bodies in the last one. */
void dm_let_fall(dm_falling *f, double h) {
    double back[9], by[9], damped = 0, *v = f->now.velocity, *l = f->now.momentum;
    for (int c = 0; c < 6; c++) damped += f->answer[c] * f->answer[c], f->apart[c] = 0;
    double left = damped > 0 ? 1 / (1 + h * f->damping / f->mass) : 1;
    for (int c = 0; c < 3; c++) {
        v[c] = left * v[c] + h * f->now.gravity[c] + f->answer[c] / f->mass;
        l[c] = left * l[c] + f->answer[3 + c];
    }
    dm_transpose3x3(f->now.turn, back);
    dm_multiply3x3(f->inverse, back, by), dm_multiply3x3(f->now.turn, by, f->turned);
    dm_times(f->turned, l, f->spin);
}

void dm_answer_prop(dm_falling *f, const double *point, const double *impulse, double sign) {
    double arm[3], moment[3];
    for (int c = 0; c < 3; c++) arm[c] = point[c] - f->now.centre[c];
    dm_cross3(arm, impulse, moment);
    dm_add3(f->answer, sign, impulse), dm_add3(f->answer + 3, sign, moment);
}

double dm_speed_of_prop(const dm_falling *f) { return dm_length3(f->now.velocity) + dm_length3(f->spin) * f->radius; }

/* List the corners of a prop that may touch the ground in a substep; return their number. */
int dm_find_ground(dm_falling *f, dm_support *to, double h) {
    static const double to_side[DM_SIDES][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    double ground = f->now.ground, near = DM_HELD * f->radius + h * dm_speed_of_prop(f), lowest = INFINITY;
    const double *turn = f->now.turn, *centre = f->now.centre;
    if (!(centre[2] - f->radius < ground + near)) return 0;
    int64_t corner[DM_CORNERS] = {0};
    double most[DM_CORNERS];
    int count = 0;
    for (int64_t k = 0; k < f->count; k++) {
        double height = dm_inner3(turn + 6, f->seen[k]);
        if (height < lowest) lowest = height, corner[0] = k;
    }
    if (!(lowest + centre[2] < ground + near)) return 0;
    for (int d = 1; d < DM_CORNERS; d++) most[d] = -INFINITY;
    for (int64_t k = 0; k < f->count; k++) {
        if (!(dm_inner3(turn + 6, f->seen[k]) < lowest + near)) continue;
        double x = dm_inner3(turn, f->seen[k]), y = dm_inner3(turn + 3, f->seen[k]);
        for (int d = 1; d < DM_CORNERS; d++) {
            double out = x * to_side[d - 1][0] + y * to_side[d - 1][1];
            if (out > most[d]) most[d] = out, corner[d] = k;
        }
    }
    for (int d = 0; d < DM_CORNERS; d++) {
        int known = 0;
        for (int e = 0; e < d; e++) known |= corner[e] == corner[d];
        if (known) continue;
        double ends[2][3];
        dm_support *c = to + count++;
        memset(c, 0, sizeof *c);
        c->of[0] = f, c->normal[2] = c->share = 1;
        dm_times(turn, f->seen[corner[d]], ends[0]), dm_add3(ends[0], 1, centre);
        memcpy(ends[1], ends[0], sizeof *ends), ends[1][2] = ground;
        dm_begin_support(c, (const double(*)[3])ends, h);
    }
    return count;
}

/* Return 1 / effective mass of a contact along a direction [1/kg]. */
static double dm_give_along(const dm_support *c, const double *way) {
    double give = 0, about[3], turn[3];
    for (int j = 0; j < 2; j++) {
        if (!c->of[j]) continue;
        dm_cross3(c->arms[j], way, about), dm_times(c->of[j]->turned, about, turn);
        give += 1 / c->of[j]->mass + dm_inner3(about, turn);
    }
    return give;
}

void dm_begin_support(dm_support *c, const double (*ends)[3], double h) {
    double way[3], skin = c->of[0] ? c->of[0]->skin : 0, whole = skin + (c->of[1] ? c->of[1]->skin : 0), all = 0;
    for (int k = 0; k < 3; k++) {
        way[k] = ends[0][k] - ends[1][k];
        c->point[k] = ends[0][k] - (whole > 0 ? skin / whole : 0) * way[k]; /* between the visible surfaces */
    }
    for (int j = 0; j < 2; j++)
        for (int k = 0; k < 3 && c->of[j]; k++) c->arms[j][k] = c->point[k] - c->of[j]->now.centre[k];
    c->begin = dm_inner3(way, c->normal), dm_add3(way, -c->begin, c->normal);
    c->least = c->begin > c->touch ? -(c->begin - c->touch) / h : 0;
    c->give[0] = dm_give_along(c, c->normal);
    for (int k = 0; k < 3; k++) all += dm_give_along(c, (double[]){k == 0, k == 1, k == 2});
    c->give[1] = all - c->give[0];
    for (int k = 0; k < 3; k++) c->back[k] = DM_BACK / h * (way[k] - c->anchor[k]);
}

/* Find the relative velocity of the two sides at a contact. */
static void dm_find_slip(const dm_support *c, double *u) {
    double turn[3];
    memcpy(u, c->led, sizeof c->led);
    for (int j = 0; j < 2; j++) {
        if (!c->of[j]) continue;
        dm_cross3(c->of[j]->spin, c->arms[j], turn);
        dm_add3(u, j ? -1 : 1, c->of[j]->now.velocity), dm_add3(u, j ? -1 : 1, turn);
    }
}

static void dm_pass_on(const dm_support *c, const double *impulse, const double *moment) {
    for (int j = 0; j < 2; j++)
        if (c->of[j]) dm_push_prop(c->of[j], j ? -1 : 1, impulse, c->arms[j], moment);
}

/* Change the impulse of a contact so that its sides come no nearer than allowed, and slide no more than friction
 * allows; return the size of the change. */
static double dm_resolve_support(dm_support *c) {
    static const double none[3] = {0};
    double u[3], more[3] = {0}, soft = c->give[0] * (1 / c->share - 1), before = c->push;
    dm_find_slip(c, u);
    double push = before + c->share / c->give[0] * (c->least - dm_inner3(u, c->normal) - soft * before);
    c->push = push > 0 ? push : 0;
    dm_add3(more, c->push - before, c->normal);
    dm_pass_on(c, more, none);
    double changed = fabs(c->push - before);
    dm_find_slip(c, u), dm_add3(u, -dm_inner3(u, c->normal), c->normal), dm_add3(u, 1, c->back);
    memcpy(more, c->drag, sizeof more);
    dm_add3(c->drag, -1 / c->give[1], u);
    double size = dm_length3(c->drag), most = c->friction * c->push;
    for (int k = 0; k < 3; k++) {
        if (size > most) c->drag[k] *= most / size;
        more[k] = c->drag[k] - more[k];
    }
    dm_pass_on(c, more, none);
    return changed + dm_length3(more);
}

/* Apply rolling resistance: the two sides turn against each other only by a moment above a small arm times the load. */
static void dm_resist_turning(const dm_support *c) {
    static const double none[3] = {0};
    double spin[3] = {0}, turn[3], size = 0, give = 0;
    for (int j = 0; j < 2; j++)
        if (c->of[j]) dm_add3(spin, j ? -1 : 1, c->of[j]->spin), size = fmax(size, 2 * c->of[j]->radius);
    double square = dm_inner3(spin, spin);
    if (!(square > 0) || !(c->push > 0)) return;
    for (int j = 0; j < 2; j++)
        if (c->of[j]) dm_times(c->of[j]->turned, spin, turn), give += dm_inner3(turn, spin);
    double by = fmin(square / give, DM_ROLL_ARM * size * c->push / sqrt(square));
    for (int k = 0; k < 3; k++) turn[k] = -by * spin[k];
    dm_pass_on(c, none, turn);
}

/* Separate the sides of a contact if they would be nearer than they touch; let the anchor follow if they slide. */
static void dm_part_support(dm_support *c, double h) {
    double u[3], turn[3], about[3];
    dm_find_slip(c, u);
    double gap = c->begin + h * dm_inner3(u, c->normal);
    for (int j = 0; j < 2; j++) {
        if (!c->of[j]) continue;
        dm_cross3(c->of[j]->apart + 3, c->arms[j], turn), dm_add3(turn, 1, c->of[j]->apart);
        gap += (j ? -1 : 1) * dm_inner3(turn, c->normal);
    }
    double by = c->push > 0 && gap < c->touch ? c->share * DM_BACK * (c->touch - gap) / c->give[0] : 0;
    for (int j = 0; j < 2 && by > 0; j++) {
        if (!c->of[j]) continue;
        dm_cross3(c->arms[j], c->normal, about), dm_times(c->of[j]->turned, about, turn);
        dm_add3(c->of[j]->apart, (j ? -by : by) / c->of[j]->mass, c->normal), dm_add3(c->of[j]->apart + 3, j ? -by : by, turn);
    }
    if (!(c->push > 0) || dm_length3(c->drag) >= c->friction * c->push * (1 - DM_ROUNDING))
        dm_add3(c->anchor, h / DM_BACK, c->back);
}

void dm_resolve_supports(dm_support *c, uint32_t count, double h) {
    static const double none[3] = {0};
    for (uint32_t k = 0; k < count; k++) { /* start from the impulses of the last substep: they are nearly right */
        double j[3] = {c[k].drag[0], c[k].drag[1], c[k].drag[2]};
        dm_add3(j, c[k].push, c[k].normal);
        if (c[k].push > 0) dm_pass_on(c + k, j, none);
    }
    for (int sweep = 0; sweep < DM_SWEEPS; sweep++) {
        double changed = 0, whole = 0;
        for (uint32_t k = 0; k < count; k++)
            if (dm_is_awake(c + k)) changed += dm_resolve_support(c + k), whole += c[k].push;
        if (!(changed > DM_EXACT * whole)) break; /* at DM_ROUNDING a pile of four sinks by 1 mm */
    }
    for (uint32_t k = 0; k < count; k++) dm_resist_turning(c + k);
    for (uint32_t k = 0; k < count; k++)
        if (dm_is_awake(c + k)) dm_part_support(c + k, h);
}

void dm_find_pose(const dm_falling *f, double h, double share, double *pose) {
    double turn[3], by[9], *to = pose + 3;
    for (int c = 0; c < 3; c++) {
        pose[c] = f->now.centre[c] + share * (h * f->now.velocity[c] + f->apart[c]);
        turn[c] = share * (h * f->spin[c] + f->apart[3 + c]);
    }
    /* Rodrigues' formula */
    double angle = dm_length3(turn), sine = angle < 1e-8 ? 1 : sin(angle) / angle;
    double versed = angle < 1e-8 ? 0.5 : (1 - cos(angle)) / (angle * angle);
    const double cross[9] = {0, -turn[2], turn[1], turn[2], 0, -turn[0], -turn[1], turn[0], 0};
    dm_multiply3x3(cross, cross, by);
    for (int k = 0; k < 9; k++) by[k] = (k % 4 == 0) + sine * cross[k] + versed * by[k];
    dm_multiply3x3(by, f->now.turn, to);
    if (!(f->now.ground > -INFINITY) || share < 1) return;
    double lowest = INFINITY;
    if (pose[2] - f->radius < f->now.ground)
        for (int64_t k = 0; k < f->count; k++) lowest = fmin(lowest, dm_inner3(to + 6, f->seen[k]));
    pose[2] = fmax(pose[2], lowest < INFINITY ? f->now.ground - lowest : pose[2]);
}

void dm_find_places(const dm_falling *f, const double *pose, double (*x)[3]) {
    for (int64_t k = 0; k < f->count; k++) dm_times(pose + 3, f->arms[k], x[k]), dm_add3(x[k], 1, pose);
}

/* After a tick: note whether a prop has been slow, and in place, for DM_REST_TIME. */
void dm_watch_prop(dm_falling *f, double tick) {
    double pose[12], way[3], size = 2 * f->radius, turn = 0;
    f->rested = 0;
    if (dm_speed_of_prop(f) > DM_REST_SPEED * size) {
        f->quiet = 0;
        return;
    }
    memcpy(pose, f->now.centre, 3 * sizeof(double)), memcpy(pose + 3, f->now.turn, 9 * sizeof(double));
    if (f->quiet == 0) memcpy(f->still, pose, sizeof pose);
    f->quiet += tick;
    if (f->quiet < DM_REST_TIME) return;
    for (int k = 0; k < 9; k++) turn += (pose[3 + k] - f->still[3 + k]) * (pose[3 + k] - f->still[3 + k]);
    for (int c = 0; c < 3; c++) way[c] = pose[c] - f->still[c];
    f->quiet = 0, f->rested = dm_length3(way) + sqrt(turn) * f->radius <= DM_ROUNDING * size;
}
