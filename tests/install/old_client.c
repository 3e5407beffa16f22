/* A client compiled against an earlier header hands shorter descriptors: the library must read struct_size bytes and no more, and
 * take its defaults for the fields behind. Each short descriptor ends right before a page that may not be touched. A client of a
 * later header hands longer ones; and one that never set struct_size is told so. */
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "librt/rt.h"

static int failures;
#define CHECK(condition, ...) ((condition) ? (void)0 : (void)(++failures, fprintf(stderr, __VA_ARGS__), fputc('\n', stderr)))

/* Where earlier shapes of these descriptors end. */
enum {
    OLD_CONTEXT = offsetof(rt_context_desc, parallel),
    OLD_PLANE = offsetof(rt_plane_desc, texture_size),
    OLD_CAMERA = offsetof(rt_camera_desc, aperture),
    OLD_LIGHT = offsetof(rt_light_desc, falloff),
    OLD_COMMIT = offsetof(rt_commit_desc, builder),
    OLD_RENDER = offsetof(rt_render_desc, seed)
};

static char *fence; /* the first byte that may not be touched */

/* The first `size` bytes of desc, struct_size set to it, right before the fence. */
static const void *shortened(const void *desc, uint32_t size)
{
    char *place = fence - size;
    memcpy(place, desc, size);
    memcpy(place, &size, sizeof size);
    return place;
}

static rt_status render_with(rt_scene *scene, uint32_t size, char hash[33])
{
    rt_render_desc render = rt_render_desc_default();
    rt_image *image = NULL;
    render.width = 16;
    render.height = 12;
    render.samples = 1;
    render.workers = 1;
    rt_status status = rt_render(scene, shortened(&render, size), &image);
    if (status == RT_OK)
        rt_image_hash(image, hash);
    rt_image_destroy(image);
    return status;
}

static void earlier_client(void)
{
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    char old_hash[33] = "", new_hash[33] = "";
    rt_context_desc cd = rt_context_desc_default();
    rt_plane_desc plane = rt_plane_desc_default();
    rt_light_desc light = rt_light_desc_default();
    rt_camera_desc camera = rt_camera_desc_default();
    rt_commit_desc commit = rt_commit_desc_default();
    cd.workers = 1;
    plane.normal = (rt_vec3){0, 1, 0};
    plane.point = (rt_vec3){0, -1, 0};
    light.at = (rt_vec3){0, 10, 0};
    CHECK(rt_context_create(shortened(&cd, OLD_CONTEXT), &context) == RT_OK, "rt_context_create refused an earlier descriptor");
    CHECK(rt_context_workers(context) == 1, "the earlier descriptor's workers were lost");
    CHECK(rt_scene_create(context, &scene) == RT_OK, "rt_scene_create failed");
    CHECK(rt_scene_add_plane(scene, shortened(&plane, OLD_PLANE), NULL) == RT_OK, "an earlier plane was refused");
    CHECK(rt_scene_add_light(scene, shortened(&light, OLD_LIGHT), NULL) == RT_OK, "an earlier light was refused");
    CHECK(rt_scene_set_camera(scene, shortened(&camera, OLD_CAMERA)) == RT_OK, "an earlier camera was refused");
    CHECK(rt_scene_get_camera(scene, (rt_camera_desc *)(void *)(fence - OLD_CAMERA)) == RT_OK, "an earlier camera was not given");
    CHECK(rt_scene_commit(scene, shortened(&commit, OLD_COMMIT)) == RT_OK, "an earlier commit was refused");
    CHECK(render_with(scene, OLD_RENDER, old_hash) == RT_OK, "an earlier render was refused");
    CHECK(render_with(scene, sizeof(rt_render_desc), new_hash) == RT_OK, "today's render was refused");
    CHECK(old_hash[0] && strcmp(old_hash, new_hash) == 0, "the earlier client's picture is %s, today's is %s", old_hash,
          new_hash);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
}

static void later_client_and_unset(void)
{
    struct {
        rt_sphere_desc known;
        char later[64];
    } longer = {rt_sphere_desc_default(), {0}};
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    char message[512] = "";
    rt_sphere_desc unset;
    memset(&unset, 0, sizeof unset);
    unset.radius = 1;
    CHECK(rt_context_create(NULL, &context) == RT_OK && rt_scene_create(context, &scene) == RT_OK, "no context");
    CHECK(rt_scene_add_sphere(scene, &unset, NULL) == RT_ERROR_ARGUMENT, "a descriptor without struct_size was taken");
    rt_context_error(context, message, sizeof message);
    CHECK(strstr(message, "_default") || strstr(message, "struct_size"), "the sentence does not help: \"%s\"", message);
    longer.known.struct_size = sizeof longer;
    longer.known.radius = 1;
    CHECK(rt_scene_add_sphere(scene, &longer.known, NULL) == RT_OK, "a later client's sphere was refused");
    rt_scene_destroy(scene);
    rt_context_destroy(context);
}

int main(void)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED || mprotect(pages + page, page, PROT_NONE) != 0)
        return 3;
    fence = pages + page;
    earlier_client();
    later_client_and_unset();
    munmap(pages, 2 * page);
    return failures != 0;
}
