/* Colours of textures over rows, at every instruction set this processor has, are those of one lookup after another, to the bit.
 */
#include "kernel_random.h"
#include "scene_kit.h"

#include <math.h>

#include "kernel/texture.h"
#include "render/lanes_table.h"
#include "scene/snapshot.h"

#define TEXTURES 24u
#define SIDE     40u
#define SHEAVES  4000

typedef void lookup(const rtk_scene *scene, rti_sheaf *sheaf);

static lookup *lookup_at(rti_isa isa)
{
    switch (isa) {
#define CASE(name, level)                                                                                                        \
    case level:                                                                                                                  \
        return rti_lanes_texture_##name;
        RTI_ISA_EACH(CASE)
#undef CASE
    default:
        return NULL;
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
        c->cr[k] = rng_unit(r);
        c->cg[k] = rng_unit(r);
        c->cb[k] = rng_unit(r);
    }
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
    const rtk_scene *view = rti_snapshot_view(snapshot);
    for (int n = 0; n < SHEAVES; n++) {
        rti_sheaf given;
        fill(&given, &r, view);
        for (int isa = 0; isa < RTI_ISA_COUNT; isa++) {
            rti_sheaf c = given;
            if (!rti_isa_runs((rti_isa)isa))
                continue;
            lookup_at((rti_isa)isa)(view, &c);
            for (uint32_t k = 0; k < c.count; k++) {
                const float found[3] = {c.cr[k], c.cg[k], c.cb[k]};
                float rgba[4];
                rtk_texture_sample(view->textures[view->materials[given.material[k]].color_tex], given.tu[k], given.tv[k],
                                   given.footprint[k] * given.uv_scale[k], rgba);
                const float wanted[3] = {given.cr[k] * rgba[0], given.cg[k] * rgba[1], given.cb[k] * rgba[2]};
                if (memcmp(found, wanted, sizeof found) != 0)
                    fail_msg("level %d, lane %u at (%g, %g) over %g: %g %g %g, not %g %g %g", isa, k, (double)given.tu[k],
                             (double)given.tv[k], (double)given.footprint[k] * (double)given.uv_scale[k], (double)found[0],
                             (double)found[1], (double)found[2], (double)wanted[0], (double)wanted[1], (double)wanted[2]);
            }
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
