/* The functions behind an instruction set's rti_lanes. */
#ifndef RTI_LANES_TABLE_H
#define RTI_LANES_TABLE_H

#include "../base/isa.h"
#include "lanes.h"

#define RTI_LANES_DECLARE(isa)                                                                                                   \
    void rti_lanes_camera_##isa(const rti_frame *frame, const rti_pixel_group *group, bool again, rti_pixel_seeds *seeds,        \
                                rtk_trace_block *trace, rtk_path_block *path, rti_home_block *home, float *px, float *py);       \
    void rti_lanes_sheaves_##isa(rti_worker *worker, uint32_t first, uint32_t count, rti_sheaf_fn then);                         \
    void rti_lanes_whitted_##isa(rti_worker *worker, rti_sheaf *sheaf);                                                          \
    void rti_lanes_path_##isa(rti_worker *worker, rti_sheaf *sheaf);                                                             \
    void rti_lanes_surface_##isa(const rti_worker *worker, rti_sheaf *sheaf);                                                    \
    void rti_lanes_body_##isa(const rtk_group *group, uint32_t kind, rti_sheaf *sheaf);                                          \
    void rti_lanes_placed_##isa(const rtk_scene *scene, rti_sheaf *sheaf);                                                       \
    void rti_lanes_texture_##isa(const rtk_scene *scene, rti_sheaf *sheaf);                                                      \
    void rti_lanes_sky_##isa(const rtk_scene *scene, const rti_sheaf *sheaf, rti_light_lanes *light);                            \
    void rti_lanes_shine_sphere_##isa(rti_worker *worker, uint32_t light);                                                       \
    void rti_lanes_one_##isa(rti_worker *worker);                                                                                \
    void rti_lanes_shine_##isa(rti_worker *worker, uint32_t light);                                                              \
    void rti_lanes_ao_##isa(rti_worker *worker, rti_sheaf *sheaf);                                                               \
    void rti_lanes_around_##isa(rti_worker *worker);                                                                             \
    void rti_lanes_arrive_##isa(rti_worker *worker);                                                                             \
    void rti_lanes_resolve_##isa(const uint64_t *sum, float *out, uint32_t pixels, double unit, double samples);
#define RTI_LANES_DECLARE_EACH(isa, level) RTI_LANES_DECLARE(isa)
RTI_ISA_EACH(RTI_LANES_DECLARE_EACH)

#endif
