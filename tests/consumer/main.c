/* A program outside: one sphere, one ray, one small picture. */
#include <librt/rt.h>
#include <stdio.h>

int main(void)
{
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    rt_sphere_desc sphere = rt_sphere_desc_default();
    rt_render_desc render = rt_render_desc_default();
    rt_ray ray = {{0, 0, -3}, 0, {0, 0, 1}, 100, RT_MASK_ALL};
    rt_hit hit = {0};
    char hash[33];

    sphere.radius = 1;
    render.width = render.height = 16;
    render.samples = 1;
    if (rt_context_create(NULL, &context) != RT_OK || rt_scene_create(context, &scene) != RT_OK ||
        rt_scene_add_sphere(scene, &sphere, NULL) != RT_OK || rt_scene_commit(scene, NULL) != RT_OK)
        return 1;
    rt_scene_intersect(scene, &ray, &hit, 1);
    if (hit.t != 2.0f || rt_render(scene, &render, &image) != RT_OK)
        return 1;
    rt_image_hash(image, hash);
    printf("librt %s %s\n", rt_version(), hash);
    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return 0;
}
