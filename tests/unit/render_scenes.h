/* Small scenes for the render tests. */
#ifndef RENDER_SCENES_H
#define RENDER_SCENES_H

#include <math.h>

#include "scene_kit.h"

#include "librt/render.h"

#define OK(call) assert_int_equal(call, RT_OK)

static inline rt_context *make_context(uint32_t workers)
{
    return kit_context(NULL, workers);
}

static inline rt_vec3 v3(float x, float y, float z)
{
    rt_vec3 v = {x, y, z};
    return v;
}

static inline rt_material add_material(rt_scene *s, rt_vec3 color, float diffusion, float reflectiveness, float transparency,
                                       float index)
{
    rt_material_desc d = rt_material_desc_default();
    rt_material m;
    d.color = color;
    d.diffusion = diffusion;
    d.reflectiveness = reflectiveness;
    d.transparency = transparency;
    d.refractiveness = index;
    d.ambient = 0.0f;
    d.specular = 0.0f;
    OK(rt_scene_add_material(s, &d, &m));
    return m;
}

static inline void add_plane(rt_scene *s, rt_vec3 point, rt_vec3 normal, rt_material m)
{
    rt_plane_desc d = rt_plane_desc_default();
    d.point = point;
    d.normal = normal;
    d.common.material = m;
    OK(rt_scene_add_plane(s, &d, NULL));
}

static inline void add_sphere(rt_scene *s, rt_vec3 center, float radius, rt_material m)
{
    rt_sphere_desc d = rt_sphere_desc_default();
    d.center = center;
    d.radius = radius;
    d.common.material = m;
    OK(rt_scene_add_sphere(s, &d, NULL));
}

static inline void add_box(rt_scene *s, rt_vec3 low, rt_vec3 high, rt_material m)
{
    rt_box_desc d = rt_box_desc_default();
    d.low = low;
    d.high = high;
    d.common.material = m;
    OK(rt_scene_add_box(s, &d, NULL));
}

static inline rt_light_desc light(rt_light_type type, rt_vec3 at, rt_vec3 color, rt_falloff falloff)
{
    rt_light_desc d = rt_light_desc_default();
    d.type = type;
    d.at = at;
    d.direction = at;
    d.color = color;
    d.intensity = 1.0f;
    d.falloff = falloff;
    return d;
}

static inline void add_light(rt_scene *s, rt_light_desc d)
{
    OK(rt_scene_add_light(s, &d, NULL));
}

static inline void set_world(rt_scene *s, rt_vec3 low, rt_vec3 top)
{
    rt_world_desc d = rt_world_desc_default();
    d.ambient = v3(0, 0, 0);
    d.background = low;
    d.background_top = top;
    OK(rt_scene_set_world(s, &d));
}

/* Orthographic window of the given height around look_at, seen from eye. */
static inline void look_parallel(rt_scene *s, rt_vec3 eye, rt_vec3 at, rt_vec3 up, float height)
{
    rt_camera_desc d = rt_camera_desc_default();
    d.type = RT_CAMERA_ORTHOGRAPHIC;
    d.eye = eye;
    d.look_at = at;
    d.up = up;
    d.height = height;
    OK(rt_scene_set_camera(s, &d));
}

static inline void look(rt_scene *s, rt_vec3 eye, rt_vec3 at, float fov)
{
    rt_camera_desc d = rt_camera_desc_default();
    d.eye = eye;
    d.look_at = at;
    d.up = v3(0, 1, 0);
    d.fov_deg = fov;
    OK(rt_scene_set_camera(s, &d));
}

static inline rt_render_desc settings(uint32_t width, uint32_t height, uint32_t samples, const char *integrator)
{
    rt_render_desc d = rt_render_desc_default();
    d.width = width;
    d.height = height;
    d.samples = samples;
    d.integrator = integrator;
    d.workers = 1;
    return d;
}

static inline rt_image *render(rt_scene *s, const rt_render_desc *d)
{
    rt_image *image = NULL;
    rt_status status = rt_render(s, d, &image);
    if (status != RT_OK) {
        char text[512];
        rt_context_error(rt_scene_context(s), text, sizeof text);
        fail_msg("rt_render: %s", text);
    }
    return image;
}

static inline const float *pixel(const rt_image *image, uint32_t x, uint32_t y)
{
    return rt_image_pixels_const(image) + 4 * ((size_t)y * rt_image_width(image) + x);
}

static inline void mean_of(const rt_image *image, double out[3])
{
    size_t n = (size_t)rt_image_width(image) * rt_image_height(image);
    const float *p = rt_image_pixels_const(image);
    out[0] = out[1] = out[2] = 0;
    for (size_t i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            out[c] += p[4 * i + c];
    }
    for (int c = 0; c < 3; c++)
        out[c] /= (double)n;
}

static inline void near_to(double got, double want, double bound)
{
    if (!(fabs(got - want) <= bound))
        fail_msg("got %.9g, want %.9g within %.3g", got, want, bound);
}

/* A room with everything in it: two lights, a mirror, glass, a soft shadow. */
static inline void add_everything(rt_scene *s)
{
    rt_material floor = add_material(s, v3(0.8f, 0.7f, 0.6f), 0.9f, 0, 0, 0),
                mirror = add_material(s, v3(1, 1, 1), 0.1f, 0.8f, 0, 0);
    rt_material glass = add_material(s, v3(0.8f, 1, 0.9f), 0, 0.1f, 0.9f, 1.5f),
                red = add_material(s, v3(1, 0.1f, 0.1f), 1, 0, 0, 0);
    rt_light_desc soft = light(RT_LIGHT_SPHERE, v3(-3, 6, 3), v3(0.6f, 0.6f, 0.5f), RT_FALLOFF_NONE);
    soft.radius = 0.7f;
    soft.visible = 1;
    add_plane(s, v3(0, 0, 0), v3(0, 1, 0), floor);
    add_sphere(s, v3(-1.2f, 1, 0), 1, mirror);
    add_sphere(s, v3(1.2f, 1, 0.5f), 1, glass);
    add_box(s, v3(-0.5f, 0, -2.5f), v3(0.7f, 1.5f, -1.5f), red);
    add_light(s, light(RT_LIGHT_POINT, v3(4, 5, 4), v3(0.5f, 0.5f, 0.5f), RT_FALLOFF_NONE));
    add_light(s, soft);
    set_world(s, v3(0.3f, 0.3f, 0.4f), v3(0.1f, 0.2f, 0.6f));
    look(s, v3(0, 2.5f, 7), v3(0, 1, 0), 45);
}

/* Every kind of shape, textures, smooth normals, instances. */
static inline rt_texture add_checker(rt_scene *s)
{
    uint8_t texels[8 * 8 * 3];
    rt_texture_desc d = rt_texture_desc_default();
    rt_texture t;
    for (uint32_t i = 0; i < 64; i++) {
        uint8_t on = (i / 8 + i) & 1 ? 230 : 60;
        texels[3 * i] = on;
        texels[3 * i + 1] = (uint8_t)(on / 2 + 4 * (i % 8));
        texels[3 * i + 2] = (uint8_t)(255 - on);
    }
    d.width = d.height = 8;
    d.pixels = texels;
    d.format = RT_PIXEL_RGB8;
    OK(rt_scene_add_texture(s, &d, &t));
    return t;
}

/* A dome of n x n quads with vertex normals, uv and colours. */
static inline void add_dome(rt_scene *s, rt_vec3 at, float radius, rt_material m)
{
    enum { N = 6, V = (N + 1) * (N + 1) };
    float p[3 * V], n[3 * V], uv[2 * V], c[3 * V];
    uint32_t index[6 * N * N], k = 0;
    rt_mesh_desc d = rt_mesh_desc_default();
    for (uint32_t i = 0; i < V; i++) {
        float x = (float)(i % (N + 1)) / N * 2 - 1, z = (float)(i / (N + 1)) / N * 2 - 1, y = 1.2f - 0.6f * (x * x + z * z);
        float l = sqrtf(x * x + y * y + z * z);
        n[3 * i] = x / l, n[3 * i + 1] = y / l, n[3 * i + 2] = z / l;
        p[3 * i] = at.x + radius * x / l, p[3 * i + 1] = at.y + radius * y / l, p[3 * i + 2] = at.z + radius * z / l;
        uv[2 * i] = 0.5f + 0.5f * x, uv[2 * i + 1] = 0.5f + 0.5f * z;
        c[3 * i] = 1, c[3 * i + 1] = 0.5f + 0.5f * x, c[3 * i + 2] = 0.5f + 0.5f * z;
    }
    for (uint32_t j = 0; j < N * N; j++) {
        uint32_t a = j / N * (N + 1) + j % N, b = a + 1, e = a + N + 1, f = e + 1;
        index[k++] = a, index[k++] = e, index[k++] = b, index[k++] = b, index[k++] = e, index[k++] = f;
    }
    d.positions = p, d.normals = n, d.uvs = uv, d.colors = c, d.indices = index;
    d.vertex_count = V;
    d.triangle_count = 2 * N * N;
    d.common.material = m;
    OK(rt_scene_add_mesh(s, &d, NULL));
}

static inline void add_round_things(rt_scene *s, rt_material m)
{
    rt_cone_desc c = rt_cone_desc_default();
    rt_torus_desc t = rt_torus_desc_default();
    c.common.material = t.common.material = m;
    c.from = v3(0, 0, 0), c.to = v3(0, 1, 0.2f);
    c.radius0 = 0.4f, c.radius1 = 0.1f;
    OK(rt_scene_add_cone(s, &c, NULL));
    c.from = v3(1.2f, 0, 0), c.to = v3(1.2f, 0.8f, 0);
    c.radius0 = 0.35f;
    OK(rt_scene_add_cylinder(s, &c, NULL));
    t.center = v3(-1.3f, 0.3f, 0);
    t.axis = v3(0.3f, 1, 0.2f);
    t.major_radius = 0.45f, t.minor_radius = 0.15f;
    OK(rt_scene_add_torus(s, &t, NULL));
}

/* child: an empty scene of the same context; it must outlive nothing. */
static inline void add_shapes(rt_scene *s, rt_scene *child)
{
    rt_material_desc d = rt_material_desc_default();
    rt_material tiled, plain = add_material(s, v3(0.7f, 0.75f, 0.8f), 0.9f, 0.15f, 0, 0),
                       red = add_material(child, v3(1, 0.3f, 0.2f), 0.9f, 0, 0, 0);
    rt_instance_desc in = rt_instance_desc_default();
    rt_plane_desc floor = rt_plane_desc_default();
    rt_world_desc w = rt_world_desc_default();
    d.color_texture = add_checker(s);
    d.ambient = 1;
    d.diffusion = 0.8f;
    d.specular = 0.2f;
    d.shininess = 40;
    OK(rt_scene_add_material(s, &d, &tiled));
    floor.normal = v3(0, 1, 0);
    floor.texture_size = 4;
    floor.common.material = tiled;
    OK(rt_scene_add_plane(s, &floor, NULL));
    add_dome(s, v3(-2, 0.2f, 1), 1, tiled);
    add_box(s, v3(1.2f, 0, 0.4f), v3(2.2f, 1, 1.4f), tiled);
    add_sphere(s, v3(0, 0.6f, 1.5f), 0.6f, tiled);
    add_round_things(s, plain);
    add_round_things(child, red);
    OK(rt_scene_commit(child, NULL));
    in.child = child;
    for (int i = -1; i <= 1; i += 2) {
        in.transform = rt_transform_multiply(
            rt_transform_translate(v3((float)i * 2.2f, 1.6f, -1.5f)),
            rt_transform_multiply(rt_transform_rotate(v3(1, 0.2f, 0), (float)i * 50), rt_transform_scale(v3(1, 1.3f, 0.8f))));
        OK(rt_scene_add_instance(s, &in, NULL));
    }
    add_light(s, light(RT_LIGHT_POINT, v3(3, 5, 6), v3(0.8f, 0.8f, 0.75f), RT_FALLOFF_NONE));
    w.ambient = v3(0.15f, 0.15f, 0.2f);
    w.background = v3(0.6f, 0.6f, 0.6f);
    w.background_top = v3(0.2f, 0.3f, 0.6f);
    OK(rt_scene_set_world(s, &w));
    look(s, v3(0.5f, 2.8f, 7), v3(0, 0.8f, 0), 40);
}

#endif
