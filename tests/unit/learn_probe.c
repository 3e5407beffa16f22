/* What pencils teach, in a form that a test can call. Compiled once a level. */
#include "learn_probe.h"

#include <string.h>

#include "trace/bvh_learn.h"

void RTI_ISA_FN(probe_learn)(uint32_t place, int any, const uint8_t worse[PLACES], uint32_t away[PLACES])
{
    static pencil p;
    static rtk_group group;
    static rtk_scene scene;
    static rti_scratch scratch;
    const rtk_u32 mode = any ? RTK_MODE_ANY : 0u, rays = PLACES * place;
    memset(&scratch.learned, 0, sizeof scratch.learned);
    scene.groups = &group;
    p.scene = &scene;
    p.scratch = &scratch;
    memset(away, 0, PLACES * sizeof *away);
    for (uint32_t gone = 0; gone < rays;) {
        const uint32_t apart = learned_left(&scratch.learned, mode, rays - gone);
        const uint32_t n = apart ? apart : rtk_umin(rays - gone, PENCIL_RAYS);
        for (uint32_t i = 0; apart && i < n; i++)
            away[(gone + i) / place]++;
        if (!apart) { /* a leaf for two rays, where a ray comes to one; or for forty, where it comes to two */
            p.leaves = worse[gone / place] ? n / 2 : n / 40;
            p.told = worse[gone / place] ? n : 2 * n;
            pencil_learn(&p, mode, n);
        }
        gone += n;
    }
}
