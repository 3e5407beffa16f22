/* Both ends of a ray's life in lanes: where it leaves the camera, and the row of an image that sums become. */
#include "../kernel/filter.h"
#include "lanes.h"
#include "lanes_random.h"
#include "lanes_table.h"

RTI_LANES_FN static void seed_pixels(const rti_frame *f, const uint32_t *pixel, rti_pair_seeds *pairs)
{
    const uint32_t seed = f->seed;
    const rtk_key root = rtk_key_root();
    uint32_t vertex[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    vertex[k] = rtk_vertex_seed(seed, pixel[k], root);
    rti_seed_pairs(vertex, RTK_DIM_FILTER_X, pairs);
}

/* Where in the pixels' filter the rays pass; the single sample of a pixel is its middle. */
RTI_LANES_FN static void offsets(const rti_frame *f, const rti_pair_seeds *pairs, const uint32_t *sample, float *dx, float *dy)
{
    const float width = f->set.desc.filter_width;
    float x[RTK_BLOCK] RTI_ROW, y[RTK_BLOCK] RTI_ROW;
    rti_draw_pairs(pairs, RTK_DIM_FILTER_X, sample, 0, x, y);
    if (f->set.desc.filter == RT_FILTER_GAUSSIAN) { /* takes a logarithm: lane after lane */
        for (uint32_t k = 0; k < RTK_BLOCK; k++) {
            rtk_uv u = {x[k], y[k]};
            u = rtk_filter_gaussian(u, width);
            dx[k] = u.x;
            dy[k] = u.y;
        }
    } else {
        RTI_EACH_LANE(k)
        {
            rtk_uv u = {x[k], y[k]};
            u = rtk_filter_box(u, width);
            dx[k] = u.x;
            dy[k] = u.y;
        }
    }
}

RTI_LANES_FN static void rays(const rti_frame *f, const float *px, const float *py, rtk_trace_block *restrict t)
{
    const rtk_lens lens = f->lens;
    RTI_EACH_LANE(k)
    {
        rtk_vec3 org, dir;
        rtk_lens_ray(lens, px[k], py[k], &org, &dir);
        t->ox[k] = org.x;
        t->oy[k] = org.y;
        t->oz[k] = org.z;
        t->dx[k] = dir.x;
        t->dy[k] = dir.y;
        t->dz[k] = dir.z;
    }
}

/* What all rays of a camera share. */
RTI_LANES_FN static void states(const rti_frame *f, rtk_trace_block *restrict t, rtk_path_block *restrict p)
{
    const float width = f->lens.width, spread = f->lens.spread;
    const rtk_key root = rtk_key_root();
    RTI_EACH_LANE(k)
    {
        t->tmin[k] = 0.0f;
        t->tmax[k] = RTK_INF;
        t->mask[k] = RT_MASK_CAMERA;
        p->tpr[k] = 1.0f;
        p->tpg[k] = 1.0f;
        p->tpb[k] = 1.0f;
        p->depth_kind[k] = RTK_KIND_CAMERA << 16;
        p->key_lo[k] = root.lo;
        p->key_hi[k] = root.hi;
        p->eta[k] = 1.0f;
        p->width[k] = width;
        p->spread[k] = spread;
        p->pdf[k] = -1.0f;
    }
}

/* Columns and rows of the lanes in groups of one to four columns. What stands behind a group's last row is no ray. */
static const uint32_t columns[RTI_GROUP][RTK_BLOCK] RTI_ROW = {
    {0}, {0, 1, 0, 1, 0, 1, 0, 1}, {0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2}, {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}};
static const uint32_t rows[RTI_GROUP][RTK_BLOCK] RTI_ROW = {{0, 1, 2, 3},
                                                            {0, 0, 1, 1, 2, 2, 3, 3},
                                                            {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3},
                                                            {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}};

/* A group's samples come one after the other. */
static const rti_pair_seeds *seeds_of(const rti_frame *f, const rti_pixel_group *g, const uint32_t *pixel, rti_pixel_seeds *s)
{
    if (s->x != g->x || s->y != g->y || s->columns != g->columns) {
        s->x = g->x;
        s->y = g->y;
        s->columns = g->columns;
        seed_pixels(f, pixel, &s->pair);
    }
    return &s->pair;
}

void RTI_ISA_FN(rti_lanes_camera)(const rti_frame *f, const rti_pixel_group *group, bool again, rti_pixel_seeds *seeds,
                                  rtk_trace_block *trace, rtk_path_block *path, rti_home_block *home, float *px, float *py)
{
    const rti_pixel_group g = *group;
    const uint32_t width = f->set.desc.width, *column = columns[g.columns - 1], *row = rows[g.columns - 1];
    float dx[RTK_BLOCK] RTI_ROW = {0}, dy[RTK_BLOCK] RTI_ROW = {0};
    RTI_EACH_LANE(k)
    {
        path->pixel[k] = (g.y + row[k]) * width + g.x + column[k];
        path->sample[k] = g.sample;
        home->home[k] = g.home + row[k] * g.pitch + column[k];
    }
    if (f->set.samples > 1)
        offsets(f, seeds_of(f, group, path->pixel, seeds), path->sample, dx, dy);
    RTI_EACH_LANE(k)
    { /* signed: a coordinate is below 2^20, and older processors convert nothing else */
        px[k] = (float)(int32_t)(g.x + column[k]) + 0.5f + dx[k];
        py[k] = (float)(int32_t)(g.y + row[k]) + 0.5f + dy[k];
    }
    rays(f, px, py, trace);
    if (!again)
        states(f, trace, path);
}

/* A power of two divides as its inverse multiplies. Four pixels' sums at a time: a loop that asks for the channel is no vector.
 */
void RTI_ISA_FN(rti_lanes_resolve)(const uint64_t *restrict sum, float *restrict out, uint32_t pixels, double unit,
                                   double samples)
{
    const uint64_t whole = (uint64_t)samples;
    const bool power = (whole & (whole - 1)) == 0;
    const double times = power ? 1.0 / samples : 1.0, over = power ? 1.0 : samples;
    const uint32_t n = pixels * RTK_FILM_CHANNELS;
    double factor[RTK_BLOCK] RTI_ROW;
    uint32_t at = 0;
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        factor[k] = k % RTK_FILM_CHANNELS == 3 ? 1.0 : unit;
    for (; power && n - at >= RTK_BLOCK; at += RTK_BLOCK) {
        RTI_EACH_LANE(k)
        out[at + k] = (float)((double)(int64_t)sum[at + k] * factor[k] * times);
    }
    for (; n - at >= RTK_BLOCK; at += RTK_BLOCK) {
        RTI_EACH_LANE(k)
        out[at + k] = (float)((double)(int64_t)sum[at + k] * factor[k] / over);
    }
    for (; at < n; at++)
        out[at] = (float)((double)(int64_t)sum[at] * factor[at % RTK_FILM_CHANNELS] * times / over);
}
