/* Colours of textures at sixteen hits, and of the sky where sixteen rays miss: rtk_texture_sample of kernel/texture.h over rows,
 * texture after texture, of which a sheaf mostly has one. Where texels stand is found in vectors, all of a level's are loaded
 * before one is decoded, for they wait for memory, and they are mixed in vectors. Alpha is not asked for. */
#include "lanes.h"
#include "lanes_rows.h"
#include "lanes_table.h"

#include "../kernel/integrate.h"

#define FEW 4 /* fewer lanes of a texture are looked up singly: of many textures a sheaf has several */

/* Of each lane's place along one side of a level, as rtk_texture_pair has it. */
typedef struct pair {
    uint32_t low[RTK_BLOCK] RTI_ROW, high[RTK_BLOCK] RTI_ROW;
    float weight[RTK_BLOCK] RTI_ROW;
} pair;

/* Where they are looked up. */
typedef struct lookups {
    float u[RTK_BLOCK] RTI_ROW, v[RTK_BLOCK] RTI_ROW, footprint[RTK_BLOCK] RTI_ROW;
} lookups;

typedef struct colors {
    float row[3][RTK_BLOCK] RTI_ROW;
} colors;

/* Each lane's finer level, and the coarser one's weight. */
RTI_LANES_FN static void levels(rtk_texture tex, const lookups *l, uint32_t *level, float *weight)
{
    const float last = (float)(tex.head->level_count - 1u);
    RTI_EACH_LANE(k)
    {
        const float at = rtk_min(rtk_texture_level(tex, l->footprint[k]), last);
        const int32_t low = (int32_t)at; /* few: signed ones are vectors everywhere */
        level[k] = (uint32_t)low;
        weight[k] = at - (float)low;
    }
}

/* Of coordinates along one side. */
RTI_LANES_FN static void pairs(uint32_t side, uint32_t flags, const uint32_t *level, const float *at, pair *p)
{
    float within[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    within[k] = rtk_texture_wrap(at[k], flags);
    RTI_EACH_LANE(k)
    {
        const uint32_t size = rtk_level_size(side, level[k]);
        p->weight[k] = rtk_texture_pair(within[k] * (float)(int32_t)size - 0.5f, size, flags, &p->low[k], &p->high[k]);
    }
}

RTI_LANES_FN static void places(uint32_t width, const uint32_t *level, const pair *x, const pair *y, uint32_t at[4][RTK_BLOCK])
{
    RTI_EACH_LANE(k)
    {
        const uint32_t w = rtk_level_size(width, level[k]);
        at[0][k] = rtk_texel_index(w, x->low[k], y->low[k]);
        at[1][k] = rtk_texel_index(w, x->high[k], y->low[k]);
        at[2][k] = rtk_texel_index(w, x->low[k], y->high[k]);
        at[3][k] = rtk_texel_index(w, x->high[k], y->high[k]);
    }
}

/* Bytes of texels, as rtk_texel decodes them. */
static void decode(const rtk_u8 *texel, colors *out)
{
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        for (uint32_t i = 0; i < 3; i++)
            out->row[i][k] = rtk_srgb_table[texel[4 * k + i]];
}

RTI_LANES_FN static void scale(const rtk_u8 *texel, colors *out)
{
    for (uint32_t i = 0; i < 3; i++) {
        RTI_EACH_LANE_INNER(k)
        out->row[i][k] = (float)texel[4 * k + i] / 255.0f;
    }
}

/* What stands at places of a level: floats, */
static void fetch_floats(rtk_texture tex, const uint32_t *level, uint32_t at[4][RTK_BLOCK], colors four[4])
{
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const rtk_u8 *base = (const rtk_u8 *)tex.head + tex.head->off_level[level[k]];
        for (uint32_t j = 0; j < 4; j++) {
            const float *f = (const float *)(const void *)base + 4 * (size_t)at[j][k];
            for (uint32_t i = 0; i < 3; i++)
                four[j].row[i][k] = f[i];
        }
    }
}

/* or bytes, which are loaded all before one is asked for. */
static void fetch_bytes(rtk_texture tex, const uint32_t *level, uint32_t at[4][RTK_BLOCK], colors four[4])
{
    rtk_u8 texel[4][4 * RTK_BLOCK] RTI_ROW;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const rtk_u8 *base = (const rtk_u8 *)tex.head + tex.head->off_level[level[k]];
        for (uint32_t j = 0; j < 4; j++)
            memcpy(&texel[j][4 * k], base + 4 * (size_t)at[j][k], 4);
    }
    if (tex.head->flags & RTK_TEX_SRGB) {
        for (uint32_t j = 0; j < 4; j++)
            decode(texel[j], &four[j]);
    } else {
        for (uint32_t j = 0; j < 4; j++)
            scale(texel[j], &four[j]);
    }
}

RTI_LANES_FN static void mix(const float *fx, const float *fy, const colors four[4], colors *out)
{
    for (uint32_t i = 0; i < 3; i++) {
        RTI_EACH_LANE_INNER(k)
        {
            out->row[i][k] =
                rtk_texture_mix(four[0].row[i][k], four[1].row[i][k], four[2].row[i][k], four[3].row[i][k], fx[k], fy[k]);
        }
    }
}

static void bilinear(rtk_texture tex, const lookups *l, rtk_texture_wraps wraps, const uint32_t *level, colors *out)
{
    uint32_t at[4][RTK_BLOCK] RTI_ROW; /* of the four around a place, in the order of rtk_texture_bilinear */
    colors four[4];
    pair x, y;
    pairs(tex.head->width, wraps.u, level, l->u, &x);
    pairs(tex.head->height, wraps.v, level, l->v, &y);
    places(tex.head->width, level, &x, &y, at);
    if (tex.head->flags & RTK_TEX_FLOAT)
        fetch_floats(tex, level, at, four);
    else
        fetch_bytes(tex, level, at, four);
    mix(x.weight, y.weight, four, out);
}

/* The coarser level's colours into the finer one's, where they have a weight. */
RTI_LANES_FN static void blend(colors *fine, const colors *coarse, const float *weight)
{
    for (uint32_t i = 0; i < 3; i++) {
        RTI_EACH_LANE_INNER(k)
        {
            const float at = fine->row[i][k], both = at + weight[k] * (coarse->row[i][k] - at);
            fine->row[i][k] = weight[k] > 0.0f ? both : at;
        }
    }
}

static void filtered(rtk_texture tex, const lookups *l, rtk_texture_wraps wraps, colors *out)
{
    const uint32_t last = tex.head->level_count - 1u;
    uint32_t level[RTK_BLOCK] RTI_ROW, between = 0;
    float weight[RTK_BLOCK] RTI_ROW;
    colors coarse;
    levels(tex, l, level, weight);
    bilinear(tex, l, wraps, level, out);
    RTI_EACH_LANE(k)
    between |= (uint32_t)(weight[k] > 0.0f);
    if (between == 0)
        return;
    RTI_EACH_LANE(k)
    level[k] = level[k] < last ? level[k] + 1u : last;
    bilinear(tex, l, wraps, level, &coarse);
    blend(out, &coarse, weight);
}

/* Lane after lane. */
static void singly(rtk_texture tex, const lookups *l, rtk_texture_wraps wraps, uint32_t lanes, colors *out)
{
    for (; lanes != 0; lanes &= lanes - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(lanes);
        float rgba[4];
        rtk_texture_sample_wrapped(tex, l->u[k], l->v[k], l->footprint[k], wraps, rgba);
        for (uint32_t i = 0; i < 3; i++)
            out->row[i][k] = rgba[i];
    }
}

/* At chosen lanes; at others anything. */
static void find(rtk_texture tex, const lookups *l, rtk_texture_wraps wraps, uint32_t lanes, colors *out)
{
    if (tex.head->flags & RTK_TEX_NEAREST || __builtin_popcount(lanes) < FEW)
        singly(tex, l, wraps, lanes, out);
    else
        filtered(tex, l, wraps, out);
}

/* The materials' colours, which the rows have, times their textures'. */
void RTI_ISA_FN(rti_lanes_texture)(const rtk_scene *scene, rti_sheaf *c)
{
    uint32_t texture[RTK_BLOCK] RTI_ROW, left = (1u << c->count) - 1;
    lookups l;
    memcpy(l.u, c->tu, sizeof l.u);
    memcpy(l.v, c->tv, sizeof l.v);
    RTI_EACH_LANE(k)
    l.footprint[k] = c->footprint[k] * c->uv_scale[k];
    for (uint32_t k = 0; k < RTK_BLOCK; k++) /* of lanes behind the last, as of the first */
        texture[k] = scene->materials[c->material[k < c->count ? k : 0]].color_tex;
    colors found = {{{0.0f}}};
    while (left != 0) {
        const uint32_t one = texture[__builtin_ctz(left)], others = rti_u32_unlike(texture, one);
        find(scene->textures[one], &l, rtk_texture_wraps_of(scene->textures[one]), left & ~others, &found);
        left &= others;
        RTI_EACH_LANE_INNER(k)
        {
            const bool its = texture[k] == one;
            c->cr[k] *= its ? found.row[0][k] : 1.0f;
            c->cg[k] *= its ? found.row[1][k] : 1.0f;
            c->cb[k] *= its ? found.row[2][k] : 1.0f;
        }
    }
}

RTI_LANES_FN static void directions(const rti_sheaf *c, lookups *l)
{
    RTI_EACH_LANE(k)
    {
        const rtk_vec3 d = rtk_v3(c->dx[k], c->dy[k], c->dz[k]);
        l->u[k] = rtk_sky_u(d);
        l->v[k] = rtk_sky_v(d);
        l->footprint[k] = rtk_sky_footprint(c->spread[k]);
    }
}

/* What a map of the sky has in the rays' directions: rtk_background. */
void RTI_ISA_FN(rti_lanes_sky)(const rtk_scene *scene, const rti_sheaf *c, rti_light_lanes *light)
{
    lookups l;
    colors found;
    directions(c, &l);
    find(scene->textures[scene->world->background_tex], &l, rtk_sky_wraps(), (1u << RTK_BLOCK) - 1, &found);
    memcpy(light->r, found.row[0], sizeof light->r);
    memcpy(light->g, found.row[1], sizeof light->g);
    memcpy(light->b, found.row[2], sizeof light->b);
}
