#!/bin/sh
# Builds every variant and runs its tests; the last line is the sum, "N passed, N failed". usage: matrix.sh [VARIANT...]
#
#   release   GCC, everything, all tests              clang   Clang, every optional part off; its image hashes must be the release's
#   asan      address and undefined-behaviour sanitizers, by Clang; readers under libFuzzer
#   tsan      thread sanitizer, what renders          msan    memory sanitizer, what reads files
#   fuzz      asan's readers alone                    asan-gcc  asan by GCC; with LIBRT_FULL=1 only
#   bare      GCC, every optional part off; with LIBRT_FULL=1 only, where clang has every part
#   avx512    AVX-512's kernels in other instructions; with LIBRT_FULL=1 only, where the machine has none of its own and SIMDe is installed
#   arm       the kernels of 64-bit ARM by GCC, under qemu; with LIBRT_FULL=1 only, where the tools are (cmake/arm.cmake names them)
#   lint      luacheck, clang-format, clang-tidy, shellcheck: those that are installed
#
# LIBRT_FULL=1: the long figures, fuzzing for minutes, and every test and instruction set in every variant; without it a variant leaves out
# what another has shown already (below), and of AVX-512, where the processor lacks it, release only checks that it compiles. A variant's log is
# out/matrix/VARIANT.log (of fuzz, asan.log).
set -u
cd "$(dirname "$0")/.." || exit 1
ROOT=$(pwd)
LOGS=$ROOT/out/matrix
JOBS=${JOBS:-$(nproc 2>/dev/null || echo 2)}
FULL=${LIBRT_FULL:-0}
export JOBS
mkdir -p "$LOGS"
passed=0
failed=0
whole=0
if [ $# -eq 0 ]; then
    whole=1
    set -- release clang asan tsan msan lint
    [ "$FULL" = 0 ] || set -- "$@" bare asan-gcc avx512 arm
fi

# Sanitizers: the first report ends the program; leaks count.
ASAN_OPTIONS=abort_on_error=0:detect_leaks=1:allocator_may_return_null=1:${ASAN_OPTIONS:-}
UBSAN_OPTIONS=print_stacktrace=1:${UBSAN_OPTIONS:-}
TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:${TSAN_OPTIONS:-}
export ASAN_OPTIONS UBSAN_OPTIONS TSAN_OPTIONS

# A German locale of our own, for the tests that ask for one: the system's stay as they are.
if command -v localedef >/dev/null 2>&1 && [ ! -d "$ROOT/out/locale/de_DE.UTF-8" ]; then
    mkdir -p "$ROOT/out/locale"
    localedef --no-archive -i de_DE -f UTF-8 "$ROOT/out/locale/de_DE.UTF-8" >"$LOGS/locale.log" 2>&1 || rm -rf "$ROOT/out/locale"
fi
if [ -d "$ROOT/out/locale/de_DE.UTF-8" ]; then
    LOCPATH=$ROOT/out/locale
    export LOCPATH
fi

launcher=
command -v ccache >/dev/null 2>&1 && launcher=-DCMAKE_C_COMPILER_LAUNCHER=ccache

now() { date +%s; }
row() { printf '%-8s %s\n' "$1" "$2"; }

# count VARIANT GOOD BAD: adds to the sums.
count() {
    passed=$((passed + $1))
    failed=$((failed + $2))
}

# broken VARIANT WHAT: one failure, with the end of its log.
broken() {
    row "$1" "$2; the end of $LOGS/$1.log:"
    tail -n 40 "$LOGS/$1.log"
    count 0 1
}

# configure [CMAKE ARGUMENTS]: the variant's preset. Of a folder that another compiler has built CMake keeps the new compiler alone, whether it
# fails or not: it is asked once more for all else.
configure() {
    for _ in once again; do
        # shellcheck disable=SC2086 # nothing or one argument
        cmake --preset "$variant" -DLIBRT_WERROR=ON $launcher "$@" >"$LOGS/$variant.log" 2>&1
        configured=$?
        grep -q 'require your cache to be deleted' "$LOGS/$variant.log" || break
    done
    return "$configured"
}

# build VARIANT TARGET [CMAKE ARGUMENTS]: configures a preset and builds a target of it.
build() {
    variant=$1
    target=$2
    shift 2
    began=$(now)
    if ! configure "$@" || ! cmake --build "out-$variant" --target "$target" -j "$JOBS" >>"$LOGS/$variant.log" 2>&1; then
        broken "$variant" "does not build"
        return 1
    fi
    row "$variant" "built in $(($(now) - began)) s"
}

# check VARIANT [CTEST ARGUMENTS]: runs its tests and adds up what ctest says.
check() {
    variant=$1
    shift
    began=$(now)
    limit=1200
    case $variant in arm | avx512) limit=7200 ;; esac
    long=0 # the hours-long figures are the release's: sanitizers would take days
    [ "$variant" != release ] || long=$FULL
    rays= # release: as many as the tests ask for; what differs elsewhere is the code's making, for which fewer do
    [ "$variant" = release ] || rays=1000
    case $variant in arm | avx512) rays=100 ;; esac # twenty times slower
    LIBRT_FULL=$long LIBRT_RAYS=$rays ctest --test-dir "out-$variant" -j "$JOBS" --timeout "$limit" --output-on-failure --no-tests=error "$@" >"$LOGS/$variant.log" 2>&1
    status=$?
    # "97% tests passed, 1 tests failed out of 33"
    bad=$(sed -n 's/.*tests passed, \([0-9]*\) tests failed out of.*/\1/p' "$LOGS/$variant.log")
    all=$(sed -n 's/.*tests failed out of \([0-9]*\).*/\1/p' "$LOGS/$variant.log")
    if [ -z "$all" ] || { [ "$status" -ne 0 ] && [ "$bad" = 0 ]; }; then
        broken "$variant" "ctest did not run"
        return 1
    fi
    count "$((all - bad))" "$bad"
    row "$variant" "$((all - bad)) of $all tests passed in $(($(now) - began)) s"
    if [ "$bad" -ne 0 ]; then
        cat "$LOGS/$variant.log"
        return 1
    fi
}

# The same scenes, the same bits: every variant's list of image hashes against the release's.
compare_hashes() {
    [ -f out-release/tests/hashes.txt ] && [ -f "out-$1/tests/hashes.txt" ] || return 0
    if cmp -s out-release/tests/hashes.txt "out-$1/tests/hashes.txt"; then
        count 1 0
        row "$1" "all $(wc -l <"out-$1/tests/hashes.txt") image hashes are the release's"
    else
        count 0 1
        row "$1" "image hashes differ from the release's:"
        diff out-release/tests/hashes.txt "out-$1/tests/hashes.txt"
    fi
}

lint() {
    if sh tests/lint.sh >"$LOGS/lint.log" 2>&1; then
        count 1 0
        row lint "$(tail -n 1 "$LOGS/lint.log")"
    else
        broken lint "found something"
    fi
}

# What is left out where it would be shown twice. Clang: the program, the binding and the optional parts are GCC's, and the address sanitizer's
# by Clang, so that here they are off; real meshes are the release's. Sanitizers: AVX2 beside generic where memory counts (its stores in eights
# reach behind rows, those of AVX-512 go by masks) but for packets and pencils, AVX2's alone; generic alone where threads and readers do; of the
# program and of sweeps, what more than their Lua does; a Lua test that has a .gc, which does the same with all collected at once, as that. Of both kinds of AVX-512 the better that the processor has is run, the other only compiled.
seconds=1
parts='-DLIBRT_LUA=OFF -DLIBRT_STB=OFF -DLIBRT_PNG=OFF -DLIBRT_MPI=OFF -DLIBRT_OPENCL=OFF' # Clang's
release_less='\.gc$' # under the address sanitizer, where it tells more
clang_less='^unit\.(base|checkpoint)$|^variants\.(tracers|(moved|pencils)\.generic|tracers\.sse42)$|^hash\.sse42$'
asan_less='^lua\.(alloc|report|sweep|describe|draw|image|items|job|scene)$|^variants\.(moved|pencils)\.generic$|^unit\.(camera|motion)$|\.generational$|^cli\.(animate|bench|help|limit|render|replay|report|sdf|sweep|tools|tree|tutorial)|^hash\.(generic|avx2)$|^variants\.tracers(\.generic)?$'
arm_tests='^variants\.|^hash\.|^unit\.(kernel_|(ball|tri)_lanes$|lanes(_path)?$|isa$|cell_wide$|tree)'
avx512_tests='^variants\..*avx512|^hash\.|^unit\.(simd|lanes(_path)?|(ball|tri)_lanes|isa|cell_wide|tree|extreme)$'
release_isas=AUTO # an AVX-512 is a third of what a compiler takes
own_isas=AUTO     # Clang's
asan_isas=AUTO
few_isas=NONE
slow='slow|source'
case $(uname -m) in x86_64 | amd64)
    own_isas=avx2
    asan_isas=avx2
    if grep -q avx512_vbmi2 /proc/cpuinfo 2>/dev/null; then
        own_isas=avx512_vbmi2
        release_isas='sse42;avx2;avx512_vbmi2'
    elif grep -q avx512vl /proc/cpuinfo 2>/dev/null; then
        own_isas=avx512
        release_isas='sse42;avx2;avx512'
    elif grep -q avx2 /proc/cpuinfo 2>/dev/null; then
        release_isas='sse42;avx2'
    fi
    ;;
esac
if [ "$FULL" != 0 ]; then
    seconds=120
    release_less='^$'
    parts='-DLIBRT_LUA=AUTO -DLIBRT_STB=AUTO -DLIBRT_PNG=AUTO -DLIBRT_MPI=AUTO -DLIBRT_OPENCL=AUTO'
    clang_less='^$'
    asan_less='^$'
    slow=source
    release_isas=AUTO
    own_isas=AUTO
    asan_isas=AUTO
    few_isas=AUTO
fi
# twice LEVELS: tests of the best of these levels, which show once more, on fewer rays, what those without a level show.
twice() {
    level=${1##*;}
    if [ "$level" = AUTO ]; then
        level=$(out-release/bin/rtray info 2>/dev/null | sed -n 's/^isa *//p')
    fi
    if [ "$FULL" != 0 ] || [ -z "$level" ]; then
        echo '^$'
    else
        echo "^(variants\\.(balls|moved|pencils|streams)|unit\\.(extreme|refit))\\.$level\$"
    fi
}

started=$(now)
for variant in "$@"; do
    case $variant in
    release)
        build release all "-DLIBRT_ISAS=$release_isas" && build release check_isas "-DLIBRT_ISAS=$release_isas" &&
            check release -E "$release_less|$(twice "$release_isas")"
        ;;
    clang)
        # shellcheck disable=SC2086 # arguments
        build clang all "-DLIBRT_ISAS=$own_isas" $parts && check clang -LE "$slow" -E "$clang_less|$(twice "$own_isas")" && compare_hashes clang
        ;;
    bare) build bare all "-DLIBRT_ISAS=$few_isas" && check bare -LE "$slow" && compare_hashes bare ;;
    asan | asan-gcc)
        build "$variant" all "-DLIBRT_ISAS=$asan_isas" "-DLIBRT_FUZZ_SECONDS=$seconds" &&
            check "$variant" -LE "$slow" -E "$asan_less|$(twice "$asan_isas")" && compare_hashes "$variant"
        ;;
    tsan) build tsan tests_threads "-DLIBRT_ISAS=$few_isas" && check tsan -L threads && compare_hashes tsan ;;
    msan) build msan tests_readers "-DLIBRT_ISAS=$few_isas" && check msan -L readers ;;
    fuzz) build asan tests_fuzz "-DLIBRT_ISAS=$asan_isas" "-DLIBRT_FUZZ_SECONDS=$seconds" && check asan -L fuzz ;;
    avx512)
        if grep -q avx512_vbmi2 /proc/cpuinfo 2>/dev/null; then
            row avx512 "left out: this machine has it, and the release's tests used it"
        elif ! grep -q avx2 /proc/cpuinfo 2>/dev/null || [ ! -f /usr/include/simde/x86/avx512.h ]; then
            row avx512 "left out: no AVX2, or SIMDe is not installed"
        else
            build avx512 all && check avx512 -LE source -R "$avx512_tests" && compare_hashes avx512
        fi
        ;;
    arm)
        if command -v aarch64-linux-gnu-gcc >/dev/null 2>&1 && command -v qemu-aarch64 >/dev/null 2>&1; then
            build arm all && check arm -R "$arm_tests" && compare_hashes arm
        else
            row arm "left out: aarch64-linux-gnu-gcc or qemu-aarch64 is not installed"
        fi
        ;;
    lint) lint ;;
    *)
        echo "matrix.sh: no variant is called $variant" >&2
        exit 2
        ;;
    esac
done
if [ "$whole" = 1 ] && [ "$FULL" = 0 ]; then
    cat <<'WORDS'
only test --full has: ten million rays of each mesh against brute force, 200,000 of each made scene (10,000 here, 1,000 but in release);
    ten million triangles; two minutes of fuzzing a reader (a second here); AVX-512 without VBMI2 where the processor has both, and with it
    over SIMDe where it has neither, and either under a sanitizer; 64-bit ARM (under qemu); every test and instruction set by Clang, with every optional part, and under each
    sanitizer; the address sanitizer by GCC, and readers' replays under it; GCC with no optional part, and its image hashes; clang-tidy
WORDS
fi
printf 'in %d min %d s\n' $((($(now) - started) / 60)) $((($(now) - started) % 60))
printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
