/* Shading in lanes: the per-ray functions of kernel/, called in loops of sixteen that the compiler makes vectors of. These files
 * are compiled once for each instruction set; the bits are the same from each, for the operations are.
 *
 * A sheaf is up to sixteen hits of one kind (lanes_sort.c), taken out of the batch into rows. A loop over its lanes has no branch
 * and no load that depends on one: what is rare (a sliver, a moving instance) is marked, and told by the scalar function
 * afterwards. Lanes behind count repeat the last one. */
#ifndef RTI_LANES_H
#define RTI_LANES_H

#include <string.h>

#include "../base/isa.h"
#include "wavefront.h"

#if defined(__GNUC__)
#define RTI_ROW __attribute__((aligned(64)))
/* A loop over the sixteen lanes whose turns touch their own lane of rows alone, so that they may be taken together. Clang would
 * unroll it before it looks for vectors, and GCC one that stands within another loop of its function: there it is _INNER.
 * NOLINTBEGIN(bugprone-macro-parentheses): k is declared. */
#if defined(__clang__)
#define RTI_EACH_LANE(k) _Pragma("clang loop unroll(disable) vectorize(assume_safety)") for (uint32_t k = 0; k < RTK_BLOCK; k++)
#define RTI_EACH_LANE_INNER(k) RTI_EACH_LANE(k)
#elif defined(__GNUC__)
#define RTI_EACH_LANE(k)       _Pragma("GCC ivdep") for (uint32_t k = 0; k < RTK_BLOCK; k++)
#define RTI_EACH_LANE_INNER(k) _Pragma("GCC ivdep") _Pragma("GCC unroll 1") for (uint32_t k = 0; k < RTK_BLOCK; k++)
#endif
/* Everything inline: a call in a lane loop keeps it scalar. */
#define RTI_LANES_FN __attribute__((flatten))
#else
#define RTI_ROW
#define RTI_LANES_FN
#define RTI_EACH_LANE(k)       for (uint32_t k = 0; k < RTK_BLOCK; k++)
#define RTI_EACH_LANE_INNER(k) RTI_EACH_LANE(k)
#endif
/* NOLINTEND(bugprone-macro-parentheses) */

/* Of a sheaf's materials (rti_load_looks). */
typedef struct rti_looks {
    float diffusion[RTK_BLOCK] RTI_ROW, reflectiveness[RTK_BLOCK] RTI_ROW, transparency[RTK_BLOCK] RTI_ROW;
    float ambient[RTK_BLOCK] RTI_ROW, specular[RTK_BLOCK] RTI_ROW, shininess[RTK_BLOCK] RTI_ROW;
    float index[RTK_BLOCK] RTI_ROW; /* of refraction */
    uint32_t of_all;                /* the material of all lanes, or RTK_INVALID */
    bool shown, mirrors, clear;     /* some lane has ambient light; reflects; is transparent */
    bool shiny;                     /* has highlights */
} rti_looks;

typedef struct rti_sheaf {
    uint32_t count;
    uint32_t surface_kind, material_kind;
    uint32_t depth;                  /* of all its rays */
    uint32_t ray[RTK_BLOCK] RTI_ROW; /* index in the batch */
    uint32_t block_count, block[RTK_BLOCK],
        lanes[RTK_BLOCK]; /* with RTI_PACK: the batch's blocks that they are in, and which of them */
    uint32_t home[RTK_BLOCK] RTI_ROW;
    float ox[RTK_BLOCK] RTI_ROW, oy[RTK_BLOCK] RTI_ROW, oz[RTK_BLOCK] RTI_ROW; /* of shapes and planes only */
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW;
    float tpr[RTK_BLOCK] RTI_ROW, tpg[RTK_BLOCK] RTI_ROW, tpb[RTK_BLOCK] RTI_ROW;
    float width[RTK_BLOCK] RTI_ROW, spread[RTK_BLOCK] RTI_ROW;
    float t[RTK_BLOCK] RTI_ROW, u[RTK_BLOCK] RTI_ROW, v[RTK_BLOCK] RTI_ROW;
    uint32_t prim[RTK_BLOCK] RTI_ROW, geom[RTK_BLOCK] RTI_ROW, inst[RTK_BLOCK] RTI_ROW;

    /* The surface, turned to the ray. */
    float px[RTK_BLOCK] RTI_ROW, py[RTK_BLOCK] RTI_ROW, pz[RTK_BLOCK] RTI_ROW, error[RTK_BLOCK] RTI_ROW;
    float nx[RTK_BLOCK] RTI_ROW, ny[RTK_BLOCK] RTI_ROW, nz[RTK_BLOCK] RTI_ROW;       /* shading normal */
    float gx[RTK_BLOCK] RTI_ROW, gy[RTK_BLOCK] RTI_ROW, gz[RTK_BLOCK] RTI_ROW;       /* geometric normal */
    float tr[RTK_BLOCK] RTI_ROW, tg[RTK_BLOCK] RTI_ROW, tb[RTK_BLOCK] RTI_ROW;       /* tint, where there is any */
    float tu[RTK_BLOCK] RTI_ROW, tv[RTK_BLOCK] RTI_ROW, uv_scale[RTK_BLOCK] RTI_ROW; /* of textured materials only */
    float footprint[RTK_BLOCK] RTI_ROW;
    float cr[RTK_BLOCK] RTI_ROW, cg[RTK_BLOCK] RTI_ROW, cb[RTK_BLOCK] RTI_ROW; /* the material's colour here */
    uint32_t material[RTK_BLOCK] RTI_ROW, outside[RTK_BLOCK] RTI_ROW, plain[RTK_BLOCK] RTI_ROW;
    bool one_material;                      /* that of lane 0 */
    bool tinted, smooth;                    /* its kind may have tints; shading normals of their own */
    rti_looks looks;
} rti_sheaf;

/* Light for sixteen places of the film. */
typedef struct rti_light_lanes {
    float r[RTK_BLOCK] RTI_ROW, g[RTK_BLOCK] RTI_ROW, b[RTK_BLOCK] RTI_ROW;
} rti_light_lanes;

/* Sorted by what a hit needs. */
enum {
    RTI_SURFACE_MISS = 0,
    RTI_SURFACE_MESH,
    RTI_SURFACE_SMOOTH,
    RTI_SURFACE_SPHERE,
    RTI_SURFACE_BOX,
    RTI_SURFACE_CONE, /* and cylinders */
    RTI_SURFACE_PLANE,
    RTI_SURFACE_OTHER,
    RTI_SURFACE_PLACED, /* and above: those from MESH to CONE in instances that stand still */
    RTI_SURFACE_COUNT = RTI_SURFACE_PLACED + RTI_SURFACE_CONE - RTI_SURFACE_MESH + 1
};
#define RTI_LOOK_EMISSIVE 0u
#define RTI_LOOK_PLAIN    1u
#define RTI_LOOK_TEXTURED 2u /* and above, by the texture */
#define RTI_LOOK_TEXTURES 17u
#define RTI_LOOK_COUNT    (RTI_LOOK_TEXTURED + RTI_LOOK_TEXTURES)

/* What a step of an integrator does with a sheaf whose surfaces are there. */
typedef void (*rti_sheaf_fn)(rti_worker *worker, rti_sheaf *sheaf);

/* Neighbouring pixels of a tile and one sample of each. */
#define RTI_GROUP 4u /* most columns and rows */
typedef struct rti_pixel_group {
    uint32_t x, y; /* the first pixel, in the whole image */
    uint32_t columns, rows;
    uint32_t sample;
    uint32_t home, pitch; /* place of the first, and of a pixel below another */
} rti_pixel_group;

/* Of one instruction set. */
struct rti_lanes {
    /* The rays of a group's pixels. again: in their place stand others of this camera, with which they share most of their
     * state. seeds: those of the group before, which become this one's. */
    void (*camera)(const rti_frame *frame, const rti_pixel_group *group, bool again, rti_pixel_seeds *seeds,
                   rtk_trace_block *trace, rtk_path_block *path, rti_home_block *home, float px[RTK_BLOCK], float py[RTK_BLOCK]);
    /* Hits [first, first + count) of the batch, of one depth, by kind: misses add the world's light, each sheaf goes to `then`.
     */
    void (*sheaves)(rti_worker *worker, uint32_t first, uint32_t count, rti_sheaf_fn then);
    rti_sheaf_fn whitted; /* the classic material, whole */
    rti_sheaf_fn path;    /* likewise */
    rti_sheaf_fn ao;      /* notes points for `around` */
    /* Every lit point [0, count) from one light: one ray each, or to a spherical one as many as it says. */
    void (*shine)(rti_worker *worker, uint32_t light);
    /* Every lit point [0, count) from one light each, chosen by power. */
    void (*one)(rti_worker *worker);
    /* Every lit point [0, count) from all around, ao_samples rays each. */
    void (*around)(rti_worker *worker);
    /* Adds what pending rays bring that are not occluded. */
    void (*arrive)(rti_worker *worker);
    /* One row of the image from a row of sums. */
    void (*resolve)(const uint64_t *sum, float *out, uint32_t pixels, double unit, double samples);
};

const rti_lanes *rti_lanes_find(rti_isa isa);

/* The whole of [first, first + count), which the wavefront sorts by depth. */
void rti_sheaves(rti_worker *worker, uint32_t first, uint32_t count, rti_sheaf_fn then);

#endif
