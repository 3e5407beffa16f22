/* Random numbers without a stream: each is a hash of (seed, pixel, path key, dimension) and a sample index, so it is the same
 * whoever asks, in whatever order (architecture.md, idea 4).
 *
 * Values: Owen-scrambled Sobol points by hashing, Burley 2020 ("Practical Hash-based Owen Scrambling"), with the permutation of
 * the scramble as improved by Vegdahl 2021. Every group of dimensions (table below) is a Sobol sequence of its own, its
 * index shuffled by a hash of (seed, pixel, key, group): 2^k samples of a pixel are stratified in each dimension, in both
 * dimensions of the first pair of each group (every elementary interval holds its share), and groups, pixels and keys
 * are independent of each other.
 */
#ifndef RTK_RNG_H
#define RTK_RNG_H

#include "types.h"

/* The one table of dimensions: group * 8 + place in the group. Places 0 and 1 are the best pair; at most five places. A path
 * vertex has its own key, so these are per vertex, not per path. */
enum {
    RTK_DIM_FILTER_X = 0, /* where in the pixel's filter */
    RTK_DIM_FILTER_Y = 1,
    RTK_DIM_LENS_U = 2,
    RTK_DIM_LENS_V = 3,
    RTK_DIM_TIME = 4,
    RTK_DIM_LIGHT_U = 8, /* point on (cone towards) a light; index: sample * shadow rays + ray */
    RTK_DIM_LIGHT_V = 9,
    RTK_DIM_LIGHT_CHOICE = 10,
    RTK_DIM_BSDF_U = 16, /* scattered direction */
    RTK_DIM_BSDF_V = 17,
    RTK_DIM_LOBE = 18, /* which part of the material scatters */
    RTK_DIM_ROULETTE = 19,
    RTK_DIM_AO_U = 24, /* index: sample * ao rays + ray */
    RTK_DIM_AO_V = 25,
    RTK_DIM_CUT = 32, /* stochastic choices of textures and cut-outs */
    RTK_DIM_USER = 40 /* and above: debug views, tests */
};

/* Address of a path vertex: the camera's root, and each child from its parent and the number of the branch it took (RTK_KIND_*,
 * or kind and ray number where a vertex sends several). */
typedef struct rtk_key {
    rtk_u32 lo, hi;
} rtk_key;

/* A bijection of 32-bit words in which every input bit reaches every output bit (two multiply-xorshift rounds). */
RTK_FN rtk_u32 rtk_mix(rtk_u32 x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15);
}

RTK_FN rtk_u32 rtk_hash2(rtk_u32 a, rtk_u32 b)
{
    return rtk_mix(rtk_mix(a + 0x9e3779b9u) ^ (b + 0x7f4a7c15u));
}

RTK_FN rtk_key rtk_key_root(void)
{
    rtk_key k;
    k.lo = 0x243f6a88u;
    k.hi = 0x85a308d3u;
    return k;
}

/* 64 bits, the finaliser of SplitMix64: two vertices of one pixel share a key about never. */
RTK_FN rtk_key rtk_key_child(rtk_key parent, rtk_u32 branch)
{
    rtk_u64 x = (((rtk_u64)parent.hi << 32) | parent.lo) + ((rtk_u64)branch + 1u) * 0x9e3779b97f4a7c15u;
    rtk_key k;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    k.lo = (rtk_u32)x;
    k.hi = (rtk_u32)(x >> 32);
    return k;
}

/* [0, 1), multiples of 2^-24. */
RTK_FN float rtk_unit_float(rtk_u32 x)
{
    return (float)(x >> 8) * 5.9604645e-08f;
}

RTK_FN rtk_u32 rtk_reverse(rtk_u32 x)
{
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

/* A permutation in which bit i of the result depends on bits 0 ... i of x alone: Owen's scramble of the reversed number. */
RTK_FN rtk_u32 rtk_owen_reversed(rtk_u32 x, rtk_u32 seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Direction numbers of the third to fifth Sobol dimension (Joe, Kuo 2008). The first two need none: a bit reversal, and
 * that times Pascal's triangle modulo 2. */
RT_CONSTANT rtk_u32 rtk_sobol_directions[3][32] = {
    {0x80000000u, 0xc0000000u, 0x60000000u, 0x90000000u, 0xe8000000u, 0x5c000000u, 0x8e000000u, 0xc5000000u,
     0x68800000u, 0x9cc00000u, 0xee600000u, 0x55900000u, 0x80680000u, 0xc09c0000u, 0x60ee0000u, 0x90550000u,
     0xe8808000u, 0x5cc0c000u, 0x8e606000u, 0xc5909000u, 0x6868e800u, 0x9c9c5c00u, 0xeeee8e00u, 0x5555c500u,
     0x8000e880u, 0xc0005cc0u, 0x60008e60u, 0x9000c590u, 0xe8006868u, 0x5c009c9cu, 0x8e00eeeeu, 0xc5005555u},
    {0x80000000u, 0xc0000000u, 0x20000000u, 0x50000000u, 0xf8000000u, 0x74000000u, 0xa2000000u, 0x93000000u,
     0xd8800000u, 0x25400000u, 0x59e00000u, 0xe6d00000u, 0x78080000u, 0xb40c0000u, 0x82020000u, 0xc3050000u,
     0x208f8000u, 0x51474000u, 0xfbea2000u, 0x75d93000u, 0xa0858800u, 0x914e5400u, 0xdbe79e00u, 0x25db6d00u,
     0x58800080u, 0xe54000c0u, 0x79e00020u, 0xb6d00050u, 0x800800f8u, 0xc00c0074u, 0x200200a2u, 0x50050093u},
    {0x80000000u, 0x40000000u, 0x20000000u, 0xb0000000u, 0xf8000000u, 0xdc000000u, 0x7a000000u, 0x9d000000u,
     0x5a800000u, 0x2fc00000u, 0xa1600000u, 0xf0b00000u, 0xda880000u, 0x6fc40000u, 0x81620000u, 0x40bb0000u,
     0x22878000u, 0xb3c9c000u, 0xfb65a000u, 0xddb2d000u, 0x78022800u, 0x9c0b3c00u, 0x5a0fb600u, 0x2d0ddb00u,
     0xa2878080u, 0xf3c9c040u, 0xdb65a020u, 0x6db2d0b0u, 0x800228f8u, 0x400b3cdcu, 0x200fb67au, 0xb00ddb9du}};

RTK_FN rtk_u32 rtk_sobol(rtk_u32 index, rtk_u32 place)
{
    rtk_u32 x, i;
    if (place >= 2u) {
        x = 0u;
        for (i = 0u; i < 32u; i++)
            x ^= rtk_sobol_directions[place - 2u][i] & (0u - ((index >> i) & 1u));
        return x;
    }
    x = rtk_reverse(index);
    if (place == 1u) {
        x ^= (x & 0x55555555u) << 1;
        x ^= (x & 0x33333333u) << 2;
        x ^= (x & 0x0f0f0f0fu) << 4;
        x ^= (x & 0x00ff00ffu) << 8;
        x ^= x << 16;
    }
    return x;
}

/* What all dimensions of one path vertex share. */
RTK_FN rtk_u32 rtk_vertex_seed(rtk_u32 seed, rtk_u32 pixel, rtk_key key)
{
    return rtk_hash2(rtk_hash2(rtk_hash2(seed, pixel), key.lo), key.hi);
}

/* The place of the index-th sample in the sequence that the dimensions of dim's group share. */
RTK_FN rtk_u32 rtk_shuffled(rtk_u32 vertex_seed, rtk_u32 index, rtk_u32 dim)
{
    return rtk_reverse(rtk_owen_reversed(rtk_reverse(index), rtk_hash2(vertex_seed, dim >> 3)));
}

/* The number of dimension dim at that place. */
RTK_FN rtk_u32 rtk_scrambled(rtk_u32 vertex_seed, rtk_u32 shuffled, rtk_u32 dim)
{
    rtk_u32 point = rtk_sobol(shuffled, rtk_umin(dim & 7u, 4u));
    return rtk_reverse(rtk_owen_reversed(rtk_reverse(point), rtk_hash2(vertex_seed, dim + 0x10000u)));
}

/* The index-th number of a dimension (RTK_DIM_*) at a vertex: 32 random bits, of which the leading ones are stratified. */
RTK_FN rtk_u32 rtk_random_bits(rtk_u32 vertex_seed, rtk_u32 index, rtk_u32 dim)
{
    return rtk_scrambled(vertex_seed, rtk_shuffled(vertex_seed, index, dim), dim);
}

RTK_FN float rtk_random(rtk_u32 vertex_seed, rtk_u32 index, rtk_u32 dim)
{
    return rtk_unit_float(rtk_random_bits(vertex_seed, index, dim));
}

/* A plain hash for what needs no stratification: PCG-quality bits from any three words. */
RTK_FN rtk_u32 rtk_hash3(rtk_u32 a, rtk_u32 b, rtk_u32 c)
{
    return rtk_hash2(rtk_hash2(a, b), c);
}

#endif
