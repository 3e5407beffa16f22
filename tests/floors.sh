#!/bin/sh
# A file includes only from its own floor or the floors below it. usage: floors.sh SOURCE_ROOT | floors.sh --catches
#
#   base 1 < kernel 2 < accel 3 < trace 4 < scene 5 < render 6 < gpu 7 < cluster 8 < lua, examples 9
#
# trace stands below scene: a tracer knows the snapshot's view (kernel/) and nothing of descriptions, while a scene answers rays.
# The public headers (librt/...) are types and contracts and may be included from every floor but kernel/, which is plain C that
# a GPU's compiler reads too: it includes its own folder alone, and system headers only in types.h.
set -eu

check() {
    cd "$1"
    find librt lua examples -name '*.[ch]' -o -name '*.inl' 2>/dev/null | LC_ALL=C sort | while read -r file; do
        awk -v file="$file" '
        function floor_of(path) {
            if (path ~ /^librt\/include\//) return "public"
            if (path ~ /^librt\//) { split(path, p, "/"); return p[2] }
            split(path, p, "/"); return p[1]
        }
        function normal(path,   n, i, part, out, m) {
            n = split(path, part, "/"); m = 0
            for (i = 1; i <= n; i++) {
                if (part[i] == "..") m--
                else if (part[i] != "." && part[i] != "") out[++m] = part[i]
            }
            path = out[1]
            for (i = 2; i <= m; i++) path = path "/" out[i]
            return path
        }
        function bad(why) { printf "%s:%d: %s: %s\n", file, FNR, $0, why }
        BEGIN {
            split("base kernel accel trace scene render gpu cluster", names, " ")
            for (i = 1; i <= 8; i++) rank[names[i]] = i
            rank["lua"] = rank["examples"] = 9
            mine = floor_of(file); dir = file; sub(/[^\/]*$/, "", dir)
        }
        /^[ \t]*#[ \t]*include[ \t]*[<"]/ {
            quoted = $0 ~ /"/
            name = $0; sub(/^[^<"]*[<"]/, "", name); sub(/[>"].*/, "", name)
            if (name ~ /^librt\//) {
                if (mine == "kernel") bad("kernel/ includes its own folder alone")
                next
            }
            if (!quoted) {
                if (mine == "kernel" && file != "librt/kernel/types.h") bad("system headers stand in kernel/types.h alone")
                if (mine == "public" && name !~ /^std[a-z]+\.h$/) bad("a public header includes the C standard alone")
                if (mine != "lua" && name ~ /^(lua|lauxlib|lualib)/) bad("only lua/ knows Lua")
                next
            }
            if (name ~ /^stb_|^(lua|lauxlib|lualib)/) next
            target = normal(dir name)
            theirs = floor_of(target)
            if (theirs == "public") next
            if (mine == "public") { bad("a public header includes public headers alone"); next }
            if (mine == theirs) next
            if (mine == "lua" || mine == "examples") { bad("uses the public API alone"); next }
            if (mine == "kernel") { bad("kernel/ includes its own folder alone"); next }
            if (!(theirs in rank)) { bad("no such floor: " theirs); next }
            if (rank[theirs] > rank[mine]) bad(mine "/ stands below " theirs "/")
        }' "$file"
    done
}

# The check itself must catch each kind of break.
catches() {
    dir=$(mktemp -d)
    trap 'rm -rf "$dir"' EXIT
    mkdir -p "$dir/librt/base" "$dir/librt/kernel" "$dir/librt/trace" "$dir/librt/include/librt" "$dir/lua" "$dir/examples"
    echo '#include "../trace/trace.h"' >"$dir/librt/base/up.c"
    echo '#include "../base/base.h"' >"$dir/librt/kernel/base.h"
    echo '#include <stdio.h>' >"$dir/librt/kernel/system.h"
    echo '#include <lua.h>' >"$dir/librt/trace/lua.c"
    echo '#include "../../base/base.h"' >"$dir/librt/include/librt/inside.h"
    echo '#include "../librt/base/base.h"' >"$dir/lua/inside.c"
    echo '#include "../base/base.h"' >"$dir/librt/trace/good.c"
    echo '#include "librt/rt.h"' >"$dir/examples/good.c"
    found=$(check "$dir")
    count=$(printf '%s\n' "$found" | grep -c .)
    if [ "$count" -ne 6 ] || printf "%s\n" "$found" | grep -q good; then
        printf 'expected 6 breaks, none in good.c; found %s:\n%s\n' "$count" "$found"
        exit 1
    fi
}

if [ "${1:-}" = --catches ]; then
    catches
else
    found=$(check "$1")
    [ -z "$found" ] || {
        printf '%s\n' "$found"
        exit 1
    }
fi
