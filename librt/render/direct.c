/* Light that comes straight from the scene's lights to the lit points. */
#include "direct.h"
#include "lanes.h"

/* Below this the whole queue waits for more rays before it is answered: small batches cost a tracer as much as half-full ones. */
#define FLUSH_PART 2u

static void put_row3(rti_worker *w, uint32_t row, uint32_t i, rtk_vec3 x)
{
    float *to = w->lit + (size_t)row * w->lit_stride + i;
    to[0] = x.x;
    to[w->lit_stride] = x.y;
    to[2 * (size_t)w->lit_stride] = x.z;
}

void rti_lit_add(rti_worker *worker, uint32_t ray, const rtk_surface *s, rtk_vec3 view, rtk_vec3 k, rtk_vec3 specular,
                 float shininess, float diffuse_pdf)
{
    uint32_t i = worker->lit_count;
    if (rtk_maxabs(k) == 0.0f && rtk_maxabs(specular) == 0.0f)
        return;
    worker->lit_count = i + 1;
    put_row3(worker, RTI_LIT_PX, i, s->p);
    put_row3(worker, RTI_LIT_NX, i, s->ns);
    put_row3(worker, RTI_LIT_GX, i, s->ng);
    put_row3(worker, RTI_LIT_VX, i, view);
    put_row3(worker, RTI_LIT_KR, i, k);
    put_row3(worker, RTI_LIT_SR, i, specular);
    worker->lit[(size_t)RTI_LIT_ERROR * worker->lit_stride + i] = s->error;
    worker->lit[(size_t)RTI_LIT_SHININESS * worker->lit_stride + i] = shininess;
    worker->lit[(size_t)RTI_LIT_DIFFUSE_PDF * worker->lit_stride + i] = diffuse_pdf;
    worker->lit_ray[i] = ray;
    worker->lit_home[i] = worker->batch.home[ray / RTK_BLOCK].home[ray % RTK_BLOCK];
}

void rti_light_all(rti_worker *worker)
{
    for (uint32_t i = 0; i < worker->frame->scene->light_count && !rti_cancelled(worker->frame->cancel); i++) {
        worker->frame->lanes->shine(worker, i);
        if (worker->frame->scene->light_count > 1 && worker->shadows.count >= worker->shadows.capacity / FLUSH_PART)
            rti_shadow_flush(worker);
    }
    worker->lit_count = 0;
}

void rti_light_one(rti_worker *worker)
{
    worker->frame->lanes->one(worker);
    worker->lit_count = 0;
}

void rti_light_around(rti_worker *worker)
{
    worker->frame->lanes->around(worker);
    worker->lit_count = 0;
}
