/* Uses the library as a ray caster: own rays, own camera, own shading; only the intersections are librt's. A heap of balls is lit
 * from the upper left: rt_scene_intersect gives the nearest hits of a whole row, rt_scene_surface the normals, rt_scene_occluded
 * the shadows. usage: trace_rays [WIDTHxHEIGHT [FILE]] */
#include "arguments.h"

#include <math.h>

enum { BALLS = 400 };
static const rt_vec3 to_light = {-0.48f, 0.6f, 0.64f}; /* unit */

/* A spiral on a hemisphere: every ball touches its neighbours' places, none is random. */
static void describe(rt_scene *scene)
{
    float centers[3 * BALLS];
    rt_spheres_desc balls = rt_spheres_desc_default();
    for (int i = 0; i < BALLS; ++i) {
        float y = (i + 0.5f) / BALLS, r = sqrtf(1 - y * y), angle = 2.3999632f * (float)i;
        centers[3 * i] = r * cosf(angle);
        centers[3 * i + 1] = y;
        centers[3 * i + 2] = r * sinf(angle);
    }
    balls.centers = centers; /* copied by the call */
    balls.count = BALLS;
    balls.radius = 0.085f;
    must(rt_scene_context(scene), rt_scene_add_spheres(scene, &balls, NULL));

    rt_plane_desc floor = rt_plane_desc_default();
    floor.normal = (rt_vec3){0, 1, 0};
    must(rt_scene_context(scene), rt_scene_add_plane(scene, &floor, NULL));
    must(rt_scene_context(scene), rt_scene_commit(scene, NULL));
}

static float dot(rt_vec3 a, rt_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* One row: its camera rays together, then its shadow rays together. Batches are what makes tracing fast. */
static void shade_row(const rt_scene *scene, const rt_image *image, uint32_t y, rt_ray *rays, rt_hit *hits, uint8_t *dark,
                      float *out)
{
    uint32_t width = rt_image_width(image), height = rt_image_height(image);
    for (uint32_t x = 0; x < width; ++x) {
        float u = (2 * ((float)x + 0.5f) - (float)width) / (float)height, v = 1 - 2 * ((float)y + 0.5f) / (float)height;
        rays[x] = (rt_ray){{0, 1.3f, 3.1f}, 0, {0.46f * u, 0.46f * v - 0.26f, -1}, INFINITY, RT_MASK_ALL};
    }
    rt_scene_intersect(scene, rays, hits, width);
    for (uint32_t x = 0; x < width; ++x) {
        rt_surface at;
        float *pixel = out + 4 * (size_t)x;
        pixel[0] = 0.75f - 0.9f * rays[x].dir.y; /* the sky */
        pixel[1] = 0.85f - 0.6f * rays[x].dir.y;
        pixel[2] = 0.95f;
        pixel[3] = 1;
        if (hits[x].geom_id == RT_INVALID_ID)
            continue;
        rt_scene_surface(scene, &rays[x], &hits[x], &at);
        float lit = fmaxf(0, dot(at.ns, to_light)), tone = hits[x].geom_id == 0 ? (float)at.face_id / BALLS : 0.5f;
        pixel[0] = lit * (0.4f + 0.6f * tone);
        pixel[1] = lit * 0.75f;
        pixel[2] = lit * (1 - 0.6f * tone);
        /* The shadow ray starts where rounding cannot put it below the surface: the library says how wide that is. */
        float step = 4 * at.position_error;
        rays[x].org = (rt_vec3){at.position.x + step * at.ng.x, at.position.y + step * at.ng.y, at.position.z + step * at.ng.z};
        rays[x].dir = to_light;
    }
    rt_scene_occluded(scene, rays, dark, width);
    for (uint32_t x = 0; x < width; ++x)
        for (int c = 0; c < 3 && hits[x].geom_id != RT_INVALID_ID; ++c)
            out[4 * (size_t)x + c] = out[4 * (size_t)x + c] * (dark[x] ? 0.25f : 1) + 0.02f;
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){800, 600, "trace_rays.png"});
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    must(NULL, rt_context_create(NULL, &context));
    must(context, rt_scene_create(context, &scene));
    describe(scene);
    must(context, rt_image_create(context, a.width, a.height, &image));

    rt_ray *rays = malloc(a.width * sizeof *rays);
    rt_hit *hits = malloc(a.width * sizeof *hits);
    uint8_t *dark = malloc(a.width);
    if (!rays || !hits || !dark)
        must(NULL, RT_ERROR_MEMORY);
    for (uint32_t y = 0; y < a.height; ++y)
        shade_row(scene, image, y, rays, hits, dark, rt_image_pixels(image) + 4 * (size_t)a.width * y);
    must(context, rt_image_save(image, a.path, NULL));
    printf("%s: %u balls\n", a.path, (unsigned)BALLS);

    free(dark);
    free(hits);
    free(rays);
    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return 0;
}
