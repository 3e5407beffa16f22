/* What the writer and the reader of checkpoint files share. The layout: head, u32 done[done_count], pixels of these tiles, for
 * each unfinished tile the first four fields of rti_check_partial and its film, and a hash of all before it. Numbers stand as on
 * the machine that wrote them; another byte order is refused. */
#ifndef RTI_CHECKPOINT_FILE_H
#define RTI_CHECKPOINT_FILE_H

#include "../kernel/film.h"
#include "checkpoint.h"

#define RTI_CHECK_MAGIC        "RTFILM1\n"
#define RTI_CHECK_ORDER        0x01020304u
#define RTI_CHECK_PARTIAL_HEAD (4 * sizeof(uint32_t))

uint64_t rti_check_tile_bytes(const rti_frame *frame, uint32_t tile);

#endif
