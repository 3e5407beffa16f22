#include "scenes.h"

#include <stddef.h>

/* Own numbers: the same everywhere, no libm, in [0, 1). */
static float noise(uint32_t *state)
{
    *state = *state * 747796405u + 2891336453u;
    uint32_t word = ((*state >> ((*state >> 28) + 4)) ^ *state) * 277803737u;
    return (float)((word >> 22 ^ word) >> 8) * (1.0f / 16777216.0f);
}

#define TRY(call)                                                                                                                \
    do {                                                                                                                         \
        rt_status try_status = (call);                                                                                           \
        if (try_status != RT_OK)                                                                                                 \
            return try_status;                                                                                                   \
    } while (0)

static rt_status set_view(rt_scene *scene, rt_vec3 eye, rt_vec3 look_at)
{
    rt_camera_desc camera = rt_camera_desc_default();
    rt_world_desc world = rt_world_desc_default();
    camera.eye = eye;
    camera.look_at = look_at;
    camera.fov_deg = 45;
    TRY(rt_scene_set_camera(scene, &camera));
    world.ambient = (rt_vec3){0.2f, 0.2f, 0.25f};
    world.background = (rt_vec3){0.6f, 0.7f, 0.8f};
    world.background_top = (rt_vec3){0.2f, 0.3f, 0.6f};
    return rt_scene_set_world(scene, &world);
}

static rt_status add_light(rt_scene *scene, rt_light_type type, rt_vec3 at, rt_falloff falloff, float intensity)
{
    rt_light_desc light = rt_light_desc_default();
    light.type = type;
    light.at = at;
    light.direction = (rt_vec3){-at.x, -at.y, -at.z};
    light.radius = 0.75f;
    light.falloff = falloff;
    light.intensity = intensity;
    light.visible = type == RT_LIGHT_SPHERE;
    return rt_scene_add_light(scene, &light, NULL);
}

static rt_status add_material(rt_scene *scene, rt_vec3 color, float diffusion, float mirror, float glass, rt_material *material)
{
    rt_material_desc d = rt_material_desc_default();
    d.color = color;
    d.diffusion = diffusion;
    d.reflectiveness = mirror;
    d.transparency = glass;
    d.refractiveness = 1.5f;
    d.specular = 0.4f;
    d.shininess = 40;
    return rt_scene_add_material(scene, &d, material);
}

static rt_status add_plane(rt_scene *scene, rt_vec3 point, rt_vec3 normal)
{
    static const uint8_t texels[3 * 3 * 3] = {250, 240, 200, 40,  60,  90,  120, 30, 20, 10, 200, 90, 90, 90,
                                              90,  0,   0,   250, 255, 255, 255, 30, 30, 0,  200, 10, 220};
    rt_texture_desc texture = rt_texture_desc_default();
    rt_material_desc material = rt_material_desc_default();
    rt_plane_desc plane = rt_plane_desc_default();
    texture.width = texture.height = 3;
    texture.pixels = texels;
    TRY(rt_scene_add_texture(scene, &texture, &material.color_texture));
    material.reflectiveness = 0.15f;
    TRY(rt_scene_add_material(scene, &material, &plane.common.material));
    plane.point = point;
    plane.normal = normal;
    plane.texture_size = 2.5f;
    return rt_scene_add_plane(scene, &plane, NULL);
}

static rt_status add_floor(rt_scene *scene)
{
    return add_plane(scene, (rt_vec3){0, -1, 0}, (rt_vec3){0, 1, 0});
}

/* One of each shape, in glass, mirror and clay, over a textured floor, under each kind of light. */
static rt_status fill_shapes(rt_scene *scene, rt_scene *child)
{
    rt_material glass, mirror, clay;
    rt_sphere_desc sphere = rt_sphere_desc_default();
    rt_box_desc box = rt_box_desc_default();
    rt_cone_desc cylinder = rt_cone_desc_default(), cone = rt_cone_desc_default();
    rt_torus_desc torus = rt_torus_desc_default();
    (void)child;
    TRY(add_floor(scene));
    TRY(add_material(scene, (rt_vec3){0.9f, 1, 0.95f}, 0.05f, 0.1f, 0.85f, &glass));
    TRY(add_material(scene, (rt_vec3){1, 0.8f, 0.5f}, 0.2f, 0.8f, 0, &mirror));
    TRY(add_material(scene, (rt_vec3){0.7f, 0.3f, 0.2f}, 0.95f, 0, 0, &clay));
    sphere.center = (rt_vec3){0, 0.2f, 1};
    sphere.radius = 1.1f;
    sphere.common.material = glass;
    TRY(rt_scene_add_sphere(scene, &sphere, NULL));
    box.low = (rt_vec3){-3, -1, -1};
    box.high = (rt_vec3){-1.7f, 0.7f, 0.5f};
    box.common.material = clay;
    TRY(rt_scene_add_box(scene, &box, NULL));
    cylinder.from = (rt_vec3){1.5f, -1, -2};
    cylinder.to = (rt_vec3){1.9f, 1.2f, -2.3f};
    cylinder.radius0 = 0.5f;
    cylinder.common.material = mirror;
    TRY(rt_scene_add_cylinder(scene, &cylinder, NULL));
    cone.from = (rt_vec3){2.6f, -1, 0.6f};
    cone.to = (rt_vec3){2.6f, 0.8f, 0.6f};
    cone.radius0 = 0.7f;
    cone.radius1 = 0.2f;
    cone.common.material = clay;
    TRY(rt_scene_add_cone(scene, &cone, NULL));
    torus.center = (rt_vec3){-0.6f, -0.6f, 3};
    torus.axis = (rt_vec3){0.2f, 1, 0.1f};
    torus.major_radius = 0.6f;
    torus.minor_radius = 0.22f;
    torus.common.material = mirror;
    TRY(rt_scene_add_torus(scene, &torus, NULL));
    TRY(add_light(scene, RT_LIGHT_POINT, (rt_vec3){-4, 5, 4}, RT_FALLOFF_NONE, 0.5f));
    TRY(add_light(scene, RT_LIGHT_SPHERE, (rt_vec3){4, 5, 2}, RT_FALLOFF_INVERSE_SQUARE, 12));
    TRY(add_light(scene, RT_LIGHT_DIRECTIONAL, (rt_vec3){1, 3, 2}, RT_FALLOFF_NONE, 0.3f));
    TRY(set_view(scene, (rt_vec3){0.5f, 1.6f, 8}, (rt_vec3){0, 0, 0}));
    return rt_scene_commit(scene, NULL);
}

/* Loose triangles and many spheres, far from the origin: every ray meets several primitives, some coincident. */
static rt_status fill_soup(rt_scene *scene, rt_scene *child)
{
    enum { TRIANGLES = 900, BALLS = 60 };
    float positions[9 * TRIANGLES], colors[9 * TRIANGLES], centers[3 * BALLS];
    uint32_t indices[3 * TRIANGLES], seed = 7;
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_spheres_desc balls = rt_spheres_desc_default();
    (void)child;
    for (int i = 0; i < TRIANGLES; ++i) {
        float center[3];
        for (int k = 0; k < 3; ++k)
            center[k] = 1000 + 4 * noise(&seed);
        for (int k = 0; k < 9; ++k) {
            int again = i % 50 == 49; /* the same triangle once more */
            positions[9 * i + k] = again ? positions[9 * (i - 1) + k] : center[k % 3] + 0.6f * noise(&seed) - 0.3f;
            colors[9 * i + k] = noise(&seed);
        }
        for (int k = 0; k < 3; ++k)
            indices[3 * i + k] = (uint32_t)(3 * i + k);
    }
    mesh.positions = positions;
    mesh.colors = colors;
    mesh.vertex_count = 3 * TRIANGLES;
    mesh.indices = indices;
    mesh.triangle_count = TRIANGLES;
    TRY(rt_scene_add_mesh(scene, &mesh, NULL));
    for (int i = 0; i < 3 * BALLS; ++i)
        centers[i] = 1000 + 4 * noise(&seed);
    balls.centers = centers;
    balls.count = BALLS;
    balls.radius = 0.15f;
    TRY(add_material(scene, (rt_vec3){1, 1, 1}, 0.3f, 0.5f, 0.2f, &balls.common.material));
    TRY(rt_scene_add_spheres(scene, &balls, NULL));
    TRY(add_light(scene, RT_LIGHT_SPHERE, (rt_vec3){1002, 1008, 1006}, RT_FALLOFF_NONE, 1));
    TRY(set_view(scene, (rt_vec3){1002, 1003, 1009}, (rt_vec3){1002, 1002, 1002}));
    return rt_scene_commit(scene, NULL);
}

/* A small pyramid and a ball, placed forty times, turned, stretched and mirrored. */
static rt_status fill_instances(rt_scene *scene, rt_scene *child)
{
    static const float positions[15] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, 0, 1.5f, 0};
    static const uint32_t sizes[5] = {4, 3, 3, 3, 3}, corners[16] = {0, 1, 2, 3, 1, 0, 4, 2, 1, 4, 3, 2, 4, 0, 3, 4};
    uint32_t seed = 11;
    rt_polyhedron_desc pyramid = rt_polyhedron_desc_default();
    rt_sphere_desc ball = rt_sphere_desc_default();
    pyramid.positions = positions;
    pyramid.vertex_count = 5;
    pyramid.face_sizes = sizes;
    pyramid.face_count = 5;
    pyramid.indices = corners;
    pyramid.index_count = 16;
    TRY(rt_scene_add_polyhedron(child, &pyramid, NULL));
    ball.center = (rt_vec3){0, 1.9f, 0};
    ball.radius = 0.45f;
    TRY(add_material(child, (rt_vec3){0.4f, 0.6f, 0.9f}, 0.4f, 0.5f, 0, &ball.common.material));
    TRY(rt_scene_add_sphere(child, &ball, NULL));
    TRY(rt_scene_commit(child, NULL));
    for (int i = 0; i < 40; ++i) {
        rt_instance_desc place = rt_instance_desc_default();
        float s = 0.3f + 0.4f * noise(&seed);
        rt_vec3 at = {8 * noise(&seed) - 4, 4 * noise(&seed) - 1, 8 * noise(&seed) - 4},
                axis = {noise(&seed) + 0.1f, noise(&seed), noise(&seed)};
        rt_transform turn = rt_transform_rotate(axis, 360 * noise(&seed)),
                     size = rt_transform_scale((rt_vec3){i % 3 ? s : -s, 1.5f * s, s});
        place.child = child;
        place.transform = rt_transform_multiply(rt_transform_translate(at), rt_transform_multiply(turn, size));
        TRY(rt_scene_add_instance(scene, &place, NULL));
    }
    TRY(add_floor(scene));
    TRY(add_light(scene, RT_LIGHT_POINT, (rt_vec3){3, 8, 6}, RT_FALLOFF_NONE, 1));
    TRY(set_view(scene, (rt_vec3){1, 3, 11}, (rt_vec3){0, 0.5f, 0}));
    return rt_scene_commit(scene, NULL);
}

/* Balls and a box a hundred thousand times smaller than what they stand on: a group of two parts. */
static rt_status fill_parts(rt_scene *scene, rt_scene *child)
{
    enum { BALLS = 120 };
    float centers[3 * BALLS];
    uint32_t seed = 23;
    rt_spheres_desc balls = rt_spheres_desc_default();
    rt_box_desc box = rt_box_desc_default();
    (void)child;
    for (int i = 0; i < BALLS; ++i) {
        centers[3 * i] = 0.2f * noise(&seed) - 0.1f;
        centers[3 * i + 1] = 0.1f * noise(&seed);
        centers[3 * i + 2] = 0.2f * noise(&seed) - 0.1f;
    }
    balls.centers = centers;
    balls.count = BALLS;
    balls.radius = 0.008f;
    TRY(add_material(scene, (rt_vec3){1, 0.8f, 0.6f}, 0.4f, 0.4f, 0.2f, &balls.common.material));
    TRY(rt_scene_add_spheres(scene, &balls, NULL));
    box.low = (rt_vec3){-3000, -1, -3000};
    box.high = (rt_vec3){3000, 0, 3000};
    TRY(add_material(scene, (rt_vec3){0.7f, 0.8f, 0.9f}, 0.7f, 0.3f, 0, &box.common.material));
    TRY(rt_scene_add_box(scene, &box, NULL));
    TRY(add_light(scene, RT_LIGHT_SPHERE, (rt_vec3){1.3f, 2.6f, 1.4f}, RT_FALLOFF_NONE, 1));
    TRY(set_view(scene, (rt_vec3){0.02f, 0.15f, 0.4f}, (rt_vec3){0, 0.04f, 0}));
    return rt_scene_commit(scene, NULL);
}

/* The shapes again, through a lens of seven blades that moves. */
static rt_status fill_lens(rt_scene *scene, rt_scene *child)
{
    rt_camera_desc camera = rt_camera_desc_default();
    TRY(fill_shapes(scene, child));
    camera.eye = (rt_vec3){0.5f, 1.6f, 8};
    camera.fov_deg = 45;
    camera.aperture = 0.25f;
    camera.blades = 7;
    camera.blade_rotation_deg = 10;
    camera.shutter_open = 0.125f;
    TRY(rt_scene_set_camera(scene, &camera));
    camera.eye = (rt_vec3){0.1f, 1.9f, 7.5f};
    camera.look_at = (rt_vec3){0, 0.3f, 0.5f};
    camera.up = (rt_vec3){0.1f, 1, 0};
    camera.fov_deg = 40;
    camera.aperture = 0.1f;
    TRY(rt_scene_set_camera_motion(scene, &camera));
    return rt_scene_commit(scene, NULL);
}

/* The pyramids and balls again: every other one goes, turns and grows to where its neighbour stood, some over three places,
 * seen through a lens. */
static rt_status fill_motion(rt_scene *scene, rt_scene *child)
{
    uint32_t seed = 31;
    rt_camera_desc camera = rt_camera_desc_default();
    TRY(fill_instances(scene, child));
    for (uint32_t i = 0; i < 40; i += 2) {
        rt_transform motion[3];
        for (int k = 0; k < 3; ++k) {
            float s = 0.3f + 0.3f * noise(&seed);
            rt_vec3 at = {8 * noise(&seed) - 4, 4 * noise(&seed) - 1, 8 * noise(&seed) - 4},
                    axis = {noise(&seed) + 0.1f, noise(&seed), noise(&seed)};
            motion[k] = rt_transform_multiply(rt_transform_translate(at),
                                              rt_transform_multiply(rt_transform_rotate(axis, 360 * noise(&seed)),
                                                                    rt_transform_scale((rt_vec3){i % 3 ? s : -s, 1.2f * s, s})));
        }
        TRY(rt_scene_set_instance_motion(scene, (rt_instance){i}, motion, 1 + i % 3));
    }
    camera.eye = (rt_vec3){1, 3, 11};
    camera.look_at = (rt_vec3){0, 0.5f, 0};
    camera.fov_deg = 45;
    camera.aperture = 0.1f;
    camera.shutter_close = 0.75f;
    TRY(rt_scene_set_camera(scene, &camera));
    return rt_scene_commit(scene, NULL);
}

/* Textured slopes all around balls that are only pushed: their turns and sizes stay. What is made of normals and of placements
 * goes through doubles and back, which compilers may not leave out. */
static rt_status fill_slopes(rt_scene *scene, rt_scene *child)
{
    uint32_t seed = 5;
    rt_camera_desc camera = rt_camera_desc_default();
    rt_sphere_desc ball = rt_sphere_desc_default();
    ball.radius = 1;
    TRY(rt_scene_add_sphere(child, &ball, NULL));
    TRY(rt_scene_commit(child, NULL));
    for (int i = 0; i < 12; ++i) {
        rt_vec3 n = {2 * noise(&seed) - 1, 2 * noise(&seed) - 1, 2 * noise(&seed) - 1};
        TRY(add_plane(scene, (rt_vec3){-8 * n.x, -8 * n.y, -8 * n.z}, n));
    }
    for (int i = 0; i < 24; ++i) {
        rt_instance_desc d = rt_instance_desc_default();
        rt_vec3 axis = {noise(&seed) + 0.1f, noise(&seed), noise(&seed)},
                size = {0.2f + 0.3f * noise(&seed), 0.2f + 0.3f * noise(&seed), 0.2f + 0.3f * noise(&seed)};
        rt_transform pushed;
        d.child = child;
        d.transform = rt_transform_multiply(rt_transform_rotate(axis, 360 * noise(&seed)), rt_transform_scale(size));
        for (int k = 0; k < 3; ++k)
            d.transform.m[4 * k + 3] = 4 * noise(&seed) - 2;
        pushed = d.transform;
        pushed.m[3] += noise(&seed);
        d.motion = &pushed;
        d.motion_count = 1;
        TRY(rt_scene_add_instance(scene, &d, NULL));
    }
    TRY(add_light(scene, RT_LIGHT_POINT, (rt_vec3){1, 3, 4}, RT_FALLOFF_NONE, 1));
    camera.eye = (rt_vec3){0, 1, 6};
    camera.look_at = (rt_vec3){0, 0, 0};
    camera.shutter_close = 1;
    TRY(rt_scene_set_camera(scene, &camera));
    return rt_scene_commit(scene, NULL);
}

const hash_scene hash_scenes[] = {{"shapes", fill_shapes}, {"soup", fill_soup}, {"instances", fill_instances},
                                  {"parts", fill_parts},   {"lens", fill_lens}, {"motion", fill_motion},
                                  {"slopes", fill_slopes}};
const unsigned hash_scene_count = sizeof hash_scenes / sizeof hash_scenes[0];
