/* Arrays of structures into structures of arrays and back, for one instruction set. */
#include "turn.h"

#include <stddef.h>
#include <string.h>

#include "../base/simd.h"

_Static_assert(offsetof(rti_ray, dir) == 16 && offsetof(rti_ray, mask) == 32 && sizeof(rti_ray) == 36, "nine words");
_Static_assert(offsetof(rti_hit, prim) == 12 && offsetof(rti_hit, inst) == 20 && sizeof(rti_hit) == 24, "six words");

static void turn_rays(const rti_ray *rays, uint32_t count, rtk_trace_block *out)
{
    for (; count >= RTK_BLOCK; count -= RTK_BLOCK, rays += RTK_BLOCK, out++) {
        float *const to[9] = {out->ox, out->oy, out->oz, out->tmin, out->dx, out->dy, out->dz, out->tmax, (float *)out->mask};
        rti_nines((const float *)rays, to);
    }
    for (uint32_t k = 0u; k < count; k++) {
        const rti_ray *r = &rays[k];
        out->ox[k] = r->org[0];
        out->oy[k] = r->org[1];
        out->oz[k] = r->org[2];
        out->dx[k] = r->dir[0];
        out->dy[k] = r->dir[1];
        out->dz[k] = r->dir[2];
        out->tmin[k] = r->tmin;
        out->tmax[k] = r->tmax;
        out->mask[k] = r->mask;
    }
}

static void turn_hits(const rtk_hit_block *blocks, uint32_t count, rti_hit *hits)
{
    for (; count >= RTK_BLOCK; count -= RTK_BLOCK, hits += RTK_BLOCK, blocks++) {
        const rtk_hit_block *b = blocks;
        const float *const from[6] = {b->t, b->u, b->v, (const float *)b->prim, (const float *)b->geom, (const float *)b->inst};
        rti_sixes(from, (float *)hits);
    }
    for (uint32_t k = 0u; k < count; k++)
        hits[k] = (rti_hit){blocks->t[k], blocks->u[k], blocks->v[k], blocks->prim[k], blocks->geom[k], blocks->inst[k]};
}

const rti_turn RTI_ISA_FN(rti_turn) = {turn_rays, turn_hits};
