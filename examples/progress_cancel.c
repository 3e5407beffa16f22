/* A render as a job: starts it, shows every finished tile as it comes, cancels a second one half-way, and prints what each worker
 * did. usage: progress_cancel [WIDTHxHEIGHT [FILE]] */
#include "arguments.h"

/* Balls of falling size, one on another. */
static void describe(rt_scene *scene)
{
    float height = 0;
    for (int i = 0; i < 6; ++i) {
        rt_sphere_desc ball = rt_sphere_desc_default();
        rt_material_desc material = rt_material_desc_default();
        material.color = (rt_vec3){0.9f, 0.25f + 0.12f * (float)i, 0.2f + 0.05f * (float)i};
        material.reflectiveness = 0.15f;
        material.diffusion = 0.85f;
        must(rt_scene_context(scene), rt_scene_add_material(scene, &material, &ball.common.material));
        ball.radius = 1.2f / (1 + 0.5f * (float)i);
        ball.center = (rt_vec3){0, height + ball.radius, 0};
        height += 2 * ball.radius;
        must(rt_scene_context(scene), rt_scene_add_sphere(scene, &ball, NULL));
    }
    rt_plane_desc floor = rt_plane_desc_default();
    floor.normal = (rt_vec3){0, 1, 0};
    must(rt_scene_context(scene), rt_scene_add_plane(scene, &floor, NULL));
    rt_light_desc sun = rt_light_desc_default();
    sun.type = RT_LIGHT_DIRECTIONAL;
    sun.direction = (rt_vec3){1, -2, -1.5f};
    must(rt_scene_context(scene), rt_scene_add_light(scene, &sun, NULL));
    rt_world_desc world = rt_world_desc_default();
    world.ambient = (rt_vec3){0.25f, 0.28f, 0.35f};
    world.background = (rt_vec3){0.8f, 0.86f, 0.92f};
    world.background_top = (rt_vec3){0.3f, 0.45f, 0.7f};
    must(rt_scene_context(scene), rt_scene_set_world(scene, &world));
    rt_camera_desc camera = rt_camera_desc_default();
    camera.eye = (rt_vec3){4, 4.5f, 13};
    camera.look_at = (rt_vec3){0, height * 0.48f, 0};
    camera.fov_deg = 38;
    must(rt_scene_context(scene), rt_scene_set_camera(scene, &camera));
    must(rt_scene_context(scene), rt_scene_commit(scene, NULL));
}

/* Called inside rt_job_wait, on this thread. A program with a window would draw the tile's pixels here. */
static int on_tile(void *user, const rt_tile *tile, const rt_image *image)
{
    unsigned *count = user;
    (void)image;
    ++*count;
    printf("tile %3u at %4u,%-4u\r", *count, (unsigned)tile->x, (unsigned)tile->y);
    fflush(stdout);
    return 0; /* anything else cancels */
}

/* Waits in short steps, as a program does that has other things to do; `stop_at` is the share after which it is cancelled. */
static rt_job_state watch(rt_job *job, float stop_at)
{
    float done = 0;
    while (rt_job_wait(job, 0.05) == RT_JOB_RUNNING)
        if (rt_job_poll(job, &done) == RT_JOB_RUNNING && done >= stop_at)
            rt_job_cancel(job); /* ends within 100 ms; may come from any thread */
    return rt_job_poll(job, NULL);
}

static void report(rt_job *job)
{
    rt_worker_stats workers[64];
    rt_render_stats all;
    rt_job_stats(job, &all);
    uint32_t count = rt_job_worker_stats(job, workers, 64);
    printf("%u of %u tiles in %.3f s\n", (unsigned)all.tiles_done, (unsigned)all.tiles, all.seconds);
    for (uint32_t i = 0; i < count && i < 64; ++i)
        printf("  worker %u: %3u tiles, %8llu rays, busy %.3f s\n", (unsigned)i, (unsigned)workers[i].tiles,
               (unsigned long long)workers[i].rays, workers[i].busy_seconds);
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){800, 600, "progress_cancel.png"});
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_job *job = NULL;
    unsigned tiles = 0;
    must(NULL, rt_context_create(NULL, &context));
    must(context, rt_scene_create(context, &scene));
    describe(scene);

    rt_render_desc render = rt_render_desc_default();
    render.width = a.width;
    render.height = a.height;
    render.samples = 16;
    render.tile = 32;
    must(context, rt_job_start(scene, &render, &job));
    rt_job_on_tile(job, on_tile, &tiles);
    rt_job_state state = watch(job, 2); /* never */
    must(context, rt_job_status(job));
    report(job);
    must(context, rt_image_save(rt_job_image(job), a.path, NULL));
    rt_job_destroy(job);
    int ok = state == RT_JOB_DONE;

    /* The same picture with four times the samples, stopped at a tenth: what was finished can be used. */
    render.samples = 64;
    must(context, rt_job_start(scene, &render, &job));
    state = watch(job, 0.1f);
    printf("stopped early: %s\n", state == RT_JOB_CANCELLED ? "yes" : "no, it was faster");
    report(job);
    rt_job_destroy(job);

    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return ok ? 0 : 1;
}
