/* The walk of no tree: every primitive, in order; or those of a list. Instantiated like kd_stack.inl. */
RTK_FN int RTK_WALK(rtk_query *q, rtk_tree tree, rtk_u32 prim_count, const rtk_pray *r, float outer)
{
    rtk_u32 i;
    (void)outer;
    for (i = 0u; i < prim_count; i++)
        if (RTK_PRIM(q, RTK_MODE, r, tree.refs ? tree.refs[i] : i))
            return 1;
    return 0;
}
