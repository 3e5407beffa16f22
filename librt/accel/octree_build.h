/* What the octree's builder asks of each instruction set (octree_touched.c). Private to accel/. */
#ifndef RTI_OCTREE_BUILD_H
#define RTI_OCTREE_BUILD_H

#include "../base/isa.h"
#include "build.h"

/* Of a cell that is to be halved, by axis. room: half and what it is grown by, half as much again. */
typedef struct rti_octree_middle {
    float mid[4], half[3], room[3]; /* half: of a child's sides; mid[3] is 0 */
} rti_octree_middle;

#define RTI_OCTREE_AHEAD 8u /* places behind what is asked for that are read and written, too */

typedef struct rti_octree_kernels {
    /* Which children references belong to, a bit each: boxes stay whole, only the cell counts. which: their places in `refs`,
     * NULL: 0, 1 and so on. To each of counts is added how many are in that child. */
    void (*touched)(const rti_octree_middle *m, const rti_build_input *in, const rti_ref *refs, const uint32_t *which,
                    uint32_t count, uint8_t *masks, uint32_t counts[8]);
    /* Those of the last child to `to`, behind them those of the one before, and so on. from, masks and to have
     * RTI_OCTREE_AHEAD places more; masks are changed. */
    void (*deal)(const uint32_t *from, uint8_t *masks, uint32_t count, uint32_t *to);
} rti_octree_kernels;
const rti_octree_kernels *rti_octree_kernels_at(rti_isa isa);

#endif
