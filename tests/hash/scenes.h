/* The scenes of the hash test: between them every primitive, material, light, and both levels of instancing. */
#ifndef TESTS_HASH_SCENES_H
#define TESTS_HASH_SCENES_H

#include "librt/rt.h"

typedef struct hash_scene {
    const char *name;
    /* Fills and commits `scene`; child is an empty scene of the same context for instances. RT_OK or what failed. */
    rt_status (*fill)(rt_scene *scene, rt_scene *child);
} hash_scene;

extern const hash_scene hash_scenes[];
extern const unsigned hash_scene_count;

#endif
