/* Files of cameras (tests/bench/rays/camera.c). */
#include <math.h>
#include <stdlib.h>

#include "rays.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bench_view view;
    char why[200] = "";
    char *exact = malloc(size ? size : 1); /* its end is the allocation's end */
    if (!exact)
        return 0;
    for (size_t i = 0; i < size; i++)
        exact[i] = (char)data[i];
    int found = bench_camera_parse(exact, size, "a", &view, why, sizeof why);
    if (found < 0 && !why[0])
        abort();
    if (found > 0 && !(view.vfov > 0 && view.vfov < 180 && isfinite(view.eye[0]) && isfinite(view.at[2]) && isfinite(view.up[1])))
        abort();
    free(exact);
    return 0;
}
