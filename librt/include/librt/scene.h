/** librt: scenes. An rt_scene is the editable description; rt_scene_commit turns it into an immutable snapshot that renders and queries use.
 *
 *  A render or query holds the snapshot it began with, so a scene may be edited and committed beside it. Editing calls on one scene must
 *  not run at the same time as each other or as its commit; queries may run at any time. Every add copies its data. Handles are
 *  positions in description order, from 0, one count a kind; a removed one is never given again. Coordinates and lengths are finite and at
 *  most 1e12 in size; a scene holds at most 2^30 triangles and shapes. A call that is refused changes nothing. */
#ifndef LIBRT_SCENE_H
#define LIBRT_SCENE_H

#include "librt/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rt_material {
    uint32_t id;
} rt_material; /* {0} is the scene's default material */
typedef struct rt_texture {
    uint32_t id;
} rt_texture; /* {RT_INVALID_ID}: none */
typedef struct rt_geometry {
    uint32_t id;
} rt_geometry; /* the geom_id of hits */
typedef struct rt_instance {
    uint32_t id;
} rt_instance; /* the inst_id of hits */
typedef struct rt_light {
    uint32_t id;
} rt_light;

/** Bits of a geometry's mask that the renderer's own rays carry; the upper 24 bits are the caller's. */
enum { RT_MASK_CAMERA = 1, RT_MASK_SHADOW = 2, RT_MASK_REFLECTION = 4, RT_MASK_REFRACTION = 8, RT_MASK_DIFFUSE = 16 };
#define RT_MASK_ALL 0xffffffffu

/* ---- scene ---- */

/** Makes an empty scene with one default material (white, diffusion 1) and no light. Errors ARGUMENT, MEMORY. Owner the caller. */
RT_API rt_status rt_scene_create(rt_context *context, rt_scene **scene);
/** Running jobs keep the snapshot they hold. A scene that others instance lives on until they are destroyed. NULL is fine. */
RT_API void rt_scene_destroy(rt_scene *scene);
RT_API rt_context *rt_scene_context(const rt_scene *scene);

/* ---- textures ---- */

typedef enum rt_pixel_format { RT_PIXEL_RGB8 = 0, RT_PIXEL_RGBA8, RT_PIXEL_GRAY8, RT_PIXEL_RGB32F, RT_PIXEL_RGBA32F } rt_pixel_format;
typedef enum rt_wrap { RT_WRAP_REPEAT = 0, RT_WRAP_CLAMP } rt_wrap;
typedef struct rt_texture_desc {
    uint32_t struct_size;
    uint32_t width, height; /**< 1 ... 65536 */
    const void *pixels;     /**< rows from the top, without padding */
    rt_pixel_format format;
    rt_wrap wrap;
    int linear;  /**< values of 8 bits, and of 16 in files, are linear already (0: sRGB encoded) */
    int nearest; /**< no interpolation, no mip-maps */
} rt_texture_desc;
RT_API rt_texture_desc rt_texture_desc_default(void);
/** Errors ARGUMENT, MEMORY. Threads: one editor. Owner: pixels are copied. */
RT_API rt_status rt_scene_add_texture(rt_scene *scene, const rt_texture_desc *desc, rt_texture *texture);
/** Reads an image file (PNG, JPEG, GIF, BMP, TGA, HDR) and adds it. desc gives wrap, linear, nearest (its size and pixels are ignored); NULL: defaults.
 *  The same file with the same desc added twice gives the same texture. Errors IO, FORMAT, MEMORY, UNSUPPORTED (built without an image reader). */
RT_API rt_status rt_scene_load_texture(rt_scene *scene, const char *path, const rt_texture_desc *desc, rt_texture *texture);

/* ---- materials ---- */

typedef enum rt_material_type {
    RT_MATERIAL_CLASSIC = 0, /**< the model of paper 000: diffuse, mirror, glass, highlight, each by its weight */
    RT_MATERIAL_EMISSIVE     /**< a body that shines with `emission` and scatters nothing */
} rt_material_type;
typedef struct rt_material_desc {
    uint32_t struct_size;
    rt_material_type type;
    rt_vec3 color;        /**< linear, 0 ... 1; default 1, 1, 1 */
    float diffusion;      /**< weight of Lambert reflection, 0 ... 1; default 1 */
    float reflectiveness; /**< weight of the mirror direction, 0 ... 1 */
    float transparency;   /**< weight of the refracted ray, 0 ... 1 */
    float refractiveness; /**< index of refraction, default 1; 0 counts as 1 (paper 000 writes 0 for opaque bodies) */
    float ambient;        /**< weight of the scene's ambient light, 0 ... 1; default 1, which glass and mirrors had better not have */
    float specular;       /**< weight of the highlight (normalised Blinn-Phong), >= 0 */
    float shininess;      /**< its exponent, 1 ... 100000; default 50 */
    rt_vec3 emission;     /**< radiance */
    rt_texture color_texture; /**< multiplies color */
    rt_texture alpha_texture; /**< its alpha (or grey, when it has none) cuts holes where it is below alpha_cut */
    float alpha_cut; /**< default 0.5 */
    int opaque_shadow; /**< a transparent body that casts a full shadow */
} rt_material_desc;
RT_API rt_material_desc rt_material_desc_default(void);
/** Errors ARGUMENT (names the field and the value), MEMORY. */
RT_API rt_status rt_scene_add_material(rt_scene *scene, const rt_material_desc *desc, rt_material *material);
RT_API rt_status rt_scene_set_material(rt_scene *scene, rt_material material, const rt_material_desc *desc);

/* ---- geometry: each add gives one geometry, or an error and no change ---- */

/** Fields that every geometry has. */
typedef struct rt_geometry_common {
    rt_material material;
    uint32_t mask;    /**< seen by rays with (ray mask & mask) != 0; default all bits */
    uint32_t user_id; /**< yours; in rt_surface */
    float uv_transform[6]; /**< texture placement: u' = a u + b v + c, v' = d u + e v + f; default u' = u, v' = v */
} rt_geometry_common;

/** Triangles. Degenerate ones are legal and never hit. */
typedef struct rt_mesh_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    const float *positions; /**< [3 vertex_count], finite */
    uint32_t vertex_count;
    const uint32_t *indices; /**< [3 triangle_count], each < vertex_count */
    uint32_t triangle_count;
    const float *normals;            /**< [3 vertex_count] or NULL: smooth shading; a zero normal falls back to the face's */
    const float *uvs;                /**< [2 vertex_count] or NULL; v grows upwards in the image */
    const float *colors;             /**< [3 vertex_count] linear, or NULL: multiply the material's colour */
    const uint32_t *face_materials;  /**< [triangle_count] material ids, or NULL: common.material */
} rt_mesh_desc;
RT_API rt_mesh_desc rt_mesh_desc_default(void);
RT_API rt_status rt_scene_add_mesh(rt_scene *scene, const rt_mesh_desc *desc, rt_geometry *geometry);

/** Polygon faces (a polyhedron): face f has face_sizes[f] corners (3 ... 65535), simple polygons, convex or not, near to planar. They are cut into
 *  triangles (ear clipping); prim_id of a hit is a triangle's, rt_surface gives the face. */
typedef struct rt_polyhedron_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    const float *positions;
    uint32_t vertex_count;
    const uint32_t *face_sizes;
    uint32_t face_count;
    const uint32_t *indices; /**< the corners of all faces in a row */
    size_t index_count;      /**< must be the sum of face_sizes */
} rt_polyhedron_desc;
RT_API rt_polyhedron_desc rt_polyhedron_desc_default(void);
RT_API rt_status rt_scene_add_polyhedron(rt_scene *scene, const rt_polyhedron_desc *desc, rt_geometry *geometry);

typedef struct rt_sphere_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    rt_vec3 center;
    float radius; /**< > 0; default 1 */
} rt_sphere_desc;
RT_API rt_sphere_desc rt_sphere_desc_default(void);
RT_API rt_status rt_scene_add_sphere(rt_scene *scene, const rt_sphere_desc *desc, rt_geometry *geometry);

/** Many spheres as one geometry: prim_id is the index. */
typedef struct rt_spheres_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    const float *centers; /**< [3 count] */
    const float *radii;   /**< [count], > 0; or NULL: `radius` for all */
    float radius;         /**< default 1 */
    uint32_t count;
    const float *colors;            /**< [3 count] linear, or NULL */
    const uint32_t *face_materials; /**< [count] material ids, or NULL */
} rt_spheres_desc;
RT_API rt_spheres_desc rt_spheres_desc_default(void);
/** Ranges, errors, threads and owner as of rt_scene_add_cylinders. */
RT_API rt_status rt_scene_add_spheres(rt_scene *scene, const rt_spheres_desc *desc, rt_geometry *geometry);

/** Infinite plane, two-sided. A texture stands in the plane with its lower left corner at `point`, `texture_size` units wide (and as high as the image's
 *  shape asks; texture_height > 0 sets it), repeated unless the texture clamps; its u axis is horizontal (up x normal) unless u_axis is given. */
typedef struct rt_plane_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    rt_vec3 point, normal; /**< normal of any length, not zero; default 0, 1, 0 */
    rt_vec3 u_axis;        /**< zero: chosen */
    float texture_size, texture_height; /**< 1e-12 ... 1e12, default 1; the height may be 0 */
} rt_plane_desc;
RT_API rt_plane_desc rt_plane_desc_default(void);
RT_API rt_status rt_scene_add_plane(rt_scene *scene, const rt_plane_desc *desc, rt_geometry *geometry);

typedef struct rt_box_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    rt_vec3 low, high; /**< low < high on each axis; default -1 and 1 */
} rt_box_desc;
RT_API rt_box_desc rt_box_desc_default(void);
RT_API rt_status rt_scene_add_box(rt_scene *scene, const rt_box_desc *desc, rt_geometry *geometry);

/** Capped cylinder, and capped cone frustum with radius0 at `from` and radius1 at `to`. */
typedef struct rt_cone_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    rt_vec3 from, to;       /**< distinct; to: default 0, 1, 0 */
    float radius0, radius1; /**< >= 0, not both 0; a cylinder takes radius0 */
} rt_cone_desc;
RT_API rt_cone_desc rt_cone_desc_default(void);
RT_API rt_status rt_scene_add_cylinder(rt_scene *scene, const rt_cone_desc *desc, rt_geometry *geometry);
RT_API rt_status rt_scene_add_cone(rt_scene *scene, const rt_cone_desc *desc, rt_geometry *geometry);

/** Many capped cylinders, or capped cone frusta, as one geometry (tubes, sticks, hairs): prim_id is the index. As many geometries of one take some
 *  200 bytes more each, and longer to be added, committed and rendered. */
typedef struct rt_cones_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    const float *from, *to; /**< [3 count], the ends of each: distinct, coordinates from -1e12 to 1e12 */
    const float *radii;     /**< [count] at `from`, up to 1e12, or NULL: `radius` for all. Cylinders' are > 0, cones' >= 0 */
    const float *to_radii;  /**< [count] cones' at `to`, >= 0, or NULL: `to_radius` for all. Not read for cylinders. Of a cone one of both is > 0 */
    float radius, to_radius;        /**< default 1 and 0 */
    uint32_t count;                 /**< at most 2^30 */
    const float *colors;            /**< [3 count] linear, from -1e6 to 1e6, or NULL */
    const uint32_t *face_materials; /**< [count] material ids, or NULL: common.material */
} rt_cones_desc;
RT_API rt_cones_desc rt_cones_desc_default(void);
/** Errors ARGUMENT (an array or number out of its range, which the sentence names, elements from 0), STATE (a scene from a file), MEMORY; the scene
 *  stays as it was. Threads one editor. Owner: all arrays are copied. */
RT_API rt_status rt_scene_add_cylinders(rt_scene *scene, const rt_cones_desc *desc, rt_geometry *geometry);
RT_API rt_status rt_scene_add_cones(rt_scene *scene, const rt_cones_desc *desc, rt_geometry *geometry);

typedef struct rt_torus_desc {
    uint32_t struct_size;
    rt_geometry_common common;
    rt_vec3 center, axis;             /**< axis: default 0, 1, 0 */
    float major_radius, minor_radius; /**< 0 < minor < major; default 1 and 0.25 */
} rt_torus_desc;
RT_API rt_torus_desc rt_torus_desc_default(void);
RT_API rt_status rt_scene_add_torus(rt_scene *scene, const rt_torus_desc *desc, rt_geometry *geometry);

RT_API rt_status rt_scene_set_geometry_material(rt_scene *scene, rt_geometry geometry, rt_material material);
RT_API rt_status rt_scene_set_geometry_mask(rt_scene *scene, rt_geometry geometry, uint32_t mask);
/** New places for the vertices of a mesh or polyhedron; its triangles and all else stay as they are. The next commit refits the BVH where that
 *  serves (rt_commit_desc.refit), so a mesh that moves is cheaper than one that is removed and added again.
 *  positions  [3 vertex_count] in  finite
 *  normals    [3 vertex_count] in  or NULL: those that the mesh has, if it has any, stay
 *  Errors     ARGUMENT (no mesh, another count of vertices, a number that is not finite), STATE (a scene from a file), MEMORY; the mesh stays as it was
 *  Threads    one editor
 *  Owner      both are copied */
RT_API rt_status rt_scene_set_mesh_positions(rt_scene *scene, rt_geometry geometry, const float *positions, const float *normals, uint32_t vertex_count);
/** Smooth shading for a mesh or polyhedron: a vertex's normal is the sum of its triangles' normals, each as long as twice the triangle's area, as they
 *  stand now; vertices that shall have an edge between them stand there twice. After rt_scene_set_mesh_positions it is called again. A sum whose
 *  components come to more than 1e18 becomes zero: there the triangles' own normals stand.
 *  Errors   ARGUMENT (no mesh), STATE (a scene from a file), MEMORY; the mesh stays as it was
 *  Threads  one editor
 *  Source   Gouraud 1971, each triangle by its area */
RT_API rt_status rt_scene_smooth_mesh(rt_scene *scene, rt_geometry geometry);
RT_API rt_status rt_scene_remove_geometry(rt_scene *scene, rt_geometry geometry);

/* ---- instances: a whole scene placed in another (two levels: the child may have no instances of its own) ---- */

typedef struct rt_instance_desc {
    uint32_t struct_size;
    rt_scene *child;        /**< same context, committed before the parent is; later edits of it count from the parent's next commit */
    rt_transform transform; /**< invertible; default the identity */
    rt_material material;   /**< {RT_INVALID_ID}: the child's own; else a material of the parent for all of it */
    uint32_t mask, user_id;
    const rt_transform *motion; /**< [motion_count] or NULL: where it stands at the times 1 / motion_count, 2 / motion_count, ... 1; at 0 it is `transform` */
    uint32_t motion_count;      /**< 0 ... 1024 */
} rt_instance_desc;
RT_API rt_instance_desc rt_instance_desc_default(void);
/** An instance with motion goes from place to place: each is taken apart into a translation, a rotation and a (symmetric) stretch; the child's origin
 *  and the stretch go in straight lines, the rotation turns evenly about one axis, the shorter way, so a spin wants a place at least every 180 degrees (and
 *  120 to say which way). A body turns about its own origin: one that is to turn about something else is modelled there, or gets more places. The camera's shutter
 *  says which times an image covers. Moving places may not mirror one and not the next, stretch by more than 1000 : 1, or scale by less than 1e-9 or more
 *  than 1e9. Equal places stand still. Lights do not move. Errors ARGUMENT, MEMORY. */
RT_API rt_status rt_scene_add_instance(rt_scene *scene, const rt_instance_desc *desc, rt_instance *instance);
/** The instance's places behind its transform, as in rt_instance_desc; count 0: it stands still. Errors ARGUMENT, MEMORY. */
RT_API rt_status rt_scene_set_instance_motion(rt_scene *scene, rt_instance instance, const rt_transform *motion, uint32_t count);
/** Where it stands at all times: a motion it had ends. Errors ARGUMENT. */
RT_API rt_status rt_scene_set_instance_transform(rt_scene *scene, rt_instance instance, const rt_transform *transform);
RT_API rt_status rt_scene_remove_instance(rt_scene *scene, rt_instance instance);
/** What an instance is: child, transform, material, mask, user_id, motion and motion_count as they were given and set since, for programs that hand a
 *  scene on. Equal places of motion come back as none (NULL, 0).
 *  desc     begins with rt_instance_desc_default; as much of it is filled as its struct_size has room for, and struct_size says how much that is
 *  Errors   ARGUMENT (no such instance, or it was removed), STATE (a scene from a file); desc stays as it was
 *  Threads  any number, beside a commit too, but beside no edit
 *  Owner    the scene: motion points into it and is good until its next edit, child until the instance is removed or the scene destroyed */
RT_API rt_status rt_scene_get_instance(const rt_scene *scene, rt_instance instance, rt_instance_desc *desc);

/** Affine maps. Angle in degrees, right-handed about the axis. multiply(a, b): b first, then a. */
RT_API rt_transform rt_transform_identity(void);
RT_API rt_transform rt_transform_translate(rt_vec3 by);
RT_API rt_transform rt_transform_scale(rt_vec3 by);
RT_API rt_transform rt_transform_rotate(rt_vec3 axis, float degrees);
RT_API rt_transform rt_transform_multiply(rt_transform a, rt_transform b);

/* ---- lights, world, camera ---- */

typedef enum rt_light_type { RT_LIGHT_POINT = 0, RT_LIGHT_SPHERE, RT_LIGHT_DIRECTIONAL } rt_light_type;
typedef enum rt_falloff {
    RT_FALLOFF_NONE = 0,      /**< paper 000, POV-Ray: a white surface of diffusion 1 facing the light shows `color`, at any distance */
    RT_FALLOFF_INVERSE_SQUARE /**< POINT: color is the radiant intensity / pi; SPHERE: color is the radiance of its surface */
} rt_falloff;
typedef struct rt_light_desc {
    uint32_t struct_size;
    rt_light_type type;
    rt_vec3 at;        /**< POINT, SPHERE */
    rt_vec3 direction; /**< DIRECTIONAL: the way the light travels; default 0, -1, 0 */
    float radius;      /**< SPHERE, > 0: soft shadows; default 1 */
    rt_vec3 color;     /**< linear, >= 0; default 1, 1, 1 */
    float intensity;   /**< multiplies color; default 1 */
    rt_falloff falloff;
    int visible;      /**< SPHERE: its body is seen (as an emissive sphere that casts no shadow of its own light) */
    uint32_t samples; /**< shadow rays a hit; 0: the render's setting */
} rt_light_desc;
RT_API rt_light_desc rt_light_desc_default(void);
/** What stands in front of a POINT or SPHERE light by less than 2^-17 of its greatest coordinate and the lit point's together (at a kilometre, 15 mm), but
 *  no farther than half of the way between the two, throws no shadow: so what a light stands on does not hide it.
 *  A point light inside an opaque sphere of the scene itself (not of an instance) is not shadowed by that sphere, the largest if there are several: the
 *  sphere is its lamp. The body of a visible light is a sphere of its own: hits on it have a geom_id behind those of the described geometries,
 *  and it stands in the way of other lights as any opaque body does. Lights of an instanced scene do not shine; the bodies of its visible ones are seen. */
RT_API rt_status rt_scene_add_light(rt_scene *scene, const rt_light_desc *desc, rt_light *light);
RT_API rt_status rt_scene_set_light(rt_scene *scene, rt_light light, const rt_light_desc *desc);
RT_API rt_status rt_scene_remove_light(rt_scene *scene, rt_light light);

typedef struct rt_world_desc {
    uint32_t struct_size;
    rt_vec3 ambient;
    rt_vec3 background;     /**< towards -y */
    rt_vec3 background_top; /**< towards +y; equal to background: plain */
    rt_texture background_texture; /**< equirectangular, seen instead; it goes around and ends at the poles, whatever its wrap */
} rt_world_desc;
RT_API rt_world_desc rt_world_desc_default(void);
RT_API rt_status rt_scene_set_world(rt_scene *scene, const rt_world_desc *desc);

typedef enum rt_camera_type { RT_CAMERA_PINHOLE = 0, RT_CAMERA_ORTHOGRAPHIC } rt_camera_type;
typedef struct rt_camera_desc {
    uint32_t struct_size;
    rt_camera_type type;
    rt_vec3 eye, look_at, up; /**< eye != look_at; an up along the view is replaced; default 0, 0, 5, the origin and 0, 1, 0 */
    float fov_deg;            /**< vertical, 0 < fov < 180; default 50 */
    float height;             /**< ORTHOGRAPHIC: height of the window in scene units, > 0; default 2 */
    float aperture;           /**< radius of a thin lens in scene units, 0 ... 1e12; 0: everything is sharp. Focal length f, f-number N: f / (2 N) */
    float focus_distance;     /**< from eye along the view to the plane that is sharp, in scene units; 0: where look_at is */
    uint32_t blades;          /**< the lens is a regular polygon of 3 ... 64 corners in the circle of that radius; 0: a disc */
    float blade_rotation_deg; /**< counter-clockwise; at 0 a corner points up */
    float shutter_open, shutter_close; /**< times that the image covers of what moves, 0 <= open <= close <= 1; default 0 and 1 */
} rt_camera_desc;
RT_API rt_camera_desc rt_camera_desc_default(void);
/** The camera at every time: a motion it had ends. Errors ARGUMENT (names the field and the value). */
RT_API rt_status rt_scene_set_camera(rt_scene *scene, const rt_camera_desc *desc);
/** The camera moves: at time 0 it is as rt_scene_set_camera said, at time 1 as desc says; between them eye, look_at, up, the lens and the window
 *  (the tangent of half of fov_deg, or height) go in straight lines, so what look_at follows stays in the middle. desc's type is the camera's; its
 *  blades and shutter are not read. NULL: it stands still again. Errors ARGUMENT, also for a way on which the camera would look at itself or along up. */
RT_API rt_status rt_scene_set_camera_motion(rt_scene *scene, const rt_camera_desc *desc);
/** The camera at time 0, and at time 1. Fields from `aperture` on are written when desc's struct_size is today's (begin with rt_camera_desc_default);
 *  else struct_size comes back as that of the shorter descriptor that was filled. Of a loaded scene look_at lies in the right direction. Errors ARGUMENT. */
RT_API rt_status rt_scene_get_camera(const rt_scene *scene, rt_camera_desc *desc);
RT_API rt_status rt_scene_get_camera_motion(const rt_scene *scene, rt_camera_desc *desc);
/** Puts a pinhole camera so that everything finite is seen from ahead, a little above and to the right, at the given aspect (width / height). */
RT_API rt_status rt_scene_frame_camera(rt_scene *scene, float aspect);
/** Box of everything finite in the description. An empty scene gives low > high. Errors ARGUMENT. */
RT_API rt_status rt_scene_bounds(const rt_scene *scene, rt_vec3 *low, rt_vec3 *high);

/* ---- commit ---- */

typedef struct rt_commit_desc {
    uint32_t struct_size;
    const char *accel; /**< trees to build: "auto" ("bvh"; "kdtree" where the builder is one of its), "kdtree", "octree", "bvh", "brute" (none), or several with commas */
    const char *builder; /**< "auto"; kd-tree: "exact", "binned", "paper" (exact, depth up to 96); BVH: "compact" (no copies of vertices), "spatial" (spatial splits) */
    uint32_t max_depth, leaf_size; /**< 0: the builder's own; of an octree a cell of 1024, where there are no more triangles than shapes of 32, of instances of 8 */
    /** 0: the builder's own. Costs in steps: of an inner node and a primitive (1/128 in cells of a kd-tree or an octree over more triangles than shapes, else 1; of a kd-tree 1/16 for planes that part
     *  about as well as boxes or better; a given one stands for both); what a plane is cheaper by that cuts off nothing but space, 0 ... 1 (above 0.95 as 0.95) */
    float cost_traverse, cost_intersect, empty_bonus;
    float duplication; /**< bound of references per primitive; 0: the builder's own */
    /** Where the vertices of meshes have only moved since the last commit, the BVH over them is refitted, in a tenth of a build's time, unless its
     *  cost has come to be so many times (1 ... 1e6) more or less than when it was built; 0: always built. At 1.25, the default, rays take about a tenth
     *  longer than in a tree that is built, and took half as long again at worst. Hits are the same. Trees of the builder "spatial", kd-trees and octrees
     *  are always built, and so is the top level over instances. */
    float refit;
} rt_commit_desc;
RT_API rt_commit_desc rt_commit_desc_default(void);
/** Makes the snapshot. Chunks whose content has not changed are shared with the last one (a material edit builds no tree), and within the context by content.
 *  A tree that a render or query asks for later by name and that is missing is built then.
 *  The last used trees are kept, up to 256 MiB or a quarter of the memory limit, so that a later scene with the same mesh finds its tree.
 *  desc     NULL: defaults (or what the last commit used)
 *  Errors   MEMORY, MEMORY_LIMIT, CANCELLED (by rt_scene_cancel), STATE (child not committed), ARGUMENT
 *  Threads  one editor; queries and renders of the old snapshot go on */
RT_API rt_status rt_scene_commit(rt_scene *scene, const rt_commit_desc *desc);
/** Ends a commit that runs on another thread within 100 ms; it returns CANCELLED and the old snapshot stays. Any thread. */
RT_API void rt_scene_cancel(rt_scene *scene);

/** Content hash of the committed snapshot (all that can change an image, without trees), 32 hex digits and NUL. Errors STATE. */
RT_API rt_status rt_scene_hash(const rt_scene *scene, char text[33]);
/** The same in parts, 32 hex digits and NUL each: rest, of all but the looks of materials; looks[i] (at most capacity), of material i with what its
 *  textures hold. Materials stand in the order of their handles, those of instanced scenes behind. rest has what a material decides beside its look:
 *  whether shadow rays pass, its kind and cut-out, and the film's unit. *count receives the number of materials; rest, looks and count may be NULL.
 *  Errors STATE. */
RT_API rt_status rt_scene_looks_hash(const rt_scene *scene, char rest[33], char (*looks)[33], uint32_t capacity, uint32_t *count);

typedef struct rt_tree_info {
    const char *name; /**< "kdtree", "octree", "bvh" */
    uint64_t primitives, references, nodes, leaves, empty_leaves, bytes;
    uint32_t depth, largest_leaf;
    double build_seconds;
    float sah_cost;
    uint32_t part; /**< a group that holds things of very different scale has several trees, from the largest scale to the smallest: 0, 1, ... */
} rt_tree_info;
typedef struct rt_scene_info {
    uint64_t triangles, shapes, planes, geometries, instances, materials, textures, lights;
    uint64_t geometry_bytes, attribute_bytes, texture_bytes, tree_bytes, total_bytes;
    uint32_t tree_count; /**< trees of all groups and the top level */
    uint32_t reused_chunks, built_trees; /**< by the last commit */
    uint32_t built_top_trees; /**< of built_trees: over the instances */
    uint32_t kept_trees;      /**< found in the context instead of built */
    uint32_t refitted_trees;  /**< fitted to vertices that have moved instead of built (rt_commit_desc.refit) */
} rt_scene_info;
RT_API rt_status rt_scene_get_info(const rt_scene *scene, rt_scene_info *info);

/** What moves in the committed scene while the shutter is open. */
typedef struct rt_motion_info {
    uint32_t moving_instances, places; /**< places: of all of them, the ones at time 0 included */
    int camera_moves;
    float shutter_open, shutter_close;
} rt_motion_info;
/** Errors ARGUMENT, STATE. */
RT_API rt_status rt_scene_get_motion_info(const rt_scene *scene, rt_motion_info *info);
/** Statistics of one tree, index < tree_count. group: 0 the scene's own, then the children in order of first use; RT_INVALID_ID: top level. */
RT_API rt_status rt_scene_get_tree_info(const rt_scene *scene, uint32_t index, uint32_t *group, rt_tree_info *info);

/** One file with the committed snapshot: versioned, hashed. Errors IO, STATE. */
RT_API rt_status rt_scene_save(const rt_scene *scene, const char *path);
/** A scene that holds the saved snapshot: it renders and answers queries; editing calls give STATE. The file is not trusted: every count, offset, index and the
 *  hash are checked. Errors IO, FORMAT, MEMORY. */
RT_API rt_status rt_scene_load(rt_context *context, const char *path, rt_scene **scene);

/* ---- queries ---- */

/** t in units of dir (any length); a hit counts when tmin < t < tmax. A NaN or infinite number in
 *  org or dir, a dir whose largest component is not in 1e-18 ... 1e18, or tmin >= tmax: the ray misses. */
typedef struct rt_ray {
    rt_vec3 org;
    float tmin;
    rt_vec3 dir;
    float tmax;
    uint32_t mask;
} rt_ray;
typedef struct rt_hit {
    float t;    /**< tmax on a miss */
    float u, v; /**< triangles: weights of the second and third vertex; other shapes: surface parameters */
    uint32_t prim_id, geom_id, inst_id; /**< RT_INVALID_ID on a miss; inst_id also for geometry of the scene itself */
} rt_hit;

/** Closest hits. rays [count] in, hits [count] out. Equal t: the lowest (instance, geometry, primitive) in description order, the scene's own geometry first.
 *  Errors none: the scene must be committed. Threads any number, beside edits too. Owner keeps no pointer. Calls of 32 rays or more work in
 *  12 MB of the context's memory (without instances they touch 7.5, with shapes 8.5), one piece for each thread that is in such a call at a time, which the context keeps
 *  for the next; where there is none, rays that are not coherent go one by one. Calls of fewer allocate nothing. */
RT_API void rt_scene_intersect(const rt_scene *scene, const rt_ray *rays, rt_hit *hits, size_t count);
/** Any hit in (tmin, tmax): occluded[i] = 1 or 0. Otherwise as rt_scene_intersect. */
RT_API void rt_scene_occluded(const rt_scene *scene, const rt_ray *rays, uint8_t *occluded, size_t count);
/** The first `capacity` hits along one ray in the order of hits, coincident ones included. Returns how many were written. */
RT_API size_t rt_scene_intersect_all(const rt_scene *scene, const rt_ray *ray, rt_hit *hits, size_t capacity);
/** The same at a time from 0 to 1 (others count as the nearer end, NaN as 0) for each ray: times [count]. The calls without times ask at time 0. */
RT_API void rt_scene_intersect_at(const rt_scene *scene, const rt_ray *rays, const float *times, rt_hit *hits, size_t count);
RT_API void rt_scene_occluded_at(const rt_scene *scene, const rt_ray *rays, const float *times, uint8_t *occluded, size_t count);
RT_API size_t rt_scene_intersect_all_at(const rt_scene *scene, const rt_ray *ray, float time, rt_hit *hits, size_t capacity);
/** The tracer that rt_scene_intersect and its like use: "auto", "kdtree", "octree", "bvh", "brute". Takes effect at the next commit. Errors ARGUMENT with the names. */
RT_API rt_status rt_scene_set_tracer(rt_scene *scene, const char *name);

/** What is at a hit. */
typedef struct rt_surface {
    rt_vec3 position;  /**< world space */
    rt_vec3 ng, ns;    /**< unit geometric and shading normal, outwards as described (not turned to the ray) */
    float u, v;        /**< texture coordinates after placement */
    rt_material material;
    uint32_t material_scene; /**< 0: material is of this scene; else 1 + index of the child's group */
    uint32_t face_id;  /**< polyhedron: the face; mesh: the triangle; many shapes as one: the index */
    uint32_t user_id, inst_user_id;
    rt_vec3 color;     /**< the material's colour with texture and vertex colour */
    float position_error; /**< bound of position's distance from the surface, for the start of rays that leave it */
} rt_surface;
/** Errors none; a miss, or a hit that this scene cannot have given, gives all zero and material {RT_INVALID_ID}. The body of a visible light has a material
 *  behind those of the scene. ray: the one that gave the hit. Threads any. */
RT_API void rt_scene_surface(const rt_scene *scene, const rt_ray *ray, const rt_hit *hit, rt_surface *surface);
/** The same for a ray that was asked at a time. */
RT_API void rt_scene_surface_at(const rt_scene *scene, const rt_ray *ray, float time, const rt_hit *hit, rt_surface *surface);

#ifdef __cplusplus
}
#endif
#endif
