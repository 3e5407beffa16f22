/* Pairs of a ray and a triangle, asked by a vector leaf test of one instruction set. */
#ifndef TRI_LANES_PROBE_H
#define TRI_LANES_PROBE_H

#include "base/isa.h"
#include "kernel/triangle.h"

typedef struct probe_answer {
    int hit, doubt, certain;
    float t, u, v, off;
} probe_answer;

/* The widest of 4, 8, 16 up to at_most; the answers of as many pairs. exact: of as many pairs as are
 * widest (no ray moved), the doubted ones by tri_exact; returns how many those were. double: how many of them are on no edge; in
 * doubt are those that tri_double leaves, and hits those of which tri_double_one, or tri_double of one triangle, says something
 * else. settle: of as many pairs, how many packet_settle_many and rti_tri_settle say different things of. part: of as many rays,
 * those that packets leave out of the part. */
#define PROBE(name, level)                                                                                                       \
    uint32_t probe_width_##name(uint32_t at_most);                                                                               \
    void probe_triangles_##name(uint32_t width, const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);                   \
    uint32_t probe_exact_##name(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);                                    \
    uint32_t probe_double_##name(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);                                   \
    uint32_t probe_settle_##name(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);                                  \
    uint32_t probe_part_##name(const rtk_ray *rays, const rtk_part *part);
RTI_ISA_EACH(PROBE)
#undef PROBE

#endif
