/* What the render tests begin with and end: a context and a scene. */
#ifndef RENDER_STAGE_H
#define RENDER_STAGE_H

#include "render_scenes.h"

static rt_context *ctx;
static rt_scene *scene;
static rt_scene *child; /* of those tests that make one */

/* The scene is empty. */
static inline int stage(uint32_t workers)
{
    ctx = make_context(workers);
    OK(rt_scene_create(ctx, &scene));
    return 0;
}

/* For cmocka: two workers and a room with everything in it, committed. */
static inline int setup_room(void **state)
{
    (void)state;
    stage(2);
    add_everything(scene);
    OK(rt_scene_commit(scene, NULL));
    return 0;
}

/* For cmocka: one worker, and a world that gives no light. */
static inline int setup_dark(void **state)
{
    (void)state;
    stage(1);
    set_world(scene, v3(0, 0, 0), v3(0, 0, 0));
    return 0;
}

static inline int teardown(void **state)
{
    (void)state;
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
    child = NULL;
    return 0;
}

#define IN_ROOM(name) cmocka_unit_test_setup_teardown(name, setup_room, teardown)
#define IN_DARK(name) cmocka_unit_test_setup_teardown(name, setup_dark, teardown)

static inline void hash_of(const rt_render_desc *d, char text[33])
{
    rt_image *image = render(scene, d);
    rt_image_hash(image, text);
    rt_image_destroy(image);
}

static inline rt_image *commit_and_render(const rt_render_desc *d)
{
    OK(rt_scene_commit(scene, NULL));
    return render(scene, d);
}

static inline void floor_from_above(rt_material m)
{
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), m);
    look_parallel(scene, v3(0, 5, 0), v3(0, 0, 0), v3(0, 0, -1), 4);
}

/* The background's gradient tells the direction: what a ray shows is 0.5 + 0.5 dir.y. */
static inline void sky_compass(void)
{
    set_world(scene, v3(0, 0, 0), v3(1, 1, 1));
}

#endif
