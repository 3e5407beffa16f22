/* What a mesh file holds, before there is a scene: parts (one a material) of vertices and triangles, and the looks they name. */
#ifndef RTI_MODEL_H
#define RTI_MODEL_H

#include "../../base/base.h"

#define RTI_MODEL_MAX_TRIANGLES (1u << 30)

/* Triangles of one look. Arrays of vertices have room for vertex_capacity of them; those that are not there are NULL. */
typedef struct rti_part {
    float *positions;  /* [3 vertex_count], finite */
    float *normals;    /* [3 vertex_count] of any length */
    float *uvs;        /* [2 vertex_count], v upwards */
    float *colors;     /* [3 vertex_count], linear */
    uint32_t *indices; /* [3 triangle_count], each < vertex_count */
    uint32_t vertex_count, triangle_count;
    size_t vertex_capacity, index_capacity;
    uint32_t look; /* RT_INVALID_ID: none named */
} rti_part;

/* A material as MTL files describe it. Paths and the name stand in the model's arena, NULL: none. */
typedef struct rti_look {
    const char *name;
    bool defined; /* false: only named by the mesh file */
    float diffuse[3], specular[3], emission[3];
    float shininess, opacity, refraction;
    int illum;
    const char *diffuse_map, *opacity_map;
} rti_look;

typedef struct rti_model {
    rt_context *ctx;
    char name[300]; /* of the file, escaped */
    rti_arena arena;
    rti_part *parts;
    size_t part_count, part_capacity;
    rti_look *looks;
    size_t look_count, look_capacity;
    const char **libraries; /* names after mtllib, as written */
    size_t library_count, library_capacity;
    uint32_t warnings;
} rti_model;

void rti_model_init(rti_model *model, rt_context *ctx, const char *path);
void rti_model_fini(rti_model *model);

/* "NAME: sentence" to the log as a warning (the first 50 of a file), and counts it. */
void rti_model_warn(rti_model *model, const char *format, ...) RTI_PRINTF(2, 3);

/* Appends an empty part. NULL: no memory. */
rti_part *rti_model_add_part(rti_model *model, uint32_t look);
void rti_part_fini(rt_context *ctx, rti_part *part);
/* Room for vertices (whichever arrays are asked for; the others stay NULL); counts stay. false: no memory. */
bool rti_part_reserve(rt_context *ctx, rti_part *part, size_t vertices, bool normals, bool uvs, bool colors);
/* Room for `more` further triangles, then one. Triangles beyond RTI_MODEL_MAX_TRIANGLES: false too. */
bool rti_part_reserve_triangles(rt_context *ctx, rti_part *part, size_t more);
static inline void rti_part_triangle(rti_part *part, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = part->indices + 3 * (size_t)part->triangle_count++;
    to[0] = a, to[1] = b, to[2] = c;
}
/* Cuts a polygon of 3 ... 65535 corners into n - 2 triangles: a fan when it is convex, otherwise by ear clipping. */
bool rti_part_polygon(rt_context *ctx, rti_part *part, const uint32_t *corners, uint32_t n);

/* Gives a part without normals angle-weighted ones: faces that meet along an edge at less than crease_deg share them, others get
 * vertices of their own. Vertices at one place count as one. Linear time. false: no memory. */
bool rti_part_smooth(rt_context *ctx, rti_part *part, float crease_deg);

/* A number as rti_parse_double reads it, or nan or inf in their usual spellings (for the caller to refuse or replace). */
bool rti_parse_any(const char **p, const char *end, double *out);
static inline bool rti_is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* The readers: name is for messages. They fill model->parts (PLY, STL: one; OBJ: one a look). */
rt_status rti_ply_read(rti_model *model, const void *bytes, size_t size);
rt_status rti_stl_read(rti_model *model, const void *bytes, size_t size);
rt_status rti_obj_read(rti_model *model, const void *bytes, size_t size);
/* A material library: fills the looks of these names (all of them are taken). path: of the library, for messages. */
rt_status rti_mtl_read(rti_model *model, const char *path, const void *bytes, size_t size);

typedef enum rti_mesh_format { RTI_MESH_UNKNOWN = 0, RTI_MESH_PLY, RTI_MESH_OBJ, RTI_MESH_STL } rti_mesh_format;
/* By content (PLY and STL), then by the path's ending. */
rti_mesh_format rti_mesh_format_of(const char *path, const void *bytes, size_t size);

#endif
