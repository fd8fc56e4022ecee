/* The functions of a body, in one precision and for one instruction set; each build of variant.c has one such table.
 * The arguments are those of dimple.h, checked by api.c. */
#ifndef DM_METHODS_H
#define DM_METHODS_H
#include "threads.h"

typedef struct dm_state dm_state; /* of one body; its fields depend on the precision */

typedef struct dm_scene_state dm_scene_state;

typedef struct {
    int32_t (*create)(dm_state **state, const dm_body_def *def);
    void (*destroy)(dm_state *state);
    int32_t (*set_constants)(dm_state *state, const dm_constants *constants);
    void (*set_rest)(dm_state *state, const double *rest, const double *surface, int64_t surface_vertices,
                     const double *rate, const double *gain);
    void (*wake)(dm_state *state);
    double (*rest_volume)(const dm_state *state);
    void (*set_state)(dm_state *state, const double *positions, const double *velocities);
    void (*get_state)(const dm_state *state, double *positions, double *velocities);
    int64_t (*pinned)(const dm_state *state);
    int (*asleep)(const dm_state *state);
    void (*step)(dm_state *state, const dm_motion *motion, dm_frame *frame);
    void (*get_law)(const dm_state *state, int64_t fingertip, const double *factors, double factors_end, int64_t count,
                    const double *depths, double *forces);
    void (*carry)(const dm_binding *binding, const float *motions, float *skin);
    int32_t (*scene_create)(dm_scene_state **scene, int64_t bodies, dm_state *const *body, const uint8_t *self,
                            const double *offset, int64_t colliders, const dm_collider_def *collider,
                            dm_crossings *left_out);
    void (*scene_destroy)(dm_scene_state *scene);
    void (*scene_find)(dm_scene_state *scene, dm_crossings *found);
    void (*scene_place)(dm_scene_state *scene, int64_t collider, const double *positions);
    void (*scene_read)(const dm_scene_state *scene, int64_t collider, double *positions);
    int32_t (*scene_step)(dm_scene_state *scene, const dm_motion *motions, const dm_collider_motion *colliders,
                          double first, double last, dm_frame *frames, dm_scene_frame *out, double *passed,
                          double *given);
} dm_methods;
#endif
