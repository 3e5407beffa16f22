/* What a snapshot is made of, for the files that make, save and load one. */
#ifndef RTI_PARTS_H
#define RTI_PARTS_H

#include "../kernel/blocks.h"
#include "scene.h"

#define RTI_TREE_KINDS 4u /* RTK_TREE_NONE (unused place), KD, OCTREE, BVH */

typedef struct rti_part_group {
    rti_chunk *group, *attribute, *geometry;    /* attribute: NULL when no geometry has any */
    rti_chunk *tree[RTK_PARTS][RTI_TREE_KINDS]; /* of each part of the group chunk */
    uint32_t material_base;                     /* its materials start here in the snapshot's table */
} rti_part_group;

struct rti_snapshot {
    rt_context *ctx;
    size_t size; /* of this block, views included */
    atomic_uint refs;
    uint32_t group_count, texture_count;
    uint32_t reused_chunks, built_trees, built_tops, kept_trees, refitted_trees;
    const struct rti_tracer *tracer;
    rti_build_settings settings;
    bool auto_builder;
    rti_part_group *groups; /* [0]: the scene's own geometry */
    rti_chunk **textures;
    rti_chunk *top, *top_tree[RTI_TREE_KINDS];
    rti_chunk *materials, *lights, *world;
    rtk_group *view_groups;
    rtk_texture *view_textures;
    rtk_scene view;
    struct rti_cell_view {
        rtk_group *groups; /* NULL: there is no such view */
        rtk_scene scene;
    } kdtree_view, octree_view;
};

/* Empty, one reference; NULL: no memory. Chunks are then put in (their references go to it) and finish makes the view,
 * or fails for want of memory, told as of `call`. */
rti_snapshot *rti_snapshot_new(rt_context *ctx, uint32_t group_count, uint32_t texture_count);
rt_status rti_snapshot_finish(rti_snapshot *snapshot, const char *call);
/* Which part of the group a tree of it is over. */
uint32_t rti_tree_part(const rti_part_group *group, const rti_chunk *tree);
/* The same trees for another record of the group. */
void rti_trees_retain(rti_part_group *to, const rti_part_group *from);
/* A snapshot of the scene from before its own primitives moved. */
typedef struct rti_moved {
    const rti_snapshot *before; /* NULL: there is none, or other primitives are in it */
    float limit;                /* a BVH of it is refitted rather than built where its cost stays within so many times what it was; 0: never */
} rti_moved;
/* Gives every group and the top level trees of the kinds (bits 1 << RTK_TREE_*): found in the context, refitted or built. Before finish. */
rt_status rti_snapshot_build(rti_snapshot *snapshot, const char *call, uint32_t kinds, const rti_moved *moved, rti_cancel *cancel);
bool rti_snapshot_complete(const rti_snapshot *snapshot, uint32_t kind); /* has such a tree wherever there is something to find */
uint32_t rti_snapshot_tree(const rti_snapshot *snapshot);                /* RTK_TREE_* of its tracer */
/* Calls visit for every chunk that is there, in a fixed order. group: RTK_INVALID for what belongs to none. */
typedef void (*rti_chunk_visit)(void *data, const rti_chunk *chunk, uint32_t group);
void rti_snapshot_each(const rti_snapshot *snapshot, rti_chunk_visit visit, void *data);

/* Rays of a plain array into blocks. */
void rti_rays_gather(const rt_context *ctx, const rt_ray *rays, uint32_t count, rtk_trace_block *out);

/* The primitives of a part, as references; NULL: all of the group. */
static inline const uint32_t *rti_part_list(const rti_chunk *group, uint32_t part)
{
    const rtk_group_header *head = group->data;
    const uint32_t *list = rti_chunk_at(group, head->off_list);
    if (!head->off_list)
        return NULL;
    for (uint32_t i = 0; i < part; i++)
        list += head->parts[i].count;
    return list;
}

/* ---- making chunks from a description (commit_*.c). Each returns a reference through its last argument and counts reuse. ----
 */
typedef struct rti_commit {
    rt_scene *scene;
    const char *call;
    rti_snapshot *last; /* before this commit, or NULL */
    rti_snapshot *next;
    rti_snapshot **children; /* [child_count], in order of first use: group i + 1 of next is theirs */
    rt_scene **child_scenes;
    uint32_t child_count, child_capacity;
    uint32_t lamp_count; /* visible lights: their bodies stand behind the geometries, their materials behind the scene's */
} rti_commit;

rt_status rti_commit_chunk(rti_commit *c, uint32_t kind, void *data, size_t size, rti_chunk **chunk);
/* Where a geometry's arrays stand in its group's ATTRIBUTE chunk: called for each geometry that has any, in order. */
#define RTI_ATTRIBUTE_HEADER 64u /* the chunk's first bytes: no array stands at offset 0, which means absent */
void rti_plan_attributes(rti_layout *layout, const rti_geometry *geometry, rtk_geom *out);
/* Writes bounds (grown) and scale into head and its parts, from the arrays and the list of the chunk that it describes. */
void rti_group_measure(rt_context *ctx, rtk_group_header *head, const void *chunk);
/* The cover of a group that is not empty. */
void rti_group_cover(rt_context *ctx, const rti_chunk *group, rti_cover_boxes *out);
/* Cuts a measured group into parts where that pays: the block (layout->size bytes) is then replaced by a longer one with the
 * list. */
rt_status rti_group_cut(rti_commit *c, rtk_group_header **head, rti_layout *layout);
rt_status rti_commit_group(rti_commit *c);    /* GROUP, ATTRIBUTE of the scene itself */
rt_status rti_commit_geometry(rti_commit *c); /* GEOMETRY of all groups, after materials */
rt_status rti_commit_table(rti_commit *c, size_t count, size_t record, void **block, size_t *size, void **records);
rt_status rti_commit_materials(rti_commit *c); /* MATERIAL and TEXTURES, own and children's */
rt_status rti_commit_lights(rti_commit *c);    /* after the group */
rt_status rti_commit_world(rti_commit *c);
rt_status rti_commit_top(rti_commit *c); /* after the groups */

#endif
