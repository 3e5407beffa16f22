/* Rays of plain arrays into blocks, and hits out of them, which are a tenth of what tracing a coherent ray takes. */
#ifndef RTI_TURN_H
#define RTI_TURN_H

#include "../base/isa.h"
#include "trace.h"

typedef struct rti_turn {
    /* [count] rays to (count + 15) / 16 blocks; lanes behind the last ray are left as they are. */
    void (*rays)(const rti_ray *rays, uint32_t count, rtk_trace_block *out);
    void (*hits)(const rtk_hit_block *blocks, uint32_t count, rti_hit *hits);
} rti_turn;
const rti_turn *rti_turn_at(rti_isa isa);

#endif
