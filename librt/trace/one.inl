/* rti_tracer.one by a tracer's own walk, for one mode, of closest or of any hits. Included by modes.inl. */
static __attribute__((noinline)) int RTK_NAME(one_plain)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    const rtk_ray r = {rtk_v3(ray->org[0], ray->org[1], ray->org[2]), rtk_v3(ray->dir[0], ray->dir[1], ray->dir[2]), ray->tmin,
                       ray->tmax, ray->mask};
    rtk_query q;
    rtk_query_init(&q, scene, r);
    q.time = time;
    const int end = RTK_NAME(trace)(&q);
    if (RTK_MODE & RTK_MODE_ANY)
        return end;
    rtk_query_finish(&q);
    *hit = (rti_hit){q.best.t, q.best.u, q.best.v, q.best.prim, q.best.geom, q.best.inst};
    return hit->prim != RTK_INVALID;
}
