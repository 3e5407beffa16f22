/* Embree 3 as an entrant, inside: its library and scenes (embree.c), its ways to take rays (embree_rays.c). */
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
    X(rtcSetGeometryBuildQuality)                                                                                                \
    X(rtcSetSharedGeometryBuffer)                                                                                                \
    X(rtcCommitGeometry)                                                                                                         \
    X(rtcAttachGeometry)                                                                                                         \
    X(rtcIntersect1)                                                                                                             \
    X(rtcIntersect8)                                                                                                             \
    X(rtcIntersect16)                                                                                                            \
    X(rtcIntersect1M)                                                                                                            \
    X(rtcOccluded1)                                                                                                              \
    X(rtcOccluded8)                                                                                                              \
    X(rtcOccluded16)                                                                                                             \
    X(rtcOccluded1M)

enum { EMBREE_SCENES_MOST = 6 };

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
    float *vertices;
    uint32_t *indices;
    rt_triangle *triangles;
    uint32_t vertex_count, triangle_count;
};

/* What an entrant of Embree is: its data. */
typedef struct embree_entrant {
    const bench_embree *embree;
    RTCScene scene;
} embree_entrant;

/* Sets an entrant's functions, and its width: mode is "single", "8", "16" or "stream". */
void bench_embree_set_mode(bench_entrant *entrant, const char *mode);

#endif
