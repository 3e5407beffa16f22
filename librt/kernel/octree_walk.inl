/* Walk of an octree, front to back: the planes through a cell's middle cut the ray's interval into at most four pieces, one a
 * child.
 *
 * Instantiated like kd_stack.inl. Source: parametric order of Revelles, Urena, Lastra 2000. What differs: plane distances are
 * computed from the planes, (mid - org) * inv, never halved from the parent's, and intervals tile the ray as in a kd-tree.
 */
RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    rtk_octcell stack[RTK_OCT_STACK];
    rtk_octcell c;
    float t0 = r->t0;
    rtk_u32 top = 0u, i, back = rtk_bits(r->inv.x) >> 31 | rtk_bits(r->inv.y) >> 31 << 1 | rtk_bits(r->inv.z) >> 31 << 2;
    (void)prim_count;
    if (rtk_query_done(q, RTK_MODE, r, outer, t0))
        return 0;
    c.lo = tree.lo;
    c.hi = tree.hi;
    c.t1 = r->t1;
    c.node = 0u;
    for (;;) {
        rtk_octnode n = tree.oct[c.node];
        if (RTK_MODE & RTK_MODE_STEPS)
            q->nodes++;
        if (n.child != 0u) {
            /* Pieces in order of t; the first is walked at once, the others wait on the stack, the last one lowest. */
            rtk_octcell piece[4];
            rtk_u32 count = rtk_oct_pieces(&c, n.child, r, t0, back, piece);
            while (count > 1u)
                stack[top++] = piece[--count];
            c = piece[0];
            continue;
        }
        if (RTK_MODE & RTK_MODE_STEPS)
            q->leaves++;
        if (!rtk_query_before(q, RTK_MODE, r, outer, c.t1)) {
            for (i = 0u; i < n.count; i++)
                if (RTK_PRIM(q, RTK_MODE, r, tree.refs[n.first + i]))
                    return 1;
        }
        if (top == 0u || rtk_query_done(q, RTK_MODE, r, outer, c.t1))
            return 0;
        t0 = c.t1;
        c = stack[--top];
    }
}
