/* Walk of a tree of eight-wide nodes by one ray: all boxes of a node at once, triangles four at a time. Instantiated like
 * kernel/bvh_walk.inl, which is told in full there. What a ray costs (RTK_MODE_STEPS) is counted on that walk itself, so that it is
 * the same at every instruction set.
 */
#if RTK_MODE & 4
#include "../kernel/bvh_walk.inl"
#else
/* Of whatever primitives. */
RTI_APART int BVH_WALK_OTHER(RTK_WALK)(rtk_query *q, rtk_tree tree, const rtk_pray *r, float outer)
{
    float stack_t[RTK_BVH_STACK + RTK_BVH_WIDTH]; /* what waits: slots, and where the ray enters them */
    rtk_u32 stack_child[RTK_BVH_STACK + RTK_BVH_WIDTH], stack_count[RTK_BVH_STACK + RTK_BVH_WIDTH];
    const bvh_ray v = bvh_ray_of(r);
    rti_tri_ray4 lanes = {0};
    bvh_late late = {(q->group->flags & RTK_GROUP_PLAIN) && q->mask != 0u, RTK_INVALID};
    float reach = bvh_reach(q, RTK_MODE, r, outer);
    rtk_u32 at = 0u, count = 0u, top = 0u, ready = 0u, i;
    if (rtk_query_done(q, RTK_MODE, r, outer, r->t0))
        return 0;
    for (;;) {
        while (count == 0u) {
            float t[RTK_BVH_WIDTH];
            const rtk_bvhnode *n = &tree.bvh[at];
            rtk_u32 bits = bvh_open(n, &v, reach, t);
            if (bits == 0u)
                goto next;
            i = bvh_choose(n, bits, t, stack_t, stack_child, stack_count, &top);
            at = n->child[i];
            count = n->count[i];
        }
        if (at < 4u * tree.block_count) {
            if (!ready) {
                bvh_tri_ray(r, &lanes);
                ready = 1u;
            }
            if (bvh_blocks(q, RTK_MODE, r, &lanes, &tree, at, count, outer, &late))
                return 1;
        } else {
            bvh_settle(q, &late);
            for (i = 0u; i < count; i++)
                if (RTK_PRIM(q, RTK_MODE, r, tree.refs[at + i]))
                    return 1;
        }
        reach = bvh_reach(q, RTK_MODE, r, outer);
    next:
        do {
            if (top == 0u) {
                bvh_settle(q, &late);
                return 0;
            }
            top--;
        } while (stack_t[top] > reach);
        at = stack_child[top];
        count = stack_count[top];
    }
}

RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    int end;
    (void)prim_count;
    if (RTK_MODE <= RTK_MODE_ANY && lone_tree(&tree) && (q->group->flags & RTK_GROUP_PLAIN) && q->mask != 0u &&
        outer == 0.0f && lone_group(q, RTK_MODE, &tree, r, &end))
        return end;
    return BVH_WALK_OTHER(RTK_WALK)(q, tree, r, outer);
}
#endif
