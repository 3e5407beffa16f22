/* Classic ray tracing (paper 000; Whitted 1980) in lanes: what the ambient light shows, a point that asks all lights, and a
 * mirror ray and a refracted ray that go on. */
#include "lanes.h"
#include "lanes_classic.h"
#include "lanes_film.h"
#include "lanes_table.h"
#include "shade.h"

RTI_LANES_FN static void show_ambient(rti_worker *w, const rti_sheaf *c, const rti_looks *l, uint32_t lanes)
{
    const rtk_world *world = w->frame->scene->world;
    const rtk_vec3 light = rtk_v3(world->ambient[0], world->ambient[1], world->ambient[2]);
    rti_light_lanes e;
    RTI_EACH_LANE(k)
    {
        rtk_vec3 tinted = rtk_mul(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), rtk_v3(c->cr[k], c->cg[k], c->cb[k]));
        rtk_vec3 shown = rtk_mul(rtk_scale(tinted, l->ambient[k]), light);
        int some = l->ambient[k] > 0.0f;
        e.r[k] = some ? shown.x : 0.0f;
        e.g[k] = some ? shown.y : 0.0f;
        e.b[k] = some ? shown.z : 0.0f;
    }
    rti_add_lanes(w, c->home, lanes, &e);
}

/* Rows of points that may be lit. */
RTI_LANES_FN static void note_lit(rti_worker *w, const rti_sheaf *c, const rti_looks *l)
{
    float *kr = rti_lit_row(w, RTI_LIT_KR), *kg = rti_lit_row(w, RTI_LIT_KG), *kb = rti_lit_row(w, RTI_LIT_KB);
    rti_note_seen(w, c, l);
    memset(rti_lit_row(w, RTI_LIT_DIFFUSE_PDF), 0, sizeof c->px);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 tinted = rtk_mul(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), rtk_v3(c->cr[k], c->cg[k], c->cb[k]));
        rtk_vec3 diffuse = rtk_scale(tinted, l->diffusion[k]);
        kr[k] = diffuse.x;
        kg[k] = diffuse.y;
        kb[k] = diffuse.z;
    }
    rti_note_lit(w, c);
}

/* Mirror rays; strength: what they keep. */
RTI_LANES_FN static void send_mirrors(rti_worker *w, const rti_sheaf *c, const float *strength, rti_leaving *s)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 tp = rtk_scale(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), strength[k]);
        s->tr[k] = tp.x;
        s->tg[k] = tp.y;
        s->tb[k] = tp.z;
    }
    rti_push_mirrors(w, c, s, (1u << c->count) - 1);
}

/* Both rays of each lane. */
RTI_LANES_FN static void send_both(rti_worker *w, const rti_sheaf *c, const rti_looks *l)
{
    rti_bent b;
    rti_leaving from, s;
    rti_bend_lanes(c, l, &b);
    rti_leaving_of(w, c, &from);
    s = from;
    send_mirrors(w, c, b.mirror, &s);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 tp = rtk_mul(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), rtk_v3(b.cr[k], b.cg[k], b.cb[k]));
        from.tr[k] = tp.x;
        from.tg[k] = tp.y;
        from.tb[k] = tp.z;
        from.pdf[k] = -1.0f;
    }
    rti_push_refracted(w, c, l, &b, &from, (1u << c->count) - 1);
}

/* Mirror rays where nothing is transparent. */
static void send_reflected(rti_worker *w, const rti_sheaf *c, const rti_looks *l)
{
    rti_leaving s;
    rti_leaving_of(w, c, &s);
    send_mirrors(w, c, l->reflectiveness, &s);
}

void RTI_ISA_FN(rti_lanes_whitted)(rti_worker *w, rti_sheaf *c)
{
    const rti_looks *l = &c->looks;
    if (c->material_kind == RTI_LOOK_EMISSIVE) {
        for (uint32_t k = 0; k < c->count; k++)
            rti_add(w, c->home[k],
                    rtk_mul(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), rti_emission(&w->frame->scene->materials[c->material[k]])));
        return;
    }
    rti_load_looks(w->frame->scene, c);
    if (l->shown)
        show_ambient(w, c, l, (1u << c->count) - 1);
    note_lit(w, c, l);
    if (c->depth >= w->frame->set.desc.max_depth)
        return;
    if (l->clear)
        send_both(w, c, l);
    else if (l->mirrors)
        send_reflected(w, c, l);
}
