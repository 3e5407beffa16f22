/* Finished trees: views, how nodes of each kind open, and the check of trees that come from outside. */
#include <string.h>

#include "../kernel/bvh.h"
#include "../kernel/shape_surface.h"
#include "build.h"

rtk_tree rti_tree_view(const void *chunk)
{
    const rtk_tree_header *h = chunk;
    const char *bytes = chunk;
    rtk_tree v;
    v.kind = h->kind;
    v.lo = rtk_v3(h->lo[0], h->lo[1], h->lo[2]);
    v.hi = rtk_v3(h->hi[0], h->hi[1], h->hi[2]);
    v.kd = h->kind == RTK_TREE_KD ? (const rtk_kdnode *)(const void *)(bytes + h->off_nodes) : NULL;
    v.oct = h->kind == RTK_TREE_OCTREE ? (const rtk_octnode *)(const void *)(bytes + h->off_nodes) : NULL;
    v.bvh = (const rtk_bvhnode *)(const void *)(bytes + (h->kind == RTK_TREE_BVH ? h->off_nodes : h->off_wide));
    v.refs = (const rtk_u32 *)(const void *)(bytes + h->off_refs);
    v.block_count = h->block_count;
    v.blocks = v.block_count ? (const rtk_bvhblock *)(const void *)(bytes + h->off_blocks) : NULL;
    v.ball_count = h->ball_count;
    v.ball_size = h->ball_size;
    v.balls = v.ball_count ? (const float *)(const void *)(bytes + h->off_balls) : NULL;
    return v;
}

/* ---- how nodes of each kind open ---- */

static uint32_t open_kd(const rtk_tree *tree, const rti_tree_spot *spot, rti_tree_spot *children, uint32_t *refs)
{
    rtk_kdnode n = tree->kd[spot->node];
    uint32_t axis = n.b & 3u;
    if (axis == RTK_KD_LEAF) {
        *refs = n.b >> 2;
        return 0;
    }
    for (uint32_t i = 0; i < 2; i++) {
        children[i] = *spot;
        (i == 0 ? children[i].hi : children[i].lo)[axis] = rtk_float(n.a);
        children[i].node = (n.b >> 2) + i;
        children[i].depth = spot->depth + 1;
    }
    return 2;
}

static uint32_t open_octree(const rtk_tree *tree, const rti_tree_spot *spot, rti_tree_spot *children, uint32_t *refs)
{
    rtk_octnode n = tree->oct[spot->node];
    if (n.child == 0) {
        *refs = n.count;
        return 0;
    }
    for (uint32_t i = 0; i < 8; i++) {
        children[i] = *spot;
        for (uint32_t a = 0; a < 3; a++)
            ((i >> a) & 1u ? children[i].lo : children[i].hi)[a] = 0.5f * (spot->lo[a] + spot->hi[a]);
        children[i].node = n.child + i;
        children[i].depth = spot->depth + 1;
    }
    return 8;
}

static uint32_t open_bvh(const rtk_tree *tree, const rti_tree_spot *spot, rti_tree_spot *children, uint32_t *refs)
{
    const rtk_bvhnode *n = &tree->bvh[spot->node];
    rti_tree_spot from = *spot;
    uint32_t count = 0;
    if (from.leaf > 0) {
        *refs = from.leaf;
        return 0;
    }
    for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++) {
        if (n->child[i] == 0 && n->count[i] == 0)
            continue;
        for (uint32_t a = 0; a < 3; a++) {
            children[count].lo[a] = n->box[a][0][i];
            children[count].hi[a] = n->box[a][1][i];
        }
        children[count].node = n->child[i];
        children[count].leaf = n->count[i];
        children[count++].depth = from.depth + 1;
    }
    return count;
}

static const rti_tree_kind kinds[] = {
    {"kdtree", RTK_TREE_KD, open_kd},
    {"octree", RTK_TREE_OCTREE, open_octree},
    {"bvh", RTK_TREE_BVH, open_bvh},
};

const rti_tree_kind *rti_tree_kind_of(uint32_t kind)
{
    for (size_t i = 0; i < RTI_COUNT(kinds); i++) {
        if (kinds[i].kind == kind)
            return &kinds[i];
    }
    return NULL;
}

rti_tree_spot rti_tree_root(const rtk_tree *tree)
{
    return (rti_tree_spot){{tree->lo.x, tree->lo.y, tree->lo.z}, {tree->hi.x, tree->hi.y, tree->hi.z}, 0, 0, 0};
}

/* ---- trees from outside ------------------------------------------------------------------------------------------------- */

/* An array of `count` items at `off` lies inside the chunk, behind the header, aligned. */
static bool inside(uint64_t off, uint64_t count, uint64_t item, size_t size)
{
    return off >= sizeof(rtk_tree_header) && off % 64 == 0 && off <= size && count <= (size - off) / item;
}

/* Children stand behind their parent, so there is no cycle; where parents share children, a walk from the root meets more nodes
 * than there are. */
static bool walk_valid(const rtk_tree_header *h)
{
    rtk_tree t = rti_tree_view(h);
    uint32_t stack[RTI_TREE_WALK], depths[RTI_TREE_WALK], count = 1;
    uint32_t step = h->kind == RTK_TREE_KD ? 2 : 8, limit = h->kind == RTK_TREE_KD ? RTK_KD_DEPTH : RTK_OCT_DEPTH;
    uint64_t met = 0;
    stack[0] = depths[0] = 0;
    while (count > 0) {
        uint32_t node = stack[--count], depth = depths[count], child, first, refs;
        if (++met > h->node_count || depth > limit)
            return false;
        if (h->kind == RTK_TREE_KD) {
            bool leaf = (t.kd[node].b & 3u) == RTK_KD_LEAF;
            child = leaf ? 0 : t.kd[node].b >> 2;
            first = t.kd[node].a;
            refs = t.kd[node].b >> 2;
            if (!leaf && (child == 0 || !rtk_finite(rtk_float(t.kd[node].a))))
                return false;
        } else {
            child = t.oct[node].child;
            first = t.oct[node].first;
            refs = t.oct[node].count;
        }
        if (child == 0) {
            if (refs > h->ref_count || first > h->ref_count - refs)
                return false;
            continue;
        }
        if (child <= node || h->node_count < step || child > h->node_count - step)
            return false;
        for (uint32_t i = 0; i < step; i++) {
            stack[count] = child + i;
            depths[count++] = depth + 1;
        }
    }
    return true;
}

/* A slot that no ray can enter: anything else with child and count 0 would be walked as the root. */
static bool slot_empty(const rtk_bvhnode *n, uint32_t slot)
{
    for (int a = 0; a < 3; a++)
        if (n->box[a][0][slot] != RTK_INF || n->box[a][1][slot] != -RTK_INF)
            return false;
    return true;
}

static uint32_t wide_count(const rtk_tree_header *h)
{
    return h->kind == RTK_TREE_BVH ? h->node_count : h->wide_count;
}

static bool slot_valid(const rtk_tree_header *h, const rtk_bvhnode *n, uint32_t node, uint32_t slot)
{
    uint32_t child = n->child[slot], count = n->count[slot], blocked = h->block_count * RTK_BVH_BLOCK;
    if (child == 0 && count == 0)
        return slot_empty(n, slot);
    for (int a = 0; a < 3; a++)
        if (!rtk_finite(n->box[a][0][slot]) || !rtk_finite(n->box[a][1][slot]) || n->box[a][0][slot] > n->box[a][1][slot])
            return false;
    if (count == 0)
        return child > node && child < wide_count(h);
    if (child >= blocked)
        return count <= h->ref_count && child <= h->ref_count - count &&
               (h->ball_count == 0 || (child - blocked <= h->ball_count && count <= h->ball_count - (child - blocked)));
    return count <= blocked - child;
}

static bool wide_valid(const rtk_tree_header *h)
{
    rtk_tree t = rti_tree_view(h);
    uint32_t stack[RTI_TREE_WALK], depths[RTI_TREE_WALK], count = 1;
    uint64_t met = 0;
    stack[0] = depths[0] = 0;
    while (count > 0) {
        uint32_t node = stack[--count], depth = depths[count];
        if (++met > wide_count(h) || depth >= RTK_BVH_DEPTH)
            return false;
        for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++) {
            const rtk_bvhnode *n = &t.bvh[node];
            if (!slot_valid(h, n, node, i))
                return false;
            if (n->count[i] == 0 && n->child[i] > 0) {
                stack[count] = n->child[i];
                depths[count++] = depth + 1;
            }
        }
    }
    return true;
}

static bool arrays_valid(const rtk_tree_header *h, size_t size)
{
    static const uint64_t node_size[] = {0, sizeof(rtk_kdnode), sizeof(rtk_octnode), sizeof(rtk_bvhnode)};
    if (h->node_count == 0 || h->node_count > RTI_NODE_MAX || !inside(h->off_nodes, h->node_count, node_size[h->kind], size) ||
        !inside(h->off_refs, h->ref_count, sizeof(rtk_u32), size) || h->filler_count > h->ref_count)
        return false;
    if (h->kind == RTK_TREE_BVH && (h->wide_count != 0 || h->off_wide != 0))
        return false;
    if (h->kind != RTK_TREE_BVH &&
        (h->wide_count == 0 || h->wide_count > RTI_NODE_MAX || !inside(h->off_wide, h->wide_count, sizeof(rtk_bvhnode), size)))
        return false;
    if (h->ball_count != 0 && ((h->ball_size != RTK_BALL && h->ball_size != RTK_FORM) ||
                               !inside(h->off_balls, rti_balls_room(h->ball_count, h->ball_size), 1, size)))
        return false;
    if (h->block_count == 0)
        return h->block_count == 0 && h->off_blocks == 0 && h->ball_count <= h->ref_count;
    return h->block_count <= h->ref_count / RTK_BVH_BLOCK && h->ball_count <= h->ref_count - h->block_count * RTK_BVH_BLOCK &&
           inside(h->off_blocks, h->block_count, sizeof(rtk_bvhblock), size);
}

bool rti_tree_valid(const void *chunk, size_t size, uint32_t prim_limit)
{
    const rtk_tree_header *h = chunk;
    if (size < sizeof *h || !rti_tree_kind_of(h->kind) || !arrays_valid(h, size))
        return false;
    const rtk_u32 *refs = rti_tree_view(chunk).refs;
    for (uint32_t i = 0; i < h->ref_count; i++)
        if (refs[i] >= prim_limit)
            return false;
    return (h->kind == RTK_TREE_BVH || walk_valid(h)) && wide_valid(h);
}

/* A ball, or a form, of nothing. */
static const float nothing[RTK_FORM] = {0.0f, 0.0f, 0.0f, -1.0f, 0.0f, 0.0f, 0.0f, RTK_FORM_OTHER, 0.0f, 0.0f, 0.0f, 0.0f};

bool rti_tree_is_over(const void *chunk, const float lo[3], const float hi[3])
{
    const rtk_tree_header *h = chunk;
    const rti_cell root = rti_root_cell(h->kind == RTK_TREE_OCTREE, lo, hi);
    return memcmp(h->lo, root.lo, sizeof root.lo) == 0 && memcmp(h->hi, root.hi, sizeof root.hi) == 0;
}

/* What a reference's ball holds, and behind it its form where there is room. */
static void ball_of(const rtk_shape *shapes, uint32_t tri_count, uint32_t ref, float *to, uint32_t size)
{
    const rtk_shape *shape = !shapes || ref < tri_count ? NULL : &shapes[ref - tri_count];
    memcpy(to, nothing, size * sizeof *to);
    to[3] = -RTK_INF;
    if (!shape)
        return;
    rtk_shape_ball(shape, to);
    if (shape->type != RTK_SHAPE_SPHERE)
        to[3] = -to[3];
    if (size == RTK_FORM)
        rtk_shape_form(shape, to + RTK_BALL);
}

bool rti_tree_copies_valid(const void *chunk, const rtk_tri *tris, uint32_t tri_count, const rtk_shape *shapes)
{
    rtk_tree t = rti_tree_view(chunk);
    if (t.ball_count > 0 && !shapes) /* instances have none */
        return false;
    for (size_t i = 0; t.ball_count > 0 && i < rti_balls_room(t.ball_count, 1) / sizeof *t.balls; i++) {
        float ball[RTK_FORM];
        memcpy(ball, nothing, sizeof ball);
        if (i < t.ball_count)
            ball_of(shapes, tri_count, t.refs[(size_t)t.block_count * RTK_BVH_BLOCK + i], ball, t.ball_size);
        if (memcmp(ball, t.balls + i * t.ball_size, t.ball_size * sizeof *ball) != 0)
            return false;
    }
    for (uint32_t i = 0; i < t.block_count * RTK_BVH_BLOCK; i++) {
        const rtk_bvhblock *b = &t.blocks[i / RTK_BVH_BLOCK];
        uint32_t lane = i % RTK_BVH_BLOCK;
        if (t.refs[i] >= tri_count)
            return false;
        for (int a = 0; a < 3; a++) {
            const rtk_tri *tri = &tris[t.refs[i]];
            if (memcmp(&b->v0[a][lane], &tri->v0[a], 4) != 0 || memcmp(&b->v1[a][lane], &tri->v1[a], 4) != 0 ||
                memcmp(&b->v2[a][lane], &tri->v2[a], 4) != 0)
                return false;
        }
    }
    return true;
}

/* ---- balls ---- */

#define BALLS_A_TASK 4096u

typedef struct ball_job {
    const rtk_shape *shapes;
    uint32_t tri_count, count, size;
    const uint32_t *refs; /* of the first */
    float *balls;
} ball_job;

static void ball_task(void *data, uint32_t task)
{
    ball_job *job = data;
    uint32_t first = task * BALLS_A_TASK, end = rtk_umin(job->count, first + BALLS_A_TASK);
    for (uint32_t i = first; i < end; i++) {
        ball_of(job->shapes, job->tri_count, job->refs[i], job->balls + (size_t)i * job->size, job->size);
    }
}

void rti_tree_balls(rt_context *ctx, void *chunk, const rtk_shape *shapes, uint32_t tri_count)
{
    rtk_tree_header *h = chunk;
    const size_t room = rti_balls_room(h->ball_count, 1) / sizeof(float);
    if (h->ball_count == 0)
        return;
    ball_job job = {.shapes = shapes, .tri_count = tri_count, .count = h->ball_count, .size = h->ball_size};
    job.refs = rti_tree_view(chunk).refs + (size_t)h->block_count * RTK_BVH_BLOCK;
    job.balls = (float *)(void *)((char *)chunk + h->off_balls);
    for (size_t i = h->ball_count; i < room; i++)
        memcpy(job.balls + i * job.size, nothing, job.size * sizeof *nothing);
    rti_parallel(ctx, (h->ball_count + BALLS_A_TASK - 1) / BALLS_A_TASK, ball_task, &job);
}
