/* Statistics of finished trees. A large tree is opened from the root on until there are some hundreds of subtrees, a task each:
 * by one thread alone this took a tenth of a build by sixteen. What is summed, and in which order, depends on the tree alone.
 */
#include "build.h"

#define LARGE 2048u /* nodes; a smaller tree is one task */
#define SPOTS 512u  /* that wait to be opened, or are tasks, at most */

typedef struct measured {
    double cost;
    uint32_t depth, leaves, empty, largest;
} measured;

typedef struct job {
    const rtk_tree_header *h;
    rtk_tree tree;
    const rti_tree_kind *kind;
    double unit, root; /* the longest side of the root, and its area in that */
    rti_tree_spot spots[SPOTS];
    measured found[SPOTS];
    uint32_t first, count; /* of the spots that are tasks */
} job;

/* Half the surface, relative to the root's longest side. */
static double cell_area(const rti_tree_spot *c, double unit)
{
    double d[3];
    for (int a = 0; a < 3; a++)
        d[a] = ((double)c->hi[a] - c->lo[a]) / unit;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

static void add(measured *to, const measured *m)
{
    to->cost += m->cost;
    to->leaves += m->leaves;
    to->empty += m->empty;
    to->largest = m->largest > to->largest ? m->largest : to->largest;
    to->depth = m->depth > to->depth ? m->depth : to->depth;
}

/* Adds a spot itself; its children go to `children`. Returns how many. */
static uint32_t open_spot(const job *j, const rti_tree_spot *spot, rti_tree_spot *children, measured *m)
{
    const double p = cell_area(spot, j->unit) / j->root;
    uint32_t prims = 0, opened = j->kind->open(&j->tree, spot, children, &prims);
    if (opened)
        m->cost += p * j->h->cost_traverse;
    else
        add(m, &(measured){p * j->h->cost_intersect * prims, spot->depth, 1, prims == 0, prims});
    return opened;
}

static void spot_task(void *data, uint32_t index)
{
    job *j = data;
    measured m = {0};
    rti_tree_spot stack[RTI_TREE_WALK];
    uint32_t count = 1;
    stack[0] = j->spots[j->first + index];
    while (count > 0) {
        const rti_tree_spot spot = stack[--count];
        count += open_spot(j, &spot, stack + count, &m);
    }
    j->found[index] = m;
}

/* Without a context by the caller alone. */
static measured measure_tree(rt_context *ctx, const rtk_tree_header *h)
{
    job j = {.h = h, .tree = rti_tree_view(h), .kind = rti_tree_kind_of(h->kind)};
    measured m = {0};
    j.spots[0] = rti_tree_root(&j.tree);
    j.count = 1;
    for (int a = 0; a < 3; a++)
        j.unit = h->hi[a] - h->lo[a] > j.unit ? h->hi[a] - h->lo[a] : j.unit;
    j.unit = j.unit > 0.0 ? j.unit : 1.0;
    j.root = cell_area(&j.spots[0], j.unit);
    j.root = j.root > 0.0 ? j.root : 1.0;
    while (h->node_count > LARGE && j.count > 0 && j.first + j.count + RTI_TREE_CHILDREN <= SPOTS) {
        const rti_tree_spot *spot = &j.spots[j.first++];
        j.count += open_spot(&j, spot, &j.spots[j.first + j.count - 1], &m) - 1;
    }
    if (ctx)
        rti_parallel(ctx, j.count, spot_task, &j);
    for (uint32_t i = 0; i < j.count; i++) {
        if (!ctx)
            spot_task(&j, i);
        add(&m, &j.found[i]);
    }
    return m;
}

void rti_tree_measure(rt_context *ctx, rtk_tree_header *h)
{
    const measured m = measure_tree(ctx, h);
    h->depth = m.depth;
    h->leaf_count = m.leaves;
    h->empty_leaf_count = m.empty;
    h->largest_leaf = m.largest;
    h->sah_cost = (float)m.cost;
}

float rti_tree_sah(const rtk_tree_header *tree)
{
    return (float)measure_tree(NULL, tree).cost;
}
