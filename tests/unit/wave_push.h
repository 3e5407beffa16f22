/* A ray onto a worker's stack, as integrators put theirs. */
#ifndef WAVE_PUSH_H
#define WAVE_PUSH_H

#include "render/wavefront.h"

static void push(rti_worker *worker, rtk_vec3 org, rtk_vec3 dir, uint32_t mask, const rti_ray_state *state)
{
    const uint32_t b = worker->stack.count / RTK_BLOCK, k = worker->stack.count % RTK_BLOCK;
    rtk_trace_block *t = &worker->stack.trace[b];
    rtk_path_block *p = &worker->stack.path[b];
    t->ox[k] = org.x;
    t->oy[k] = org.y;
    t->oz[k] = org.z;
    t->dx[k] = dir.x;
    t->dy[k] = dir.y;
    t->dz[k] = dir.z;
    t->tmin[k] = 0.0f;
    t->tmax[k] = RTK_INF;
    t->mask[k] = mask;
    p->tpr[k] = state->tp.x;
    p->tpg[k] = state->tp.y;
    p->tpb[k] = state->tp.z;
    p->pixel[k] = state->pixel;
    p->sample[k] = state->sample;
    p->depth_kind[k] = state->depth | state->kind << 16;
    p->key_lo[k] = state->key_lo;
    p->key_hi[k] = state->key_hi;
    p->eta[k] = state->eta;
    p->width[k] = state->width;
    p->spread[k] = state->spread;
    p->pdf[k] = state->pdf;
    worker->stack.home[b].home[k] = state->home;
    worker->stack.count++;
    worker->slots[state->home >> worker->frame->slot_shift].live++;
    worker->counts.rays[state->kind]++;
}

#endif
