/* What a body can do, in one precision and for one instruction set; each variant.c offers one such table.
 * Arguments are those of dimple.h, checked by api.c. */
#ifndef DM_METHODS_H
#define DM_METHODS_H
#include <stdint.h>

struct body;
typedef struct body *body_ref;

typedef struct {
    int32_t (*create)(body_ref *body, int64_t n, const double *rest, int64_t width, const int64_t *ring,
                      const int64_t *ring_spring);
    void (*destroy)(body_ref body);
    int32_t (*set_springs)(body_ref body, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                           const double *damping, int64_t l, const int64_t *loose, const uint8_t *ends);
    int32_t (*set_bend)(body_ref body, int64_t m, const int64_t *pairs, const double *rest, const double *stiffness,
                        const double *damping);
    int32_t (*set_faces)(body_ref body, int64_t t, const int64_t *triangles);
    int32_t (*set_fill)(body_ref body, int32_t fill, double rest_volume, int64_t c, const int64_t *corners, int64_t e,
                        const int64_t *cap_edges, const int64_t *cap_loop);
    int32_t (*set_matter)(body_ref body, const double *mass, const double *inverse_mass, const double *friction);
    int32_t (*set_memory)(body_ref body, const double *k1, const double *k2, const double *d0, const double *damping);
    int32_t (*set_world)(body_ref body, int32_t laws, double rest_area, const double *gravity, double ground);
    int32_t (*set_state)(body_ref body, const double *positions, const double *velocities, const double *pose,
                         const double *pace);
    int32_t (*set_contact)(body_ref body, double inner_force, int64_t count, const int64_t *vertices);
    int32_t (*step)(body_ref body, int64_t ticks, int64_t substeps, double tick, int64_t fingers, const double *centres,
                    const double *radii, double *impulses);
    int32_t (*read)(body_ref body, double *positions, double *velocities, double *pressure);
    int32_t (*read_contact)(body_ref body, int64_t *vertices, int64_t *count);
    void (*fit_rotation)(const double *h, double *r);
} methods;
#endif
