/* Walk of an eight-wide BVH with a full stack: the slots that a ray enters are put by in the order of their distances, and those that the best
 * hit has overtaken in between are left out.
 *
 * Instantiated like kd_stack.inl. Blocks are not looked at: references lead to the same triangles.
 */
RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    rtk_u32 stack_child[RTK_BVH_STACK], stack_count[RTK_BVH_STACK];
    float stack_t0[RTK_BVH_STACK];
    rtk_u32 back[3], at = 0u, count = 0u, top = 0u, i;
    (void)prim_count;
    back[0] = rtk_bits(r->inv.x) >> 31;
    back[1] = rtk_bits(r->inv.y) >> 31;
    back[2] = rtk_bits(r->inv.z) >> 31;
    if (rtk_query_done(q, RTK_MODE, r, outer, r->t0))
        return 0;
    for (;;) {
        if (count == 0u) {
            rtk_bvhslot slots[RTK_BVH_WIDTH];
            rtk_u32 first = top, n = rtk_bvh_open(&tree.bvh[at], r, back, slots);
            if (RTK_MODE & RTK_MODE_STEPS)
                q->nodes++;
            for (i = 0u; i < n; i++) {
                rtk_u32 to = top;
                if (rtk_query_done(q, RTK_MODE, r, outer, slots[i].t0) || rtk_query_before(q, RTK_MODE, r, outer, slots[i].t1))
                    continue;
                for (; to > first && stack_t0[to - 1u] < slots[i].t0; to--) { /* the nearest comes to lie on top */
                    stack_t0[to] = stack_t0[to - 1u];
                    stack_child[to] = stack_child[to - 1u];
                    stack_count[to] = stack_count[to - 1u];
                }
                stack_t0[to] = slots[i].t0;
                stack_child[to] = slots[i].child;
                stack_count[to] = slots[i].count;
                top++;
            }
        } else {
            if (RTK_MODE & RTK_MODE_STEPS)
                q->leaves++;
            for (i = 0u; i < count; i++)
                if (RTK_PRIM(q, RTK_MODE, r, tree.refs[at + i]))
                    return 1;
        }
        do {
            if (top == 0u)
                return 0;
            top--;
        } while (rtk_query_done(q, RTK_MODE, r, outer, stack_t0[top]));
        at = stack_child[top];
        count = stack_count[top];
    }
}
