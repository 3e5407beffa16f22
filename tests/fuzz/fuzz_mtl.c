#include "fuzz_model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char obj[] = "v 0 0 0\nusemtl a\nf 1 1 1\nusemtl b c\nf 1 1 1\nusemtl\nf 1 1 1\n";
    rti_model model;
    rti_model_init(&model, fuzz_context(), "fuzz.mtl");
    rt_status status = rti_obj_read(&model, obj, sizeof obj - 1);
    if (status)
        abort();
    rti_mtl_read(&model, "fuzz.mtl", data, size);
    fuzz_end(&model, RT_OK);
    return 0;
}
