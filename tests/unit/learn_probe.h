/* Which rays of a picture would go as others than pencils, as told by what pencils before have met, by the constants of one
 * instruction set. */
#ifndef LEARN_PROBE_H
#define LEARN_PROBE_H

#include "base/isa.h"

#define PLACES 100u

/* PLACES places of `place` coherent rays each, one behind the other, of closest or any hits (any); worse[i]: pencils in the i-th
 * cost more than streams. away[i]: how many of its rays go as others. */
#define PROBE(name, level) void probe_learn_##name(uint32_t place, int any, const uint8_t worse[PLACES], uint32_t away[PLACES]);
RTI_ISA_EACH(PROBE)
#undef PROBE

#endif
