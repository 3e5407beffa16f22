/* Cut-outs: whether the surface is there at a hit, by its material's alpha map. Part of the leaf test, so pure. */
#ifndef RTK_ALPHA_H
#define RTK_ALPHA_H

#include "snapshot.h"

RTK_FN rtk_u32 rtk_alpha_material(RT_GLOBAL const rtk_group *g, RT_GLOBAL const rtk_geom *geom, rtk_u32 prim, rtk_u32 placed)
{
    if (placed != RTK_INVALID)
        return placed;
    if (geom->flags & RTK_GEOM_FACE_MATERIALS)
        return ((RT_GLOBAL const rtk_u32 *)(g->attributes + geom->off_materials))[prim] + geom->material_base;
    return geom->material;
}

/* Texture coordinates as shading has them (surface.h), from the hit's u, v and, for planes, its point in the group's space. */
RTK_FN void rtk_alpha_uv(RT_GLOBAL const rtk_group *g, RT_GLOBAL const rtk_geom *geom, rtk_u32 prim, rtk_vec3 p, float *u,
                         float *v)
{
    float x = *u, y = *v;
    if (geom->type == RTK_GEOM_PLANE) {
        RT_GLOBAL const rtk_shape *plane = &g->planes[geom->first];
        rtk_vec3 d = rtk_v3(p.x - plane->p[0], p.y - plane->p[1], p.z - plane->p[2]);
        rtk_vec3 n = rtk_v3(plane->p[4], plane->p[5], plane->p[6]), a = rtk_v3(geom->t_dir[0], geom->t_dir[1], geom->t_dir[2]);
        x = rtk_dot3(d, a);
        y = rtk_dot3(d, rtk_cross3(n, a));
    } else if (geom->type == RTK_GEOM_MESH && geom->off_uvs != 0u && geom->off_indices != 0u) {
        RT_GLOBAL const rtk_u32 *index = (RT_GLOBAL const rtk_u32 *)(g->attributes + geom->off_indices) + 3u * (rtk_u64)prim;
        RT_GLOBAL const float *uvs = (RT_GLOBAL const float *)(g->attributes + geom->off_uvs);
        RT_GLOBAL const float *a = uvs + 2u * (rtk_u64)index[0], *b = uvs + 2u * (rtk_u64)index[1],
                              *c = uvs + 2u * (rtk_u64)index[2];
        x = a[0] + *u * (b[0] - a[0]) + *v * (c[0] - a[0]);
        y = a[1] + *u * (b[1] - a[1]) + *v * (c[1] - a[1]);
    }
    *u = geom->uv_xfm[0] * x + geom->uv_xfm[1] * y + geom->uv_xfm[2];
    *v = geom->uv_xfm[3] * x + geom->uv_xfm[4] * y + geom->uv_xfm[5];
}

RTK_FN rtk_u32 rtk_alpha_texel(float x, rtk_u32 size, rtk_u32 flags)
{
    float f = flags & RTK_TEX_CLAMP ? rtk_clamp(x, 0.0f, 1.0f) : x - rtk_floor(x);
    float at = f * (float)size;
    return at > 0.0f ? rtk_umin((rtk_u32)rtk_min(at, 1.0e9f), size - 1u) : 0u;
}

/* The nearest texel of the finest level: its alpha, or its grey when the picture has none. */
RTK_FN float rtk_alpha_at(rtk_texture tex, float u, float v)
{
    RT_GLOBAL const rtk_u8 *base = (RT_GLOBAL const rtk_u8 *)tex.head + tex.head->off_level[0];
    rtk_u32 w = tex.head->width, flags = tex.head->flags, channel = flags & RTK_TEX_ALPHA ? 3u : 1u;
    rtk_u32 x = rtk_alpha_texel(u, w, flags), y = rtk_alpha_texel(v, tex.head->height, flags);
    rtk_u64 tile = (rtk_u64)(y / 8u) * ((w + 7u) / 8u) + x / 8u, i = 4u * (tile * 64u + (y % 8u) * 8u + x % 8u) + channel;
    return flags & RTK_TEX_FLOAT ? ((RT_GLOBAL const float *)base)[i] : (float)base[i] / 255.0f;
}

/* placed: the instance's material, or RTK_INVALID. */
RTK_COLD int rtk_alpha_solid(const rtk_scene *s, RT_GLOBAL const rtk_group *g, rtk_u32 geom_index, rtk_u32 prim, rtk_u32 placed,
                             rtk_vec3 p, float u, float v)
{
    RT_GLOBAL const rtk_geom *geom = &g->geoms[geom_index];
    rtk_u32 id = rtk_alpha_material(g, geom, prim, placed);
    if (id >= s->material_count || s->materials[id].alpha_tex >= s->texture_count)
        return 1;
    rtk_alpha_uv(g, geom, prim, p, &u, &v);
    return !(rtk_alpha_at(s->textures[s->materials[id].alpha_tex], u, v) < s->materials[id].alpha_cut);
}

#endif
