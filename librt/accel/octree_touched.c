/* Which children of an octree's cell a triangle touches: separating axes after Akenine-Moeller 2001, for all eight children at
 * once and several triangles side by side. A hot file (base/isa.h): the same answers at each level.
 *
 * In floats: coordinates err by less than 2^-22 of the scale each, the growth is 2^-17 of it, so half as much again covers every
 * rounding (what cancels in the plane's normal has a term of its own), and what is listed too much does no harm.
 */
#include <string.h>

#include "corners.h"
#include "octree_build.h"

/* What products lose that are denormal or zero: an edge and a coordinate (or two edges) each less than 2^-148, here with room for
 * all of a sum; LOST_NORMAL is multiplied as the normal's own roundings are. */
#define LOST        1e-42f
#define LOST_NORMAL 1e-38f
/* Products of three coordinates of 4e12 and more may not fit floats: where they come near to that, nothing is told by them. */
#define MUCH 1e38f

/* Of each child, whose plane does not pass it. e, f: two edges; v: a vertex. */
static inline void by_plane(const rti_octree_middle *m, const lanes e[3], const lanes f[3], const lanes v[3], yes out[8])
{
    lanes d[3], h[3], reach[3], size = V(set)(0.0f);
    for (uint32_t a = 0; a < 3; a++) {
        const uint32_t b = (a + 1) % 3, g = (a + 2) % 3;
        const lanes x = e[b] * f[g], y = e[g] * f[b], n = x - y;
        const lanes lost = V(abs)(x) + V(abs)(y) + V(set)(LOST_NORMAL), half = V(set)(m->half[a]);
        d[a] = n * v[a];
        h[a] = n * half;
        size = size + (V(abs)(d[a]) + V(abs)(h[a]));
        reach[a] = V(abs)(n) * V(set)(m->room[a]) + lost * (V(abs)(v[a]) + half) * V(set)(2.0e-6f);
    }
    const lanes near = (reach[0] + reach[1] + reach[2]) + V(set)(LOST), mid = d[0] + d[1] + d[2];
    const lanes most = V(select)(V(lt)(size, V(set)(MUCH)), near, V(set)(RTK_INF));
    const lanes up = mid + h[0], down = mid - h[0], s[4] = {up + h[1], down + h[1], up - h[1], down - h[1]};
    for (uint32_t i = 0; i < 4; i++) {
        out[i] = V(lt)(most, V(abs)(s[i] + h[2]));
        out[4 + i] = V(lt)(most, V(abs)(s[i] - h[2]));
    }
}

/* Of children by halves low low, high low, low high, high high of the two axes after axis a: which are beyond what lies across it
 * and the edge e, between vertices like v, with o the one across. A child's place there depends on its halves of those two alone.
 */
RTI_VEC void by_edge(const rti_octree_middle *m, uint32_t a, const lanes e[3], const lanes v[3], const lanes o[3], yes out[4])
{
    const uint32_t b = (a + 1) % 3, g = (a + 2) % 3;
    const lanes x = e[b] * v[g] - e[g] * v[b], y = e[b] * o[g] - e[g] * o[b];
    const lanes by_b = e[g] * V(set)(m->half[b]), by_g = e[b] * V(set)(m->half[g]), sum = by_g + by_b, less = by_g - by_b;
    const lanes reach = V(abs)(e[b]) * V(set)(m->room[g]) + V(abs)(e[g]) * V(set)(m->room[b]) + V(set)(LOST);
    const lanes low = V(min)(y, x) - reach, high = V(max)(x, y) + reach;
    out[0] = M(or)(V(lt)(-less, low), V(lt)(high, -less));
    out[1] = M(or)(V(lt)(-sum, low), V(lt)(high, -sum));
    out[2] = M(or)(V(lt)(sum, low), V(lt)(high, sum));
    out[3] = M(or)(V(lt)(less, low), V(lt)(high, less));
}

/* Marks children that are beyond what lies across axis a and an edge. a is constant: lanes stay in registers. */
RTI_VEC void by_axis(const rti_octree_middle *m, uint32_t a, lanes v[3][3], lanes e[3][3], yes out[8])
{
    yes all[4], one[4];
    by_edge(m, a, e[0], v[0], v[2], all);
    for (uint32_t i = 1; i < 3; i++) {
        by_edge(m, a, e[i], v[i], v[i - 1], one);
        for (uint32_t k = 0; k < 4; k++)
            all[k] = M(or)(all[k], one[k]);
    }
    for (uint32_t c = 0; c < 8; c++)
        out[c] = M(or)(out[c], all[(c >> (a + 1) % 3 & 1u) | (c >> (a + 2) % 3 & 1u) << 1]);
}

/* Bit i of byte k is bit k of byte i. */
static inline uint64_t turned(uint64_t x)
{
    uint64_t t = (x ^ x >> 7) & 0x00aa00aa00aa00aau;
    x ^= t ^ t << 7;
    t = (x ^ x >> 14) & 0x0000cccc0000ccccu;
    x ^= t ^ t << 14;
    t = (x ^ x >> 28) & 0x00000000f0f0f0f0u;
    return x ^ t ^ t << 28;
}

/* A byte for each triangle: which children it is not in. */
static inline uint64_t bytes_of(const yes outside[8])
{
    uint64_t rows = 0;
    for (uint32_t c = 0; c < 8; c++)
        rows |= (uint64_t)M(bits)(outside[c]) << 8 * c;
    return turned(rows);
}

/* A byte for each of the triangles: the children that its plane does not pass, and those beyond it on any axis. */
typedef struct answer {
    uint64_t plane, edges;
} answer;

static inline answer ask(const rti_octree_middle *m, const rtk_tri *const tris[LANES])
{
    lanes v[3][3], e[3][3];
    yes outside[8];
    answer a;
    corners_of(tris, v);
    for (uint32_t k = 0; k < 3; k++)
        for (uint32_t c = 0; c < 3; c++)
            v[c][k] = v[c][k] - V(set)(m->mid[k]); /* seen from the cell's middle */
    for (uint32_t k = 0; k < 3; k++) {
        e[0][k] = v[1][k] - v[0][k];
        e[1][k] = v[2][k] - v[1][k];
        e[2][k] = v[0][k] - v[2][k];
    }
    by_plane(m, e[0], e[1], v[0], outside);
    a.plane = bytes_of(outside);
    by_axis(m, 0, v, e, outside);
    by_axis(m, 1, v, e, outside);
    by_axis(m, 2, v, e, outside);
    a.edges = bytes_of(outside);
    return a;
}

#define BATCH 64u /* references whose boxes are asked before triangles are */

/* Which children the boxes of references are in; returns how many are triangles in several, whose places go to `open`. */
static inline uint32_t by_boxes(const rti_octree_middle *m, uint32_t tri_count, const rti_ref *refs, const uint32_t *which,
                                uint32_t count, uint8_t *masks, uint8_t open[BATCH])
{
    /* By axes on which a box is below the middle, and above it. */
    static const uint8_t below[8] = {0x80, 0xc0, 0xa0, 0xf0, 0x88, 0xcc, 0xaa, 0xff};
    static const uint8_t above[8] = {0x01, 0x03, 0x05, 0x0f, 0x11, 0x33, 0x55, 0xff};
    const rti_f4 mid = rti_f4_load(m->mid);
    uint32_t opens = 0;
    for (uint32_t i = 0; i < count; i++) {
        const rti_ref *ref = &refs[which ? which[i] : i];
        const unsigned low = rti_m4_bits(rti_f4_lt(rti_f4_load(ref->lo), mid)) & 7u;
        const unsigned high = rti_m4_bits(rti_f4_lt(mid, rti_f4_load(ref->hi))) & 7u;
        const unsigned mask = below[low] & above[high];
        masks[i] = (uint8_t)mask;
        open[opens] = (uint8_t)i;
        opens += (unsigned)((mask & (mask - 1)) != 0) & (unsigned)(ref->prim < tri_count);
    }
    return opens;
}

static inline void by_triangles(const rti_octree_middle *m, const rtk_tri *tris, const rti_ref *refs, const uint32_t *which,
                                const uint8_t *open, uint32_t opens, uint8_t *masks)
{
    const rtk_tri *some[BATCH + LANES];
    for (uint32_t i = 0; i < opens; i++) {
        some[i] = &tris[refs[which ? which[open[i]] : open[i]].prim];
        rti_tri_expect(some[i]);
    }
    for (uint32_t i = opens; i % LANES != 0; i++)
        some[i] = some[opens - 1];
    for (uint32_t first = 0; first < opens; first += LANES) {
        const answer a = ask(m, some + first);
        for (uint32_t i = 0; i < LANES && first + i < opens; i++) {
            uint8_t *mask = &masks[open[first + i]];
            const unsigned left = *mask & ~(unsigned)(a.plane >> 8 * i);
            *mask = (uint8_t)((left & (left - 1)) != 0 ? left & ~(unsigned)(a.edges >> 8 * i) : left);
        }
    }
}

/* Adds up to 255 masks to the counts of their bits. */
static inline void count_bits(const uint8_t *masks, uint32_t count, uint32_t counts[8])
{
    uint64_t few = 0; /* a byte a child */
    for (uint32_t i = 0; i < count; i++)
        few += ((masks[i] * 0x0101010101010101u & 0x8040201008040201u) + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u;
    for (unsigned c = 0; c < 8; c++)
        counts[c] += few >> 8 * c & 0xffu;
}

static void touched(const rti_octree_middle *m, const rti_build_input *in, const rti_ref *refs, const uint32_t *which,
                    uint32_t count, uint8_t *masks, uint32_t counts[8])
{
    uint8_t open[BATCH];
    for (uint32_t i = 0; i < count; i += BATCH) {
        const uint32_t n = rtk_umin(count - i, BATCH);
        const uint32_t *some = which ? which + i : NULL;
        const rti_ref *from = which ? refs : refs + i;
        const uint32_t opens = by_boxes(m, in->tri_count, from, some, n, masks + i, open);
        by_triangles(m, in->tris, from, some, open, opens, masks + i);
        count_bits(masks + i, n, counts);
    }
}

/* Those of eight that are in `bits` side by side; returns where they end. All eight places are read and written. */
static inline uint32_t *put(const uint32_t *from, unsigned bits, uint32_t *to)
{
#ifdef RTI_PACK8
    rti_u8_pack(to, bits, from);
    return to + __builtin_popcount(bits);
#else
    for (uint32_t i = 0; i < 8; i++) {
        *to = from[i];
        to += bits >> i & 1u;
    }
    return to;
#endif
}

static void deal(const uint32_t *from, uint8_t *masks, uint32_t count, uint32_t *to)
{
    memset(masks + count, 0, RTI_OCTREE_AHEAD);
    for (uint32_t i = 0; i < count; i += 8) { /* now a byte a child */
        uint64_t eight;
        memcpy(&eight, masks + i, sizeof eight);
        eight = turned(eight);
        for (uint32_t c = 0; c < 8; c++)
            masks[i + c] = (uint8_t)(eight >> 8 * c);
    }
    for (uint32_t c = 8; c-- > 0;)
        for (uint32_t i = 0; i < count; i += 8)
            to = put(from + i, masks[i + c], to);
}

const rti_octree_kernels RTI_ISA_FN(rti_octree_kernels) = {touched, deal};
