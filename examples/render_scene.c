/* Builds a scene in C and renders it to a file: a glass ball, a mirror ball and a ring on a chequered floor under a soft light.
 * usage: render_scene [WIDTHxHEIGHT [FILE]] */
#include "arguments.h"

static rt_material add_material(rt_scene *scene, rt_vec3 color, float diffusion, float mirror, float glass, float index)
{
    rt_material_desc d = rt_material_desc_default();
    rt_material material;
    d.color = color;
    d.diffusion = diffusion;
    d.reflectiveness = mirror;
    d.transparency = glass;
    d.refractiveness = index;
    d.specular = 0.06f;
    d.shininess = 80;
    must(rt_scene_context(scene), rt_scene_add_material(scene, &d, &material));
    return material;
}

/* Two by two texels, repeated over the plane. */
static rt_material add_chequers(rt_scene *scene)
{
    static const uint8_t texels[4 * 3] = {235, 225, 205, 60, 80, 95, 60, 80, 95, 235, 225, 205};
    rt_texture_desc t = rt_texture_desc_default();
    rt_material_desc m = rt_material_desc_default();
    rt_material material;
    t.width = t.height = 2;
    t.pixels = texels;
    t.format = RT_PIXEL_RGB8;
    t.nearest = 1;
    must(rt_scene_context(scene), rt_scene_add_texture(scene, &t, &m.color_texture));
    m.diffusion = 0.9f;
    m.reflectiveness = 0.1f;
    must(rt_scene_context(scene), rt_scene_add_material(scene, &m, &material));
    return material;
}

static void add_sphere(rt_scene *scene, rt_vec3 center, float radius, rt_material material)
{
    rt_sphere_desc d = rt_sphere_desc_default();
    d.center = center;
    d.radius = radius;
    d.common.material = material;
    must(rt_scene_context(scene), rt_scene_add_sphere(scene, &d, NULL));
}

static void describe(rt_scene *scene)
{
    const rt_context *context = rt_scene_context(scene);
    rt_plane_desc floor = rt_plane_desc_default();
    floor.normal = (rt_vec3){0, 1, 0};
    floor.texture_size = 2;
    floor.common.material = add_chequers(scene);
    must(context, rt_scene_add_plane(scene, &floor, NULL));

    add_sphere(scene, (rt_vec3){-1.1f, 1, 0.4f}, 1, add_material(scene, (rt_vec3){1, 1, 1}, 0, 0.1f, 0.9f, 1.5f));
    add_sphere(scene, (rt_vec3){1.3f, 1, -0.8f}, 1, add_material(scene, (rt_vec3){1, 0.85f, 0.55f}, 0.1f, 0.8f, 0, 1));

    rt_torus_desc ring = rt_torus_desc_default();
    ring.center = (rt_vec3){0.6f, 0.25f, 1.6f};
    ring.axis = (rt_vec3){0, 1, 0};
    ring.major_radius = 0.7f;
    ring.minor_radius = 0.25f;
    ring.common.material = add_material(scene, (rt_vec3){0.8f, 0.2f, 0.15f}, 0.9f, 0.05f, 0, 1);
    must(context, rt_scene_add_torus(scene, &ring, NULL));

    rt_light_desc lamp = rt_light_desc_default();
    lamp.type = RT_LIGHT_SPHERE;
    lamp.at = (rt_vec3){-4, 7, 5};
    lamp.radius = 0.8f;
    lamp.color = (rt_vec3){1, 0.96f, 0.9f};
    must(context, rt_scene_add_light(scene, &lamp, NULL));

    rt_world_desc world = rt_world_desc_default();
    world.ambient = (rt_vec3){0.15f, 0.17f, 0.2f};
    world.background = (rt_vec3){0.75f, 0.82f, 0.9f};
    world.background_top = (rt_vec3){0.25f, 0.42f, 0.7f};
    must(context, rt_scene_set_world(scene, &world));

    rt_camera_desc camera = rt_camera_desc_default();
    camera.eye = (rt_vec3){0, 2.2f, 6.5f};
    camera.look_at = (rt_vec3){0.1f, 0.7f, 0};
    camera.fov_deg = 38;
    must(context, rt_scene_set_camera(scene, &camera));
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){800, 600, "render_scene.png"});
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    must(NULL, rt_context_create(NULL, &context)); /* NULL: malloc, all CPUs, silent */
    must(context, rt_scene_create(context, &scene));
    describe(scene);
    must(context, rt_scene_commit(scene, NULL)); /* builds the tree; from here on the scene can be rendered and queried */

    rt_render_desc render = rt_render_desc_default();
    render.width = a.width;
    render.height = a.height;
    render.samples = 16;
    must(context, rt_render(scene, &render, &image));
    must(context, rt_image_save(image, a.path, NULL)); /* the format is the ending's */
    printf("%s: %ux%u\n", a.path, (unsigned)rt_image_width(image), (unsigned)rt_image_height(image));

    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return 0;
}
