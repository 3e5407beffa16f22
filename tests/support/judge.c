#include "judge.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "rays.h"
#include "trace/lane.h"

#define MANY 4096u /* triangles */
#define LEAF 8u
#define FAR  1e-3 /* of a part's scale */

/* Triangles order[first, first + count); left and right below when there are more than LEAF. */
typedef struct node {
    float lo[3], hi[3];
    uint32_t first, count, left, right;
} node;

typedef struct part_tree {
    uint32_t *order;
    node *nodes;
    uint32_t node_count;
} part_tree;

struct test_judge_far {
    const rtk_scene *scene;
    part_tree parts[RTK_PARTS];
};

static void *room_for(size_t count, size_t item)
{
    void *p = malloc((count ? count : 1) * item);
    if (!p)
        abort();
    return p;
}

static float middle(const rtk_tri *t, int axis)
{
    return 0.25f * (t->v0[axis] + t->v1[axis] + 2.0f * t->v2[axis]); /* anywhere in the triangle will do */
}

/* order[first, last) so that its middle one stands where sorting by `axis` would put it, none before it greater, none behind it
 * less. */
static void halve(const rtk_tri *tris, uint32_t *order, uint32_t first, uint32_t last, int axis)
{
    const uint32_t nth = first + (last - first) / 2;
    while (last - first > 1) {
        const float pivot = middle(&tris[order[first + (last - first) / 2]], axis);
        uint32_t i = first, k = last - 1;
        for (;;) {
            while (middle(&tris[order[i]], axis) < pivot)
                i++;
            while (middle(&tris[order[k]], axis) > pivot)
                k--;
            if (i >= k)
                break;
            const uint32_t swapped = order[i];
            order[i++] = order[k];
            order[k--] = swapped;
        }
        const uint32_t cut = k + 1; /* [first, cut) is not greater than the pivot, [cut, last) not less */
        if (nth < cut)
            last = cut == last ? last - 1 : cut;
        else
            first = cut;
    }
}

static uint32_t build(part_tree *p, const rtk_tri *tris, uint32_t first, uint32_t count)
{
    const uint32_t at = p->node_count++;
    node n = {.first = first, .count = count};
    int axis = 0;
    for (int a = 0; a < 3; a++) {
        n.lo[a] = RTK_INF;
        n.hi[a] = -RTK_INF;
        for (uint32_t i = first; i < first + count; i++) {
            const rtk_tri *t = &tris[p->order[i]];
            if (!rtk_finite(t->v0[a] + t->v1[a] + t->v2[a])) { /* is near all lines */
                n.lo[a] = -RTK_INF;
                n.hi[a] = RTK_INF;
                break;
            }
            n.lo[a] = rtk_min(n.lo[a], rtk_min(t->v0[a], rtk_min(t->v1[a], t->v2[a])));
            n.hi[a] = rtk_max(n.hi[a], rtk_max(t->v0[a], rtk_max(t->v1[a], t->v2[a])));
        }
        if (n.hi[a] - n.lo[a] > n.hi[axis] - n.lo[axis])
            axis = a;
    }
    if (count > LEAF) {
        halve(tris, p->order, first, first + count, axis);
        n.left = build(p, tris, first, count / 2);
        n.right = build(p, tris, first + count / 2, count - count / 2);
    }
    p->nodes[at] = n;
    return at;
}

static test_judge_far *judge_new(const rtk_scene *scene)
{
    const rtk_group *g = scene->groups;
    test_judge_far *j = room_for(1, sizeof *j);
    *j = (test_judge_far){.scene = scene};
    for (uint32_t k = 0; k < g->part_count; k++) {
        const rtk_part *part = &g->parts[k];
        part_tree *p = &j->parts[k];
        p->order = room_for(part->count, sizeof *p->order);
        p->nodes = room_for(2u * (size_t)part->count, sizeof *p->nodes);
        for (uint32_t i = 0; i < part->count; i++)
            p->order[i] = part->all.refs ? part->all.refs[i] : i;
        build(p, g->tris, 0, part->count);
    }
    return j;
}

/* A prepared ray's line. */
typedef struct line {
    uint32_t x, y, z; /* its order of axes */
    double ox, oy, oz, sx, sy, off;
} line;

/* Whether o + s z, for z from z0 to z1, stays outside of [lo, hi]. */
static bool beside(double o, double s, double z0, double z1, double lo, double hi)
{
    const double a = o + s * z0, b = o + s * z1;
    return (a < lo && b < lo) || (a > hi && b > hi);
}

static bool misses(const line *l, const node *n)
{
    const double z0 = n->lo[l->z] - l->off - l->oz, z1 = n->hi[l->z] + l->off - l->oz;
    return beside(l->ox, l->sx, z0, z1, n->lo[l->x] - l->off, n->hi[l->x] + l->off) ||
           beside(l->oy, l->sy, z0, z1, n->lo[l->y] - l->off, n->hi[l->y] + l->off);
}

static void through(const part_tree *p, uint32_t at, const line *l, const rtk_pray *r, rtk_query *q)
{
    const node *n = &p->nodes[at];
    if (misses(l, n))
        return;
    if (n->count > LEAF) {
        through(p, n->left, l, r, q);
        through(p, n->right, l, r, q);
        return;
    }
    for (uint32_t i = n->first; i < n->first + n->count; i++)
        rtk_query_tri(q, 0, r, &q->group->tris[p->order[i]]);
}

static void ask_far(const test_judge_far *j, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count)
{
    const rti_scratch none = {0};
    for (uint32_t i = 0; i < count; i++) {
        rtk_query q;
        rti_lane_query(&q, j->scene, rays, i, &none);
        for (uint32_t k = 0; k < q.group->part_count && rtk_ray_valid(q.ray); k++) {
            const rtk_part *part = &q.group->parts[k];
            rtk_pray r;
            if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
                continue;
            const line l = {r.kx, r.ky, r.kz, r.korg.x, r.korg.y, r.korg.z, r.sx, r.sy, FAR * part->scale};
            through(&j->parts[k], 0, &l, &r, &q);
        }
        rti_lane_hit(&q, hits, i);
    }
}

void test_closest_open(test_closest *j, const rtk_scene *scene)
{
    const rtk_group *g = scene->groups;
    const bool other = scene->instance_count != 0 || g->plane_count != 0 || g->shape_count != 0;
    *j = (test_closest){.scene = scene, .brute = test_judge()};
    if (g->tri_count > MANY && !other)
        j->far = judge_new(scene);
}

void test_closest_close(test_closest *j)
{
    for (uint32_t k = 0; j->far && k < RTK_PARTS; k++) {
        free(j->far->parts[k].order);
        free(j->far->parts[k].nodes);
    }
    free(j->far);
}

void test_closest_ask(test_closest *j, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count)
{
    rti_scratch scratch = {.room = test_room()};
    const uint32_t blocks = count / RTK_BLOCK;
    if (!j->far) {
        j->brute->intersect(j->scene, rays, hits, count, 0, &scratch);
        return;
    }
    ask_far(j->far, rays, hits, count);
    for (uint32_t b = blocks == 0u ? 0u : j->asked++ % rtk_umin(blocks, 64u); b < blocks; b += 64) {
        rtk_hit_block want;
        j->brute->intersect(j->scene, &rays[b], &want, RTK_BLOCK, 0, &scratch);
        if (memcmp(&want, &hits[b], sizeof want) != 0)
            fail_msg("brute force and test_closest_ask, which leaves out what is far, differ in block %u", b);
    }
}
