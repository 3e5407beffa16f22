/* Commit: lights, the choice among them by power, and the lamps around point lights. */
#include "parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double luminance(const float c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Emitted power up to a common factor. Lights without falloff give what they give at the scene's size: reach is its radius
 * squared. */
static double power(const rtk_light *l, double reach)
{
    const double pi = 3.14159265358979323846;
    if (l->falloff <= 0.0f)
        return luminance(l->color) * reach;
    if (l->type == RTK_LIGHT_SPHERE)
        return luminance(l->color) * 4.0 * pi * l->radius * l->radius;
    return luminance(l->color) * 4.0 * pi;
}

static double reach_of(const rtk_group_header *head)
{
    double sum = 0.0;
    if (!(head->lo[0] <= head->hi[0]))
        return 1.0;
    for (int k = 0; k < 3; k++)
        sum += 0.25 * ((double)head->hi[k] - head->lo[k]) * ((double)head->hi[k] - head->lo[k]);
    return sum;
}

/* Probabilities and their running sum; without any power every light is as likely. */
static void set_choice(rtk_light *lights, size_t count, double reach)
{
    double total = 0.0, sum = 0.0;
    for (size_t i = 0; i < count; i++)
        total += power(&lights[i], reach);
    for (size_t i = 0; i < count; i++) {
        double p = total > 0.0 ? power(&lights[i], reach) / total : 1.0 / (double)count;
        sum += p;
        lights[i].select_pdf = (float)p;
        lights[i].select_cdf = i + 1 == count ? 1.0f : fminf((float)sum, 1.0f);
    }
}

/* ---- lamps: for each point light the largest opaque sphere of the scene itself that contains it ---- */

static bool opaque(const rt_scene *scene, const rti_geometry *g, uint32_t prim)
{
    uint32_t id = g->mesh && g->mesh->materials ? g->mesh->materials[prim] : g->material;
    const rtk_material *m = RTI_AT(scene->materials, rtk_material, id);
    return !(m->flags & RTK_MAT_TRANSPARENT);
}

static bool inside(const rtk_shape *s, const float at[3])
{
    double x = (double)at[0] - s->p[0], y = (double)at[1] - s->p[1], z = (double)at[2] - s->p[2], r = s->p[3];
    return x * x + y * y + z * z <= r * r;
}

/* Point lights in the order of x: a sphere asks only those within its reach. */
typedef struct by_x {
    float x;
    uint32_t light;
} by_x;

static int compare_x(const void *a, const void *b)
{
    const by_x *p = a, *q = b;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    return p->light < q->light ? -1 : 1;
}

static void offer_body(const rtk_shape *s, rtk_light *lights, const by_x *order, size_t count)
{
    float low = s->p[0] - s->p[3], high = s->p[0] + s->p[3];
    size_t first = 0, last = count;
    low -= 1.0e-6f * fabsf(low);
    high += 1.0e-6f * fabsf(high);
    while (first < last) {
        size_t mid = first + (last - first) / 2;
        if (order[mid].x < low)
            first = mid + 1;
        else
            last = mid;
    }
    for (; first < count && order[first].x <= high; first++) {
        rtk_light *l = &lights[order[first].light];
        if (s->p[3] > l->body_radius && inside(s, l->at)) {
            memcpy(l->body_at, s->p, sizeof l->body_at);
            l->body_radius = s->p[3];
        }
    }
}

static rt_status find_bodies(rti_commit *c, rtk_light *lights, size_t light_count)
{
    const rt_scene *scene = c->scene;
    by_x *order = rti_alloc_array(scene->ctx, light_count, sizeof *order);
    size_t count = 0;
    rt_status status = RT_OK;
    if (!order)
        return rti_fail_memory(scene->ctx, c->call, light_count * sizeof *order);
    for (size_t i = 0; i < light_count; i++) {
        if (lights[i].type == RTK_LIGHT_POINT)
            order[count++] = (by_x){lights[i].at[0], (uint32_t)i};
    }
    qsort(order, count, sizeof *order, compare_x);
    for (size_t i = 0; count > 0 && i < scene->geometries.count && status == RT_OK; i++) {
        const rti_geometry *g = RTI_AT(scene->geometries, rti_geometry, i);
        if (rti_cancelled(&c->scene->cancel))
            status = rti_fail(scene->ctx, RT_ERROR_CANCELLED, "%s: cancelled", c->call);
        for (uint32_t k = 0; g->alive && g->type == RTK_GEOM_SHAPES && k < g->count; k++) {
            const rtk_shape *s = RTI_AT(scene->shapes, rtk_shape, g->first + k);
            if (s->type == RTK_SHAPE_SPHERE && opaque(scene, g, k))
                offer_body(s, lights, order, count);
        }
    }
    rti_free(scene->ctx, order, light_count * sizeof *order);
    return status;
}

rt_status rti_commit_lights(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    size_t count = 0, size = 0;
    uint32_t lamp = (uint32_t)scene->geometries.count;
    rtk_light *lights;
    void *block = NULL, *records = NULL;
    rt_status status;
    for (size_t i = 0; i < scene->lights.count; i++)
        count += RTI_AT(scene->lights, rti_light, i)->alive;
    status = rti_commit_table(c, count, sizeof *lights, &block, &size, &records);
    if (status != RT_OK)
        return status;
    lights = records;
    count = 0;
    for (size_t i = 0; i < scene->lights.count; i++) {
        const rti_light *l = RTI_AT(scene->lights, rti_light, i);
        if (!l->alive)
            continue;
        lights[count] = l->light;
        if (l->visible)
            lights[count].geom = lamp++;
        count++;
    }
    set_choice(lights, count, reach_of(c->next->groups[0].group->data));
    status = count > 0 ? find_bodies(c, lights, count) : RT_OK;
    if (status != RT_OK) {
        rti_free(scene->ctx, block, size);
        return status;
    }
    return rti_commit_chunk(c, RTK_CHUNK_LIGHT, block, size, &c->next->lights);
}
