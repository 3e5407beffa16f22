/* Embree 3 as an entrant, inside: its library and entrants (embree.c), its scenes (embree_scenes.c), its ways to take rays
 * (embree_rays.c). */
#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

#include <stdatomic.h>

#include <embree3/rtcore.h>

#include "rays.h"

/* What is loaded of it. */
#define EMBREE_CALLS(X)                                                                                                          \
    X(rtcNewDevice)                                                                                                              \
    X(rtcReleaseDevice)                                                                                                          \
    X(rtcGetDeviceProperty)                                                                                                      \
    X(rtcGetDeviceError)                                                                                                         \
    X(rtcSetDeviceMemoryMonitorFunction)                                                                                         \
    X(rtcNewScene)                                                                                                               \
    X(rtcReleaseScene)                                                                                                           \
    X(rtcSetSceneBuildQuality)                                                                                                   \
    X(rtcSetSceneFlags)                                                                                                          \
    X(rtcCommitScene)                                                                                                            \
    X(rtcNewGeometry)                                                                                                            \
    X(rtcReleaseGeometry)                                                                                                        \
    X(rtcSetSharedGeometryBuffer)                                                                                                \
    X(rtcSetGeometryInstancedScene)                                                                                              \
    X(rtcSetGeometryTransform)                                                                                                   \
    X(rtcCommitGeometry)                                                                                                         \
    X(rtcAttachGeometryByID)                                                                                                     \
    X(rtcIntersect1)                                                                                                             \
    X(rtcIntersect8)                                                                                                             \
    X(rtcIntersect16)                                                                                                            \
    X(rtcIntersect1M)                                                                                                            \
    X(rtcOccluded1)                                                                                                              \
    X(rtcOccluded8)                                                                                                              \
    X(rtcOccluded16)                                                                                                             \
    X(rtcOccluded1M)

enum { EMBREE_SCENES_MOST = 6 };

/* The triangles of a scene as indexed vertices. */
typedef struct embree_mesh {
    const rt_scene *scene;
    float *vertices;
    uint32_t *indices;
    rt_triangle *triangles;
    uint32_t vertex_count, triangle_count;
} embree_mesh;

/* Where a mesh is placed, and the inst_id that our hits there have. */
typedef struct embree_place {
    rt_transform to_world;
    uint32_t mesh, inst_id;
} embree_place;

/* What Embree gets of a scene: its own triangles are mesh 0, which may have none; each scene that instances place is one more. */
typedef struct embree_geometry {
    embree_mesh *meshes;
    RTCScene *children; /* [mesh_count] of the scene that is being made; 0 is not used */
    embree_place *places;
    uint32_t mesh_count, mesh_room, place_count;
    const float *balls; /* the world's */
    uint32_t ball_count;
} embree_geometry;

/* The geomIDs in Embree's scene: of the scene's own triangles, and of place i. */
enum { EMBREE_OWN = 0, EMBREE_FIRST_PLACE = 1 };

struct bench_embree {
    void *library;
#define MEMBER(name) __typeof__(name) *name;
    EMBREE_CALLS(MEMBER)
#undef MEMBER
    RTCDevice device;
    RTCScene scenes[EMBREE_SCENES_MOST];
    uint32_t scene_count;
    atomic_llong bytes; /* what the device holds, by its own account */
    char version[32];
    embree_geometry geometry;
};

/* What an entrant of Embree is: its data. */
typedef struct embree_entrant {
    const bench_embree *embree;
    RTCScene scene;
} embree_entrant;

/* Copies what the world holds; BENCH_OK, or a status after a sentence that says why Embree cannot have it. To be freed after
 * either. */
int bench_embree_geometry_take(embree_geometry *geometry, const bench_world *world);
void bench_embree_geometry_free(embree_geometry *geometry);
/* A scene of e->geometry. seconds, cpu: of its commit and those of the scenes that it places. */
RTCScene bench_embree_scene(const bench_embree *e, const char *quality, bool robust, double *seconds, double *cpu);

/* Sets an entrant's functions, and its width: mode is "single", "8", "16" or "stream". */
void bench_embree_set_mode(bench_entrant *entrant, const char *mode);

#endif
