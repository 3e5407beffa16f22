#include "parts.h"

#include <stdlib.h>

#include "generate.h"

rt_status test_parts_init(test_parts *p, test_world *w, uint32_t parts, float by, uint32_t triangles, float size)
{
    static const uint32_t builders[TEST_TREES] = {RTI_BUILD_KD_BINNED, RTI_BUILD_OCTREE, RTI_BUILD_BVH};
    uint32_t first = 0;
    float place = 1.0f;
    rt_status status;
    *p = (test_parts){.list = calloc(parts * (size_t)triangles, sizeof *p->list)};
    if (!p->list)
        return RT_ERROR_MEMORY;
    for (uint32_t i = 0; i < parts; i++, place *= by) {
        test_mesh_soup(&p->mesh[i], triangles, size, 5 + i);
        test_mesh_place(&p->mesh[i], place, 0.0f);
        test_world_mesh(w, 0, &p->mesh[i], 0xffffffffu);
    }
    status = test_world_commit(w, NULL);
    w->groups[0].part_count = parts;
    for (uint32_t i = 0; i < parts && status == RT_OK; i++) {
        const rti_build_input in = test_input(&p->mesh[i]);
        rtk_part *part = &w->groups[0].parts[i];
        rtk_tree *trees[TEST_TREES] = {&part->kdtree, &part->octree, &part->bvh};
        *part = (rtk_part){.lo = rtk_v3(in.lo[0], in.lo[1], in.lo[2]),
                           .hi = rtk_v3(in.hi[0], in.hi[1], in.hi[2]),
                           .scale = in.grow / RTK_GROW,
                           .count = p->mesh[i].count};
        for (uint32_t k = 0; k < TEST_TREES; k++) {
            const rti_build_settings how = {.builder = builders[k], .leaf_size = builders[k] == RTI_BUILD_OCTREE ? 8 : 0};
            status = rti_tree_build(w->ctx, &in, &how, NULL, &p->chunks[i][k], &p->sizes[i][k]);
            if (status != RT_OK)
                break;
            *trees[k] = rti_tree_view(p->chunks[i][k]);
            rtk_u32 *refs = (rtk_u32 *)(uintptr_t)trees[k]->refs; /* a part's triangles are numbered as the group's */
            for (uint32_t r = 0; r < ((const rtk_tree_header *)p->chunks[i][k])->ref_count; r++)
                refs[r] += first;
        }
        for (uint32_t k = 0; k < p->mesh[i].count; k++)
            p->list[first + k] = first + k;
        part->all.refs = p->list + first;
        first += p->mesh[i].count;
    }
    test_world_changed(w);
    return status;
}

void test_parts_free(test_parts *p, test_world *w)
{
    for (uint32_t i = 0; i < RTK_PARTS; i++) {
        for (uint32_t k = 0; k < TEST_TREES; k++)
            rti_free(w->ctx, p->chunks[i][k], p->sizes[i][k]);
        test_mesh_free(&p->mesh[i]);
    }
    test_world_free(w);
    free(p->list);
}
