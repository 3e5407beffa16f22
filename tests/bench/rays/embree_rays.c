/* Rays through each of Embree's interfaces: one by one, packets of 8 and 16, streams. They are laid out before the clock runs;
 * denormals count as zero in its calls, as its manual advises. */
#include "embree.h"

#include <string.h>

#if defined(__SSE__)
#include <xmmintrin.h>
#define FAST_DENORMALS 0x8040u /* flush to zero, denormals are zero */
#endif

static void enter(struct RTCIntersectContext *c, const embree_entrant *t, const bench_rays *rays, unsigned *saved)
{
    bool coherent = (rays->hints & RT_RAYS_COHERENT) != 0;
    /* Embree 3.13 may never return from an any-hit call for packets or streams of coherent rays in a scene with instances: shadow
     * rays of 5,000 bunnies hung in rtcOccluded16 and rtcOccluded1M. It is no slower without the flag. */
    if (rays->any && t->embree->geometry.place_count > 0)
        coherent = false;
    rtcInitIntersectContext(c);
    c->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    *saved = 0;
#ifdef FAST_DENORMALS
    *saved = _mm_getcsr();
    _mm_setcsr(*saved | FAST_DENORMALS);
#endif
}

static void leave(unsigned saved)
{
#ifdef FAST_DENORMALS
    _mm_setcsr(saved);
#else
    (void)saved;
#endif
}

static size_t single_room(const bench_rays *rays)
{
    return rays->count * (rays->any ? sizeof(struct RTCRay) : sizeof(struct RTCRayHit));
}

static void fill_ray(struct RTCRay *to, const rt_ray *r)
{
    *to = (struct RTCRay){.org_x = r->org.x,
                          .org_y = r->org.y,
                          .org_z = r->org.z,
                          .tnear = r->tmin,
                          .dir_x = r->dir.x,
                          .dir_y = r->dir.y,
                          .dir_z = r->dir.z,
                          .tfar = r->tmax,
                          .mask = 0xffffffffu};
}

static void single_prepare(bench_entrant *entrant, const bench_rays *rays, void *scratch)
{
    struct RTCRayHit *hits = scratch;
    (void)entrant;
    for (size_t i = 0; i < rays->count; i++) {
        if (rays->any) {
            fill_ray((struct RTCRay *)scratch + i, &rays->rays[i]);
        } else {
            memset(&hits[i].hit, 0, sizeof hits[i].hit);
            fill_ray(&hits[i].ray, &rays->rays[i]);
            hits[i].hit.geomID = hits[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        }
    }
}

static void single_trace(bench_entrant *entrant, const bench_rays *rays, void *scratch, size_t first, size_t count)
{
    const embree_entrant *t = entrant->data;
    struct RTCIntersectContext c;
    unsigned saved;
    enter(&c, t, rays, &saved);
    if (rays->any)
        for (size_t i = first; i < first + count; i++)
            t->embree->rtcOccluded1(t->scene, &c, (struct RTCRay *)scratch + i);
    else
        for (size_t i = first; i < first + count; i++)
            t->embree->rtcIntersect1(t->scene, &c, (struct RTCRayHit *)scratch + i);
    leave(saved);
}

static void stream_trace(bench_entrant *entrant, const bench_rays *rays, void *scratch, size_t first, size_t count)
{
    const embree_entrant *t = entrant->data;
    struct RTCIntersectContext c;
    unsigned saved;
    enter(&c, t, rays, &saved);
    if (rays->any)
        t->embree->rtcOccluded1M(t->scene, &c, (struct RTCRay *)scratch + first, (unsigned)count, sizeof(struct RTCRay));
    else
        t->embree->rtcIntersect1M(t->scene, &c, (struct RTCRayHit *)scratch + first, (unsigned)count, sizeof(struct RTCRayHit));
    leave(saved);
}

/* As our own hits have it: Embree's ids are those of embree_scenes.c. */
static rt_hit hit_of(const embree_entrant *t, float tfar, float u, float v, uint32_t instance, uint32_t geometry,
                     uint32_t primitive)
{
    const embree_geometry *g = &t->embree->geometry;
    const embree_mesh *mesh = &g->meshes[0];
    uint32_t inst_id = RT_INVALID_ID;
    if (geometry != RTC_INVALID_GEOMETRY_ID && instance != RTC_INVALID_GEOMETRY_ID) {
        const embree_place *place = &g->places[instance - EMBREE_FIRST_PLACE];
        mesh = &g->meshes[place->mesh];
        inst_id = place->inst_id;
    }
    if (geometry == EMBREE_OWN && primitive < g->ball_count) /* spheres are one geometry; Embree gives them no u and v */
        return (rt_hit){tfar, 0, 0, primitive, 0, inst_id};
    if (geometry == RTC_INVALID_GEOMETRY_ID || primitive >= mesh->triangle_count)
        return (rt_hit){tfar, 0, 0, RT_INVALID_ID, RT_INVALID_ID, RT_INVALID_ID};
    return (rt_hit){tfar, u, v, mesh->triangles[primitive].prim_id, mesh->triangles[primitive].geom_id, inst_id};
}

static void single_answers(bench_entrant *entrant, const bench_rays *rays, const void *scratch, rt_hit *hits, uint8_t *occluded)
{
    for (size_t i = 0; i < rays->count; i++) {
        if (rays->any) {
            occluded[i] = ((const struct RTCRay *)scratch)[i].tfar < 0;
        } else {
            const struct RTCRayHit *h = (const struct RTCRayHit *)scratch + i;
            hits[i] = hit_of(entrant->data, h->ray.tfar, h->hit.u, h->hit.v, h->hit.instID[0], h->hit.geomID, h->hit.primID);
        }
    }
}

/* Packets of N: one body for 8 and 16, whose types differ in nothing else. */
#define PACKET(N, RAY, RAYHIT, INTERSECT, OCCLUDED)                                                                              \
    static size_t packet##N##_room(const bench_rays *rays)                                                                       \
    {                                                                                                                            \
        return (rays->count + N - 1) / N * (rays->any ? sizeof(struct RAY) : sizeof(struct RAYHIT));                             \
    }                                                                                                                            \
    static void packet##N##_prepare(bench_entrant *entrant, const bench_rays *rays, void *scratch)                               \
    {                                                                                                                            \
        (void)entrant;                                                                                                           \
        memset(scratch, 0, packet##N##_room(rays));                                                                              \
        for (size_t i = 0; i < rays->count; i++) {                                                                               \
            const rt_ray *r = &rays->rays[i];                                                                                    \
            struct RAYHIT *hit = rays->any ? NULL : (struct RAYHIT *)scratch + i / N;                                            \
            struct RAY *ray = rays->any ? (struct RAY *)scratch + i / N : &hit->ray;                                             \
            size_t k = i % N;                                                                                                    \
            ray->org_x[k] = r->org.x;                                                                                            \
            ray->org_y[k] = r->org.y;                                                                                            \
            ray->org_z[k] = r->org.z;                                                                                            \
            ray->tnear[k] = r->tmin;                                                                                             \
            ray->dir_x[k] = r->dir.x;                                                                                            \
            ray->dir_y[k] = r->dir.y;                                                                                            \
            ray->dir_z[k] = r->dir.z;                                                                                            \
            ray->tfar[k] = r->tmax;                                                                                              \
            ray->mask[k] = 0xffffffffu;                                                                                          \
            if (hit)                                                                                                             \
                hit->hit.geomID[k] = hit->hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;                                            \
        }                                                                                                                        \
    }                                                                                                                            \
    static void packet##N##_trace(bench_entrant *entrant, const bench_rays *rays, void *scratch, size_t first, size_t count)     \
    {                                                                                                                            \
        const embree_entrant *t = entrant->data;                                                                                 \
        struct RTCIntersectContext c;                                                                                            \
        unsigned saved;                                                                                                          \
        _Alignas(64) int valid[N];                                                                                               \
        enter(&c, t, rays, &saved);                                                                                              \
        for (int k = 0; k < N; k++)                                                                                              \
            valid[k] = -1;                                                                                                       \
        for (size_t i = first; i < first + count; i += N) {                                                                      \
            for (size_t k = first + count - i; k < N; k++)                                                                       \
                valid[k] = 0;                                                                                                    \
            if (rays->any)                                                                                                       \
                t->embree->OCCLUDED(valid, t->scene, &c, (struct RAY *)scratch + i / N);                                         \
            else                                                                                                                 \
                t->embree->INTERSECT(valid, t->scene, &c, (struct RAYHIT *)scratch + i / N);                                     \
        }                                                                                                                        \
        leave(saved);                                                                                                            \
    }                                                                                                                            \
    static void packet##N##_answers(bench_entrant *entrant, const bench_rays *rays, const void *scratch, rt_hit *hits,           \
                                    uint8_t *occluded)                                                                           \
    {                                                                                                                            \
        for (size_t i = 0; i < rays->count; i++) {                                                                               \
            size_t k = i % N;                                                                                                    \
            const struct RAYHIT *h = (const struct RAYHIT *)scratch + i / N;                                                     \
            if (rays->any)                                                                                                       \
                occluded[i] = ((const struct RAY *)scratch)[i / N].tfar[k] < 0;                                                  \
            else                                                                                                                 \
                hits[i] = hit_of(entrant->data, h->ray.tfar[k], h->hit.u[k], h->hit.v[k], h->hit.instID[0][k], h->hit.geomID[k], \
                                 h->hit.primID[k]);                                                                              \
        }                                                                                                                        \
    }
PACKET(8, RTCRay8, RTCRayHit8, rtcIntersect8, rtcOccluded8)
PACKET(16, RTCRay16, RTCRayHit16, rtcIntersect16, rtcOccluded16)

void bench_embree_set_mode(bench_entrant *x, const char *mode)
{
    x->width = strcmp(mode, "8") == 0 ? 8 : strcmp(mode, "16") == 0 ? 16 : strcmp(mode, "single") == 0 ? 1 : 64;
    x->room = x->width == 8 ? packet8_room : x->width == 16 ? packet16_room : single_room;
    x->prepare = x->width == 8 ? packet8_prepare : x->width == 16 ? packet16_prepare : single_prepare;
    x->trace = x->width == 8 ? packet8_trace : x->width == 16 ? packet16_trace : x->width == 1 ? single_trace : stream_trace;
    x->answers = x->width == 8 ? packet8_answers : x->width == 16 ? packet16_answers : single_answers;
}
