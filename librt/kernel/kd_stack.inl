/* Walk of a kd-tree with a full stack, front to back.
 *
 * Instantiated with RTK_WALK (name), RTK_PRIM(q, mode, r, ref) (what a leaf does with a reference) and RTK_MODE.
 * A stack entry is eight bytes: the near end of a node that was put by is the far end of what is walked before it.
 * Source: Wald 2004 (near and far by the direction's sign). What differs: >= and <= send a plane at an end of the interval to the
 * side that the theory of ray.h needs, so that the intervals of visited cells tile the ray.
 */
RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    rtk_u32 stack_node[RTK_KD_STACK];
    float stack_t1[RTK_KD_STACK];
    float org[3], inv[3];
    rtk_u32 back[3]; /* 1: the high child is the near one */
    rtk_u32 at = 0u, top = 0u, i;
    float t0 = r->t0, t1 = r->t1;
    (void)prim_count;
    org[0] = r->org.x;
    org[1] = r->org.y;
    org[2] = r->org.z;
    inv[0] = r->inv.x;
    inv[1] = r->inv.y;
    inv[2] = r->inv.z;
    for (i = 0u; i < 3u; i++)
        back[i] = rtk_bits(inv[i]) >> 31;
    if (rtk_query_done(q, RTK_MODE, r, outer, t0))
        return 0;
    for (;;) {
        rtk_kdnode n = tree.kd[at];
        while ((n.b & 3u) != RTK_KD_LEAF) {
            rtk_u32 axis = n.b & 3u, child = n.b >> 2;
            float t = (rtk_float(n.a) - org[axis]) * inv[axis];
            at = child + back[axis];
            if (t < t1) {
                rtk_u32 far = child + (1u - back[axis]);
                if (t <= t0) {
                    at = far;
                } else {
                    stack_node[top] = far;
                    stack_t1[top++] = t1;
                    t1 = t;
                }
            }
            n = tree.kd[at];
            if (RTK_MODE & RTK_MODE_STEPS)
                q->nodes++;
        }
        if (RTK_MODE & RTK_MODE_STEPS)
            q->leaves++;
        if (!rtk_query_before(q, RTK_MODE, r, outer, t1)) {
            for (i = 0u; i < n.b >> 2; i++)
                if (RTK_PRIM(q, RTK_MODE, r, tree.refs[n.a + i]))
                    return 1;
        }
        if (top == 0u || rtk_query_done(q, RTK_MODE, r, outer, t1))
            return 0;
        top--;
        t0 = t1;
        t1 = stack_t1[top];
        at = stack_node[top];
    }
}
