/* A model as the context keeps it. */
#ifndef RTI_KEPT_MODEL_H
#define RTI_KEPT_MODEL_H

#include "../kept.h"
#include "model.h"

/* The model's geometry and the names it uses, in a block of its own; *bytes: what it takes with its meshes. Before any library is read. */
rt_status rti_kept_model_make(const rti_model *model, rti_kept_model **out, size_t *bytes);
/* Gives an empty model the names, and the number of warnings its reader had (said in one line). */
rt_status rti_kept_model_names(const rti_kept_model *kept, rti_model *model);

#endif
