/* The hits of a batch by what they need: counting-sorted, and taken out of the batch sixteen at a time. */
#include "lanes.h"
#include "lanes_film.h"
#include "lanes_rows.h"
#include "lanes_table.h"
#include "shade.h"

#define KEYS (RTI_SURFACE_COUNT * RTI_LOOK_COUNT)
_Static_assert(KEYS <= 256 && RTK_BLOCK == 16, "a key is a byte, a block's are two words");

/* Kinds, a bit each: a batch has few of them. */
typedef struct kinds_seen {
    uint64_t words[(KEYS + 63) / 64];
} kinds_seen;

static void see(kinds_seen *seen, uint32_t key)
{
    seen->words[key / 64] |= (uint64_t)1 << key % 64;
}

/* The least of them, which is taken out; KEYS: there is none. */
static uint32_t next_kind(kinds_seen *seen)
{
    for (uint32_t i = 0; i < RTI_COUNT(seen->words); i++)
        if (seen->words[i] != 0) {
            const uint32_t key = 64 * i + (uint32_t)__builtin_ctzll(seen->words[i]);
            seen->words[i] &= seen->words[i] - 1;
            return key;
        }
    return KEYS;
}

static uint32_t look_of(const rtk_scene *scene, uint32_t material)
{
    const rtk_material *m = &scene->materials[material];
    if (m->type == RTK_MATERIAL_EMISSIVE)
        return RTI_LOOK_EMISSIVE;
    return m->color_tex == RTK_INVALID ? RTI_LOOK_PLAIN : RTI_LOOK_TEXTURED + m->color_tex % RTI_LOOK_TEXTURES;
}

static uint32_t surface_of(const rtk_group *g, const rtk_geom *geom, uint32_t prim)
{
    if (geom->type == RTK_GEOM_MESH)
        return geom->off_normals | geom->off_colors | geom->off_uvs ? RTI_SURFACE_SMOOTH : RTI_SURFACE_MESH;
    if (geom->type == RTK_GEOM_PLANE)
        return RTI_SURFACE_PLANE;
    switch (g->shapes[geom->first + prim].type) {
    case RTK_SHAPE_SPHERE:
        return RTI_SURFACE_SPHERE;
    case RTK_SHAPE_BOX:
        return RTI_SURFACE_BOX;
    case RTK_SHAPE_CYLINDER:
    case RTK_SHAPE_CONE:
        return RTI_SURFACE_CONE;
    default:
        return RTI_SURFACE_OTHER;
    }
}

/* What hits of a kind may have. */
static const struct {
    bool smooth, tinted;
} kinds[RTI_SURFACE_COUNT] = {
    [RTI_SURFACE_SMOOTH] = {true, true},
    [RTI_SURFACE_SPHERE] = {false, true},
    [RTI_SURFACE_BOX] = {false, true},
    [RTI_SURFACE_CONE] = {false, true},
    [RTI_SURFACE_OTHER] = {true, true},
    [RTI_SURFACE_PLACED + RTI_SURFACE_SMOOTH - RTI_SURFACE_MESH] = {true, true},
    [RTI_SURFACE_PLACED + RTI_SURFACE_SPHERE - RTI_SURFACE_MESH] = {false, true},
    [RTI_SURFACE_PLACED + RTI_SURFACE_BOX - RTI_SURFACE_MESH] = {false, true},
    [RTI_SURFACE_PLACED + RTI_SURFACE_CONE - RTI_SURFACE_MESH] = {false, true},
};

/* As what it stands in an instance. */
static uint32_t placed_of(const rtk_instance *i, uint32_t surface)
{
    if (i->flags & RTK_INST_MOVING || surface < RTI_SURFACE_MESH || surface > RTI_SURFACE_CONE)
        return RTI_SURFACE_OTHER;
    return RTI_SURFACE_PLACED + surface - RTI_SURFACE_MESH;
}

static uint32_t key_of(const rtk_scene *scene, uint32_t geom_index, uint32_t prim, uint32_t inst, uint32_t *material)
{
    const rtk_instance *i = inst != RTK_INVALID ? &scene->instances[inst] : NULL;
    const rtk_group *g = &scene->groups[i ? i->group : 0];
    const rtk_geom *geom = &g->geoms[geom_index];
    const uint32_t surface = surface_of(g, geom, prim);
    *material = rtk_material_of(g, geom, prim, i);
    return (i ? placed_of(i, surface) : surface) * RTI_LOOK_COUNT + look_of(scene, *material);
}

/* What neighbours mostly share: the geometry that was hit last, and what is known of its hits. Shapes of one geometry are of one
 * type. */
typedef struct last_hit {
    uint32_t geom, inst, key, material;
} last_hit;

static uint32_t find_key(const rtk_scene *scene, const rtk_hit_block *h, uint32_t k, last_hit *last, uint32_t *material)
{
    uint32_t key;
    if (h->prim[k] == RTK_INVALID) {
        *material = 0;
        return 0;
    }
    if (h->geom[k] == last->geom && h->inst[k] == last->inst) {
        *material = last->material;
        return last->key;
    }
    key = key_of(scene, h->geom[k], h->prim[k], h->inst[k], material);
    if (!(scene->groups[h->inst[k] == RTK_INVALID ? 0 : scene->instances[h->inst[k]].group].geoms[h->geom[k]].flags &
          RTK_GEOM_FACE_MATERIALS))
        *last = (last_hit){h->geom[k], h->inst[k], key, *material};
    return key;
}

/* Whether all of a block's rays that hit anything, which are given as bits, hit the geometry that was hit last. */
static bool all_last(const rtk_hit_block *h, const last_hit *last, uint32_t *some)
{
    *some = rti_u32_unlike(h->prim, RTK_INVALID);
    return (*some & (rti_u32_unlike(h->geom, last->geom) | rti_u32_unlike(h->inst, last->inst))) == 0;
}

static void find_keys(rti_worker *w, uint32_t first, uint32_t count, uint32_t *counts, kinds_seen *seen)
{
    last_hit last = {RTK_INVALID, 0, 0, 0};
    for (uint32_t n = 0; n < count;) {
        const rtk_hit_block *h = &w->hits[(first + n) / RTK_BLOCK];
        uint32_t some;
        uint32_t k = (first + n) % RTK_BLOCK, end = RTK_BLOCK - k < count - n ? RTK_BLOCK : k + (count - n);
        if (end - k == RTK_BLOCK && all_last(h, &last, &some)) {
            uint32_t *materials = w->materials + first + n;
            const uint32_t hit = (uint32_t)__builtin_popcount(some);
            uint8_t *keys = w->keys + n;
            RTI_EACH_LANE_INNER(i)
            {
                keys[i] = (uint8_t)(some >> i & 1u ? last.key : 0);
                materials[i] = some >> i & 1u ? last.material : 0;
            }
            counts[last.key] += hit;
            counts[0] += RTK_BLOCK - hit;
            n += RTK_BLOCK;
            continue;
        }
        for (; k < end; k++, n++) {
            uint32_t key = find_key(w->frame->scene, h, k, &last, &w->materials[first + n]);
            w->keys[n] = (uint8_t)key;
            counts[key]++;
            see(seen, key);
        }
    }
}

/* Of a block's kinds those that are `key`, a bit each. */
static uint32_t lanes_of_kind(const uint8_t keys[RTK_BLOCK], uint32_t key)
{
    const uint64_t all = key * 0x0101010101010101u;
    uint64_t eight[RTK_BLOCK / 8];
    uint32_t lanes = 0;
    memcpy(eight, keys, sizeof eight);
    if (eight[0] == all && eight[1] == all) /* mostly */
        return (1u << RTK_BLOCK) - 1;
    RTI_EACH_LANE_INNER(k)
    lanes |= (uint32_t)(keys[k] == key) << k;
    return lanes;
}

/* The order of the sorted: behind the beginnings of their kinds, which become their ends. A block has few kinds. */
static void place_rays(rti_worker *w, uint32_t first, uint32_t count, uint32_t *begins)
{
    uint32_t n = 0;
    for (; count - n >= RTK_BLOCK; n += RTK_BLOCK) {
        const uint8_t *keys = w->keys + n;
        for (uint32_t left = (1u << RTK_BLOCK) - 1; left != 0;) {
            const uint32_t key = keys[__builtin_ctz(left)], lanes = lanes_of_kind(keys, key);
            rti_put_numbers(w->order + begins[key], first + n, lanes);
            begins[key] += (uint32_t)__builtin_popcount(lanes);
            left &= ~lanes;
        }
    }
    for (; n < count; n++)
        w->order[begins[w->keys[n]]++] = first + n;
}

/* ---- sheaves ---- */

/* Rows of neighbouring fields are neighbours in blocks and sheaves. */
static void take_scattered(const rti_worker *w, rti_sheaf *c)
{
#define TAKE(from, size, field, rows) rti_take_rows(c, from, size, rows, (char *)c + offsetof(rti_sheaf, field))
    const rtk_path_block *p = w->batch.path;
    rti_find_blocks(c);
    TAKE(w->batch.home, sizeof *w->batch.home, home, 1);
    TAKE(w->batch.trace, sizeof *w->batch.trace, ox, 6);
    TAKE(p, sizeof *p, tpr, 3);
    TAKE((const char *)p + offsetof(rtk_path_block, width), sizeof *p, width, 2);
    TAKE(w->hits, sizeof *w->hits, t, 6);
    TAKE(w->materials, RTK_BLOCK * sizeof *w->materials, material, 1);
#undef TAKE
}

/* All sixteen in their places of one block. */
static void take_block(const rti_worker *w, rti_sheaf *restrict c)
{
    const uint32_t b = c->ray[0] / RTK_BLOCK;
    c->block_count = 1;
    c->block[0] = b;
    c->lanes[0] = (1u << RTK_BLOCK) - 1;
    const rtk_trace_block *t = &w->batch.trace[b];
    const rtk_path_block *p = &w->batch.path[b];
    const rtk_hit_block *h = &w->hits[b];
    memcpy(c->home, w->batch.home[b].home, sizeof c->home);
    memcpy(c->ox, t->ox, sizeof c->ox);
    memcpy(c->oy, t->oy, sizeof c->oy);
    memcpy(c->oz, t->oz, sizeof c->oz);
    memcpy(c->dx, t->dx, sizeof c->dx);
    memcpy(c->dy, t->dy, sizeof c->dy);
    memcpy(c->dz, t->dz, sizeof c->dz);
    memcpy(c->tpr, p->tpr, sizeof c->tpr);
    memcpy(c->tpg, p->tpg, sizeof c->tpg);
    memcpy(c->tpb, p->tpb, sizeof c->tpb);
    memcpy(c->width, p->width, sizeof c->width);
    memcpy(c->spread, p->spread, sizeof c->spread);
    memcpy(c->t, h->t, sizeof c->t);
    memcpy(c->u, h->u, sizeof c->u);
    memcpy(c->v, h->v, sizeof c->v);
    memcpy(c->prim, h->prim, sizeof c->prim);
    memcpy(c->geom, h->geom, sizeof c->geom);
    memcpy(c->inst, h->inst, sizeof c->inst);
    memcpy(c->material, w->materials + c->ray[0], sizeof c->material);
}

/* Sorting keeps the order of the batch, so that sixteen in a row are seen by the ends alone. */
static void take(const rti_worker *w, const uint32_t *order, uint32_t count, rti_sheaf *c)
{
    c->count = count;
    if (count == RTK_BLOCK && order[0] % RTK_BLOCK == 0 && order[RTK_BLOCK - 1] == order[0] + RTK_BLOCK - 1) {
        memcpy(c->ray, order, sizeof c->ray);
        take_block(w, c);
        return;
    }
    RTI_EACH_LANE_INNER(k)
    c->ray[k] = order[k < count ? k : count - 1];
    take_scattered(w, c);
}

/* ---- what every integrator asks ---- */

static void touch(rti_worker *w, rti_sheaf *c)
{
    c->one_material = rti_u32_unlike(c->material, c->material[0]) == 0;
    if (c->one_material) {
        rti_touch(w, c->material[0]);
        return;
    }
    for (uint32_t k = 0; k < c->count; k++)
        rti_touch(w, c->material[k]);
}

/* The material's colour times the tint. */
static void plain_colors(const rtk_scene *scene, rti_sheaf *c)
{
    const rtk_material *of = scene->materials, *all = &of[c->material[0]];
    const float r = all->color[0], g = all->color[1], b = all->color[2];
    if (c->one_material) {
        RTI_EACH_LANE_INNER(k)
        {
            c->cr[k] = r;
            c->cg[k] = g;
            c->cb[k] = b;
        }
    } else {
        RTI_EACH_LANE_INNER(k)
        {
            const rtk_material *m = &of[c->material[k]];
            c->cr[k] = m->color[0];
            c->cg[k] = m->color[1];
            c->cb[k] = m->color[2];
        }
    }
    if (!c->tinted)
        return;
    RTI_EACH_LANE_INNER(k)
    {
        c->cr[k] *= c->tr[k];
        c->cg[k] *= c->tg[k];
        c->cb[k] *= c->tb[k];
    }
}

RTI_LANES_FN static void misses(rti_worker *w, const rti_sheaf *c)
{
    const rtk_scene *scene = w->frame->scene;
    const rtk_world *world = scene->world;
    rti_light_lanes l;
    if (world->background_tex == RTK_INVALID) {
        const rtk_vec3 low = rtk_v3(world->background[0], world->background[1], world->background[2]);
        const rtk_vec3 top = rtk_v3(world->background_top[0], world->background_top[1], world->background_top[2]);
        RTI_EACH_LANE_INNER(k)
        {
            rtk_vec3 e = rtk_gradient(low, top, rtk_v3(c->dx[k], c->dy[k], c->dz[k]));
            l.r[k] = c->tpr[k] * e.x;
            l.g[k] = c->tpg[k] * e.y;
            l.b[k] = c->tpb[k] * e.z;
        }
    } else {
        RTI_ISA_FN(rti_lanes_sky)(scene, c, &l);
        RTI_EACH_LANE_INNER(k)
        {
            l.r[k] *= c->tpr[k];
            l.g[k] *= c->tpg[k];
            l.b[k] *= c->tpb[k];
        }
    }
    rti_add_lanes(w, c->home, (1u << c->count) - 1, &l);
}

/* Behind everything is nothing that shines. */
static bool is_black(const rtk_world *world)
{
    const float *a = world->background, *b = world->background_top;
    return world->background_tex == RTK_INVALID && a[0] == 0.0f && a[1] == 0.0f && a[2] == 0.0f && b[0] == 0.0f && b[1] == 0.0f &&
           b[2] == 0.0f;
}

static void hits(rti_worker *w, rti_sheaf *c, rti_sheaf_fn then)
{
    const rtk_scene *scene = w->frame->scene;
    if (c->depth == 0)
        rti_cover_lanes(w, c->home, c->count);
    RTI_ISA_FN(rti_lanes_surface)(w, c);
    touch(w, c);
    if (c->material_kind != RTI_LOOK_EMISSIVE)
        plain_colors(scene, c);
    if (c->material_kind >= RTI_LOOK_TEXTURED)
        RTI_ISA_FN(rti_lanes_texture)(scene, c);
    then(w, c);
    if (w->lit_count + RTK_BLOCK > w->lit_most)
        w->frame->set.integrator->light(w);
}

void RTI_ISA_FN(rti_lanes_sheaves)(rti_worker *w, uint32_t first, uint32_t count, rti_sheaf_fn then)
{
    uint32_t ends[KEYS] = {0}, at = 0;
    kinds_seen seen = {{1}}, left; /* kind 0 is that of misses */
    rti_sheaf c;
    find_keys(w, first, count, ends, &seen);
    left = seen;
    for (uint32_t key; (key = next_kind(&left)) < KEYS;) { /* counts to beginnings */
        uint32_t n = ends[key];
        ends[key] = at;
        at += n;
    }
    place_rays(w, first, count, ends);
    c.looks.of_all = RTK_INVALID;
    c.depth = w->batch.path[first / RTK_BLOCK].depth_kind[first % RTK_BLOCK] & 0xffffu;
    at = is_black(w->frame->scene->world) ? ends[0] : 0;
    for (uint32_t key; (key = next_kind(&seen)) < KEYS;) {
        c.surface_kind = key / RTI_LOOK_COUNT;
        c.material_kind = key % RTI_LOOK_COUNT;
        c.smooth = kinds[c.surface_kind].smooth;
        c.tinted = kinds[c.surface_kind].tinted;
        while (at < ends[key]) {
            uint32_t n = ends[key] - at < RTK_BLOCK ? ends[key] - at : RTK_BLOCK;
            take(w, w->order + at, n, &c);
            at += n;
            if (c.surface_kind == RTI_SURFACE_MISS)
                misses(w, &c);
            else
                hits(w, &c, then);
        }
    }
}
