#!/bin/sh
# usage: kernels.sh SOURCE_ROOT. Every kernel header alone, as C11, OpenCL C 1.2 and OpenCL C 3.0, without double precision: any warning is a failure.
# The OpenCL half needs clang; without it a word says so.
set -u
cd "$1" || exit 1
CC=${CC:-cc}
fail=0
tried=0

# try WORDS COMMAND...
try() {
    words=$1
    shift
    tried=$((tried + 1))
    if ! output=$("$@" 2>&1); then
        printf '%s:\n%s\n' "$words" "$output"
        fail=1
    fi
}

cl_flags='-x cl -fsyntax-only -Wall -Wextra -Werror -Wno-unused-function -Wno-unused-const-variable -Xclang -finclude-default-header -Xclang -fdeclare-opencl-builtins'
cl_flags="$cl_flags -Xclang -cl-ext=-cl_khr_fp64,-__opencl_c_fp64"
have_clang=0
command -v clang >/dev/null 2>&1 && have_clang=1
for header in librt/kernel/*.h tests/walks.h; do
    try "$header as C11" "$CC" -x c -std=c11 -fsyntax-only -Wall -Wextra -Wpedantic -Wdouble-promotion -Werror -Wno-unused-function -Wno-unused-const-variable "$header"
    [ "$have_clang" -eq 1 ] || continue
    for standard in CL1.2 CL3.0; do
        # shellcheck disable=SC2086 # a list of flags
        try "$header as $standard" clang $cl_flags "-cl-std=$standard" "$header"
    done
done
[ "$have_clang" -eq 1 ] || echo "clang is not installed: the headers were not tried as OpenCL C"
echo "$tried compilations"
[ "$tried" -gt 0 ] && exit $fail
