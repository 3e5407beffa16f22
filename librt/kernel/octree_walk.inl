/* Walk of an octree, front to back: the planes through a cell's middle cut the ray's interval into at most four pieces, one a
 * child.
 *
 * Instantiated like kd_stack.inl. Source: parametric order of Revelles, Urena, Lastra 2000. What differs: plane distances are
 * computed from the planes, (mid - org) * inv, never halved from the parent's, and intervals tile the ray as in a kd-tree.
 */
RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    rtk_octcell stack[RTK_OCT_STACK], piece[4], c;
    rtk_u32 top = 0u, i, back = rtk_bits(r->inv.x) >> 31 | rtk_bits(r->inv.y) >> 31 << 1 | rtk_bits(r->inv.z) >> 31 << 2;
    (void)prim_count;
    if (rtk_query_done(q, RTK_MODE, r, outer, r->t0))
        return 0;
    c = rtk_oct_root(tree, r->t0, r->t1);
    for (;;) {
        rtk_u32 count = 0u;
        if (c.child != 0u) {
            if (RTK_MODE & RTK_MODE_STEPS)
                q->nodes++;
            count = rtk_oct_pieces(tree, &c, r, back, piece);
        } else {
            if (RTK_MODE & RTK_MODE_STEPS)
                q->leaves++;
            for (i = rtk_query_before(q, RTK_MODE, r, outer, c.t1) ? c.count : 0u; i < c.count; i++)
                if (RTK_PRIM(q, RTK_MODE, r, tree.refs[c.first + i]))
                    return 1;
        }
        if (count != 0u) {
            c = piece[0];
            while (count > 1u)
                stack[top++] = piece[--count];
        } else {
            if (top == 0u || rtk_query_done(q, RTK_MODE, r, outer, stack[top - 1u].t0))
                return 0;
            c = stack[--top];
        }
    }
}
