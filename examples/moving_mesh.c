/* A flag in the wind: one mesh whose vertices move from frame to frame. The first commit builds a tree; the ones behind refit it,
 * which takes a small part of the time. The last frame is saved. usage: moving_mesh [WIDTHxHEIGHT [FILE]] */
#include "arguments.h"

#include <math.h>

enum { COLUMNS = 160, ROWS = 100, VERTICES = (COLUMNS + 1) * (ROWS + 1), FRAMES = 25 };

/* Where the cloth is at a time in seconds: fast at the pole, the wilder the farther from it. */
static void blow(float *positions, float time)
{
    for (int i = 0; i < VERTICES; ++i) {
        const int column = i % (COLUMNS + 1), row = i / (COLUMNS + 1);
        float u = (float)column / COLUMNS, v = (float)row / ROWS;
        float sway = u * (0.15f * sinf(9 * u - 7 * time + 2 * v) + 0.05f * sinf(17 * u - 11 * time));
        positions[3 * i] = 1.6f * u - 0.8f;
        positions[3 * i + 1] = v - 0.5f - 0.1f * u * u;
        positions[3 * i + 2] = sway;
    }
}

static rt_geometry add_flag(rt_scene *scene, const float *positions)
{
    static uint32_t indices[6 * COLUMNS * ROWS];
    uint32_t *to = indices;
    rt_material_desc cloth = rt_material_desc_default();
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_geometry flag;
    for (uint32_t i = 0; i < COLUMNS * ROWS; ++i) {
        uint32_t a = i / COLUMNS * (COLUMNS + 1) + i % COLUMNS,
                 quad[6] = {a, a + 1, a + COLUMNS + 1, a + 1, a + COLUMNS + 2, a + COLUMNS + 1};
        memcpy(to, quad, sizeof quad);
        to += 6;
    }
    cloth.color = (rt_vec3){0.8f, 0.15f, 0.1f};
    must(rt_scene_context(scene), rt_scene_add_material(scene, &cloth, &mesh.common.material));
    mesh.positions = positions; /* copied by the call, like all others */
    mesh.vertex_count = VERTICES;
    mesh.indices = indices;
    mesh.triangle_count = 2 * COLUMNS * ROWS;
    must(rt_scene_context(scene), rt_scene_add_mesh(scene, &mesh, &flag));
    return flag;
}

static void add_rest(rt_scene *scene)
{
    rt_cone_desc pole = rt_cone_desc_default();
    rt_light_desc sun = rt_light_desc_default();
    rt_camera_desc camera = rt_camera_desc_default();
    pole.from = (rt_vec3){-0.82f, -1.5f, 0};
    pole.to = (rt_vec3){-0.82f, 0.55f, 0};
    pole.radius0 = 0.02f;
    must(rt_scene_context(scene), rt_scene_add_cylinder(scene, &pole, NULL));
    sun.type = RT_LIGHT_DIRECTIONAL;
    sun.direction = (rt_vec3){0.6f, -0.5f, -1};
    must(rt_scene_context(scene), rt_scene_add_light(scene, &sun, NULL));
    camera.eye = (rt_vec3){0.3f, -0.4f, 3};
    camera.look_at = (rt_vec3){0, 0, 0};
    must(rt_scene_context(scene), rt_scene_set_camera(scene, &camera));
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){640, 480, "moving_mesh.png"});
    static float positions[3 * VERTICES];
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    rt_render_desc how = rt_render_desc_default();
    must(NULL, rt_context_create(NULL, &context));
    must(context, rt_scene_create(context, &scene));
    blow(positions, 0);
    rt_geometry flag = add_flag(scene, positions);
    add_rest(scene);
    how.width = a.width;
    how.height = a.height;

    for (int frame = 0; frame < FRAMES; ++frame) {
        if (frame > 0) {
            blow(positions, (float)frame / FRAMES);
            must(context, rt_scene_set_mesh_positions(scene, flag, positions, NULL, VERTICES));
        }
        must(context, rt_scene_commit(scene, NULL));
        rt_image_destroy(image);
        must(context, rt_render(scene, &how, &image));
    }
    must(context, rt_image_save(image, a.path, NULL));

    rt_context_work_stats work = rt_context_work(context);
    printf("%s: frame %d; of the trees over the mesh %u were built and %u refitted, in %.1f ms\n", a.path, FRAMES,
           (unsigned)work.trees_built, (unsigned)work.trees_refitted, 1000 * work.build_seconds);
    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return 0;
}
