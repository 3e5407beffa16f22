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

/* Of the third to fifth Sobol dimension (direction numbers of Joe, Kuo 2008) what each four bits of an index add, numbers
 * reversed: [dimension][which four][their value]. The first two need no table: the index itself, and that times Pascal's
 * triangle modulo 2. */
RT_CONSTANT rtk_u32 rtk_sobol_fours[3][8][16] = {
    {{0x00000000u, 0x00000001u, 0x00000003u, 0x00000002u, 0x00000006u, 0x00000007u, 0x00000005u, 0x00000004u,
      0x00000009u, 0x00000008u, 0x0000000au, 0x0000000bu, 0x0000000fu, 0x0000000eu, 0x0000000cu, 0x0000000du},
     {0x00000000u, 0x00000017u, 0x0000003au, 0x0000002du, 0x00000071u, 0x00000066u, 0x0000004bu, 0x0000005cu,
      0x000000a3u, 0x000000b4u, 0x00000099u, 0x0000008eu, 0x000000d2u, 0x000000c5u, 0x000000e8u, 0x000000ffu},
     {0x00000000u, 0x00000116u, 0x00000339u, 0x0000022fu, 0x00000677u, 0x00000761u, 0x0000054eu, 0x00000458u,
      0x000009aau, 0x000008bcu, 0x00000a93u, 0x00000b85u, 0x00000fddu, 0x00000ecbu, 0x00000ce4u, 0x00000df2u},
     {0x00000000u, 0x00001601u, 0x00003903u, 0x00002f02u, 0x00007706u, 0x00006107u, 0x00004e05u, 0x00005804u,
      0x0000aa09u, 0x0000bc08u, 0x0000930au, 0x0000850bu, 0x0000dd0fu, 0x0000cb0eu, 0x0000e40cu, 0x0000f20du},
     {0x00000000u, 0x00010117u, 0x0003033au, 0x0002022du, 0x00060671u, 0x00070766u, 0x0005054bu, 0x0004045cu,
      0x000909a3u, 0x000808b4u, 0x000a0a99u, 0x000b0b8eu, 0x000f0fd2u, 0x000e0ec5u, 0x000c0ce8u, 0x000d0dffu},
     {0x00000000u, 0x00171616u, 0x003a3939u, 0x002d2f2fu, 0x00717777u, 0x00666161u, 0x004b4e4eu, 0x005c5858u,
      0x00a3aaaau, 0x00b4bcbcu, 0x00999393u, 0x008e8585u, 0x00d2ddddu, 0x00c5cbcbu, 0x00e8e4e4u, 0x00fff2f2u},
     {0x00000000u, 0x01170001u, 0x033a0003u, 0x022d0002u, 0x06710006u, 0x07660007u, 0x054b0005u, 0x045c0004u,
      0x09a30009u, 0x08b40008u, 0x0a99000au, 0x0b8e000bu, 0x0fd2000fu, 0x0ec5000eu, 0x0ce8000cu, 0x0dff000du},
     {0x00000000u, 0x16160017u, 0x3939003au, 0x2f2f002du, 0x77770071u, 0x61610066u, 0x4e4e004bu, 0x5858005cu,
      0xaaaa00a3u, 0xbcbc00b4u, 0x93930099u, 0x8585008eu, 0xdddd00d2u, 0xcbcb00c5u, 0xe4e400e8u, 0xf2f200ffu}},
    {{0x00000000u, 0x00000001u, 0x00000003u, 0x00000002u, 0x00000004u, 0x00000005u, 0x00000007u, 0x00000006u,
      0x0000000au, 0x0000000bu, 0x00000009u, 0x00000008u, 0x0000000eu, 0x0000000fu, 0x0000000du, 0x0000000cu},
     {0x00000000u, 0x0000001fu, 0x0000002eu, 0x00000031u, 0x00000045u, 0x0000005au, 0x0000006bu, 0x00000074u,
      0x000000c9u, 0x000000d6u, 0x000000e7u, 0x000000f8u, 0x0000008cu, 0x00000093u, 0x000000a2u, 0x000000bdu},
     {0x00000000u, 0x0000011bu, 0x000002a4u, 0x000003bfu, 0x0000079au, 0x00000681u, 0x0000053eu, 0x00000425u,
      0x00000b67u, 0x00000a7cu, 0x000009c3u, 0x000008d8u, 0x00000cfdu, 0x00000de6u, 0x00000e59u, 0x00000f42u},
     {0x00000000u, 0x0000101eu, 0x0000302du, 0x00002033u, 0x00004041u, 0x0000505fu, 0x0000706cu, 0x00006072u,
      0x0000a0c3u, 0x0000b0ddu, 0x000090eeu, 0x000080f0u, 0x0000e082u, 0x0000f09cu, 0x0000d0afu, 0x0000c0b1u},
     {0x00000000u, 0x0001f104u, 0x0002e28au, 0x0003138eu, 0x000457dfu, 0x0005a6dbu, 0x0006b555u, 0x00074451u,
      0x000c9baeu, 0x000d6aaau, 0x000e7924u, 0x000f8820u, 0x0008cc71u, 0x00093d75u, 0x000a2efbu, 0x000bdfffu},
     {0x00000000u, 0x0011a105u, 0x002a7289u, 0x003bd38cu, 0x0079e7dbu, 0x006846deu, 0x00539552u, 0x00423457u,
      0x00b6dba4u, 0x00a77aa1u, 0x009ca92du, 0x008d0828u, 0x00cf3c7fu, 0x00de9d7au, 0x00e54ef6u, 0x00f4eff3u},
     {0x00000000u, 0x0100011au, 0x030002a7u, 0x020003bdu, 0x0400079eu, 0x05000684u, 0x07000539u, 0x06000423u,
      0x0a000b6du, 0x0b000a77u, 0x090009cau, 0x080008d0u, 0x0e000cf3u, 0x0f000de9u, 0x0d000e54u, 0x0c000f4eu},
     {0x00000000u, 0x1f001001u, 0x2e003003u, 0x31002002u, 0x45004004u, 0x5a005005u, 0x6b007007u, 0x74006006u,
      0xc900a00au, 0xd600b00bu, 0xe7009009u, 0xf8008008u, 0x8c00e00eu, 0x9300f00fu, 0xa200d00du, 0xbd00c00cu}},
    {{0x00000000u, 0x00000001u, 0x00000002u, 0x00000003u, 0x00000004u, 0x00000005u, 0x00000006u, 0x00000007u,
      0x0000000du, 0x0000000cu, 0x0000000fu, 0x0000000eu, 0x00000009u, 0x00000008u, 0x0000000bu, 0x0000000au},
     {0x00000000u, 0x0000001fu, 0x0000003bu, 0x00000024u, 0x0000005eu, 0x00000041u, 0x00000065u, 0x0000007au,
      0x000000b9u, 0x000000a6u, 0x00000082u, 0x0000009du, 0x000000e7u, 0x000000f8u, 0x000000dcu, 0x000000c3u},
     {0x00000000u, 0x0000015au, 0x000003f4u, 0x000002aeu, 0x00000685u, 0x000007dfu, 0x00000571u, 0x0000042bu,
      0x00000d0fu, 0x00000c55u, 0x00000efbu, 0x00000fa1u, 0x00000b8au, 0x00000ad0u, 0x0000087eu, 0x00000924u},
     {0x00000000u, 0x0000115bu, 0x000023f6u, 0x000032adu, 0x00004681u, 0x000057dau, 0x00006577u, 0x0000742cu,
      0x0000dd02u, 0x0000cc59u, 0x0000fef4u, 0x0000efafu, 0x00009b83u, 0x00008ad8u, 0x0000b875u, 0x0000a92eu},
     {0x00000000u, 0x0001e144u, 0x000393cdu, 0x00027289u, 0x0005a6dfu, 0x0004479bu, 0x00063512u, 0x0007d456u,
      0x000b4dbbu, 0x000aacffu, 0x0008de76u, 0x00093f32u, 0x000eeb64u, 0x000f0a20u, 0x000d78a9u, 0x000c99edu},
     {0x00000000u, 0x0014401eu, 0x003cd039u, 0x00289027u, 0x006df05au, 0x0079b044u, 0x00512063u, 0x0045607du,
      0x00dbb0b4u, 0x00cff0aau, 0x00e7608du, 0x00f32093u, 0x00b640eeu, 0x00a200f0u, 0x008a90d7u, 0x009ed0c9u},
     {0x00000000u, 0x0101e145u, 0x020393cfu, 0x0302728au, 0x0405a6dbu, 0x0504479eu, 0x06063514u, 0x0707d451u,
      0x0d0b4db6u, 0x0c0aacf3u, 0x0f08de79u, 0x0e093f3cu, 0x090eeb6du, 0x080f0a28u, 0x0b0d78a2u, 0x0a0c99e7u},
     {0x00000000u, 0x1f144001u, 0x3b3cd002u, 0x24289003u, 0x5e6df004u, 0x4179b005u, 0x65512006u, 0x7a456007u,
      0xb9dbb00du, 0xa6cff00cu, 0x82e7600fu, 0x9df3200eu, 0xe7b64009u, 0xf8a20008u, 0xdc8a900bu, 0xc39ed00au}}};

/* The index-th Sobol point, its bits reversed, as it is scrambled. */
RTK_FN rtk_u32 rtk_sobol_reversed(rtk_u32 index, rtk_u32 place)
{
    rtk_u32 x = index, i;
    if (place >= 2u) {
        x = 0u;
        for (i = 0u; i < 8u; i++)
            x ^= rtk_sobol_fours[place - 2u][i][(index >> (4u * i)) & 15u];
    } else if (place == 1u) {
        x ^= (x & 0xaaaaaaaau) >> 1;
        x ^= (x & 0xccccccccu) >> 2;
        x ^= (x & 0xf0f0f0f0u) >> 4;
        x ^= (x & 0xff00ff00u) >> 8;
        x ^= x >> 16;
    }
    return x;
}

/* What all dimensions of one path vertex share. */
RTK_FN rtk_u32 rtk_vertex_seed(rtk_u32 seed, rtk_u32 pixel, rtk_key key)
{
    return rtk_hash2(rtk_hash2(rtk_hash2(seed, pixel), key.lo), key.hi);
}

/* Seeds of a vertex that do not depend on the sample: of the order that the dimensions of dim's group share, and of a dimension. */
RTK_FN rtk_u32 rtk_order_seed(rtk_u32 vertex_seed, rtk_u32 dim)
{
    return rtk_hash2(vertex_seed, dim >> 3);
}

RTK_FN rtk_u32 rtk_number_seed(rtk_u32 vertex_seed, rtk_u32 dim)
{
    return rtk_hash2(vertex_seed, dim + 0x10000u);
}

/* The place of the index-th sample in the sequence of that order. */
RTK_FN rtk_u32 rtk_shuffled_by(rtk_u32 order_seed, rtk_u32 index)
{
    return rtk_reverse(rtk_owen_reversed(rtk_reverse(index), order_seed));
}

/* The number of dimension dim at that place. */
RTK_FN rtk_u32 rtk_scrambled_by(rtk_u32 number_seed, rtk_u32 shuffled, rtk_u32 dim)
{
    return rtk_reverse(rtk_owen_reversed(rtk_sobol_reversed(shuffled, rtk_umin(dim & 7u, 4u)), number_seed));
}

/* Both, with their seeds. */
RTK_FN rtk_u32 rtk_shuffled(rtk_u32 vertex_seed, rtk_u32 index, rtk_u32 dim)
{
    return rtk_shuffled_by(rtk_order_seed(vertex_seed, dim), index);
}

RTK_FN rtk_u32 rtk_scrambled(rtk_u32 vertex_seed, rtk_u32 shuffled, rtk_u32 dim)
{
    return rtk_scrambled_by(rtk_number_seed(vertex_seed, dim), shuffled, dim);
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
