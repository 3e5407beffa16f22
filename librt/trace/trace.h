/* A tracer answers batches of rays with hits; nothing above this line knows which one it is (architecture.md, idea 2). */
#ifndef RTI_TRACE_H
#define RTI_TRACE_H

#include "../base/isa.h"
#include "../kernel/blocks.h"
#include "../kernel/snapshot.h"

#define RTI_TRACE_COHERENT 1u /* rays of a tile's camera or towards one point: pencils and packets pay */
/* The hit blocks hold, on input, the last hit of each ray (prim RTK_INVALID: none): the answer is the next one in the order of
 * hits (t, instance, geometry, primitive), equal t included. This is how multi-hit and tinted shadows step. A closed shape gives
 * all its roots. */
#define RTI_TRACE_AFTER 4u
#define RTI_TRACE_STEPS 8u /* scratch->steps: what each ray cost */

/* What a worker lends a tracer. stats are added to: rays, crowded and together always, the others with RTI_TRACE_STEPS (no loop
 * counts unasked). steps (may be NULL) has count entries then. nodes: inner nodes; crowded: rays that left a stream for want of
 * room; together: rays that went through a tree as a pencil. */
typedef struct rti_trace_stats {
    uint64_t rays, nodes, leaves, tests, crowded, together;
} rti_trace_stats;
typedef struct rti_steps {
    uint32_t nodes, leaves, tests;
} rti_steps;

/* Bytes that a batch of rays may want to work in: for streams, for rays that start far away, and the last two parts where there
 * are instances. */
#define RTI_TRACE_STREAMS ((size_t)6944 << 10)
#define RTI_TRACE_MOVED   ((size_t)704 << 10)
#define RTI_TRACE_PLACED  ((size_t)2176 << 10)
#define RTI_TRACE_TOP     ((size_t)1088 << 10)
#define RTI_TRACE_PLAIN   (RTI_TRACE_STREAMS + RTI_TRACE_MOVED)
#define RTI_TRACE_ROOM    (RTI_TRACE_PLAIN + RTI_TRACE_PLACED + RTI_TRACE_TOP)

/* A ray as callers have it (rt_ray), where it stands, and their hit (rt_hit): who copied them word by word would wait until they
 * stand in memory to be read again. */
#if defined(__GNUC__)
#define RTI_ANYBODYS __attribute__((may_alias))
#else
#define RTI_ANYBODYS
#endif
typedef struct RTI_ANYBODYS rti_ray {
    float org[3], tmin, dir[3], tmax;
    rtk_u32 mask;
} rti_ray;
typedef struct RTI_ANYBODYS rti_hit {
    float t, u, v;
    rtk_u32 prim, geom, inst;
} rti_hit;

/* Where a caller's rays of the next batch stand, and where their hits are to go (NULL where any is enough), which tracers ask for
 * while they are at this one's. */
typedef struct rti_soon {
    const rti_ray *rays;
    const rti_hit *hits;
    uint32_t blocks; /* RTK_BLOCK of each */
} rti_soon;

/* What batches have told of those to come, of the same scene: it costs or saves time, never a hit. */
typedef struct rti_learned {
    uint32_t octants;  /* so many batches of closest hits that are not coherent do better by octants (bvh_stream_mix.h) */
    uint32_t apart[2]; /* coherent rays, of closest and of any hits: so many behind the last do better as others (bvh_learn.h), */
    uint32_t left[2];  /* and so many of those are still to come; */
    int64_t balance[2]; /* what batches before speak for that, worth so many rays (below 0: against it) */
} rti_learned;

typedef struct rti_scratch {
    const float *times; /* [count]: of each ray, 0 to 1; NULL: all are at 0 */
    rti_trace_stats stats;
    rti_steps *steps;
    /* RTI_TRACE_ROOM bytes, or of scenes without instances RTI_TRACE_PLAIN, 64-byte aligned, which a batch may write; NULL: rays
     * that are not coherent go singly. */
    void *room;
    bool narrow; /* streams have room for few lists (bvh_stream.h) */
    bool roomy;  /* streams may be long, as a core has a large cache (rti_context_roomy; bvh_stream.h) */
    bool turns;  /* streams go by turns through trees of any size, not of a large one alone (bvh_stream.h) */
    bool bare;   /* u and v of shapes (not of triangles) are not asked for: they may be 0 */
    rti_learned learned;
    rti_soon soon;
} rti_scratch;

typedef struct rti_tracer {
    const char *name; /* as in settings.traversal: "brute", "kdtree", "octree", "bvh" */
    const char *help;
    uint32_t tree;  /* RTK_TREE_* it walks; NONE: no tree needed */
    uint32_t width; /* rays handled together */
    /* Closest hit of rays [0, count) in rays[(count + 15) / 16]. Writes every hit. Blocks are 64-byte aligned. Lanes behind count
     * are ignored. */
    void (*intersect)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count, uint32_t flags,
                      rti_scratch *scratch);
    /* Any hit: bit i % 16 of occluded[i / 16] says that ray i hits something in (tmin, tmax). */
    void (*occluded)(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded, uint32_t count, uint32_t flags,
                     rti_scratch *scratch);
    /* One ray at a time (0 to 1), without blocks: its closest hit to *hit, or hit NULL: any. Returns whether there is one. */
    int (*one)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit);
} rti_tracer;

/* All tracers, in the order of trace.def: as many, of the same names, trees and widths, for each instruction set that this build
 * holds (another gives the generic ones). The set must run here (rti_context_isa). */
uint32_t rti_tracer_count(void);
const rti_tracer *rti_tracer_at(rti_isa isa, uint32_t index);
/* By name; NULL when there is none. */
const rti_tracer *rti_tracer_find(rti_isa isa, const char *name);

/* A scene that has trees of a kind, KD or OCTREE, with these in the place of its BVHs: rtk_scene.by_kdtree or by_octree, which the
 * caller sets. groups: for copies of as many as the scene has, which live as long as *to. To be done anew when the scene's view
 * changes. */
void rti_trace_by(uint32_t kind, const rtk_scene *scene, rtk_scene *to, rtk_group *groups);

#endif
