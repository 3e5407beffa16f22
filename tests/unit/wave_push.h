/* A ray onto a worker's stack, as integrators put theirs. */
#ifndef WAVE_PUSH_H
#define WAVE_PUSH_H

#include "render/wavefront.h"

static void push(rti_worker *worker, rtk_vec3 org, rtk_vec3 dir, uint32_t mask, const rti_ray_state *state)
{
    rti_put_ray(&worker->stack, worker->stack.count++, org, dir, mask, state);
    worker->slots[state->home >> worker->frame->slot_shift].live++;
    worker->counts.rays[state->kind]++;
}

#endif
