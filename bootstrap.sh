#!/bin/sh
# From a fresh clone to pictures, or to a passed test, in one command. No question is asked.
#
#   ./bootstrap.sh demo          install what is missing, build, render the scenes to out/      (about 5 minutes)
#   ./bootstrap.sh test          install what is missing, build the variants, run every test    (about 18 minutes on 2 cores)
#   ./bootstrap.sh test --full   the same with the long figures                                 (hours)
#   ./bootstrap.sh build         install what is missing, build out-release
#   ./bootstrap.sh packages      print what each of them would install
#
# Exit status: 0 done, 1 a build or a test failed, 2 the command line, 3 a package is missing and cannot be installed from here.
set -eu
umask 022
cd "$(dirname "$0")"
ROOT=$(pwd)
LC_ALL=C.UTF-8
TZ=UTC0
export LC_ALL TZ

say() { printf '%s\n' "bootstrap: $*"; }
die() {
    status=$1
    shift
    printf '%s\n' "bootstrap: $*" >&2
    exit "$status"
}
usage() { sed -n '2,10p' "$0" | sed 's/^# \{0,1\}//'; }
have() { command -v "$1" >/dev/null 2>&1; }

# ---- what is needed ----------------------------------------------------------------------------------------------------
# One line a package: Debian's name, and the probe that says whether it is here already, from wherever it came.

has_header() { printf '#include <%s>\n' "$1" | "${CC:-cc}" -E ${2:+$2} - >/dev/null 2>&1; }
has_module() { have pkg-config && pkg-config --exists "$1"; }
has_cmake() {
    have cmake || return 1
    cmake --version | awk 'NR == 1 { split($3, v, "."); exit !(v[1] > 3 || (v[1] == 3 && v[2] >= 25)) }'
}
has_lua() { has_module "${1:-lua5.4}" || has_module lua-5.4 || has_module lua54 || has_module 'lua >= 5.4'; }
has_stb() { has_header stb/stb_image.h || has_module stb; }
has_cxx() { printf '#include <vector>\n' | "${CXX:-c++}" -x c++ -E - >/dev/null 2>&1; }
has_lua_lib() { have lua5.4 && lua5.4 -e "require '$1'" >/dev/null 2>&1; }
# The tests make themselves a German locale from its source.
has_german() { have localedef && { test -f /usr/share/i18n/locales/de_DE || locale -a 2>/dev/null | grep -qi '^de_DE\.utf-\?8$'; }; }
# Of the systems that are known here Debian alone has another machine's packages in the same archive.
has_arm_packages() { test "$(uname -m)" = x86_64 && grep -q '^ID=debian' /etc/os-release 2>/dev/null; }
has_clang_rt() {
    have clang && test -n "$(find "$(clang -print-resource-dir 2>/dev/null)/lib" -name 'libclang_rt.asan*.so' 2>/dev/null | head -n 1)"
}

PACKAGES_BUILD='
gcc             have cc
libc6-dev       has_header stdlib.h
cmake           has_cmake
ninja-build     have ninja
pkg-config      have pkg-config
liblua5.4-dev   has_lua
libstb-dev      has_stb
libpng-dev      has_module libpng'

PACKAGES_TEST='
g++             has_cxx
lua5.4          have lua5.4
lua-busted      have busted
lua-cjson       has_lua_lib cjson
lua-check       have luacheck
libcmocka-dev   has_header cmocka.h
locales         has_german
ffmpeg          have ffmpeg
gnuplot-nox     have gnuplot
doxygen         have doxygen
lua-ldoc        have ldoc
clang           have clang
libclang-rt-dev has_clang_rt
llvm            have llvm-symbolizer'

PACKAGES_FULL='
tachyon         have tachyon
libsimde-dev    has_header simde/x86/avx512.h'

# The kernels of 64-bit ARM, from another machine; elsewhere the matrix leaves them out, or takes what is there.
PACKAGES_ARM='
qemu-user                  have qemu-aarch64
crossbuild-essential-arm64 have aarch64-linux-gnu-g++
libcmocka-dev:arm64        test -e /usr/lib/aarch64-linux-gnu/libcmocka.so'

# Prints the packages of a list whose probe fails.
missing() {
    printf '%s\n' "$1" | while read -r package probe; do
        [ -n "$package" ] || continue
        # shellcheck disable=SC2086 # the probe is a command and its arguments
        $probe </dev/null || printf '%s ' "$package"
    done
}

# ---- installing --------------------------------------------------------------------------------------------------------

# apt-get as root, without a question: everything goes to the log, a word about a lock or the size of the download to the terminal. Dpkg's
# lock is waited for, up to 15 minutes.
apt() {
    set -- env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 apt-get -q -y -o DPkg::Lock::Timeout=900 -o Acquire::Retries=3 \
        -o Dpkg::Use-Pty=0 -o Dpkg::Options::=--force-confdef -o Dpkg::Options::=--force-confold "$@"
    if [ "$(id -u)" -ne 0 ]; then
        set -- sudo "$SUDO_ASK" "$@"
    fi
    {
        "$@" </dev/null 2>&1 || echo "apt-get failed"
    } | awk -v log_file="$LOG" '
        { print >log_file }
        /^Waiting for cache lock/ && !told++ { print "bootstrap: another program is installing packages; waiting for it"; fflush() }
        /^Need to get/ { print "bootstrap: " tolower(substr($0, 1, 1)) substr($0, 2); fflush() }
        /^apt-get failed$/ { failed = 1 }
        END { exit failed }'
}

# The lists' lock has no timeout of its own in apt: try again while somebody else holds it.
apt_update() {
    tries=0
    until apt update; do
        grep -q 'Could not get lock' "$LOG" || return 1
        [ "$tries" -lt 90 ] || return 1
        [ "$tries" -gt 0 ] || say "another program holds the package lists; waiting for it"
        tries=$((tries + 1))
        sleep 10
    done
}

# Packages of another machine are found when dpkg knows of it.
add_architecture() {
    set -- dpkg --add-architecture "$1"
    [ "$(id -u)" -eq 0 ] || set -- sudo "$SUDO_ASK" "$@"
    "$@" >>"$LOG" 2>&1 || log_and_die "dpkg --add-architecture failed"
}

# A name that is not found, or a file that the mirror no longer has, means an index that is empty or old.
apt_install() {
    say "installing: $*"
    apt install --no-install-recommends "$@" && return
    case "$*" in *:arm64*) add_architecture arm64 ;; esac
    say "reading the package index"
    apt_update || log_and_die "apt-get update failed"
    apt install --no-install-recommends "$@" || log_and_die "apt-get install failed"
}

log_and_die() {
    tail -n 15 "$LOG" >&2
    die 3 "$1; the last lines are above, all of it is in $LOG"
}

other_systems() {
    cat >&2 <<TXT
bootstrap: this system has no apt-get. Install these and run the same command again:
  Fedora   gcc gcc-c++ cmake ninja-build pkgconf lua lua-devel stb_image-devel stb_image_write-devel libpng-devel; tests: libcmocka-devel clang compiler-rt lua-cjson
  Arch     gcc cmake ninja pkgconf lua54 stb libpng; tests: cmocka clang compiler-rt lua54-cjson
  Alpine   gcc g++ musl-dev cmake samurai pkgconf lua5.4-dev stb libpng-dev; tests: cmocka-dev clang compiler-rt lua5.4-cjson
  FreeBSD  cmake ninja pkgconf lua54 stb png; tests: cmocka
  macOS    (Homebrew) cmake ninja pkgconf lua libpng; tests: cmocka
TXT
}

# install_missing LIST: nothing missing, nothing done (and no network).
install_missing() {
    want=$(missing "$1")
    want=${want% }
    [ -n "$want" ] || return 0
    if ! have apt-get; then
        other_systems
        die 3 "missing here (Debian's names): $want"
    fi
    line="apt-get update && apt-get install -y --no-install-recommends $want"
    SUDO_ASK=-n
    if [ "$(id -u)" -ne 0 ]; then
        have sudo || die 3 "not root, and there is no sudo. As root, run:  $line"
        [ -t 0 ] && [ -t 2 ] && SUDO_ASK=--
        sudo "$SUDO_ASK" true || die 3 "sudo refused. As root, run:  $line"
    fi
    # shellcheck disable=SC2086 # a list of names
    apt_install $want
    want=$(missing "$1")
    [ -z "$want" ] || die 3 "installed, and yet not usable: $want"
}

# ---- building and running ----------------------------------------------------------------------------------------------

jobs_count() { nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2; }

# build_release [CMAKE ARGUMENTS]: all instruction sets, also where the tests left a tree with fewer
build_release() {
    say "building (release, $JOBS jobs)"
    cmake --preset release -DLIBRT_ISAS=AUTO "$@" >"$LOG" 2>&1 || {
        tail -n 30 "$LOG" >&2
        die 1 "cmake failed; the last lines are above"
    }
    grep '^-- librt:' "$LOG" || true
    cmake --build out-release -j "$JOBS" || die 1 "the build failed"
}

run_demo() {
    install_missing "$PACKAGES_BUILD"
    build_release -DBUILD_TESTING=OFF -DLIBRT_EXAMPLES=OFF
    sh scenes/demo.sh "$ROOT/out-release/bin/rtray" "$ROOT/out" || die 1 "a scene could not be rendered"
}

run_test() {
    list=$PACKAGES_BUILD$PACKAGES_TEST
    case ${1:-} in
    '') ;;
    --full)
        LIBRT_FULL=1
        export LIBRT_FULL
        list=$list$PACKAGES_FULL
        if has_arm_packages; then list=$list$PACKAGES_ARM; fi
        ;;
    *) die 2 "test takes --full or nothing, not $1" ;;
    esac
    install_missing "$list"
    sh tests/matrix.sh
}

prepare() {
    mkdir -p "$ROOT/out" || die 3 "cannot write in $ROOT"
    LOG=$ROOT/out/bootstrap.log
    JOBS=$(jobs_count)
    export JOBS
    # Nothing here needs HOME; a cache that cannot be written there goes beside the pictures.
    if [ -z "${CCACHE_DIR:-}" ] && ! { [ -n "${HOME:-}" ] && [ -w "$HOME" ]; }; then
        CCACHE_DIR=$ROOT/out/ccache
        export CCACHE_DIR
    fi
}

case ${1:-} in
demo | build | test)
    prepare
    command=$1
    shift
    case $command in
    demo) run_demo ;;
    build)
        install_missing "$PACKAGES_BUILD"
        build_release -DBUILD_TESTING=OFF
        say "built: out-release/bin/rtray"
        ;;
    test) run_test "$@" ;;
    esac
    ;;
packages)
    printf 'demo, build:%s\n' "$(printf '%s' "$PACKAGES_BUILD" | awk 'NF { printf " %s", $1 }')"
    printf 'test adds:%s\n' "$(printf '%s' "$PACKAGES_TEST" | awk 'NF { printf " %s", $1 }')"
    printf 'test --full adds:%s\n' "$(printf '%s' "$PACKAGES_FULL$PACKAGES_ARM" | awk 'NF { printf " %s", $1 }')"
    ;;
-h | --help | help) usage ;;
*)
    usage >&2
    exit 2
    ;;
esac
