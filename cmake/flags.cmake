# One set of flags for all of librt's own C. -ffp-contract=off is a promise (same bits everywhere), not a preference.
add_library(librt_flags INTERFACE)
target_compile_options(librt_flags INTERFACE -Wall -Wextra -Wpedantic -Wmissing-prototypes -Wstrict-prototypes -Wshadow
  -ffp-contract=off -fno-math-errno -fno-trapping-math -ffile-prefix-map=${CMAKE_SOURCE_DIR}=.)
target_compile_definitions(librt_flags INTERFACE _POSIX_C_SOURCE=200809L)
target_include_directories(librt_flags INTERFACE ${CMAKE_SOURCE_DIR}/librt/include)

set(LIBRT_SANITIZE "" CACHE STRING "Sanitizers for everything, as in -fsanitize=: address,undefined or thread")
if(LIBRT_SANITIZE)
  add_compile_options(-fsanitize=${LIBRT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${LIBRT_SANITIZE})
endif()
