/* One mode of rays that go one by one where there is nothing but triangles (bvh_lone_one.h), of the scene itself or of instances.
 * Included by bvh_packet.inl. */

/* A ray through an instance, as RTK_NAME(instance). */
RTI_APART int RTK_NAME(one_instance)(const rtk_scene *scene, const rti_ray *ray, float time, rtk_u32 ref, float outer,
                                     rtk_hit *best)
{
    const rtk_instance *inst = &scene->instances[ref];
    rtk_query q;
    int end;
    if ((ray->mask & inst->mask) == 0u)
        return 0;
    end = lone_instance(scene, RTK_MODE, ray, time, inst, outer, best);
    if (end >= 0)
        return end;
    rtk_query_init(&q, scene, lone_ray(ray));
    q.time = time;
    q.best = *best;
    end = RTK_NAME(instance)(&q, ref, q.ray.org, outer);
    *best = q.best;
    return end;
}

RTI_APART int RTK_NAME(one_refs)(lone *l, rtk_u32 at, rtk_u32 count)
{
    for (rtk_u32 k = 0u; k < count; k++)
        if (RTK_NAME(one_instance)(l->scene, l->ray, l->time, l->tree->refs[at + k], l->shift, &l->best))
            return 1;
    l->t = l->best.t;
    l->far = rtk_min(l->far, l->t);
    return 0;
}

/* Through the top level, which has no blocks; moved: the ray started far away from it. */
#define TOP(moved)                                                                                                               \
    return RTK_MODE & RTK_MODE_ANY ? lone_any(l, 0, moved, RTK_NAME(one_refs), RTK_NAME(one_refs))                               \
                                   : lone_closest(l, 0, moved, RTK_NAME(one_refs), RTK_NAME(one_refs))
RTI_APART int RTK_NAME(one_top_near)(lone *l)
{
    TOP(0);
}
RTI_APART int RTK_NAME(one_top_far)(lone *l)
{
    TOP(1);
}
#undef TOP
RTI_VEC int RTK_NAME(one_top)(lone *l)
{
    return l->shift != 0.0f ? RTK_NAME(one_top_far)(l) : RTK_NAME(one_top_near)(l);
}

/* A ray through all instances, behind what it has met. */
static int RTK_NAME(one_instances)(rtk_query *q)
{
    const rtk_scene *s = q->scene;
    rti_ray ray, apart;
    lone_given given;
    lone l;
    int end = 0;
    if (s->unbounded_count != 0u)
        return RTK_NAME(instances)(q);
    rti_f4_store(ray.org, (rti_f4){q->ray.org.x, q->ray.org.y, q->ray.org.z, q->ray.tmin});
    rti_f4_store(ray.dir, (rti_f4){q->ray.dir.x, q->ray.dir.y, q->ray.dir.z, q->ray.tmax});
    ray.mask = q->ray.mask;
    if (!lone_begin_top(&l, s, &ray, &given))
        return 0;
    l.best = q->best;
    end = lone_top_ready(&l, &given, s, &s->top_bvh, &apart);
    if (end < 0)
        return RTK_NAME(instances)(q);
    l.time = q->time;
    if (end > 0)
        end = RTK_NAME(one_top)(&l);
    q->best = l.best;
    return end;
}

/* A ray through whatever there is. */
RTI_APART int RTK_NAME(one_other)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    rtk_query q;
    int end = 0;
    rtk_query_init(&q, scene, lone_ray(ray));
    q.time = time;
    if (rtk_ray_valid(q.ray))
        end = rtk_query_planes(&q, RTK_MODE, q.ray) || RTK_NAME(group)(&q, q.ray) || RTK_NAME(one_instances)(&q);
    if (RTK_MODE & RTK_MODE_ANY)
        return end;
    rtk_query_finish(&q);
    memcpy(hit, &q.best, sizeof *hit);
    return hit->prim != RTK_INVALID;
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

/* A ray through triangles, shapes and instances, or on to one_other. */
RTI_APART int RTK_NAME(one_mixed)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    lone_given given;
    rti_ray apart;
    lone l;
    int end;
    if (!lone_fits(scene) || ray->mask == 0u ||
        !(scene->groups->part_count == 0u ? lone_begin_top(&l, scene, ray, &given) : lone_begin(&l, scene, ray, &given)))
        return RTK_NAME(one_other)(scene, ray, time, hit);
    l.inst = RTK_INVALID;
    lone_keep(&l, ray->tmax, 0.0f, 0.0f, RTK_INVALID, RTK_INVALID);
    end = lone_parts(&l, RTK_MODE, &given, scene->groups);
    if (end == 0 && scene->instance_count != 0u) {
        end = lone_top_ready(&l, &given, scene, &scene->top_bvh, &apart);
        l.time = time;
        if (end > 0)
            end = RTK_NAME(one_top)(&l);
    }
    if (end < 0)
        return RTK_NAME(one_other)(scene, ray, time, hit);
    if (RTK_MODE & RTK_MODE_ANY)
        return end;
    if (l.best.prim != RTK_INVALID &&
        scene->groups[l.best.inst == RTK_INVALID ? 0u : scene->instances[l.best.inst].group].shape_count != 0u)
        RTK_NAME(one_finish)(scene, ray, time, &l.best);
    memcpy(hit, &l.best, sizeof l.best);
    return l.best.prim != RTK_INVALID;
}

/* rti_tracer.one: a mesh's own way, which some rays are not for. */
static int RTK_NAME(one)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    if (scene->flags & RTK_SCENE_MESH) {
        lone l;
        const int walks = lone_mesh(&l, RTK_MODE, scene, ray);
        if (walks >= 0) {
            if (RTK_MODE & RTK_MODE_ANY)
                return walks && lone_walk(&l, RTK_MODE);
            if (walks)
                lone_walk(&l, RTK_MODE);
            memcpy(hit, &l.best, sizeof l.best);
            return l.best.prim != RTK_INVALID;
        }
    }
    return RTK_NAME(one_mixed)(scene, ray, time, hit);
}

/* Rays of a batch, one by one. */
static void RTK_NAME(ones)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, const rti_scratch *scratch)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const rtk_u32 k = i % RTK_BLOCK;
        const float time = scratch->times ? scratch->times[i] : 0.0f;
        rti_ray ray;
        rti_hit hit;
        rti_f4_store(ray.org, (rti_f4){b->ox[k], b->oy[k], b->oz[k], b->tmin[k]});
        rti_f4_store(ray.dir, (rti_f4){b->dx[k], b->dy[k], b->dz[k], b->tmax[k]});
        ray.mask = b->mask[k];
        if (RTK_MODE & RTK_MODE_ANY) {
            rti_lane_occluded(occluded, i, RTK_NAME(one)(scene, &ray, time, NULL));
            continue;
        }
        RTK_NAME(one)(scene, &ray, time, &hit);
        rti_lane_keep(hits, i, (rtk_hit){hit.t, hit.u, hit.v, hit.prim, hit.geom, hit.inst});
    }
}
