# One line a unit test, sorted.
librt_unit_test(base)
librt_unit_test(image)
