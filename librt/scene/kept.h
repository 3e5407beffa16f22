/* Mesh and image files once read, kept in the context: the next scene that wants the same takes them over without parsing. */
#ifndef RTI_KEPT_H
#define RTI_KEPT_H

#include "scene.h"

/* A mesh file's content ready for scenes, without its material libraries: one immutable block, its meshes shared with geometries. */
typedef struct rti_kept_part {
    rti_mesh *mesh;
    uint32_t triangle_count, look; /* look: index of its name, RT_INVALID_ID: none */
} rti_kept_part;

typedef struct rti_kept_model {
    atomic_uint refs;
    uint32_t part_count, look_count, library_count, warnings;
    size_t size; /* of the block */
    rti_kept_part *parts;
    const char **looks, **libraries; /* names in the file's order */
} rti_kept_model;

/* One of the two. */
typedef struct rti_kept {
    rti_chunk *texture;
    rti_kept_model *model;
} rti_kept;
void rti_kept_release(rt_context *ctx, rti_kept kept); /* a reference; empty is fine */

/* A file on its way in. */
typedef struct rti_kept_file {
    rt_context *ctx;
    rti_hash how; /* kind and settings: what else decides what is made of the bytes */
    rti_stamp stamp;
    bool stamped;
    rti_hash content; /* of the bytes, how and stamp's size */
    void *bytes;      /* NULL: not read */
    size_t size;
    double began;
} rti_kept_file;

/* What is held for the file (kept gets a reference, and nothing was parsed), else its bytes to be parsed. Errors of reading. End it in any case. */
rt_status rti_kept_begin(rti_kept_file *file, rt_context *ctx, const char *path, rti_hash how, rti_kept *kept);
/* Holds what was made of the bytes from now on (with references of its own): kept_bytes is what it takes. */
void rti_kept_put(rti_kept_file *file, rti_kept kept, size_t kept_bytes);
void rti_kept_end(rti_kept_file *file);

#endif
