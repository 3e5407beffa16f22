#include "fuzz_model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    rti_model model;
    rti_model_init(&model, fuzz_context(), "fuzz.ply");
    fuzz_end(&model, rti_ply_read(&model, data, size));
    return 0;
}
