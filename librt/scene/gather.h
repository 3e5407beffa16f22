/* Plain arrays of rays into blocks, and hits out of them. Four rays at a time are turned by shuffles of the compiler's own vectors:
 * scalar code would store nine words a ray one by one, a tenth of what tracing a coherent ray takes.
 */
#ifndef RTI_GATHER_H
#define RTI_GATHER_H

#include <stddef.h>
#include <string.h>

#include "../kernel/blocks.h"
#include "../trace/trace.h"
#include "librt/scene.h"

_Static_assert(offsetof(rt_ray, dir) == 16 && offsetof(rt_ray, mask) == 32 && sizeof(rt_ray) == 36, "two rows of four, and the mask");
_Static_assert(offsetof(rt_hit, prim_id) == 12 && offsetof(rt_hit, inst_id) == 20 && sizeof(rt_hit) == 24, "a row of four, and a half");

static inline void rti_gather_one(const rt_ray *ray, rtk_trace_block *b, uint32_t k)
{
    b->ox[k] = ray->org.x;
    b->oy[k] = ray->org.y;
    b->oz[k] = ray->org.z;
    b->dx[k] = ray->dir.x;
    b->dy[k] = ray->dir.y;
    b->dz[k] = ray->dir.z;
    b->tmin[k] = ray->tmin;
    b->tmax[k] = ray->tmax;
    b->mask[k] = ray->mask;
}

static inline void rti_scatter_one(const rtk_hit_block *b, uint32_t k, rt_hit *hit)
{
    *hit = (rt_hit){b->t[k], b->u[k], b->v[k], b->prim[k], b->geom[k], b->inst[k]};
}

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define RTI_GATHER_ROWS 1
#endif
#endif

#ifdef RTI_GATHER_ROWS
typedef uint32_t rti_row __attribute__((vector_size(16)));

static inline rti_row rti_row_load(const void *from)
{
    rti_row r;
    memcpy(&r, from, sizeof r);
    return r;
}

static inline void rti_row_store(void *to, rti_row r)
{
    memcpy(to, &r, sizeof r);
}

/* Rows become columns. */
static inline void rti_row_turn(rti_row r[4])
{
    rti_row ab_lo = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5), ab_hi = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7);
    rti_row cd_lo = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5), cd_hi = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
    r[0] = __builtin_shufflevector(ab_lo, cd_lo, 0, 1, 4, 5);
    r[1] = __builtin_shufflevector(ab_lo, cd_lo, 2, 3, 6, 7);
    r[2] = __builtin_shufflevector(ab_hi, cd_hi, 0, 1, 4, 5);
    r[3] = __builtin_shufflevector(ab_hi, cd_hi, 2, 3, 6, 7);
}

static inline void rti_gather_four(const rt_ray *rays, rtk_trace_block *b, uint32_t k)
{
    rti_row o[4], d[4];
    for (int i = 0; i < 4; i++) {
        o[i] = rti_row_load(&rays[i].org);
        d[i] = rti_row_load(&rays[i].dir);
        b->mask[k + (uint32_t)i] = rays[i].mask;
    }
    rti_row_turn(o);
    rti_row_turn(d);
    rti_row_store(&b->ox[k], o[0]);
    rti_row_store(&b->oy[k], o[1]);
    rti_row_store(&b->oz[k], o[2]);
    rti_row_store(&b->tmin[k], o[3]);
    rti_row_store(&b->dx[k], d[0]);
    rti_row_store(&b->dy[k], d[1]);
    rti_row_store(&b->dz[k], d[2]);
    rti_row_store(&b->tmax[k], d[3]);
}

static inline void rti_scatter_four(const rtk_hit_block *b, uint32_t k, rt_hit *hits)
{
    rti_row r[4] = {rti_row_load(&b->t[k]), rti_row_load(&b->u[k]), rti_row_load(&b->v[k]), rti_row_load(&b->prim[k])};
    rti_row geom = rti_row_load(&b->geom[k]), inst = rti_row_load(&b->inst[k]);
    rti_row low = __builtin_shufflevector(geom, inst, 0, 4, 1, 5), high = __builtin_shufflevector(geom, inst, 2, 6, 3, 7);
    rti_row_turn(r);
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t ids[4];
        rti_row_store(ids, i < 2 ? low : high);
        rti_row_store(&hits[i], r[i]);
        memcpy(&hits[i].geom_id, ids + i % 2 * 2, 2 * sizeof *ids);
    }
}
#endif

/* out has room for (count + 15) / 16 blocks. */
static inline void rti_gather(const rt_ray *rays, uint32_t count, rtk_trace_block *out)
{
    uint32_t i = 0;
#ifdef RTI_GATHER_ROWS
    for (; i + 4 <= count; i += 4)
        rti_gather_four(rays + i, &out[i / RTK_BLOCK], i % RTK_BLOCK);
#endif
    for (; i < count; i++)
        rti_gather_one(rays + i, &out[i / RTK_BLOCK], i % RTK_BLOCK);
}

/* Do all sixteen rays point into one octant? Those without order hardly ever do. Written so that compilers make vectors of it, as the next one. */
static inline int rti_one_octant(const rtk_trace_block *b)
{
    uint32_t other = 0, x = rtk_bits(b->dx[0]), y = rtk_bits(b->dy[0]), z = rtk_bits(b->dz[0]);
    for (uint32_t i = 0; i < RTK_BLOCK; i++)
        other |= (rtk_bits(b->dx[i]) ^ x) | (rtk_bits(b->dy[i]) ^ y) | (rtk_bits(b->dz[i]) ^ z);
    return !(other >> 31);
}

/* What rays look like of which nobody has said anything: coherent when in three quarters of the whole blocks, looking at every third, all rays point into one
 * octant. A wrong guess costs time, never a hit; the looking takes about a nanosecond a ray. */
static inline uint32_t rti_guess(const rtk_trace_block *b, uint32_t count)
{
    uint32_t blocks = count / RTK_BLOCK, seen = 0, alike = 0;
    for (uint32_t i = 0; i < blocks; i += 3) {
        alike += rti_one_octant(&b[i]) ? 1u : 0u;
        seen++;
    }
    return blocks == 0 || 4 * alike < 3 * seen ? 0 : RTI_TRACE_COHERENT;
}

static inline void rti_scatter(const rtk_hit_block *blocks, uint32_t count, rt_hit *hits)
{
    uint32_t i = 0;
#ifdef RTI_GATHER_ROWS
    for (; i + 4 <= count; i += 4)
        rti_scatter_four(&blocks[i / RTK_BLOCK], i % RTK_BLOCK, hits + i);
#endif
    for (; i < count; i++)
        rti_scatter_one(&blocks[i / RTK_BLOCK], i % RTK_BLOCK, hits + i);
}

#endif
