/* The functions of dimple.h for scenes; part of api.c. */

struct dm_scene {
    dm_scene_state *state;
    const dm_methods *does;
    int64_t bodies, colliders, *collider_vertices;
    dm_body **body;
};

static int32_t dm_check_collider(const dm_collider_def *d) {
    if (d->vertices < 1 || d->vertices > DM_MAX_VERTICES) return DM_SIZE;
    DM_CHECK(DM_COUNT(d->triangles) | DM_ARRAY(d->vertices, d->positions) | DM_ARRAY(d->triangles, d->corners));
    DM_CHECK(dm_check_indices(3 * d->triangles, d->corners, 0, d->vertices));
    DM_CHECK(dm_check_numbers(3 * d->vertices, d->positions, 0) | dm_check_numbers(1, &d->friction, 1));
    DM_CHECK(dm_check_numbers(1, &d->mass, 1));
    if (!(d->mass > 0)) return DM_OK;
    DM_CHECK(DM_ARRAY(d->vertices, d->arms) | DM_ARRAY(d->vertices, d->seen));
    DM_CHECK(dm_check_numbers(3 * d->vertices, d->arms, 0) | dm_check_numbers(3 * d->vertices, d->seen, 0));
    return dm_check_numbers(9, d->inverse_inertia, 0) | dm_check_numbers(1, &d->damping, 1) | dm_check_numbers(1, &d->skin, 1);
}

int32_t dm_scene_create(dm_scene **scene, int64_t bodies, dm_body *const *body, const uint8_t *self,
                        const double *offset, int64_t colliders, const dm_collider_def *collider,
                        dm_crossings *left_out) {
    if (!scene) return DM_SIZE;
    *scene = NULL;
    if (bodies < 1 || colliders < 0 || bodies + colliders > DM_MAX_BODIES) return DM_SIZE;
    if (!body || !self || !offset || !left_out) return DM_SIZE;
    DM_CHECK(DM_ARRAY(colliders, collider));
    DM_CHECK(dm_check_numbers(bodies, offset, 1));
    int64_t total = 0;
    for (int64_t k = 0; k < bodies; k++) {
        if (!body[k]) return DM_SIZE;
        if (body[k]->does != body[0]->does) return DM_OPTION;
        total += body[k]->vertices;
    }
    for (int64_t k = 0; k < colliders; k++) {
        DM_CHECK(dm_check_collider(collider + k));
        total += collider[k].vertices;
    }
    if (total > DM_MAX_VERTICES) return DM_SIZE;
    dm_scene *made = calloc(1, sizeof *made);
    dm_state **states = calloc((size_t)bodies, sizeof *states);
    int32_t code = made && states ? DM_OK : DM_MEMORY;
    if (made) {
        made->body = calloc((size_t)bodies, sizeof *made->body);
        made->collider_vertices = calloc((size_t)colliders + 1, sizeof(int64_t));
        if (!made->body || !made->collider_vertices) code = DM_MEMORY;
    }
    if (code == DM_OK) {
        for (int64_t k = 0; k < bodies; k++) states[k] = body[k]->state, made->body[k] = body[k];
        for (int64_t k = 0; k < colliders; k++) made->collider_vertices[k] = collider[k].vertices;
        made->does = body[0]->does, made->bodies = bodies, made->colliders = colliders;
        code = made->does->scene_create(&made->state, bodies, states, self, offset, colliders, collider, left_out);
    }
    free(states);
    if (code != DM_OK) return dm_scene_destroy(made), code;
    *scene = made;
    return DM_OK;
}

void dm_scene_destroy(dm_scene *scene) {
    if (!scene) return;
    if (scene->state) scene->does->scene_destroy(scene->state);
    free(scene->body), free(scene->collider_vertices), free(scene);
}

int32_t dm_scene_find_crossings(dm_scene *scene, dm_crossings *found) {
    if (!scene || !found) return DM_SIZE;
    scene->does->scene_find(scene->state, found);
    return DM_OK;
}

int32_t dm_scene_set_collider(dm_scene *scene, int64_t collider, const double *positions) {
    if (!scene || !positions) return DM_SIZE;
    if (collider < 0 || collider >= scene->colliders) return DM_INDEX;
    DM_CHECK(dm_check_numbers(3 * scene->collider_vertices[collider], positions, 0));
    scene->does->scene_place(scene->state, collider, positions);
    return DM_OK;
}

int32_t dm_scene_get_collider(const dm_scene *scene, int64_t collider, double *positions) {
    if (!scene || !positions) return DM_SIZE;
    if (collider < 0 || collider >= scene->colliders) return DM_INDEX;
    scene->does->scene_read(scene->state, collider, positions);
    return DM_OK;
}

int32_t dm_scene_step(dm_scene *scene, const dm_motion *motions, const dm_collider_motion *colliders, double first,
                      double last, dm_frame *frames, dm_scene_frame *out, double *passed, double *given) {
    if (!scene || !motions || !frames || !out || !passed || !given || (scene->colliders && !colliders)) return DM_SIZE;
    for (int64_t k = 0; k < scene->bodies; k++) {
        const dm_motion *m = motions + k;
        if (m->ticks != motions->ticks || m->substeps != motions->substeps || m->tick != motions->tick) return DM_SIZE;
        DM_CHECK(dm_check_step(scene->body[k], m));
    }
    DM_CHECK(dm_check_numbers(1, &first, 1) | dm_check_numbers(1, &last, 1));
    for (int64_t k = 0; k < scene->colliders; k++) {
        int64_t count = 3 * scene->collider_vertices[k];
        const dm_prop *prop = colliders[k].prop;
        if (prop) DM_CHECK(dm_check_numbers(offsetof(dm_prop, ground) / sizeof(double), prop->centre, 0));
        if (prop && !(prop->ground < INFINITY)) return DM_NUMBER; /* nor NaN */
        if (!colliders[k].to) continue;
        if (!colliders[k].from) return DM_SIZE;
        DM_CHECK(dm_check_numbers(count, colliders[k].from, 0) | dm_check_numbers(count, colliders[k].to, 0));
    }
    uint64_t before = dm_flush_denormals();
    int32_t code = scene->does->scene_step(scene->state, motions, colliders, first, last, frames, out, passed, given);
    dm_keep_denormals(before);
    return code;
}
