/* What is at sixteen hits in instances that stand still: as what it is in their groups (lanes_surface.c), and then placed, as
 * rtk_surface_at does both. */
#include <stddef.h>

#include "../base/simd.h"
#include "../kernel/surface.h"
#include "lanes.h"
#include "lanes_rows.h"
#include "lanes_table.h"

/* The maps of the lanes' instances, row by row: to the world, and to the object. */
typedef struct maps {
    float world[12][RTK_BLOCK] RTI_ROW, object[12][RTK_BLOCK] RTI_ROW;
} maps;
_Static_assert(offsetof(rtk_instance, to_world) == 0 && offsetof(rtk_instance, to_object) == sizeof(rtk_xfm),
               "one behind the other");

static rtk_xfm map_of(const float (*rows)[RTK_BLOCK], uint32_t k)
{
    const rtk_xfm m = {{rows[0][k], rows[1][k], rows[2][k], rows[3][k], rows[4][k], rows[5][k], rows[6][k], rows[7][k],
                        rows[8][k], rows[9][k], rows[10][k], rows[11][k]}};
    return m;
}

static void load_maps(const rtk_scene *scene, const rti_sheaf *c, maps *m)
{
    const float *from[RTK_BLOCK];
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        from[k] = (const float *)(const void *)&scene->instances[c->inst[k]];
    for (uint32_t i = 0; i < 24; i += 4) {
        rti_rows4(from, i < 12 ? m->world + i : m->object + (i - 12));
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            from[k] += 4;
    }
}

/* Rays into the spaces of their instances. */
RTI_LANES_FN static void rays_in(const maps *m, rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        const rtk_xfm w = map_of(m->object, k);
        const rtk_vec3 o = rtk_xfm_point(w, rtk_v3(c->ox[k], c->oy[k], c->oz[k]));
        const rtk_vec3 d = rtk_xfm_dir(w, rtk_v3(c->dx[k], c->dy[k], c->dz[k]));
        c->ox[k] = o.x;
        c->oy[k] = o.y;
        c->oz[k] = o.z;
        c->dx[k] = d.x;
        c->dy[k] = d.y;
        c->dz[k] = d.z;
    }
}

/* rtk_place_scale */
RTI_LANES_FN static void place_scales(const maps *m, rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    c->uv_scale[k] = rtk_place_scale(map_of(m->world, k), rtk_v3(c->gx[k], c->gy[k], c->gz[k]), c->uv_scale[k]);
}

RTI_LANES_FN static void place_points(const maps *m, rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 p = rtk_v3(c->px[k], c->py[k], c->pz[k]);
        c->error[k] = rtk_place_point(map_of(m->world, k), map_of(m->object, k), c->error[k], &p);
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
    }
}

/* The geometric normals alone, which are the others, too. */
RTI_LANES_FN static void place_normals(const maps *m, rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 g = rtk_xfm_normal(map_of(m->object, k), rtk_v3(c->gx[k], c->gy[k], c->gz[k]));
        c->plain[k] &= (uint32_t)rtk_unit_is_plain(rtk_maxabs(g));
        g = rtk_unit_plain(g);
        c->gx[k] = c->nx[k] = g.x;
        c->gy[k] = c->ny[k] = g.y;
        c->gz[k] = c->nz[k] = g.z;
    }
}

RTI_LANES_FN static void place_both_normals(const maps *m, rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        const rtk_xfm w = map_of(m->object, k);
        const rtk_vec3 ng = rtk_v3(c->gx[k], c->gy[k], c->gz[k]), ns = rtk_v3(c->nx[k], c->ny[k], c->nz[k]);
        const int same = (ng.x == ns.x) & (ng.y == ns.y) & (ng.z == ns.z);
        rtk_vec3 g = rtk_xfm_normal(w, ng), s = rtk_xfm_normal(w, ns);
        c->plain[k] &= (uint32_t)(rtk_unit_is_plain(rtk_maxabs(g)) & (same | rtk_unit_is_plain(rtk_maxabs(s))));
        g = rtk_unit_plain(g);
        s = rtk_unit_plain(s);
        c->gx[k] = g.x;
        c->gy[k] = g.y;
        c->gz[k] = g.z;
        c->nx[k] = same ? g.x : s.x;
        c->ny[k] = same ? g.y : s.y;
        c->nz[k] = same ? g.z : s.z;
    }
}

/* Rows of a sheaf from one field on. */
static float *rows_at(rti_sheaf *c, size_t field)
{
    return (float *)(void *)((char *)c + field);
}

/* All lanes; their instances are of one group. */
static void place(const rtk_scene *scene, rti_sheaf *c)
{
    const uint32_t kind = c->surface_kind - RTI_SURFACE_PLACED + RTI_SURFACE_MESH;
    const bool by_ray = kind == RTI_SURFACE_SPHERE || kind == RTI_SURFACE_BOX || kind == RTI_SURFACE_CONE;
    float ray[6 * RTK_BLOCK] RTI_ROW;
    maps m;
    load_maps(scene, c, &m);
    if (by_ray) {
        memcpy(ray, rows_at(c, offsetof(rti_sheaf, ox)), sizeof ray);
        rays_in(&m, c);
    }
    RTI_ISA_FN(rti_lanes_body)(&scene->groups[scene->instances[c->inst[0]].group], kind, c);
    if (by_ray)
        memcpy(rows_at(c, offsetof(rti_sheaf, ox)), ray, sizeof ray);
    if (c->material_kind >= RTI_LOOK_TEXTURED)
        place_scales(&m, c);
    place_points(&m, c);
    if (kind == RTI_SURFACE_SMOOTH)
        place_both_normals(&m, c);
    else
        place_normals(&m, c);
}

/* Lanes as one of them, where another group is not to be asked for them. */
static void stand_in(const rti_sheaf *from, const uint32_t *lane, rti_sheaf *c)
{
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        c->prim[k] = from->prim[lane[k]];
        c->geom[k] = from->geom[lane[k]];
        c->inst[k] = from->inst[lane[k]];
    }
}

/* What is there, of the lanes in `some`. */
static void put_some(rti_sheaf *c, const uint32_t *some, const rti_sheaf *from)
{
    const float *in = (const float *)(const void *)((const char *)from + offsetof(rti_sheaf, px));
    float *out = rows_at(c, offsetof(rti_sheaf, px));
    for (uint32_t r = 0; r < (offsetof(rti_sheaf, footprint) - offsetof(rti_sheaf, px)) / sizeof c->px; r++) {
        RTI_EACH_LANE(k)
        out[r * RTK_BLOCK + k] = some[k] ? in[r * RTK_BLOCK + k] : out[r * RTK_BLOCK + k];
    }
    RTI_EACH_LANE(k)
    c->plain[k] = some[k] ? from->plain[k] : c->plain[k];
}

/* Lanes of one group that are worth all sixteen; fewer are told one by one. */
#define PLACED_LANES 5

void RTI_ISA_FN(rti_lanes_placed)(const rtk_scene *scene, rti_sheaf *c)
{
    uint32_t group[RTK_BLOCK] RTI_ROW, left = (1u << RTK_BLOCK) - 1;
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        group[k] = scene->instances[c->inst[k]].group;
    if (rti_u32_unlike(group, group[0]) == 0) {
        place(scene, c);
        return;
    }
    memset(c->plain, 0, sizeof c->plain);
    while (left != 0) { /* group after group */
        const uint32_t first = (uint32_t)__builtin_ctz(left);
        uint32_t some[RTK_BLOCK] RTI_ROW, lane[RTK_BLOCK] RTI_ROW, lanes;
        RTI_EACH_LANE(k)
        {
            some[k] = group[k] == group[first];
            lane[k] = some[k] ? k : first;
        }
        lanes = rti_lanes_of(some, RTK_BLOCK);
        left &= ~lanes;
        if (__builtin_popcount(lanes) >= PLACED_LANES) {
            rti_sheaf of_one = *c;
            stand_in(c, lane, &of_one);
            place(scene, &of_one);
            put_some(c, some, &of_one);
        }
    }
}
