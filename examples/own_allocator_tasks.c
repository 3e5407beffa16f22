/* A host that has its own memory and its own threads: the library takes every byte from the host's allocator and runs its work as
 * the host's tasks. The picture is the same, bit for bit, as with the library's own. usage: own_allocator_tasks [WIDTHxHEIGHT
 * [FILE]] */
#include "arguments.h"

#include <pthread.h>
#include <stdatomic.h>

/* ---- memory: counts what is held; the shape is Lua's, the old size comes with every call ---- */

typedef struct meter {
    atomic_size_t now, peak, calls;
} meter;

static void *allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    meter *m = user;
    void *block;
    if (!(block = rt_allocate(NULL, ptr, old_size, new_size)) && new_size > 0)
        return NULL; /* the old block stays valid, and so does the count */
    size_t now = atomic_fetch_add(&m->now, new_size - old_size) + (new_size - old_size), peak = atomic_load(&m->peak);
    while (now > peak && !atomic_compare_exchange_weak(&m->peak, &peak, now)) {
    }
    atomic_fetch_add(&m->calls, 1);
    return block;
}

/* ---- tasks: three threads beside the calling one take indices from a common counter ---- */

typedef struct batch {
    void (*task)(void *data, uint32_t index);
    void *data;
    uint32_t count;
    atomic_uint next;
} batch;

static void *work(void *user)
{
    batch *b = user;
    for (uint32_t i = atomic_fetch_add(&b->next, 1); i < b->count; i = atomic_fetch_add(&b->next, 1))
        b->task(b->data, i);
    return NULL;
}

static void run_tasks(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data)
{
    atomic_uint *tasks = user;
    pthread_t threads[3];
    batch b = {task, data, count, 0};
    uint32_t started = 0;
    atomic_fetch_add(tasks, count);
    while (started < 3 && started + 1 < count && pthread_create(&threads[started], NULL, work, &b) == 0)
        ++started;
    work(&b); /* a thread that could not be started is no harm: this one does the rest */
    while (started > 0)
        pthread_join(threads[--started], NULL);
}

/* ---- the same scene in both contexts: a ring of glass and clay balls ---- */

static void describe(rt_scene *scene)
{
    static const rt_vec3 places[8] = {{3, 1, 0},  {2.1f, 1, 2.1f},   {0, 1, 3},  {-2.1f, 1, 2.1f},
                                      {-3, 1, 0}, {-2.1f, 1, -2.1f}, {0, 1, -3}, {2.1f, 1, -2.1f}};
    const rt_context *context = rt_scene_context(scene);
    for (int i = 0; i < 8; ++i) {
        rt_material_desc material = rt_material_desc_default();
        rt_sphere_desc ball = rt_sphere_desc_default();
        material.color = i % 2 ? (rt_vec3){0.75f, 0.35f, 0.25f} : (rt_vec3){0.95f, 1, 0.97f};
        material.transparency = i % 2 ? 0 : 0.85f;
        material.diffusion = i % 2 ? 0.9f : 0.05f;
        material.reflectiveness = 0.1f;
        material.refractiveness = 1.5f;
        must(context, rt_scene_add_material(scene, &material, &ball.common.material));
        ball.center = places[i];
        ball.radius = 1;
        must(context, rt_scene_add_sphere(scene, &ball, NULL));
    }
    rt_plane_desc floor = rt_plane_desc_default();
    floor.normal = (rt_vec3){0, 1, 0};
    must(context, rt_scene_add_plane(scene, &floor, NULL));
    rt_light_desc lamp = rt_light_desc_default();
    lamp.at = (rt_vec3){3, 8, 6};
    must(context, rt_scene_add_light(scene, &lamp, NULL));
    rt_world_desc world = rt_world_desc_default();
    world.ambient = (rt_vec3){0.25f, 0.28f, 0.35f};
    world.background = (rt_vec3){0.8f, 0.86f, 0.92f};
    world.background_top = (rt_vec3){0.3f, 0.45f, 0.7f};
    must(context, rt_scene_set_world(scene, &world));
    rt_camera_desc camera = rt_camera_desc_default();
    camera.eye = (rt_vec3){0, 5, 9};
    camera.look_at = (rt_vec3){0, 0.6f, 0};
    camera.fov_deg = 45;
    must(context, rt_scene_set_camera(scene, &camera));
    must(context, rt_scene_commit(scene, NULL));
}

static void render(const rt_context_desc *desc, const arguments *a, const char *path, char hash[33])
{
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    rt_render_desc rd = rt_render_desc_default();
    must(NULL, rt_context_create(desc, &context));
    must(context, rt_scene_create(context, &scene));
    describe(scene);
    rd.width = a->width;
    rd.height = a->height;
    rd.samples = 4;
    must(context, rt_render(scene, &rd, &image));
    rt_image_hash(image, hash);
    if (path)
        must(context, rt_image_save(image, path, NULL));
    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){800, 600, "own_allocator_tasks.png"});
    meter memory = {0, 0, 0};
    atomic_uint tasks = 0;
    char ours[33], theirs[33];

    rt_context_desc desc = rt_context_desc_default();
    desc.workers = 4;
    desc.allocate = allocate;
    desc.allocate_user = &memory;
    desc.parallel = run_tasks;
    desc.parallel_user = &tasks;
    render(&desc, &a, a.path, ours);
    render(NULL, &a, NULL, theirs);

    printf("host's memory: %zu calls, at most %zu bytes, %zu left\n", atomic_load(&memory.calls), atomic_load(&memory.peak),
           atomic_load(&memory.now));
    printf("host's tasks:  %u\n", atomic_load(&tasks));
    printf("picture:       %s, %s\n", ours,
           strcmp(ours, theirs) == 0 ? "the same as the library's own" : "DIFFERS from the library's own");
    return strcmp(ours, theirs) == 0 && atomic_load(&memory.now) == 0 && atomic_load(&tasks) > 0 ? 0 : 1;
}
