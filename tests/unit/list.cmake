# One line a unit test, sorted.
librt_unit_test(base THREADS)
librt_unit_test(image)
librt_unit_test(kernel_maths)
librt_unit_test(kernel_rng)
librt_unit_test(kernel_shapes)
librt_unit_test(kernel_triangle)
librt_unit_test(snapshot THREADS)
