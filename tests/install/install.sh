#!/bin/sh
# usage: install.sh SOURCE_ROOT BUILD_FOLDER; CC, CXX, CMAKE, HAVE_LUA in the environment.
# Installs under a DESTDIR, moves the tree elsewhere, and uses it there as others would: find_package, pkg-config (shared and static), the program,
# the Lua module. Every way must give the same picture.
set -eu
root=$1
binary=$2
CC=${CC:-cc}
CXX=${CXX:-}
CMAKE=${CMAKE:-cmake}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset LD_LIBRARY_PATH LUA_PATH LUA_CPATH LUA_PATH_5_4 LUA_CPATH_5_4 CMAKE_PREFIX_PATH PKG_CONFIG_PATH

fail() {
    printf '%s\n' "$*" >&2
    exit 1
}
# quiet COMMAND...: its output is shown only when it fails.
quiet() {
    "$@" >"$work/log" 2>&1 || {
        tail -n 30 "$work/log" >&2
        fail "failed: $*"
    }
}

DESTDIR="$work/dest" quiet "$CMAKE" --install "$binary" --prefix /opt/rt
[ -z "$(find "$work/dest" -mindepth 1 -maxdepth 1 ! -name opt)" ] || fail "something was installed outside of the prefix"
mkdir "$work/a place"
mv "$work/dest/opt/rt" "$work/a place/moved"
prefix="$work/a place/moved"
lib=$(dirname "$(find "$prefix" -name 'librtray.so' | head -n 1)")

# ---- the files ----
for file in include/librt/rt.h share/doc/librt/LICENSE; do
    [ -f "$prefix/$file" ] || fail "not installed: $file"
done
for file in librtray.so librtray.a pkgconfig/librt.pc cmake/librt/librtConfig.cmake cmake/librt/librtConfigVersion.cmake; do
    [ -e "$lib/$file" ] || fail "not installed: $file in the library folder"
done
grep -r -l -a -F -e "$root" -e "$binary" "$prefix" >"$work/named" && fail "these name a folder of the build: $(cat "$work/named")"
find "$prefix" -name '*.h' -path '*include*' ! -path '*include/librt/*' | grep . && fail "headers outside of include/librt"

# ---- find_package ----
results=$work/results
: >"$results"
if [ -n "$CXX" ]; then
    quiet "$CMAKE" -S "$root/tests/consumer" -B "$work/consumer" -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_COMPILER=$CC" "-DCMAKE_CXX_COMPILER=$CXX" \
        "-DCMAKE_PREFIX_PATH=$prefix"
    quiet "$CMAKE" --build "$work/consumer" -j 2
    for program in c_librt c_librt_static cxx_librt cxx_librt_static; do
        "$work/consumer/$program" >>"$results" || fail "$program failed"
    done
    readelf -d "$work/consumer/c_librt" | grep -q 'NEEDED.*librtray\.so\.[0-9]' || fail "c_librt does not use the shared library"
    readelf -d "$work/consumer/c_librt_static" | grep -q 'NEEDED.*librtray' && fail "c_librt_static uses the shared library"
fi

# ---- pkg-config: the folder's name has a space, which pkg-config escapes and the shell must take as written ----
if command -v pkg-config >/dev/null 2>&1; then
    PKG_CONFIG_PATH="$lib/pkgconfig"
    export PKG_CONFIG_PATH
    pkg-config --exists 'librt >= 0.1' || fail "pkg-config does not know librt"
    eval "quiet \"\$CC\" -o \"\$work/pc_shared\" \"\$root/tests/consumer/main.c\" $(pkg-config --cflags --libs librt)"
    LD_LIBRARY_PATH="$lib" "$work/pc_shared" >>"$results" || fail "the pkg-config program failed"
    shared="$(pkg-config --libs librt)"
    static="$(pkg-config --static --libs librt | sed 's/-lrtray/-l:librtray.a/')"
    case $shared in *-lm*) fail "a shared link asks for private libraries: $shared" ;; esac
    eval "quiet \"\$CC\" -o \"\$work/pc_static\" \"\$root/tests/consumer/main.c\" $(pkg-config --cflags librt) $static"
    readelf -d "$work/pc_static" | grep -q 'NEEDED.*librtray' && fail "the static program uses the shared library"
    "$work/pc_static" >>"$results" || fail "the static pkg-config program failed"
fi
[ -s "$results" ] || fail "no consumer could be built"
[ "$(sort -u "$results" | wc -l)" -eq 1 ] || fail "the consumers differ: $(cat "$results")"

# ---- the program and the Lua module ----
[ "${HAVE_LUA:-OFF}" = ON ] || exit 0
cat >"$work/scene.lua" <<'LUA'
local rt = require "rt"
return rt.scene { settings = { width = 16, height = 16, samples = 1 }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
LUA
cd "$work"
readelf -d "$prefix/bin/rtray" | grep -q 'NEEDED.*liblua' || fail "rtray does not use the shared liblua"
quiet "$prefix/bin/rtray" render scene.lua -o program.png --quiet
[ -s program.png ] || fail "the installed program wrote no picture"
quiet "$prefix/bin/rtray" help
for file in share/bash-completion/completions/rtray share/zsh/site-functions/_rtray share/fish/vendor_completions.d/rtray.fish \
    share/man/man1/rtray.1 share/man/man1/rtray-animate.1 share/man/man1/rtray-sweep.1; do
    [ -f "$prefix/$file" ] || fail "not installed: $file"
done
if command -v lua5.4 >/dev/null 2>&1; then
    module=$(find "$prefix" -path '*lua/5.4/rt.so')
    [ -n "$module" ] || fail "no Lua module was installed"
    readelf -d "$module" | grep -q 'NEEDED.*liblua' && fail "rt.so links liblua"
    LUA_CPATH="$(dirname "$module")/?.so;;" LUA_PATH="$prefix/share/lua/5.4/?.lua;$prefix/share/lua/5.4/?/init.lua;;" \
        quiet lua5.4 -e 'local rt = require "rt"; assert(type(rt.scene) == "function" or getmetatable(rt.scene)); assert(dofile "scene.lua")'
fi
