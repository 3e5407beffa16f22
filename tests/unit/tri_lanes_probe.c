/* The vector leaf tests of one instruction set, in a form that a test can call. Compiled once a level. */
#include "tri_lanes_probe.h"

#include "probe_widths.h"
#include "trace/packet.h"

#define PROBE(N)                                                                                                                 \
    static void RTI_ISA_FN(probe##N)(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)                               \
    {                                                                                                                            \
        float c[9][N], p[10][N];                                                                                                 \
        rti_tri_hit##N hit;                                                                                                      \
        for (int i = 0; i < N; i++) {                                                                                            \
            const rtk_pray *r = &rays[i];                                                                                        \
            const float *v[3] = {tris[i].v0, tris[i].v1, tris[i].v2};                                                            \
            const float of[10] = {r->korg.x, r->korg.y, r->korg.z, r->sx, r->sy, r->kdz, r->tmin, r->tmax, r->tshift, r->scale}; \
            for (int k = 0; k < 3; k++) {                                                                                        \
                c[3 * k][i] = v[k][r->kx];                                                                                       \
                c[3 * k + 1][i] = v[k][r->ky];                                                                                   \
                c[3 * k + 2][i] = v[k][r->kz];                                                                                   \
            }                                                                                                                    \
            for (int k = 0; k < 10; k++)                                                                                         \
                p[k][i] = of[k];                                                                                                 \
        }                                                                                                                        \
        rti_f##N x[9];                                                                                                           \
        for (int k = 0; k < 9; k++)                                                                                              \
            x[k] = rti_f##N##_load(c[k]);                                                                                        \
        rti_tri_ray##N r = {rti_f##N##_load(p[0]), rti_f##N##_load(p[1]), rti_f##N##_load(p[2]), rti_f##N##_load(p[3]),          \
                            rti_f##N##_load(p[4]), rti_f##N##_load(p[5]), rti_f##N##_load(p[6]), rti_f##N##_load(p[7]),          \
                            rti_f##N##_load(p[8]), rti_f##N##_load(p[9])};                                                       \
        uint32_t bits = rti_tri##N(&r, x, x + 3, x + 6, (1u << N) - 1u, &hit);                                                   \
        for (int i = 0; i < N; i++)                                                                                              \
            out[i] = (probe_answer){bits && (hit.hit >> i & 1u), bits && (hit.doubt >> i & 1u), 0, 0, 0, 0, 0};                  \
        if (bits) {                                                                                                              \
            rti_f##N##_store(p[0], hit.t);                                                                                       \
            rti_f##N##_store(p[1], hit.u);                                                                                       \
            rti_f##N##_store(p[2], hit.v);                                                                                       \
            rti_f##N##_store(p[3], hit.off);                                                                                     \
        }                                                                                                                        \
        for (int i = 0; bits && i < N; i++) {                                                                                    \
            out[i].t = p[0][i];                                                                                                  \
            out[i].u = p[1][i];                                                                                                  \
            out[i].v = p[2][i];                                                                                                  \
            out[i].off = p[3][i];                                                                                                \
            out[i].certain = (int)(hit.certain >> i & 1u);                                                                       \
        }                                                                                                                        \
    }
PROBE_WIDTHS(PROBE)
#undef PROBE

uint32_t RTI_ISA_FN(probe_width)(uint32_t at_most)
{
    return at_most < RTI_SIMD ? at_most : RTI_SIMD;
}

void RTI_ISA_FN(probe_triangles)(uint32_t width, const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)
{
#define ASK(N)                                                                                                                   \
    if (width == N)                                                                                                              \
        RTI_ISA_FN(probe##N)(rays, tris, out);
    PROBE_WIDTHS(ASK)
#undef ASK
}

/* RTI_SIMD rays and triangles in vectors: in[9], in[10] are the directions, from in[12] on the corners, in the rays' orders of
 * axes. */
static tri_ray load_pairs(const rtk_pray *rays, const rtk_tri *tris, vec in[21])
{
    float p[21][RTI_SIMD];
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rtk_pray *r = &rays[i];
        const rtk_tri *t = &tris[i];
        const float of[12] = {r->korg.x,
                              r->korg.y,
                              r->korg.z,
                              r->sx,
                              r->sy,
                              r->kdz,
                              r->tmin,
                              r->tmax,
                              r->scale,
                              rtk_axis(r->dir, r->kx),
                              rtk_axis(r->dir, r->ky),
                              0.0f};
        const rtk_u32 k[3] = {r->kx, r->ky, r->kz};
        for (rtk_u32 j = 0u; j < 12u; j++)
            p[j][i] = of[j];
        for (rtk_u32 j = 0u; j < 3u; j++) {
            p[12u + j][i] = t->v0[k[j]];
            p[15u + j][i] = t->v1[k[j]];
            p[18u + j][i] = t->v2[k[j]];
        }
    }
    for (rtk_u32 j = 0u; j < 21u; j++)
        in[j] = V(load)(p[j]);
    return (tri_ray){in[0], in[1], in[2], in[3], in[4], in[5], in[6], in[7], in[11], in[8]};
}

uint32_t RTI_ISA_FN(probe_exact)(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)
{
    vec in[21];
    float p[3][RTI_SIMD];
    tri_hit hit;
    const tri_ray r = load_pairs(rays, tris, in);
    rtk_u32 first, doubt = 0u;
    first = tri_test(&r, in + 12, in + 15, in + 18, LANES_ALL, &hit);
    if (first != 0u) {
        first = hit.doubt;
        doubt = first ? tri_exact(&r, &in[9], &in[10], in + 12, in + 15, in + 18, first, &hit) : 0u;
        V(store)(p[0], hit.t);
        V(store)(p[1], hit.u);
        V(store)(p[2], hit.v);
        for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
            out[i] = (probe_answer){hit.hit >> i & 1u, doubt >> i & 1u, 0, p[0][i], p[1][i], p[2][i], 0};
        return (uint32_t)__builtin_popcount(first);
    }
    memset(out, 0, RTI_SIMD * sizeof *out);
    return 0;
}

static rti_tri_pair pair_of(const tri_ray *r, rtk_u32 i)
{
    return (rti_tri_pair){r->ox[i],  r->oy[i],     r->oz[i],    r->sx[i],   r->sy[i],
                          r->kdz[i], r->tshift[i], r->scale[i], r->tmin[i], r->tmax[i]};
}

uint32_t RTI_ISA_FN(probe_double)(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)
{
    vec in[21];
    tri_hit hit;
    const tri_ray r = load_pairs(rays, tris, in);
    memset(&hit, 0, sizeof hit);
    rtk_u32 doubt = tri_test(&r, in + 12, in + 15, in + 18, LANES_ALL, &hit) != 0u ? hit.doubt : 0u, edges = 0u, left;
    left = tri_double(&r, &in[9], &in[10], in + 12, in + 15, in + 18, NULL, doubt, &hit, &edges);
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rti_tri_pair pair = pair_of(&r, i);
        const float c[3][3] = {
            {in[12][i], in[13][i], in[14][i]}, {in[15][i], in[16][i], in[17][i]}, {in[18][i], in[19][i], in[20][i]}};
        const float many[3] = {hit.t[i], hit.u[i], hit.v[i]};
        const rtk_u32 lane = doubt & 1u << i;
        float one[3];
        rtk_u32 edge = 0u, good = (rtk_u32)tri_double_one(&pair, in[9][i], in[10][i], c[0], c[1], c[2], one);
        out[i].doubt = (int)((left & ~edges) >> i & 1u);
        out[i].hit = lane != 0u && (good != (hit.hit >> i & 1u) || (good != 0u && memcmp(one, many, sizeof one) != 0));
        if (lane == 0u)
            continue;
        tri_hit of_one = hit; /* where all lanes' triangle is one */
        of_one.hit = 0u;
        const rtk_u32 behind = tri_double(&r, &in[9], &in[10], in + 12, in + 15, in + 18, c, lane, &of_one, &edge);
        const float same[3] = {of_one.t[i], of_one.u[i], of_one.v[i]};
        out[i].hit |= behind != (left & lane) || edge != (edges & lane) || of_one.hit != (hit.hit & lane) ||
                      memcmp(same, many, sizeof same) != 0;
    }
    return (uint32_t)__builtin_popcount(doubt & ~edges);
}

uint32_t RTI_ISA_FN(probe_settle)(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)
{
    vec in[21];
    const tri_ray r = load_pairs(rays, tris, in);
    rtk_u32 sure = 0u, ask = packet_settle_many(&r, &r.tmax, in + 12, in + 15, in + 18, LANES_ALL, &sure), differ = 0u;
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rti_tri_pair pair = pair_of(&r, i);
        const float c0[3] = {in[12][i], in[13][i], in[14][i]}, c1[3] = {in[15][i], in[16][i], in[17][i]};
        const float c2[3] = {in[18][i], in[19][i], in[20][i]};
        const int one = rti_tri_settle(&pair, c0, c1, c2, NULL), many = (int)(sure >> i & 1u) - !((sure | ask) >> i & 1u);
        out[i] = (probe_answer){many > 0, many == 0, 0, (float)one, 0, 0, 0};
        differ += one != many;
    }
    return differ;
}

uint32_t RTI_ISA_FN(probe_part)(const rtk_ray *rays, const rtk_part *part)
{
    float p[8][RTI_SIMD];
    vec org[3], inv[3], t0, t1;
    rtk_u32 far, in;
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rtk_ray *r = &rays[i];
        const float of[8] = {r->org.x, r->org.y, r->org.z, rtk_inverse(r->dir.x), rtk_inverse(r->dir.y), rtk_inverse(r->dir.z),
                             r->tmin,  r->tmax};
        for (rtk_u32 j = 0u; j < 8u; j++)
            p[j][i] = of[j];
    }
    for (rtk_u32 i = 0u; i < 3u; i++) {
        org[i] = V(load)(p[i]);
        inv[i] = V(load)(p[3u + i]);
    }
    in = packet_rays_enter(org, inv, V(load)(p[6]), V(load)(p[7]), LANES_ALL, part, &t0, &t1, &far);
    return LANES_ALL & ~(in | far);
}
