#include "probe.h"

__kernel void probe(__global const rtk_ray *rays, __global const rtk_tri *tris, __global const rtk_shape *shapes, __global rtk_u32 *out)
{
    uint i = (uint)get_global_id(0);
    probe_item(i, rays, tris, shapes, out + i * PROBE_WORDS);
}

__kernel void sizes(__global rtk_u32 *out)
{
    out[0] = sizeof(rtk_ray);
    out[1] = sizeof(rtk_tri);
    out[2] = sizeof(rtk_shape);
    out[3] = sizeof(rtk_geom);
    out[4] = sizeof(rtk_material);
    out[5] = sizeof(rtk_instance);
    out[6] = sizeof(rtk_light);
    out[7] = sizeof(rtk_world);
    out[8] = sizeof(rtk_texture_header);
    out[9] = sizeof(rtk_tree_header);
    out[10] = sizeof(rtk_kdnode);
    out[11] = sizeof(rtk_octnode);
    out[12] = sizeof(rtk_bvhnode);
    out[13] = sizeof(rtk_bvhblock);
}
