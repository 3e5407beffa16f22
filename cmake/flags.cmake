# One set of flags for all of librt's own C. -ffp-contract=off is a promise (same bits everywhere), not a preference; the two -fno- flags
# change no value, only the book-keeping of errno and of traps. The prefix maps keep the build's folders out of the binaries.
add_library(librt_flags INTERFACE)
set(librt_warnings -Wall -Wextra -Wpedantic -Wshadow $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes> $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>)
target_compile_options(librt_flags INTERFACE ${librt_warnings}
  -ffp-contract=off -fno-math-errno -fno-trapping-math
  -ffile-prefix-map=${CMAKE_SOURCE_DIR}=. -ffile-prefix-map=${CMAKE_BINARY_DIR}=out)
# GCC 12 leaves out roundings where it makes vectors of straight code: of two doubles that become floats and doubles again (planes' axes, placements
# on their way) it takes those that were. Hot files have vectors of their own and no such numbers.
target_compile_options(librt_flags INTERFACE
  $<$<AND:$<C_COMPILER_ID:GNU>,$<NOT:$<BOOL:$<TARGET_PROPERTY:LIBRT_HOT>>>>:-fno-tree-slp-vectorize>)
# Of hot files' walks it copies many for constant arguments, which are told apart where it matters (RTI_VEC): a tenth of bvh.c's code, no faster.
target_compile_options(librt_flags INTERFACE
  $<$<AND:$<C_COMPILER_ID:GNU>,$<BOOL:$<TARGET_PROPERTY:LIBRT_HOT>>>:-fno-ipa-cp-clone>)
target_compile_definitions(librt_flags INTERFACE _POSIX_C_SOURCE=200809L)
target_include_directories(librt_flags INTERFACE ${CMAKE_SOURCE_DIR}/librt/include)

option(LIBRT_WERROR "Warnings end the build" OFF)
if(LIBRT_WERROR)
  target_compile_options(librt_flags INTERFACE -Werror)
endif()

set(LIBRT_SANITIZE "" CACHE STRING "Sanitizers for everything, as in -fsanitize=: address,undefined or thread")
if(LIBRT_SANITIZE)
  add_compile_options(-fsanitize=${LIBRT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${LIBRT_SANITIZE})
  add_compile_definitions(LIBRT_SANITIZED=1)
  # What optimizers say of sanitized code is not what it is: loops need not become vectors, and GCC loses sight of what was set.
  add_compile_options($<IF:$<C_COMPILER_ID:GNU>,-Wno-maybe-uninitialized,-Wno-pass-failed>)
endif()

set(LIBRT_UNOPTIMIZED "" CACHE STRING "Folders of librt/ that are compiled with -O0, as in accel;trace;render")

# What reads files notes for libFuzzer where it has been (librt_fuzzed); builders and tracers, which other tests run for minutes, do not. The
# targets are in tests/fuzz.
option(LIBRT_FUZZ "Drive the fuzz targets with libFuzzer (Clang)" OFF)
if(LIBRT_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "LIBRT_FUZZ=ON needs Clang's libFuzzer; the compiler is ${CMAKE_C_COMPILER_ID}")
  endif()
  set(librt_fuzzed -fsanitize=fuzzer-no-link)
  add_link_options(${librt_fuzzed})
endif()
