/* A face near a fingertip: its nearest point, its inward normal and the sphere that it meets.
 * Source: studies/reference/facets.py. */
#include "body.h"

DM_INLINE dm_vec3 dm_corners_at(const dm_state *b, const uint32_t (*face)[4], int corner, dm_vec3 centre) {
    uint32_t at[DM_LANES];
    dm_vec3 x, v;
    for (int l = 0; l < DM_LANES; l++) at[l] = face[l][corner] * (uint32_t)sizeof(dm_record);
    dm_gather8(b->records, at, &x, &v);
    return dm_sub(x, centre);
}

/* Return the barycentric weights of the points of eight triangles nearest to the origin, by Voronoi regions.
 * Source: Ericson, Real-Time Collision Detection, 5.1.5. */
DM_INLINE dm_vec3 dm_nearest_weights(dm_vec3 a, dm_vec3 b, dm_vec3 c) {
    dm_vec3 ab = dm_sub(b, a), ac = dm_sub(c, a);
    dm_lanes d1 = -dm_dot(ab, a), d2 = -dm_dot(ac, a), d3 = -dm_dot(ab, b), d4 = -dm_dot(ac, b);
    dm_lanes d5 = -dm_dot(ab, c), d6 = -dm_dot(ac, c);
    dm_lanes va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    dm_lanes none = dm_splat(0), one = dm_splat(1);
    /* weights v / whole, w / whole; earlier regions take precedence, so they are written last */
    dm_lanes v = vb, w = vc, whole = va + vb + vc;
    dm_mask in_bc = (dm_mask)(va <= none) & (dm_mask)(d4 >= d3) & (dm_mask)(d5 >= d6);
    w = dm_blend(in_bc, d4 - d3, w), whole = dm_blend(in_bc, (d4 - d3) + (d5 - d6), whole);
    dm_mask in_ac = (dm_mask)(vb <= none) & (dm_mask)(d2 >= none) & (dm_mask)(d6 <= none);
    v = dm_blend(in_ac, none, v), w = dm_blend(in_ac, d2, w), whole = dm_blend(in_ac, d2 - d6, whole);
    dm_mask in_ab = (dm_mask)(vc <= none) & (dm_mask)(d1 >= none) & (dm_mask)(d3 <= none);
    v = dm_blend(in_ab, d1, v), w = dm_blend(in_ab, none, w), whole = dm_blend(in_ab, d1 - d3, whole);
    dm_mask in_c = (dm_mask)(d6 >= none) & (dm_mask)(d5 <= d6), in_b = (dm_mask)(d3 >= none) & (dm_mask)(d4 <= d3);
    dm_mask in_a = (dm_mask)(d1 <= none) & (dm_mask)(d2 <= none), at_corner = in_a | in_b | in_c;
    v = dm_blend(in_c, none, v), w = dm_blend(in_c, one, w);
    v = dm_blend(in_b, one, v), w = dm_blend(in_b, none, w);
    v = dm_blend(in_a, none, v), w = dm_blend(in_a, none, w);
    dm_mask some = ((dm_mask)(whole > dm_splat(DM_LEAST)) | (dm_mask)(whole < dm_splat(-DM_LEAST))) & ~at_corner;
    whole = dm_blend(some, whole, one);
    v /= whole, w /= whole;
    v = dm_blend(in_bc & ~(in_ac | in_ab | at_corner), one - w, v);
    return (dm_vec3){one - v - w, v, w};
}

/* Return the inward unit normal of a face, since a fingertip comes from outside. */
DM_INLINE dm_quad dm_inward_normal(const dm_state *b, const uint32_t *corner) {
    dm_quad a = b->before[corner[0]], p = b->before[corner[2]] - a, q = b->before[corner[1]] - a;
    dm_quad normal = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0], 0};
    dm_real size = DM_SQRT(dm_dot3(normal, normal));
    return normal / (size > DM_LEAST ? size : DM_LEAST);
}

/* Return the points of eight triangles with these weights. */
DM_INLINE dm_vec3 dm_point_on(dm_vec3 p, dm_vec3 q, dm_vec3 r, dm_vec3 w) {
    return (dm_vec3){
        w.x * p.x + w.y * q.x + w.z * r.x, w.x * p.y + w.y * q.y + w.z * r.y, w.x * p.z + w.y * q.z + w.z * r.z,
    };
}

/* Return the points of eight triangles nearest to the origin, and their weights. */
static __attribute__((noinline)) dm_vec3 dm_nearest_points(dm_vec3 p, dm_vec3 q, dm_vec3 r, dm_vec3 *weight) {
    *weight = dm_nearest_weights(p, q, r);
    return dm_point_on(p, q, r, *weight);
}

/* Return the radius of the sphere that a facet meets: smaller than the fingertip's, unless the facet is too large to
 * bend round the fingertip. */
static dm_real dm_met_radius(const dm_state *b, const uint32_t *at, dm_real radius) {
    dm_real bulge = 0;
    for (int j = 0; j < 3; j++) {
        const dm_vec3 *p = &b->matter[at[j] / DM_LANES].rest, *q = &b->matter[at[(j + 1) % 3] / DM_LANES].rest;
        uint32_t k = at[j] % DM_LANES, m = at[(j + 1) % 3] % DM_LANES;
        dm_real x = p->x[k] - q->x[m], y = p->y[k] - q->y[m], z = p->z[k] - q->z[m];
        bulge += (x * x + y * y + z * z) / (18 * radius);
    }
    dm_real left = (dm_real)DM_TRAVEL * radius - bulge, sunk = (dm_real)DM_SUNK * radius;
    return radius - (sunk < left ? sunk : left > 0 ? left : 0);
}
