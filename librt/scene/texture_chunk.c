/* Making a texture chunk: pixels to the tiled, mip-mapped layout that kernels read (rtk_texture_header). */
#include "scene.h"

#include <math.h>
#include <string.h>

#include "../kernel/texture.h"

static uint32_t level_count(const rti_texels *d)
{
    uint32_t n = 1, size = d->width > d->height ? d->width : d->height;
    while (!(d->flags & RTK_TEX_NEAREST) && size > 1 && n < RTK_TEX_LEVELS) {
        size >>= 1;
        n++;
    }
    return n;
}

static size_t tile_count(uint32_t width, uint32_t height)
{
    return (size_t)((width + 7) / 8) * ((height + 7) / 8);
}

/* Stores one row y of the bottom-up level from RGBA texels, repeating the last texel and row into the padding of edge tiles. */
static void store_row(uint8_t *level, uint32_t width, uint32_t height, uint32_t y, const uint8_t *row, size_t texel)
{
    uint32_t rows = y + 1 == height ? ((height + 7) & ~7u) - y : 1, padded = (width + 7) & ~7u;
    for (uint32_t k = 0; k < rows; k++) {
        for (uint32_t x = 0; x < padded; x++)
            memcpy(level + (size_t)rtk_texel_index(width, x, y + k) * texel, row + (size_t)(x < width ? x : width - 1) * texel,
                   texel);
    }
}

static void expand8(const rti_texels *d, uint32_t y, uint8_t *row)
{
    const uint8_t *p = (const uint8_t *)d->pixels + (size_t)y * d->width * d->channels;
    for (uint32_t x = 0; x < d->width; x++, p += d->channels, row += 4) {
        row[0] = p[0];
        row[1] = p[d->channels > 1 ? 1 : 0];
        row[2] = p[d->channels > 1 ? 2 : 0];
        row[3] = d->channels == 4 ? p[3] : 255;
    }
}

/* NaN and infinity would spread over a whole mip level: they become 0 and the largest value that sums can hold. */
static float sane(float x)
{
    return x >= -1.0e30f ? fminf(x, 1.0e30f) : (x < 0.0f ? -1.0e30f : 0.0f);
}

static void expand_float(const rti_texels *d, uint32_t y, float *row)
{
    const float *p = (const float *)d->pixels + (size_t)y * d->width * d->channels;
    for (uint32_t x = 0; x < d->width; x++, p += d->channels, row += 4) {
        for (unsigned k = 0; k < 3; k++)
            row[k] = sane(p[d->channels > 1 ? k : 0]);
        row[3] = d->channels == 4 ? sane(p[3]) : 1.0f;
    }
}

/* The 8-bit code whose linear value is nearest to x: the inverse of rtk_srgb_table without a power. */
static uint8_t encode_srgb(float x)
{
    unsigned low = 0, high = 255;
    while (high - low > 1) {
        unsigned mid = (low + high) / 2;
        if (rtk_srgb_table[mid] <= x)
            low = mid;
        else
            high = mid;
    }
    return (uint8_t)(x - rtk_srgb_table[low] <= rtk_srgb_table[high] - x ? low : high);
}

static void encode(const float rgba[4], uint32_t flags, uint8_t out[4])
{
    for (unsigned k = 0; k < 4; k++) {
        float x = rtk_clamp(rgba[k], 0.0f, 1.0f);
        out[k] = k < 3 && (flags & RTK_TEX_SRGB) ? encode_srgb(x) : (uint8_t)(x * 255.0f + 0.5f);
    }
}

/* Up to three texels of the finer level under one of the coarser, with weights: sizes are halved and rounded down, so an odd size
 * takes three with sliding weights (each finer texel counts the same in sum). Returns how many. */
static unsigned taps(uint32_t i, uint32_t fine, uint32_t coarse, uint32_t first[3], float weight[3])
{
    if (fine == coarse) {
        first[0] = i;
        weight[0] = 1.0f;
        return 1;
    }
    for (unsigned k = 0; k < 3; k++)
        first[k] = rtk_umin(2 * i + k, fine - 1);
    if (fine == 2 * coarse) {
        weight[0] = weight[1] = 0.5f;
        return 2;
    }
    weight[0] = (float)(coarse - i) / (float)fine;
    weight[1] = (float)coarse / (float)fine;
    weight[2] = (float)(i + 1) / (float)fine;
    return 3;
}

/* Colours are averaged in linear light and weighted by alpha, so that what a cut-out hides does not bleed into its rim. */
static void average(rtk_texture tex, uint32_t level, uint32_t x, uint32_t y, float out[4])
{
    uint32_t w = rtk_level_size(tex.head->width, level), h = rtk_level_size(tex.head->height, level), xs[3], ys[3];
    float wx[3], wy[3], plain[4] = {0.0f, 0.0f, 0.0f, 0.0f}, covered[3] = {0.0f, 0.0f, 0.0f};
    unsigned nx = taps(x, rtk_level_size(tex.head->width, level - 1), w, xs, wx);
    unsigned ny = taps(y, rtk_level_size(tex.head->height, level - 1), h, ys, wy);
    for (unsigned j = 0; j < ny; j++) {
        for (unsigned i = 0; i < nx; i++) {
            float t[4], weight = wx[i] * wy[j];
            rtk_texel(tex, level - 1, xs[i], ys[j], t);
            for (unsigned k = 0; k < 4; k++)
                plain[k] += weight * t[k];
            for (unsigned k = 0; k < 3; k++)
                covered[k] += weight * t[3] * t[k];
        }
    }
    for (unsigned k = 0; k < 3; k++)
        out[k] = (tex.head->flags & RTK_TEX_ALPHA) && plain[3] > 0.0f ? covered[k] / plain[3] : plain[k];
    out[3] = plain[3];
}

typedef struct mip_job {
    uint8_t *data, *rows; /* rows: one row of the widest level a task */
    size_t row_size;
    uint32_t level, step;
} mip_job;

static void mip_rows(void *data, uint32_t task)
{
    const mip_job *job = data;
    rtk_texture tex = {(const rtk_texture_header *)(const void *)job->data};
    uint32_t w = rtk_level_size(tex.head->width, job->level), h = rtk_level_size(tex.head->height, job->level);
    bool floats = (tex.head->flags & RTK_TEX_FLOAT) != 0;
    uint8_t *row = job->rows + job->row_size * task;
    for (uint32_t y = task * job->step; y < h && y < (task + 1) * job->step; y++) {
        for (uint32_t x = 0; x < w; x++) {
            float rgba[4];
            average(tex, job->level, x, y, rgba);
            if (floats)
                memcpy(row + sizeof rgba * x, rgba, sizeof rgba);
            else
                encode(rgba, tex.head->flags, row + 4 * (size_t)x);
        }
        store_row(job->data + tex.head->off_level[job->level], w, h, y, row, floats ? 16 : 4);
    }
}

static void store_base(uint8_t *data, const rti_texels *d, uint8_t *row)
{
    rtk_texture_header *head = (rtk_texture_header *)(void *)data;
    bool floats = (d->flags & RTK_TEX_FLOAT) != 0, alpha = false;
    for (uint32_t y = 0; y < d->height; y++) {
        uint32_t from = d->height - 1 - y;
        if (floats)
            expand_float(d, from, (float *)(void *)row);
        else
            expand8(d, from, row);
        for (uint32_t x = 0; x < d->width; x++)
            alpha |= floats ? ((float *)(void *)row)[4 * (size_t)x + 3] < 1.0f : row[4 * (size_t)x + 3] < 255;
        store_row(data + head->off_level[0], d->width, d->height, y, row, floats ? 16 : 4);
    }
    if (alpha)
        head->flags |= RTK_TEX_ALPHA;
}

#define MIP_TASKS 16u

rt_status rti_texture_chunk(rt_context *ctx, const char *call, const rti_texels *d, rti_chunk **out)
{
    size_t texel = d->flags & RTK_TEX_FLOAT ? 16 : 4, row_size = texel * d->width;
    uint64_t offset[RTK_TEX_LEVELS] = {0};
    uint32_t levels = level_count(d);
    rtk_texture_header *head;
    rti_layout layout;
    rti_fpenv env;
    uint8_t *data, *rows;
    bool shared;
    rti_layout_begin(&layout, sizeof *head);
    for (uint32_t i = 0; i < levels; i++)
        offset[i] = rti_layout_add(&layout, tile_count(rtk_level_size(d->width, i), rtk_level_size(d->height, i)), 64 * texel);
    data = layout.overflow ? NULL : rti_alloc_zero(ctx, layout.size);
    rows = data ? rti_alloc_array(ctx, MIP_TASKS, row_size) : NULL;
    if (!rows) {
        rti_free(ctx, data, layout.size);
        return rti_fail_memory(ctx, call, layout.size);
    }
    head = (rtk_texture_header *)(void *)data;
    head->width = d->width;
    head->height = d->height;
    head->level_count = levels;
    memcpy(head->off_level, offset, sizeof offset);
    head->flags = d->flags;
    env = rti_fp_enter();
    store_base(data, d, rows);
    for (uint32_t i = 1; i < levels; i++) {
        uint32_t h = rtk_level_size(d->height, i);
        mip_job job = {.data = data, .rows = rows, .row_size = row_size, .level = i, .step = (h + MIP_TASKS - 1) / MIP_TASKS};
        rti_parallel(ctx, (h + job.step - 1) / job.step, mip_rows, &job);
    }
    rti_fp_leave(env);
    rti_free(ctx, rows, MIP_TASKS * row_size);
    *out = rti_chunk_share(ctx, RTK_CHUNK_TEXTURE, data, layout.size, NULL, &shared);
    return *out ? RT_OK : rti_fail_memory(ctx, call, sizeof **out);
}
