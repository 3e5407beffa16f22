# One line a unit test, sorted.
librt_unit_test(base)
