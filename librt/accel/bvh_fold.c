/* Which nodes of the binary tree become the slots of nodes of eight, and which small subtrees one leaf: what costs the least, in
 * areas, of all ways there are (Wald, Boulos 2008 by sum of areas; Ylitie, Karras, Laine 2017 by this recurrence).
 *
 * cost(n, i) is the least for what is below n in at most i slots of one node:
 *     cost(n, 1) = the least of a leaf of all of it, where it may be one, and a node + cost(n, 8)
 *     cost(n, i) = the least of cost(n, i - 1) and, over j, cost(left, j) + cost(right, i - j)
 * where in cost(n, 8), as a node's own slots, n is split in any case. Leaves of the binary tree may be smaller than they will be:
 * what is merged here was weighed against the nodes it would need.
 *
 * Subtrees that lie in one part are a task each. Nothing recurs: a subtree is gone through children first, with a stack that
 * grows, for a tree may be deep.
 */
#include "bvh_build.h"

#define SLOTS   RTK_BVH_WIDTH
#define LARGER  (1u << 30u) /* the right child has more references */
#define MERGED  (1u << 31u)
#define LARGEST 1.0e30f /* of areas, which may be no number; above it sums are infinite, and cuts the first there are */

_Static_assert(SLOTS == 8, "a cut has three bits, and two vectors hold costs");

/* Of a subtree. count 0: there is nothing in it (of cells). */
typedef struct value {
    float cost[SLOTS]; /* in at most 1 ... 8 slots */
    uint32_t count;    /* references */
    bool tris, others; /* what they are of */
} value;

typedef struct step {
    uint32_t node;
    bool done; /* its children are */
} step;

/* Steps that are to be done and values that wait for a sibling's. */
typedef struct stack {
    step *steps;
    value *values;
    size_t step_count, step_capacity, value_count, value_capacity;
} stack;

typedef struct cutting {
    const rti_bvh *t;
    uint32_t *cuts;
    float per_node;  /* what a node costs beside its area */
    uint32_t *roots; /* of tasks */
    size_t root_count, root_capacity;
    value *found;   /* by tasks */
    rt_status *got; /* likewise */
} cutting;

static float area_of(const rti_bvh *t, uint32_t node)
{
    const float area = rti_bvh_node_area(t, node);
    return area < LARGEST ? area : LARGEST;
}

static bool is_task(const rti_bvh *t, uint32_t node)
{
    return t->nodes[node].count > 0 || !rti_bvh_in_top(t, node);
}

static value leaf_value(const rti_bvh *t, uint32_t node)
{
    const rti_bvh_node *n = &t->nodes[node];
    value v = {.count = n->count};
    const float cost = n->count > 0 ? rti_bvh_leaf_total(t, area_of(t, node), n->count) : 0.0f;
    for (uint32_t i = 0; i < SLOTS; i++)
        v.cost[i] = cost;
    if (n->count > 0) { /* of one kind */
        v.tris = t->order[n->child] < t->b->in->tri_count;
        v.others = !v.tris;
    }
    return v;
}

/* Into cost[i - 1], the least over j of left's j slots and right's i - j, with j in at[i - 1]; i = 1: infinite. */
static void combine(const value *left, const value *right, float cost[SLOTS], int32_t at[SLOTS])
{
    float padded[2 * SLOTS];
    rti_f4 best[2] = {rti_f4_set(RTK_INF), rti_f4_set(RTK_INF)};
    rti_i4 which[2] = {rti_i4_set(0), rti_i4_set(0)};
    for (uint32_t i = 0; i < SLOTS; i++) {
        padded[i] = RTK_INF;
        padded[SLOTS + i] = right->cost[i];
    }
    for (uint32_t j = 1; j < SLOTS; j++) {
        const rti_f4 l = rti_f4_set(left->cost[j - 1]);
        for (uint32_t h = 0; h < 2; h++) {
            const rti_f4 sum = l + rti_f4_load(padded + SLOTS - j + 4 * h);
            const rti_i4 less = (rti_i4)(sum < best[h]);
            best[h] = rti_f4_pick(less, sum, best[h]);
            which[h] = rti_i4_pick(less, rti_i4_set((int32_t)j), which[h]);
        }
    }
    memcpy(cost, best, sizeof best);
    memcpy(at, which, sizeof which);
}

/* The value of an inner node with something in both children, and its cuts. */
static value inner_value(const cutting *job, uint32_t node, const value *left, const value *right)
{
    const rti_bvh *t = job->t;
    const float area = area_of(t, node);
    value v = {.count = left->count + right->count, .tris = left->tris || right->tris, .others = left->others || right->others};
    float one;
    int32_t at[SLOTS];
    uint32_t cuts = right->count > left->count ? LARGER : 0u;
    combine(left, right, v.cost, at);
    at[SLOTS - 1] = at[SLOTS - 1] > 0 ? at[SLOTS - 1] : 1;
    one = job->per_node + rti_bvh_node_total(t, area) + v.cost[SLOTS - 1];
    if ((t->blocks || t->balls) && v.count <= RTI_BVH_MERGED && v.count <= t->most && v.tris != v.others) {
        const float leaf = rti_bvh_leaf_total(t, area, v.count);
        if (leaf <= one) {
            one = leaf;
            cuts |= MERGED;
        }
    }
    v.cost[0] = one;
    for (uint32_t i = 1; i < SLOTS; i++) {
        if (i + 1 < SLOTS && !(v.cost[i] < v.cost[i - 1])) { /* the right child gets a slot that it will not need */
            v.cost[i] = v.cost[i - 1];
            at[i] = at[i - 1];
        }
        cuts |= (uint32_t)at[i] << (3 * (i - 1));
    }
    job->cuts[node] = cuts;
    return v;
}

static bool push_step(rt_context *ctx, stack *s, uint32_t node, bool done)
{
    if (!rti_reserve(ctx, (void **)&s->steps, &s->step_capacity, s->step_count, 1, sizeof *s->steps))
        return false;
    s->steps[s->step_count++] = (step){node, done};
    return true;
}

static bool push_value(rt_context *ctx, stack *s, const value *v)
{
    if (!rti_reserve(ctx, (void **)&s->values, &s->value_capacity, s->value_count, 1, sizeof *s->values))
        return false;
    s->values[s->value_count++] = *v;
    return true;
}

static bool open_step(rt_context *ctx, stack *s, uint32_t node, uint32_t child)
{
    return push_step(ctx, s, node, true) && push_step(ctx, s, child + 1, false) && push_step(ctx, s, child, false);
}

/* The values of a node's two children are the last two: its own takes their place. */
static void close_step(const cutting *job, uint32_t node, stack *s)
{
    value *left = &s->values[s->value_count - 2], *right = left + 1;
    s->value_count--;
    if (left->count > 0 && right->count > 0)
        *left = inner_value(job, node, left, right);
    else if (right->count > 0)
        *left = *right; /* what is empty is passed by (rti_bvh_slots) */
}

/* Everything below a node; in the top, where tasks have their roots, what they found is taken as it comes. */
static rt_status values(const cutting *job, uint32_t root, bool top, stack *s, value *out)
{
    const rti_bvh *t = job->t;
    size_t task = 0, count = 0;
    s->step_count = s->value_count = 0;
    if (!push_step(t->ctx, s, root, false))
        return RT_ERROR_MEMORY;
    while (s->step_count > 0) {
        const step it = s->steps[--s->step_count];
        const rti_bvh_node *n = &t->nodes[it.node];
        bool room = true;
        if (++count % 4096 == 0 && rti_cancelled(t->b->cancel))
            return RT_ERROR_CANCELLED;
        if (it.done) {
            close_step(job, it.node, s);
        } else if (top && is_task(t, it.node)) {
            room = push_value(t->ctx, s, &job->found[task++]);
        } else if (n->child == 0 || n->count > 0) {
            const value v = leaf_value(t, it.node);
            room = push_value(t->ctx, s, &v);
        } else {
            room = open_step(t->ctx, s, it.node, n->child);
        }
        if (!room)
            return RT_ERROR_MEMORY;
    }
    *out = s->values[0];
    return RT_OK;
}

static void free_stack(rt_context *ctx, stack *s)
{
    rti_free(ctx, s->steps, s->step_capacity * sizeof *s->steps);
    rti_free(ctx, s->values, s->value_capacity * sizeof *s->values);
}

static void task(void *data, uint32_t index)
{
    const cutting *job = data;
    stack s = {0};
    job->got[index] = values(job, job->roots[index], false, &s, &job->found[index]);
    free_stack(job->t->ctx, &s);
}

/* The tasks' roots, in the order in which `values` meets them. */
static bool find_roots(cutting *job, uint32_t root, stack *s)
{
    const rti_bvh *t = job->t;
    if (!push_step(t->ctx, s, root, false))
        return false;
    while (s->step_count > 0) {
        const uint32_t node = s->steps[--s->step_count].node, child = t->nodes[node].child;
        if (!is_task(t, node)) {
            if (child > 0 && (!push_step(t->ctx, s, child + 1, false) || !push_step(t->ctx, s, child, false)))
                return false;
            continue;
        }
        if (!rti_reserve(t->ctx, (void **)&job->roots, &job->root_capacity, job->root_count, 1, sizeof *job->roots))
            return false;
        job->roots[job->root_count++] = node;
    }
    return true;
}

rt_status rti_bvh_cut(const rti_bvh *t, uint32_t root, float per_node, uint32_t *cuts)
{
    cutting job = {.t = t, .cuts = cuts, .per_node = per_node};
    stack s = {0};
    value all;
    rt_status status = find_roots(&job, root, &s) ? RT_OK : RT_ERROR_MEMORY;
    job.found = rti_alloc_array(t->ctx, job.root_count, sizeof *job.found);
    job.got = rti_alloc_array(t->ctx, job.root_count, sizeof *job.got);
    if (!job.found || !job.got)
        status = RT_ERROR_MEMORY;
    if (status == RT_OK)
        rti_parallel(t->ctx, (uint32_t)job.root_count, task, &job);
    for (size_t i = 0; i < job.root_count && status == RT_OK; i++)
        status = job.got[i];
    if (status == RT_OK)
        status = values(&job, root, true, &s, &all);
    rti_free(t->ctx, job.found, job.root_count * sizeof *job.found);
    rti_free(t->ctx, job.got, job.root_count * sizeof *job.got);
    rti_free(t->ctx, job.roots, job.root_capacity * sizeof *job.roots);
    free_stack(t->ctx, &s);
    return status;
}

static bool is_empty(const rti_bvh_node *n)
{
    return n->count == 0 && n->child == 0;
}

/* What stands in a node's place in a slot: of cells, the first below it with something in both children, or a leaf. */
static uint32_t pass_empty(const rti_bvh *t, uint32_t node)
{
    for (;;) {
        const rti_bvh_node *n = &t->nodes[node];
        if (!t->own || n->count > 0)
            return node;
        if (is_empty(&t->nodes[n->child]))
            node = n->child + 1;
        else if (is_empty(&t->nodes[n->child + 1]))
            node = n->child;
        else
            return node;
    }
}

bool rti_bvh_is_leaf(const rti_bvh *t, const uint32_t *cuts, uint32_t node)
{
    return t->nodes[node].count > 0 || (cuts[node] & MERGED) != 0;
}

uint32_t rti_bvh_slots(const rti_bvh *t, const uint32_t *cuts, uint32_t node, uint32_t slots[RTK_BVH_WIDTH])
{ /* where there is room, what may be one leaf is split nevertheless if that is cheaper */
    struct {
        uint32_t node, room;
    } open[SLOTS + 1], it;
    uint32_t count = 0, top = 1;
    open[0].node = node;
    open[0].room = SLOTS;
    while (top > 0) {
        uint32_t cut = 0;
        it = open[--top];
        it.node = pass_empty(t, it.node);
        if (it.room > 1 && t->nodes[it.node].count == 0)
            cut = cuts[it.node] >> (3 * (it.room - 2)) & 7u;
        if (cut == 0) {
            slots[count++] = it.node;
            continue;
        }
        open[top].node = t->nodes[it.node].child + 1;
        open[top++].room = it.room - cut;
        open[top].node = t->nodes[it.node].child;
        open[top++].room = cut;
    }
    return count;
}

uint32_t rti_bvh_next_leaf(const rti_bvh *t, const uint32_t *cuts, rti_bvh_leaves *at)
{
    while (at->count > 0) {
        uint32_t node = at->wait[--at->count];
        const rti_bvh_node *n = &t->nodes[node];
        if (n->count > 0)
            return node;
        if (n->child == 0)
            continue;
        if (t->own && (is_empty(&t->nodes[n->child]) || is_empty(&t->nodes[n->child + 1]))) {
            at->wait[at->count++] = pass_empty(t, node);
            continue;
        }
        const uint32_t right_waits = cuts[node] & LARGER ? 1 : 0; /* the smaller is next */
        at->wait[at->count++] = n->child + right_waits;
        at->wait[at->count++] = n->child + 1 - right_waits;
    }
    return RTK_INVALID;
}
