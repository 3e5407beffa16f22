/* The shadow queue: rays that carry what they bring to the film, answered in batches. */
#include "../kernel/classic.h"
#include "../kernel/integrate.h"
#include "../kernel/surface.h"
#include "lanes.h"

void rti_shadow(rti_worker *worker, uint32_t light, rtk_vec3 org, rtk_vec3 dir, float tmax, rtk_vec3 c, uint32_t home, float time)
{
    rti_shadows *q = &worker->shadows;
    uint32_t i = q->count++, k = i % RTK_BLOCK;
    rtk_trace_block *t = &q->trace[i / RTK_BLOCK];
    rti_pending_block *p = &q->pending[i / RTK_BLOCK];
    t->ox[k] = org.x;
    t->oy[k] = org.y;
    t->oz[k] = org.z;
    t->dx[k] = dir.x;
    t->dy[k] = dir.y;
    t->dz[k] = dir.z;
    t->tmin[k] = 0.0f;
    t->tmax[k] = tmax;
    t->mask[k] = RT_MASK_SHADOW;
    p->r[k] = c.x;
    p->g[k] = c.y;
    p->b[k] = c.z;
    p->home[k] = home;
    if (worker->frame->moving)
        q->times[i] = time;
    q->light = q->light == RTK_INVALID || q->light == light ? light : RTI_LIGHT_MIXED;
    if (q->count == q->capacity)
        rti_shadow_flush(worker);
}

static rtk_vec3 pending(const rti_shadows *q, uint32_t i)
{
    const rti_pending_block *p = &q->pending[i / RTK_BLOCK];
    return rtk_v3(p->r[i % RTK_BLOCK], p->g[i % RTK_BLOCK], p->b[i % RTK_BLOCK]);
}

#define LOT 16u /* blocks that are judged together, */
#define BY  4u  /* by every so manieth of them */

/* How many of the first rays are coherent: of those to one light, up to the last lot half of whose blocks run alike. What cameras
 * see comes first; rays of points that bounces see are faster in streams, though all of them run to one point, too. */
static uint32_t coherent(const rti_shadows *q)
{
    const uint32_t blocks = q->count / RTK_BLOCK;
    if (q->light == RTI_LIGHT_MIXED)
        return 0;
    for (uint32_t end = blocks, first; end > 0; end = first) {
        uint32_t looked = 0, alike = 0;
        first = (end - 1) / LOT * LOT;
        for (uint32_t b = first; b < end; b += BY, looked++)
            alike += rti_block_alike(&q->trace[b]);
        if (2 * alike >= looked)
            return end == blocks ? q->count : end * RTK_BLOCK;
    }
    return blocks == 0 ? q->count : 0;
}

static void ask(rti_worker *w, uint32_t first, uint32_t end, uint32_t flags)
{
    const rti_frame *f = w->frame;
    rti_shadows *q = &w->shadows;
    const uint32_t block = first / RTK_BLOCK;
    w->scratch.times = f->moving ? q->times + first : NULL;
    if (first < end)
        f->set.tracer->occluded(f->scene, q->trace + block, q->occluded + block, end - first, flags, &w->scratch);
}

static void flush_opaque(rti_worker *w)
{
    const uint32_t alike = coherent(&w->shadows);
    ask(w, 0, alike, RTI_TRACE_COHERENT);
    ask(w, alike, w->shadows.count, 0);
    w->frame->lanes->arrive(w);
}

/* A material's colour where ray i has its hit. Where it is the same all over, the surface is not looked at. */
static rtk_vec3 color_at(const rti_worker *w, uint32_t i, const rtk_geom *geom, const rtk_material *m)
{
    const rti_frame *f = w->frame;
    const rti_shadows *q = &w->shadows;
    const rtk_trace_block *t = &q->trace[i / RTK_BLOCK];
    const uint32_t k = i % RTK_BLOCK;
    rtk_ray ray;
    if (m->color_tex == RTK_INVALID && geom->off_colors == 0)
        return rtk_v3(m->color[0], m->color[1], m->color[2]);
    ray.org = rtk_v3(t->ox[k], t->oy[k], t->oz[k]);
    ray.dir = rtk_v3(t->dx[k], t->dy[k], t->dz[k]);
    ray.tmin = t->tmin[k];
    ray.tmax = t->tmax[k];
    ray.mask = t->mask[k];
    return rtk_base_color(f->scene, m, rtk_surface_at(f->scene, ray, rti_hit_at(q->hits, i), f->moving ? q->times[i] : 0.0f),
                          0.0f);
}

/* What is left of c behind the hit; zero when the surface lets nothing through. */
static rtk_vec3 through(rti_worker *w, uint32_t i, rtk_vec3 c)
{
    const rtk_scene *scene = w->frame->scene;
    const rtk_hit_block *h = &w->shadows.hits[i / RTK_BLOCK];
    const uint32_t k = i % RTK_BLOCK;
    const rtk_instance *inst = h->inst[k] != RTK_INVALID ? &scene->instances[h->inst[k]] : NULL;
    const rtk_group *group = &scene->groups[inst ? inst->group : 0];
    const rtk_geom *geom = &group->geoms[h->geom[k]];
    const uint32_t material = rtk_material_of(group, geom, h->prim[k], inst);
    const rtk_material *m = &scene->materials[material];
    rti_touch(w, material);
    if (!(m->flags & RTK_MAT_TRANSPARENT) || (m->flags & RTK_MAT_OPAQUE_SHADOW))
        return rtk_v3(0.0f, 0.0f, 0.0f);
    return rtk_mul(c, rtk_crossing(m, color_at(w, i, geom, m)));
}

/* Ray `from` becomes ray `to`, with its last hit and what is left of its light. */
static void keep(const rti_frame *f, rti_shadows *q, uint32_t from, uint32_t to, rtk_vec3 c)
{
    const rtk_trace_block *a = &q->trace[from / RTK_BLOCK];
    rtk_trace_block *b = &q->trace[to / RTK_BLOCK];
    const rtk_hit_block *ha = &q->hits[from / RTK_BLOCK];
    rtk_hit_block *hb = &q->hits[to / RTK_BLOCK];
    rti_pending_block *p = &q->pending[to / RTK_BLOCK];
    uint32_t i = from % RTK_BLOCK, k = to % RTK_BLOCK;
    b->ox[k] = a->ox[i];
    b->oy[k] = a->oy[i];
    b->oz[k] = a->oz[i];
    b->dx[k] = a->dx[i];
    b->dy[k] = a->dy[i];
    b->dz[k] = a->dz[i];
    b->tmin[k] = a->tmin[i];
    b->tmax[k] = a->tmax[i];
    b->mask[k] = a->mask[i];
    hb->t[k] = ha->t[i];
    hb->u[k] = ha->u[i];
    hb->v[k] = ha->v[i];
    hb->prim[k] = ha->prim[i];
    hb->geom[k] = ha->geom[i];
    hb->inst[k] = ha->inst[i];
    p->home[k] = q->pending[from / RTK_BLOCK].home[i];
    if (f->moving)
        q->times[to] = q->times[from];
    p->r[k] = c.x;
    p->g[k] = c.y;
    p->b[k] = c.z;
}

/* From hit to hit in the order of hits, each ray on its own. A ray whose light has become less than half the film's unit is
 * ended: the film would add zero. */
static void flush_tinted(rti_worker *w, uint32_t flags)
{
    const rti_frame *f = w->frame;
    rti_shadows *q = &w->shadows;
    float nothing = 0.5f / f->film_scale;
    while (q->count > 0 && !rti_cancelled(f->cancel)) {
        uint32_t left = 0;
        w->scratch.times = f->moving ? q->times : NULL;
        f->set.tracer->intersect(f->scene, q->trace, q->hits, q->count, flags, &w->scratch);
        for (uint32_t i = 0; i < q->count; i++) {
            rtk_vec3 c = pending(q, i);
            if (q->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] == RTK_INVALID) {
                rti_add(w, q->pending[i / RTK_BLOCK].home[i % RTK_BLOCK], c);
                continue;
            }
            c = through(w, i, c);
            if (!(rtk_maxabs(c) <= nothing))
                keep(f, q, i, left++, c);
        }
        q->count = left;
        flags |= RTI_TRACE_AFTER;
    }
}

void rti_shadow_flush(rti_worker *worker)
{
    const rti_frame *f = worker->frame;
    rti_shadows *q = &worker->shadows;
    bool ao = f->set.integrator->flags & RTI_INTEGRATOR_AO; /* asks for bodies, not for light: nothing is seen through */
    if (q->count > 0 && !rti_cancelled(f->cancel)) {
        worker->counts.rays[ao ? RTK_KIND_AO : RTK_KIND_SHADOW] += q->count;
        if (f->scene->flags & RTK_SCENE_TRANSPARENT && !f->set.desc.opaque_shadows && !ao)
            flush_tinted(worker, coherent(q) == q->count ? RTI_TRACE_COHERENT : 0);
        else
            flush_opaque(worker);
    }
    q->count = 0;
    q->light = RTK_INVALID;
}
