/* Layout of a committed scene: plain data in arrays, 32-bit indices, 64-bit byte offsets, no pointers (architecture.md, idea 1).
 *
 * A snapshot is a small table over immutable, reference-counted, content-hashed chunks:
 *   GROUP     the geometry of one scene (the scene itself, or one that is instanced): triangles, shapes, planes, bounds
 *   TREE      an accelerator over a group, or over the instances of the top level
 *   ATTRIBUTE per-vertex and per-face data of one group, read by shading only
 *   GEOMETRY  one record a geometry of a group: material, mask, where its data stands
 *   TOP       instances
 *   MATERIAL, TEXTURE (one each), LIGHT, WORLD (camera, ambient, background)
 * Every chunk begins with its header struct; arrays follow at 64-byte aligned offsets counted from the chunk's start. What kernels
 * use is a view: the same data with the offsets resolved (rtk_group, rtk_tree, rtk_scene), made per process or per launch.
 */
#ifndef RTK_SNAPSHOT_H
#define RTK_SNAPSHOT_H

#include "ray.h"

enum {
    RTK_CHUNK_GROUP = 1,
    RTK_CHUNK_TREE,
    RTK_CHUNK_ATTRIBUTE,
    RTK_CHUNK_GEOMETRY,
    RTK_CHUNK_TOP,
    RTK_CHUNK_MATERIAL,
    RTK_CHUNK_TEXTURE,
    RTK_CHUNK_LIGHT,
    RTK_CHUNK_WORLD
};

/* ---- geometry ------------------------------------------------------------------------------------------------------ */

/* Triangles stand in (geometry, primitive) order: the triangle of a hit is tris[geoms[geom].first + prim]. */
typedef struct rtk_tri {
    float v0[3], v1[3], v2[3];
    rtk_u32 geom; /* index in this group's geometry records */
    rtk_u32 prim;
    rtk_u32 pad;
} rtk_tri;

enum { RTK_SHAPE_SPHERE = 0, RTK_SHAPE_BOX, RTK_SHAPE_CYLINDER, RTK_SHAPE_CONE, RTK_SHAPE_TORUS, RTK_SHAPE_PLANE, RTK_SHAPE_COUNT };

/* p: SPHERE centre xyz, radius. BOX low corner, high corner. CYLINDER end 0 xyz, radius, end 1 xyz (capped). CONE end 0 xyz,
 * radius 0, end 1 xyz, radius 1 (capped frustum; a radius may be 0). TORUS centre xyz, major radius, unit axis xyz, minor radius.
 * PLANE point xyz, 0, unit normal xyz (never in a tree). */
typedef struct rtk_shape {
    rtk_u32 type, geom, prim, pad;
    float p[12];
} rtk_shape;

/* A group's triangles and shapes, or those of about one size among them (ray.h, theory point 6). */
#define RTK_PARTS 4
typedef struct rtk_part_header {
    float lo[3], hi[3]; /* grown by RTK_GROW * scale */
    float scale;        /* largest absolute coordinate of the bounds before growth, at least RTK_LEAST */
    rtk_u32 count;      /* primitives */
} rtk_part_header;

/* Shapes too stand in (geometry, primitive) order; planes likewise, in an array of their own. */
typedef struct rtk_group_header {
    float lo[3], hi[3]; /* of triangles and shapes, already grown by RTK_GROW * scale; lo > hi when there are none */
    float scale;        /* as a part's, of all */
    rtk_u32 tri_count, shape_count, plane_count;
    rtk_u32 part_count; /* 0: no triangle and no shape */
    rtk_u32 pad;
    rtk_u64 off_tris, off_shapes, off_planes;
    rtk_u64 off_list; /* several parts: u32 references, those of part 0 ascending, then those of part 1, ... */
    rtk_part_header parts[RTK_PARTS];
} rtk_group_header;

enum { RTK_GEOM_MESH = 0, RTK_GEOM_SHAPES, RTK_GEOM_PLANE };
#define RTK_GEOM_ALPHA 1u          /* some face has an alpha map: the leaf test asks it */
#define RTK_GEOM_FACE_MATERIALS 2u /* off_materials is there */

/* One geometry. first: index of its first triangle, shape or plane; those of geometries of a type stand side by side, in the
 * geometries' order. off_*: byte offsets in the group's ATTRIBUTE chunk,
 * 0 = absent: indices u32[3 prim_count], normals float[3 vertex], uvs float[2 vertex], colors float[3 vertex] (linear),
 * materials u32[prim_count], faces u32[prim_count] (triangle -> polygon of the description). */
typedef struct rtk_geom {
    rtk_u32 type, flags, first, prim_count;
    rtk_u32 material, mask, user_id, vertex_count;
    rtk_u64 off_indices, off_normals, off_uvs, off_colors, off_materials, off_faces;
    float uv_xfm[6]; /* texture placement of planes and shapes: u' = a u + b v + c, v' = d u + e v + f */
    float t_dir[3];  /* plane: direction of growing u, unit, in the plane */
    rtk_u32 material_base; /* added to the material ids of off_materials: a child's materials stand behind the parent's */
    rtk_u32 pad[2];
} rtk_geom;

typedef struct rtk_geometry_header {
    rtk_u32 geom_count, pad;
    rtk_u64 off_geoms;
} rtk_geometry_header;

/* ---- trees ---------------------------------------------------------------------------------------------------------- */

enum { RTK_TREE_NONE = 0, RTK_TREE_KD, RTK_TREE_OCTREE, RTK_TREE_BVH };

/* References: in a group, r < tri_count is triangle r, else shape r - tri_count; at the top level, an instance. */
typedef struct rtk_kdnode {
    rtk_u32 a; /* inner: bits of the split coordinate; leaf: index of its first reference */
    rtk_u32 b; /* low 2 bits: axis, or 3 = leaf; above: inner: index of the low child (the high child follows); leaf: count */
} rtk_kdnode;
#define RTK_KD_LEAF 3u

/* Octree. Cells are halved at mid = 0.5f * (lo + hi) on each axis; child i takes the high half of x, y, z by bits 0, 1, 2. */
typedef struct rtk_octnode {
    rtk_u32 child; /* index of the first of eight children, 0 = leaf */
    rtk_u32 first, count;
    rtk_u32 pad;
} rtk_octnode;

/* Bounding volume hierarchy, eight wide. What a slot holds (bvh.h says how to walk it):
 *   inner   count 0, child the node's index (greater than this node's)
 *   leaf    count references from refs[child] on
 *   empty   child and count 0, lo +inf and hi -inf; behind the others
 * Slots stand in the order in which any hit is found soonest (accel/bvh_order.c).
 * Trees of cells, kd-trees and octrees, are folded into such nodes as well, for walks in vectors: leaves are pieces of the tree's,
 * or several of these, which list a triangle once, boxes what lies in the cells. */
#define RTK_BVH_WIDTH 8u
typedef struct rtk_bvhnode {
    /* [axis][lo, hi][slot]: grown by RTK_GROW * scale (ray.h, theory point 3); of cells cut to the cell */
    float box[3][2][RTK_BVH_WIDTH];
    rtk_u32 child[RTK_BVH_WIDTH], count[RTK_BVH_WIDTH];
} rtk_bvhnode;

/* Four triangles of a leaf side by side: copies of their vertices, [axis][lane]. Block b is of refs[4 b] ... refs[4 b + 3]: a
 * leaf with child < 4 * block_count holds triangles alone, and its blocks are child / 4 to (child + count + 3) / 4 - 1. Leaves of
 * less than four triangles may share one; what is over in a block repeats a triangle of it, in the block and in refs. A walk may
 * test whole blocks. Leaves over anything else have their references behind 4 * block_count; so have all where a tree has
 * no blocks, and the own nodes of a tree of cells. */
#define RTK_BVH_BLOCK 4u
typedef struct rtk_bvhblock {
    float v0[3][RTK_BVH_BLOCK], v1[3][RTK_BVH_BLOCK], v2[3][RTK_BVH_BLOCK];
} rtk_bvhblock;

/* What leaves without blocks meet in vectors, one for each reference behind 4 * block_count but those of cells: x, y, z, radius
 * of a sphere; of another shape a ball around it, its radius with the sign turned; of anything else the radius is -infinity.
 * Behind these four, RTK_FORM in all, where there are shapes that are neither spheres nor tori, the form: of a cylinder or cone
 * end 0 xyz, the radius there, end 1 xyz, the radius; of a box low xyz, RTK_FORM_BOX, high xyz, 0; else zeros and
 * RTK_FORM_OTHER. Trees over instances have none. */
#define RTK_BALL       4u
#define RTK_FORM       12u
#define RTK_FORM_BOX   (-1.0f)
#define RTK_FORM_OTHER (-2.0f)

typedef struct rtk_tree_header {
    rtk_u32 kind; /* RTK_TREE_* */
    rtk_u32 node_count, ref_count;
    rtk_u32 depth;      /* levels below the root of the deepest leaf */
    float lo[3], hi[3]; /* root box, the part's or the top's grown bounds; of an octree these or a wider one */
    rtk_u32 leaf_count, empty_leaf_count, largest_leaf;
    rtk_u32 prim_count; /* what the tree was built over */
    float sah_cost;
    float cost_traverse, cost_intersect, empty_bonus;
    rtk_u32 max_depth, flags;
    float build_seconds; /* a fact about this build; not part of the chunk's hash */
    rtk_u32 block_count; /* 0: no leaf has blocks */
    rtk_u64 off_nodes, off_refs, off_blocks;
    rtk_u32 filler_count; /* references, among ref_count, that only fill up blocks; of cells all but their own */
    float built_cost;     /* of a BVH that was refitted: what it cost when it was built (accel/bvh_refit.c); else 0 */
    rtk_u64 off_wide;     /* of cells: their leaves by eights, wide_count nodes */
    rtk_u32 wide_count;
    rtk_u32 ball_count; /* balls, at off_balls; behind them seven or more that are nothing, up to a multiple of eight; 0: none */
    rtk_u64 off_balls;
    rtk_u32 ball_size, pad; /* RTK_BALL or RTK_FORM floats each */
} rtk_tree_header;

typedef struct rtk_tree {
    rtk_u32 kind;
    rtk_vec3 lo, hi;
    RT_GLOBAL const rtk_kdnode *kd;
    RT_GLOBAL const rtk_octnode *oct;
    RT_GLOBAL const rtk_bvhnode *bvh; /* of cells, too; 64-byte aligned, as blocks are */
    RT_GLOBAL const rtk_bvhblock *blocks;
    RT_GLOBAL const rtk_u32 *refs;
    rtk_u32 block_count, ball_count, ball_size;
    RT_GLOBAL const float *balls;
} rtk_tree;

/* ---- top level -------------------------------------------------------------------------------------------------------- */

#define RTK_INST_UNBOUNDED 1u /* its group has planes: not in the top tree, tested by every ray */
#define RTK_INST_MOVING 2u    /* motion_count segments from motion_first on, evenly spaced over the times 0 to 1 (motion.h) */

/* From key to key of an instance's way: T(u) = t0 + u dt; R(u) turns by the quaternion cos(u angle) q0 + sin(u angle) q1, q0 and q1
 * unit and orthogonal; S(u) = s0 + u ds, symmetric (xx xy xz yy yz zz) and definite. */
#define RTK_MOTION_RIGID 1u /* ds is zero, and inv the inverse of s0 */
typedef struct rtk_motion {
    float t0[3], dt[3];
    float q0[4], q1[4], angle;
    float s0[6], ds[6], inv[6];
    float size, condition; /* bounds over all of the instance's segments: of the norm of S, and of that times its inverse's */
    rtk_u32 flags;
} rtk_motion;

typedef struct rtk_instance {
    rtk_xfm to_world, to_object;
    float lo[3], hi[3]; /* world bounds, of all times, grown (with the rounding of the transform) */
    rtk_u32 group;
    rtk_u32 id;   /* inst id of hits: position in description order, and in this array: a removed or empty one keeps its
                     place with mask 0 and lo > hi, in no tree and no list */
    rtk_u32 mask; /* and-ed with the geometry's */
    rtk_u32 material; /* RTK_INVALID: each geometry's own */
    rtk_u32 user_id, flags;
    rtk_u32 motion_first, motion_count; /* MOVING: the maps above are those of time 0 */
    rtk_u32 pad[2];
} rtk_instance;

typedef struct rtk_top_header {
    float lo[3], hi[3]; /* of the bounded instances, grown; where these are turned, around the boxes of their turned boxes, larger
                         * than their own: hits' last bits depend on it, as origins are moved to it from afar */
    float scale;
    float all_lo[3], all_hi[3]; /* likewise, of all that have a box */
    rtk_u32 instance_count, unbounded_count;
    rtk_u32 motion_count;
    rtk_u64 off_instances, off_unbounded, off_motions; /* unbounded: u32 indices of instances */
} rtk_top_header;

/* ---- materials, textures, lights, world -------------------------------------------------------------------------------- */

enum { RTK_MATERIAL_CLASSIC = 0, RTK_MATERIAL_EMISSIVE, RTK_MATERIAL_COUNT };
#define RTK_MAT_TRANSPARENT 1u   /* shadow rays go through, tinted */
#define RTK_MAT_OPAQUE_SHADOW 2u /* they do not, though it is transparent */

/* The classic model (paper 000). All colours linear. */
typedef struct rtk_material {
    rtk_u32 type, flags;
    float color[3];
    float diffusion, reflectiveness, transparency, refractiveness; /* index; <= 0 means 1 */
    float ambient;                                                  /* weight of the world's ambient light */
    float specular, shininess;                                      /* highlight: weight, exponent */
    float emission[3];
    rtk_u32 color_tex, alpha_tex; /* RTK_INVALID: none */
    float alpha_cut;              /* hits with alpha below it are no hits */
    rtk_u32 pad[14];
} rtk_material;

/* A texture level is stored in 8x8-texel tiles, row-major tiles from the image's bottom row, edge tiles padded by repeating; texels are RGBA8 (sRGB
 * encoded when RTK_TEX_SRGB) or RGBA float (RTK_TEX_FLOAT). Level i is max(1, width >> i) wide. */
#define RTK_TEX_SRGB 1u
#define RTK_TEX_FLOAT 2u
#define RTK_TEX_ALPHA 4u /* some alpha is below 1 */
#define RTK_TEX_NEAREST 8u
#define RTK_TEX_CLAMP 16u
#define RTK_TEX_LEVELS 20
typedef struct rtk_texture_header {
    rtk_u32 width, height, level_count, flags;
    rtk_u64 off_level[RTK_TEX_LEVELS];
} rtk_texture_header;

enum { RTK_LIGHT_POINT = 0, RTK_LIGHT_SPHERE, RTK_LIGHT_DIRECTIONAL };

/* color: POINT, SPHERE: see librt/lights.h for units; DIRECTIONAL: irradiance on a facing surface. body: sphere around a point
 * light whose surface does not shadow it (radius 0: none). falloff: 0 none (paper 000), 2 inverse square. */
typedef struct rtk_light {
    rtk_u32 type, flags;
    float at[3]; /* position, or unit direction the light travels */
    float radius;
    float color[3];
    float falloff;
    float body_at[3], body_radius;
    float select_pdf, select_cdf; /* choice by power: probability of this light; sum up to and including it */
    rtk_u32 samples;              /* shadow rays a hit; 0: the render's setting */
    rtk_u32 geom;                 /* visible body of a spherical light: its geometry (RTK_INVALID: none) */
    rtk_u32 pad[12];
} rtk_light;

typedef struct rtk_light_header {
    rtk_u32 light_count, pad;
    rtk_u64 off_lights;
} rtk_light_header;

typedef struct rtk_material_header {
    rtk_u32 material_count, pad;
    rtk_u64 off_materials;
} rtk_material_header;

enum { RTK_CAMERA_PINHOLE = 0, RTK_CAMERA_ORTHOGRAPHIC };

#define RTK_CAMERA_MOVING 1u

/* One end of a camera's way. */
typedef struct rtk_camera_key {
    float eye[3], aim[3], up[3]; /* aim: from eye to look_at; up: of any length */
    float half_height, aperture;
    float focus; /* 0 at both ends: the length of aim */
} rtk_camera_key;

/* Right-handed frame: a ray of the image point (x, y) in [-1, 1]^2 (y up) goes along back to front. For PINHOLE dir =
 * front + x * right + y * up with right, up already scaled by tan(fov/2) and the aspect; ORTHOGRAPHIC origin = eye + x right + y up.
 * A MOVING one is at time t in [0, 1] what lies between key[0] and key[1] by t; the frame is that of time 0. */
typedef struct rtk_camera {
    rtk_u32 type, flags;
    float eye[3], front[3], up[3]; /* unit front, unit up, orthogonal */
    float right[3];                /* unit */
    float half_height;             /* tan(fov / 2), or half the height of the orthographic window */
    rtk_u32 pad;
    float aperture, focus; /* radius of the lens (0: a point), distance along front of what is sharp */
    rtk_u32 blades;        /* corners of the lens; 0: a disc */
    float blade_turn;      /* radians, from a corner that points up */
    float open, close;     /* the shutter's times, 0 <= open <= close <= 1 */
    rtk_u32 pad2[2];
    rtk_camera_key key[2];
} rtk_camera;

typedef struct rtk_world {
    rtk_camera camera;
    float ambient[3];
    float background[3], background_top[3]; /* vertical gradient by dir.y; equal: plain */
    rtk_u32 background_tex; /* equirectangular map, RTK_INVALID: none */
    rtk_u32 flags;
    rtk_u32 pad[4];
} rtk_world;

/* ---- views ------------------------------------------------------------------------------------------------------------- */

typedef struct rtk_texture {
    RT_GLOBAL const rtk_texture_header *head;
} rtk_texture;

typedef struct rtk_part {
    rtk_vec3 lo, hi; /* grown */
    float scale;
    rtk_u32 count;
    rtk_tree all;            /* no tree: refs is the list of the part's primitives, 0: it is the group */
    rtk_tree kdtree, octree, bvh; /* kind NONE when not built */
} rtk_part;

typedef struct rtk_group {
    rtk_vec3 lo, hi; /* grown */
    rtk_u32 tri_count, shape_count, plane_count, part_count;
    RT_GLOBAL const rtk_tri *tris;
    RT_GLOBAL const rtk_shape *shapes;
    RT_GLOBAL const rtk_shape *planes;
    RT_GLOBAL const rtk_geom *geoms;
    RT_GLOBAL const rtk_u8 *attributes; /* start of the ATTRIBUTE chunk */
    rtk_u32 geom_count;
    rtk_u32 flags; /* RTK_GROUP_* */
    rtk_part parts[RTK_PARTS];
} rtk_group;
#define RTK_GROUP_PLAIN 1u /* each geometry has every bit in its mask, and none has an alpha map */

typedef struct rtk_scene {
    RT_GLOBAL const rtk_group *groups; /* [0]: the scene's own geometry */
    rtk_u32 group_count;
    rtk_u32 instance_count, unbounded_count;
    RT_GLOBAL const rtk_instance *instances;
    RT_GLOBAL const rtk_u32 *unbounded;
    RT_GLOBAL const rtk_motion *motions;
    rtk_vec3 top_lo, top_hi;
    float top_scale;
    rtk_tree top_all, top_kdtree, top_octree, top_bvh; /* top_all: no tree, no list */
    RT_GLOBAL const rtk_material *materials;
    RT_GLOBAL const rtk_texture *textures;
    RT_GLOBAL const rtk_light *lights;
    RT_GLOBAL const rtk_world *world;
    rtk_u32 material_count, texture_count, light_count;
    rtk_u32 flags; /* RTK_SCENE_* */
    /* This scene with its kd-trees, or octrees, in the place of BVHs, for who goes through eight-wide nodes of any
     * (trace/cells.inl); NULL where it has not all of them. */
    RT_GLOBAL const struct rtk_scene *by_kdtree, *by_octree;
} rtk_scene;
#define RTK_SCENE_TRANSPARENT 1u /* some material lets shadow rays through */
#define RTK_SCENE_ALPHA 2u
#define RTK_SCENE_MOVING 4u /* some instance moves: rays have times */
#define RTK_SCENE_MESH 8u /* nothing but triangles of its own, of a plain group in one part of an ordinary scale */
#define RTK_SCENE_BODIES 16u /* shapes in a group that is not the scene's own */

#endif
