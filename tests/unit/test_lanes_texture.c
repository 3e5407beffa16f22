/* Colours of textures, and of maps of the sky, over rows, at every instruction set this processor has, are those of single
 * lookups, to the bit. */
#include "kernel_random.h"
#include "scene_kit.h"

#include <math.h>

#include "kernel/integrate.h"
#include "render/lanes_table.h"
#include "scene/snapshot.h"

#define TEXTURES 24u
#define SIDE     40u
#define SHEAVES  4000

typedef struct lookups {
    void (*texture)(const rtk_scene *scene, rti_sheaf *sheaf);
    void (*sky)(const rtk_scene *scene, const rti_sheaf *sheaf, rti_light_lanes *light);
} lookups;

static lookups lookups_at(rti_isa isa)
{
    switch (isa) {
#define CASE(name, level)                                                                                                        \
    case level:                                                                                                                  \
        return (lookups){rti_lanes_texture_##name, rti_lanes_sky_##name};
        RTI_ISA_EACH(CASE)
#undef CASE
    default:
        return (lookups){NULL, NULL};
    }
}

/* A texture of each kind, of any size, and a material that has it. */
static void add(rt_context *ctx, rt_scene *scene, rng *r, uint32_t i)
{
    static uint8_t bytes[4 * SIDE * SIDE];
    static float floats[4 * SIDE * SIDE];
    static const rt_pixel_format formats[] = {RT_PIXEL_RGB8, RT_PIXEL_RGBA8, RT_PIXEL_RGB32F};
    rt_texture_desc d = rt_texture_desc_default();
    rt_material_desc m = rt_material_desc_default();
    rt_material id;
    for (uint32_t k = 0; k < RTI_COUNT(bytes); k++) {
        bytes[k] = (uint8_t)rng_u32(r);
        floats[k] = 100.0f * rng_unit(r);
    }
    d.width = 1 + rng_u32(r) % SIDE;
    d.height = 1 + rng_u32(r) % SIDE;
    d.format = formats[i % 3];
    d.pixels = d.format == RT_PIXEL_RGB32F ? (const void *)floats : bytes;
    d.wrap = i / 3 % 2 ? RT_WRAP_CLAMP : RT_WRAP_REPEAT;
    d.linear = i / 6 % 2 ? 1 : 0;
    d.nearest = i % 11 == 10;
    kit_ok(ctx, rt_scene_add_texture(scene, &d, &m.color_texture));
    kit_ok(ctx, rt_scene_add_material(scene, &m, &id));
}

static float coordinate(rng *r)
{
    static const float odd[] = {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, 1e-30f, -1e-30f, 1e9f, -3e38f, INFINITY, -INFINITY, NAN};
    switch (rng_u32(r) % 8) {
    case 0:
        return odd[rng_u32(r) % RTI_COUNT(odd)];
    case 1:
        return 1000.0f * rng_pm(r);
    default:
        return 3.0f * rng_pm(r);
    }
}

static float footprint(rng *r)
{
    static const float odd[] = {0.0f, -1.0f, 1e-30f, 1e30f, INFINITY, -INFINITY, NAN};
    return rng_u32(r) % 4 == 0 ? odd[rng_u32(r) % RTI_COUNT(odd)] : 2.0f * rng_unit(r) * rng_unit(r);
}

static void fill(rti_sheaf *c, rng *r, const rtk_scene *scene)
{
    const uint32_t few = 1 + rng_u32(r) % 3, first = rng_u32(r) % TEXTURES;
    memset(c, 0, sizeof *c);
    c->count = 1 + rng_u32(r) % RTK_BLOCK;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        uint32_t texture = (first + rng_u32(r) % few) % TEXTURES, m = 0;
        while (scene->materials[m].color_tex != texture)
            m++;
        c->material[k] = m;
        c->tu[k] = coordinate(r);
        c->tv[k] = coordinate(r);
        c->footprint[k] = footprint(r);
        c->uv_scale[k] = rng_u32(r) % 8 == 0 ? footprint(r) : 1.0f;
        c->spread[k] = footprint(r);
        const rtk_vec3 d = rng_u32(r) % 8 == 0 ? rtk_v3(coordinate(r), coordinate(r), coordinate(r)) : rng_dir(r);
        c->dx[k] = d.x;
        c->dy[k] = d.y;
        c->dz[k] = d.z;
        c->cr[k] = rng_unit(r);
        c->cg[k] = rng_unit(r);
        c->cb[k] = rng_unit(r);
    }
}

static void assert_same(int isa, uint32_t k, const char *of, rtk_vec3 found, rtk_vec3 wanted)
{
    if (memcmp(&found, &wanted, sizeof found) != 0)
        fail_msg("%s, level %d, lane %u: %a %a %a, not %a %a %a", of, isa, k, (double)found.x, (double)found.y, (double)found.z,
                 (double)wanted.x, (double)wanted.y, (double)wanted.z);
}

static void textures_are_right(int isa, const rtk_scene *scene, const rti_sheaf *given)
{
    rti_sheaf c = *given;
    lookups_at((rti_isa)isa).texture(scene, &c);
    for (uint32_t k = 0; k < c.count; k++) {
        const rtk_texture texture = scene->textures[scene->materials[given->material[k]].color_tex];
        const rtk_vec3 base = rtk_v3(given->cr[k], given->cg[k], given->cb[k]);
        float rgba[4];
        rtk_texture_sample(texture, given->tu[k], given->tv[k], given->footprint[k] * given->uv_scale[k], rgba);
        assert_same(isa, k, "texture", rtk_v3(c.cr[k], c.cg[k], c.cb[k]), rtk_mul(base, rtk_v3(rgba[0], rgba[1], rgba[2])));
    }
}

static void skies_are_right(int isa, const rtk_scene *scene, const rti_sheaf *c)
{
    rti_light_lanes light;
    lookups_at((rti_isa)isa).sky(scene, c, &light);
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        assert_same(isa, k, "sky", rtk_v3(light.r[k], light.g[k], light.b[k]),
                    rtk_background(scene, rtk_v3(c->dx[k], c->dy[k], c->dz[k]), c->spread[k]));
}

static void test_each_level(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rng r = {7};
    (void)state;
    for (uint32_t i = 0; i < TEXTURES; i++)
        add(ctx, scene, &r, i);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    rti_snapshot *snapshot = rti_scene_snapshot(scene);
    rtk_scene view = *rti_snapshot_view(snapshot);
    rtk_world world = *view.world;
    view.world = &world;
    for (int n = 0; n < SHEAVES; n++) {
        rti_sheaf given;
        fill(&given, &r, &view);
        world.background_tex = rng_u32(&r) % TEXTURES;
        for (int isa = 0; isa < RTI_ISA_COUNT; isa++) {
            if (!rti_isa_runs((rti_isa)isa))
                continue;
            textures_are_right(isa, &view, &given);
            skies_are_right(isa, &view, &given);
        }
    }
    rti_snapshot_release(snapshot);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_each_level)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
