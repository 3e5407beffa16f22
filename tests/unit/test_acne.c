/* No acne, at any scale and place: with a point light in the camera's eye, whatever the camera sees is lit, so a picture with
 * shadows is the picture without, bit for bit. For convex bodies that holds exactly; a mesh with folds may lose a pixel where a
 * shadow ray, which starts beside the camera ray's hit, grazes a fold. The bodies are scaled by 10^-3 and 10^6 and moved by 10^4
 * of their extents. There a coordinate has 10^-3 of an extent left to it, the bound of a hit's error is some percent of the body,
 * and a ray that starts beside one of its rims may be on the wrong side of the other surface: such a rim may lose two pixels. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <librt/rt.h>

typedef struct place {
    float scale, shift;
} place;

static const place places[] = {{1, 0}, {1e-3f, 0}, {1e6f, 0}, {1, 1e4f}, {1e-3f, 10}, {1e6f, 1e10f}};

static float at(place p, float x)
{
    return p.scale * x + p.shift;
}
static rt_vec3 at3(place p, float x, float y, float z)
{
    return (rt_vec3){at(p, x), at(p, y), at(p, z)};
}

enum { SPHERE, BOX, CYLINDER, CONE, TORUS, ICOSPHERE, BODY_COUNT };
static const char *const names[] = {"sphere", "box", "cylinder", "cone", "torus", "icosphere"};

/* A sphere of 20 * 4^3 triangles by splitting an octahedron's faces (a convex body). */
static rt_status add_icosphere(rt_scene *scene, place p)
{
    enum { N = 24 };
    static float positions[8 * (N + 1) * (N + 1) * 3];
    static uint32_t indices[8 * N * N * 6];
    uint32_t vertices = 0, corners = 0;
    for (unsigned octant = 0; octant < 8; octant++) {
        uint32_t first = vertices;
        for (unsigned i = 0; i <= N; i++) {
            for (unsigned j = 0; j <= N - i; j++) {
                float x = (float)i, y = (float)j, z = (float)(N - i - j), l = sqrtf(x * x + y * y + z * z);
                positions[3 * vertices] = at(p, (octant & 1 ? -x : x) / l);
                positions[3 * vertices + 1] = at(p, (octant & 2 ? -y : y) / l);
                positions[3 * vertices + 2] = at(p, (octant & 4 ? -z : z) / l);
                vertices++;
            }
        }
        uint32_t row = first;
        for (unsigned i = 0; i < N; i++) {
            uint32_t length = N - i + 1, next = row + length;
            for (unsigned j = 0; j + 1 < length; j++) {
                uint32_t a = row + j, b = row + j + 1, c = next + j;
                indices[corners++] = a, indices[corners++] = b, indices[corners++] = c;
                if (j + 2 < length)
                    indices[corners++] = b, indices[corners++] = c + 1, indices[corners++] = c;
            }
            row = next;
        }
    }
    rt_mesh_desc d = rt_mesh_desc_default();
    d.positions = positions;
    d.vertex_count = vertices;
    d.indices = indices;
    d.triangle_count = corners / 3;
    return rt_scene_add_mesh(scene, &d, NULL);
}

static rt_status add_body(rt_scene *scene, unsigned body, place p)
{
    switch (body) {
    case SPHERE: {
        rt_sphere_desc d = rt_sphere_desc_default();
        d.center = at3(p, 0, 0, 0);
        d.radius = p.scale;
        return rt_scene_add_sphere(scene, &d, NULL);
    }
    case BOX: {
        rt_box_desc d = rt_box_desc_default();
        d.low = at3(p, -0.7f, -0.6f, -0.8f);
        d.high = at3(p, 0.7f, 0.8f, 0.5f);
        return rt_scene_add_box(scene, &d, NULL);
    }
    case CYLINDER:
    case CONE: {
        rt_cone_desc d = rt_cone_desc_default();
        d.from = at3(p, -0.2f, -0.8f, 0.1f);
        d.to = at3(p, 0.3f, 0.7f, -0.2f);
        d.radius0 = 0.6f * p.scale;
        d.radius1 = 0.2f * p.scale;
        return body == CYLINDER ? rt_scene_add_cylinder(scene, &d, NULL) : rt_scene_add_cone(scene, &d, NULL);
    }
    case TORUS: {
        rt_torus_desc d = rt_torus_desc_default();
        d.center = at3(p, 0, 0, 0);
        d.axis = (rt_vec3){0.2f, 0.3f, 1};
        d.major_radius = 0.7f * p.scale;
        d.minor_radius = 0.25f * p.scale;
        return rt_scene_add_torus(scene, &d, NULL);
    }
    default:
        return add_icosphere(scene, p);
    }
}

static void render_pair(rt_scene *scene, uint32_t size, rt_image *images[2])
{
    for (int shadows = 0; shadows < 2; shadows++) {
        rt_render_desc r = rt_render_desc_default();
        r.width = r.height = size;
        r.samples = 1;
        r.shadows = shadows;
        assert_int_equal(rt_render(scene, &r, &images[shadows]), RT_OK);
    }
}

static void test_bodies(void **state)
{
    (void)state;
    for (unsigned body = 0; body < BODY_COUNT; body++) {
        for (unsigned k = 0; k < sizeof places / sizeof places[0]; k++) {
            place p = places[k];
            rt_context *ctx;
            rt_scene *scene;
            rt_image *images[2];
            rt_image_difference difference;
            rt_camera_desc camera = rt_camera_desc_default();
            rt_light_desc light = rt_light_desc_default();
            assert_int_equal(rt_context_create(NULL, &ctx), RT_OK);
            assert_int_equal(rt_scene_create(ctx, &scene), RT_OK);
            assert_int_equal(add_body(scene, body, p), RT_OK);
            camera.eye = at3(p, 1.5f, 2.5f, 4);
            camera.look_at = at3(p, 0, 0, 0);
            camera.fov_deg = 30;
            light.at = camera.eye;
            assert_int_equal(rt_scene_set_camera(scene, &camera), RT_OK);
            assert_int_equal(rt_scene_add_light(scene, &light, NULL), RT_OK);
            assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
            render_pair(scene, 200, images);
            assert_int_equal(rt_image_compare(images[0], images[1], &difference, NULL), RT_OK);
            if (difference.differing_pixels)
                print_message("%s, scale %g, moved by %g: %llu pixels of 40000 are shadowed by themselves\n", names[body],
                              (double)p.scale, (double)p.shift, (unsigned long long)difference.differing_pixels);
            assert_true(difference.differing_pixels <= (p.shift == 0 ? 0 : 2));
            /* and something is seen at all */
            double sum = 0;
            for (int i = 0; i < 200 * 200; i++)
                sum += (double)rt_image_pixels(images[1])[4 * i];
            assert_true(sum > 2000);
            rt_image_destroy(images[0]);
            rt_image_destroy(images[1]);
            rt_scene_destroy(scene);
            rt_context_destroy(ctx);
        }
    }
}

static void test_real(void **state)
{
    (void)state;
    static const struct {
        const char *file;
        rt_vec3 eye, look_at;
        float fov;
    } views[] = {{"bunny.ply", {-0.0168f, 0.125f, 0.33f}, {-0.0168f, 0.108f, 0}, 35},
                 {"sponza.ply", {14.4499f, 6.89415f, -1.18547f}, {13.4563f, 6.78438f, -1.15861f}, 74},
                 {"sibenik.ply", {24, 3, 0}, {0, 4, 0}, 60}};
    const char *folder = getenv("LIBRT_SCENES");
    for (unsigned i = 0; i < sizeof views / sizeof views[0]; i++) {
        char path[1024];
        rt_context *ctx;
        rt_scene *scene;
        rt_image *images[2];
        rt_image_difference difference;
        rt_camera_desc camera = rt_camera_desc_default();
        rt_light_desc light = rt_light_desc_default();
        FILE *f;
        snprintf(path, sizeof path, "%s/%s", folder ? folder : "../shared/scenes", views[i].file);
        if (!(f = fopen(path, "rb"))) {
            print_message("%s is not there: skipped\n", path);
            continue;
        }
        fclose(f);
        assert_int_equal(rt_context_create(NULL, &ctx), RT_OK);
        assert_int_equal(rt_scene_create(ctx, &scene), RT_OK);
        assert_int_equal(rt_scene_import(scene, path, NULL, NULL), RT_OK);
        camera.eye = light.at = views[i].eye;
        camera.look_at = views[i].look_at;
        camera.fov_deg = views[i].fov;
        assert_int_equal(rt_scene_set_camera(scene, &camera), RT_OK);
        assert_int_equal(rt_scene_add_light(scene, &light, NULL), RT_OK);
        assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
        render_pair(scene, 400, images);
        assert_int_equal(rt_image_compare(images[0], images[1], &difference, NULL), RT_OK);
        print_message("%s: %llu pixels of 160000 shadowed\n", views[i].file, (unsigned long long)difference.differing_pixels);
        assert_true(difference.differing_pixels <= 16); /* 10^-4: folds seen edge-on */
        rt_image_destroy(images[0]);
        rt_image_destroy(images[1]);
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bodies), cmocka_unit_test(test_real)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
