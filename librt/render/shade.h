/* What the integrators that show light share. */
#ifndef RTI_SHADE_H
#define RTI_SHADE_H

#include "../kernel/classic.h"
#include "../kernel/integrate.h"
#include "direct.h"
#include "lanes.h"
#include "shade_limits.h"

static inline rtk_vec3 rti_emission(const rtk_material *m)
{
    return rtk_v3(m->emission[0], m->emission[1], m->emission[2]);
}

#endif
