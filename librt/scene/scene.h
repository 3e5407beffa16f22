/* The editable description behind an rt_scene: tables in the order of adding, nothing shared with a snapshot but texture chunks.
 */
#ifndef RTI_SCENE_H
#define RTI_SCENE_H

#include "chunk.h"
#include "snapshot.h"

#include "../accel/accel.h"

/* Coordinates may not be larger: the products of the leaf tests then stay inside the floats' range. */
#define RTI_COORD_MAX  1.0e12f
#define RTI_MAX_PRIMS  (1u << 30)
#define RTI_BLADES_MAX 64u

/* Arrays of a mesh (or a geometry of many shapes), all in one block. Absent ones are NULL. Never changed once it is filled while there is
 * another reference: geometries of several scenes may share it. */
typedef struct rti_mesh {
    atomic_uint refs;
    size_t size; /* of the block, this struct first */
    uint32_t vertex_count;
    float *positions, *normals, *uvs, *colors;
    uint32_t *indices, *materials, *faces;
} rti_mesh;

typedef struct rti_geometry {
    uint8_t type; /* RTK_GEOM_* */
    uint8_t alive;
    uint32_t material, mask, user_id;
    float uv_xfm[6];
    uint32_t count; /* primitives */
    uint32_t first; /* shapes and planes: index in the scene's array of them */
    rti_mesh *mesh; /* a reference; NULL: has no arrays */
} rti_geometry;

typedef struct rti_plane {
    rtk_shape shape;
    float t_dir[3];      /* unit, in the plane */
    float width, height; /* of the texture; height 0: by the image's shape */
} rti_plane;

typedef struct rti_inst {
    rt_scene *child; /* NULL: removed */
    rtk_xfm to_world;
    rt_transform *motion; /* [motion_count] places behind to_world, evenly spaced, as they were given; NULL: stands still */
    uint32_t motion_count;
    uint32_t material, mask, user_id;
    uint32_t group; /* in the snapshot that is being made */
} rti_inst;

typedef struct rti_light {
    bool alive, visible;
    rtk_light light;
} rti_light;

typedef struct rti_texture {
    rti_chunk *chunk;
    rti_hash source; /* of the path and its settings; zero when it came from memory */
} rti_texture;

typedef struct rti_array {
    void *data;
    size_t count, capacity;
} rti_array;
#define RTI_AT(array, type, index) (&((type *)(array).data)[index])

/* Two places for the current snapshot (left-right): readers count themselves into the one they read, a writer fills the other. They
 * count at seats, each in a cache line of its own, so that threads that ask for a ray at a time do not wait for one another. */
#define RTI_SEATS 16u
typedef struct rti_seat {
    atomic_uint readers[2];
    char apart[64 - 2 * sizeof(atomic_uint)];
} rti_seat;
typedef struct rti_cell {
    atomic_uint current;
    rti_snapshot *snapshot[2];
    rti_seat seats[RTI_SEATS];
} rti_cell;

/* Boxes, lo and hi each, that hold all of a group and are grown as its own: where it is when it is turned, they tell better than the
 * one does. */
#define RTI_COVER 64
typedef struct rti_cover_boxes {
    rti_hash group; /* of its chunk */
    uint32_t count;
    float box[RTI_COVER][6];
} rti_cover_boxes;

struct rt_scene {
    rt_context *ctx;
    atomic_uint refs;
    rt_scene *next_going;            /* of those that rt_scene_destroy frees, which nothing refers to */
    bool loaded;                     /* from a file: no description */
    bool geometry_changed;           /* since the last commit: group and attribute chunks must be made anew */
    bool primitives_changed;         /* since the last commit: some came or went, rather than only moved */
    rti_array materials;             /* rtk_material */
    rti_array textures;              /* rti_texture */
    rti_array geometries;            /* rti_geometry */
    rti_array shapes;                /* rtk_shape, with those of removed geometries */
    rti_array planes;                /* rti_plane */
    rti_array instances;             /* rti_inst */
    rti_array lights;                /* rti_light */
    rti_array covers;                /* rti_cover_boxes, of the last commit */
    uint64_t tri_count, shape_count; /* alive */
    rtk_world world;
    rt_camera_desc camera[2];    /* at time 0 and 1 */
    rti_build_settings settings; /* of the last commit, or defaults */
    uint32_t tree_kinds;         /* 1 << RTK_TREE_* wanted by the last commit */
    bool auto_builder;
    float refit; /* of the last commit's descriptor */
    const char *tracer; /* name from the table of tracers, NULL: auto */
    rti_cancel cancel;
    rti_cell cell;
};

void rti_array_free(rt_context *ctx, rti_array *array, size_t item_size);
/* Pushes one zeroed item; NULL: no memory (nothing changed). Counts up: take back with array->count--. */
void *rti_array_push(rt_context *ctx, rti_array *array, size_t item_size);
/* The sentence for a push or reserve that failed: arrays grow by doubling. */
rt_status rti_array_refused(rt_context *ctx, const char *call, const rti_array *array, size_t more, size_t item_size);
/* As RT_ERROR_STATE with a sentence when the scene came from a file. */
rt_status rti_scene_editable(const rt_scene *scene, const char *call);
void rti_scene_retain(rt_scene *scene);

/* Cell of the current snapshot (cell.c). */
void rti_cell_init(rti_cell *cell);
rti_snapshot *rti_cell_acquire(rti_cell *cell);
/* For a few rays: the snapshot (NULL: none) stays while the caller does, without a reference, and a writer waits for that. Returns what
 * rti_cell_leave takes. */
uint32_t rti_cell_enter(rti_cell *cell, rti_snapshot **snapshot);
void rti_cell_leave(rti_cell *cell, uint32_t token);
void rti_cell_replace(rti_cell *cell, rti_snapshot *snapshot); /* takes the reference; one writer at a time */

/* ---- checks of arguments (check.c): RT_OK, or ARGUMENT with "CALL: FIELD is VALUE; it must be ..." ---- */
rt_status rti_check_range(rt_context *ctx, const char *call, const char *field, float x, float low, float high);
rt_status rti_check_positive(rt_context *ctx, const char *call, const char *field, float x); /* 0 < x <= RTI_COORD_MAX */
rt_status rti_check_point(rt_context *ctx, const char *call, const char *field, rt_vec3 p);
rt_status rti_check_direction(rt_context *ctx, const char *call, const char *field, rt_vec3 d); /* finite, not zero */
rt_status rti_check_color(rt_context *ctx, const char *call, const char *field, rt_vec3 c, float high);
/* Every one of count * width numbers is finite and at most `high` in size; names the item. */
rt_status rti_check_floats(rt_context *ctx, const char *call, const char *field, const float *x, size_t count, unsigned width,
                           float high);
rt_status rti_check_material(const rt_scene *scene, const char *call, const char *field, uint32_t id);
rt_status rti_check_materials(const rt_scene *scene, const char *call, const char *field, const uint32_t *ids, size_t count);
rt_status rti_check_texture(const rt_scene *scene, const char *call, const char *field, uint32_t id);
rt_status rti_check_common(const rt_scene *scene, const char *call, const rt_geometry_common *common);
/* A handle's record, or NULL with the sentence set. */
rti_geometry *rti_geometry_at(rt_scene *scene, const char *call, uint32_t id);
/* The same of a scene that can be edited: STATE or ARGUMENT with the sentence. */
rt_status rti_geometry_edit(rt_scene *scene, const char *call, rt_geometry geometry, rti_geometry **out);

/* ---- adding (geometry.c, mesh.c) ---- */
rt_status rti_geometry_push(rt_scene *scene, const char *call, const rt_geometry_common *common, uint8_t type, uint32_t count,
                            rti_geometry **geometry);
rt_geometry_common rti_common_default(void);
/* A mesh record with room for the arrays asked for (counts of items, 0: none), to be filled by the caller. */
typedef struct rti_mesh_want {
    uint32_t vertices, triangles; /* positions, and triples of indices */
    bool normals, uvs;
    uint32_t colors, materials, faces;
} rti_mesh_want;
rt_status rti_mesh_make(rt_context *ctx, const char *call, const rti_mesh_want *want, rti_mesh **out);
void rti_mesh_free(rt_context *ctx, rti_mesh *mesh); /* a reference; NULL is fine */
/* A checked copy of a mesh's arrays, all but the materials of faces, which only a scene can check. */
rt_status rti_mesh_of(rt_context *ctx, const char *call, const rt_mesh_desc *desc, rti_mesh **out);
/* A new geometry of the mesh, whose reference it takes, also when that fails. */
rt_status rti_mesh_add(rt_scene *scene, const char *call, const rt_geometry_common *common, rti_mesh *mesh, uint32_t triangle_count,
                       rt_geometry *geometry);
/* What every add begins with: the scene can be edited, the descriptor is sound (copied over the defaults in full), so are its
 * common fields. common points into full. */
rt_status rti_add_begin(rt_scene *scene, const char *call, const void *desc, void *full, uint32_t size,
                        const rt_geometry_common *common);
/* Room for count shapes of a new geometry, all or nothing: *shapes is set on success alone (at least one place is there, count 0
 * too), and all of them are zero. */
rt_status rti_shapes_push(rt_scene *scene, const char *call, const rt_geometry_common *common, uint32_t count,
                          rti_geometry **geometry, rtk_shape **shapes);
/* The handle of the last geometry, for whoever wants it (NULL: nobody). */
void rti_geometry_give(const rt_scene *scene, rt_geometry *geometry);

/* ---- textures (texture_chunk.c) ---- */
typedef struct rti_texels {
    const void *pixels; /* rows from the top, no padding */
    uint32_t width, height;
    uint32_t channels; /* 1, 3 or 4 */
    uint32_t flags;    /* RTK_TEX_FLOAT (floats instead of bytes), SRGB, NEAREST, CLAMP */
} rti_texels;
rt_status rti_texture_chunk(rt_context *ctx, const char *call, const rti_texels *d, rti_chunk **out);

/* ---- transforms (transform.c) ---- */
/* Inverse in double, rounded once. false: singular, or so near to it that floats cannot hold the inverse. */
bool rti_xfm_invert(const rtk_xfm *a, rtk_xfm *out);
/* Box around the image of [lo, hi], and by how much to grow it when hits reach out to coordinate `reach` (see transform.c). */
void rti_xfm_bounds(const rtk_xfm *to_world, const float lo[3], const float hi[3], float out_lo[3], float out_hi[3]);
void rti_xfm_growth(const rtk_xfm *to_world, const rtk_xfm *to_object, float reach, float out[3]);
/* Is there more to it than scaling along the axes, in whatever order, and moving? */
bool rti_xfm_turns(const rtk_xfm *a);
/* Of [lo, hi] what is in the box around the images of these boxes, lo and hi each. */
void rti_xfm_cover(const rtk_xfm *to_world, const float (*boxes)[6], uint32_t count, float lo[3], float hi[3]);

/* ---- the ways of moving instances (motion.c) ---- */
/* Segments from keys [segments + 1]. NULL, or what is wrong: "the places ..." goes on with it. */
const char *rti_motion_make(const rtk_xfm *keys, uint32_t segments, rtk_motion *out);
/* May kernels use them? For those of a file. */
bool rti_motion_sound(const rtk_motion *motion, uint32_t segments);
/* As rti_xfm_bounds and rti_xfm_growth, over all times; [lo, hi] is the child's box for both. */
void rti_motion_bounds(const rtk_motion *motion, uint32_t segments, const float lo[3], const float hi[3], float out_lo[3],
                       float out_hi[3]);
float rti_motion_growth(const rtk_motion *motion, uint32_t segments, const float lo[3], const float hi[3], float reach);
#define RTI_MOTION_MAX 1024u /* segments of one instance */

static inline rtk_vec3 rti_vec(rt_vec3 a)
{
    return rtk_v3(a.x, a.y, a.z);
}

#endif
