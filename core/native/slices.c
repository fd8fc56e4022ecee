/* Passes over the groups of a body, in slices that several threads share. */
#include "body.h"

static void dm_run_slice(void *of, int64_t k) {
    dm_state *b = of;
    int64_t from = k * b->slice, to = from + b->slice;
    b->pass(b, from, to < b->groups ? to : b->groups, b->sums[k]);
}

/* Run a pass over all groups of a body, slice by slice. */
static void dm_run_pass(dm_state *b, dm_pass *pass) {
    b->pass = pass;
    dm_share_out(b->slices, dm_run_slice, b);
}

/* Return a sum over the slices, in their order, so that the bits do not depend on the threads. */
static double dm_sum_of_slices(const dm_state *b, int which) {
    double sum = 0;
    for (int64_t k = 0; k < b->slices; k++) sum += b->sums[k][which];
    return sum;
}

static double dm_most_of_slices(const dm_state *b, int which) {
    double most = b->sums[0][which];
    for (int64_t k = 1; k < b->slices; k++) most = b->sums[k][which] > most ? b->sums[k][which] : most;
    return most;
}
