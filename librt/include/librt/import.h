/** librt: files with geometry. */
#ifndef LIBRT_IMPORT_H
#define LIBRT_IMPORT_H

#include "librt/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rt_import_desc {
    uint32_t struct_size;
    rt_geometry_common common; /**< material of what has none of its own; {0} too */
    rt_transform transform;    /**< baked into the vertices */
    int ignore_materials;      /**< OBJ: do not read the MTL file */
    int smooth;                /**< make vertex normals (angle-weighted) where the file has none and the angle between faces is below smooth_angle_deg */
    float smooth_angle_deg;    /**< 60 */
} rt_import_desc;
RT_API rt_import_desc rt_import_desc_default(void);

typedef struct rt_import_result {
    rt_geometry first;       /**< the geometries added are first.id ... first.id + count - 1 */
    uint32_t geometry_count; /**< an OBJ gives one a material */
    uint64_t triangles, vertices;
    uint32_t warnings; /**< things passed over, each logged as a warning (missing texture, degenerate face) */
} rt_import_result;

/** Reads a mesh by its content (PLY and STL by their first bytes) or else its ending: PLY (ASCII, binary of both byte orders; polygons, colours, normals, uv),
 *  OBJ with MTL and textures (map_Kd, map_d), STL (both kinds). The file is hostile: counts are checked against its size.
 *  Errors   IO, FORMAT with file and line (byte offset for binary), MEMORY, UNSUPPORTED; the scene is unchanged then
 *  Threads  one editor
 *  Owner    result may be NULL */
RT_API rt_status rt_scene_import(rt_scene *scene, const char *path, const rt_import_desc *desc, rt_import_result *result);

#ifdef __cplusplus
}
#endif
#endif
