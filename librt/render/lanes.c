/* Which lanes an instruction set has. */
#include "direct.h"
#include "lanes.h"
#include "lanes_table.h"

RTI_ISA_TABLES(rti_lanes, rti_lanes_find)

static uint32_t depth_at(const rti_worker *w, uint32_t i)
{
    return w->batch.path[i / RTK_BLOCK].depth_kind[i % RTK_BLOCK] & 0xffffu;
}

/* Children of one depth are in no order among themselves: so within a depth, hits may be taken by kind. */
void rti_sheaves(rti_worker *w, uint32_t first, uint32_t count, rti_sheaf_fn then)
{
    const rti_lanes *lanes = w->frame->lanes;
    uint32_t end = first + count;
    while (first < end) {
        uint32_t low = first, high = end - 1, depth = depth_at(w, first); /* the last ray of this depth is in [low, high] */
        while (low < high) {
            uint32_t mid = low + (high - low + 1) / 2;
            if (depth_at(w, mid) == depth)
                low = mid;
            else
                high = mid - 1;
        }
        lanes->sheaves(w, first, low + 1 - first, then);
        first = low + 1;
    }
}

/* Integrators that show light. */
#define SHADE(name)                                                                                                              \
    void rti_shade_##name(rti_worker *worker, uint32_t first, uint32_t count)                                                    \
    {                                                                                                                            \
        rti_sheaves(worker, first, count, worker->frame->lanes->name);                                                           \
    }
SHADE(whitted)
SHADE(path)
SHADE(ao)
#undef SHADE
