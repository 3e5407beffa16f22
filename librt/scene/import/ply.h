/* PLY inside: what the header says, and a cursor over the values of either kind of file. */
#ifndef RTI_PLY_H
#define RTI_PLY_H

#include "model.h"

enum { PLY_I8, PLY_U8, PLY_I16, PLY_U16, PLY_I32, PLY_U32, PLY_F32, PLY_F64, PLY_NO_TYPE };

/* What a property is used for. */
enum {
    PLY_X,
    PLY_Y,
    PLY_Z,
    PLY_NX,
    PLY_NY,
    PLY_NZ,
    PLY_R,
    PLY_G,
    PLY_B,
    PLY_U,
    PLY_V,
    PLY_SCALARS,
    PLY_CORNERS = PLY_SCALARS,
    PLY_UNUSED
};

enum { PLY_VERTEX, PLY_FACE, PLY_STRIP, PLY_OTHER };

typedef struct ply_property {
    uint8_t type;
    uint8_t count_type; /* PLY_NO_TYPE: not a list */
    uint8_t use;
} ply_property;

typedef struct ply_element {
    uint8_t kind;
    uint64_t count;
    size_t first, property_count; /* in ply->properties */
} ply_element;

typedef enum ply_coding { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_coding;

typedef struct ply {
    rti_model *model;
    const char *start, *p, *end;
    uint64_t line; /* of an ASCII file, from 1 */
    ply_coding coding;
    ply_element *elements;
    size_t element_count, element_capacity;
    ply_property *properties;
    size_t property_count, property_capacity;
} ply;

/* Reads the header; p then stands at the first value. */
rt_status rti_ply_head(ply *f);
/* "NAME: line N: ..." or "NAME: byte N: ..." */
rt_status rti_ply_fail(const ply *f, const char *format, ...) RTI_PRINTF(2, 3);

static inline size_t rti_ply_size(uint8_t type)
{
    static const uint8_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[type];
}

#endif
