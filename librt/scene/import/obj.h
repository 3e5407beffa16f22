/* OBJ inside: the file as read, before it is sorted into parts. */
#ifndef RTI_OBJ_H
#define RTI_OBJ_H

#include "model.h"

#define RTI_OBJ_NONE UINT32_MAX

typedef struct rti_obj_corner {
    uint32_t v, vt, vn; /* RTI_OBJ_NONE: not given */
} rti_obj_corner;

typedef struct rti_obj_face {
    uint32_t corner_count;
    uint32_t look;
    uint32_t next; /* face of the same look, RTI_OBJ_NONE: the last */
} rti_obj_face;

typedef struct rti_obj_list {
    void *data;
    size_t count, capacity;
} rti_obj_list;

typedef struct rti_obj {
    rti_model *model;
    rti_obj_list v, colors, vt, vn; /* floats: 3, 3, 2, 3 each */
    rti_obj_list corners, faces;    /* corners of face i follow those of face i - 1 */
    bool has_colors;
} rti_obj;

/* Makes a part of each look that has faces, in the order of their first use. */
rt_status rti_obj_parts(rti_obj *obj);

#endif
