/* One mode of rti_tracer.one where there is nothing but triangles, of the scene itself and of instances (bvh_lone_one.h). Included
 * by bvh_packet.inl. */

/* A ray through an instance. */
RTI_APART int RTK_NAME(one_instance)(const rtk_scene *scene, const rti_ray *ray, float time, rtk_u32 ref, rtk_hit *best)
{
    const rtk_instance *inst = &scene->instances[ref];
    const rtk_ray given = lone_ray(ray);
    rtk_query q;
    int end;
    if ((ray->mask & inst->mask) == 0u)
        return 0;
    end = lone_instance(scene, RTK_MODE, ray, time, inst, best);
    if (end >= 0)
        return end;
    rtk_query_init(&q, scene, given);
    q.time = time;
    q.best = *best;
    end = RTK_NAME(instance)(&q, ref, given.org, 0.0f);
    *best = q.best;
    return end;
}

RTI_APART int RTK_NAME(one_refs)(lone *l, rtk_u32 at, rtk_u32 count)
{
    for (rtk_u32 k = 0u; k < count; k++)
        if (RTK_NAME(one_instance)(l->scene, l->ray, l->time, l->tree->refs[at + k], &l->best))
            return 1;
    l->t = l->best.t;
    l->far = rtk_min(l->far, l->t);
    return 0;
}

RTI_APART int RTK_NAME(one_top)(lone *l)
{
    return RTK_MODE & RTK_MODE_ANY ? lone_any(l, 0, 0, RTK_NAME(one_refs)) : lone_closest(l, 0, 0, RTK_NAME(one_refs));
}

/* What a hit of a shape lacks. */
RTI_APART void RTK_NAME(one_finish)(const rtk_scene *scene, const rti_ray *ray, float time, rtk_hit *best)
{
    rtk_query q;
    rtk_query_init(&q, scene, lone_ray(ray));
    q.time = time;
    q.best = *best;
    rtk_query_finish(&q);
    *best = q.best;
}

static int RTK_NAME(one)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    const rtk_hit none = rtk_hit_none(ray->tmax);
    lone_given given;
    lone l;
    int end;
    if (!lone_fits(scene) || ray->mask == 0u || !lone_begin(&l, scene, ray, &given))
        return RTK_NAME(one_plain)(scene, ray, time, hit);
    end = lone_parts(&l, RTK_MODE, &given, scene->groups, RTK_INVALID, &none);
    if (end == 0 && scene->instance_count != 0u) {
        end = lone_top_ready(&l, &given, scene, &scene->RTK_TOP_TREE);
        l.time = time;
        if (end > 0)
            end = RTK_NAME(one_top)(&l);
    }
    if (end < 0)
        return RTK_NAME(one_plain)(scene, ray, time, hit);
    if (RTK_MODE & RTK_MODE_ANY)
        return end;
    if (l.best.inst != RTK_INVALID && scene->groups[scene->instances[l.best.inst].group].shape_count != 0u)
        RTK_NAME(one_finish)(scene, ray, time, &l.best);
    memcpy(hit, &l.best, sizeof l.best);
    return l.best.prim != RTK_INVALID;
}
