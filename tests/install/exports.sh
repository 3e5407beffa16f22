#!/bin/sh
# usage: exports.sh librtray.so SOURCE_ROOT. The shared library exports exactly what the public headers declare with RT_API, and no name of
# libtachyon, which a program that compares ray tracers has in the same process.
set -eu
library=$1
root=$2
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
LC_ALL=C
export LC_ALL

nm -D --defined-only "$library" | awk '$2 != "A" { sub(/@.*/, "", $3); print $3 }' | sort -u >"$dir/exported"
awk '/^RT_API/ && match($0, /rt_[a-z0-9_]+\(/) { print substr($0, RSTART, RLENGTH - 1) }' "$root"/librt/include/librt/*.h |
    sort -u >"$dir/declared"
sort -u "$root/tests/install/tachyon_names.txt" >"$dir/tachyon"

fail=0
# tell WORDS FILE: the names in FILE, if any, are a failure.
tell() {
    [ -s "$2" ] || return 0
    printf '%s:\n' "$1"
    sed 's/^/    /' "$2"
    fail=1
}
comm -23 "$dir/exported" "$dir/declared" >"$dir/extra"
comm -13 "$dir/exported" "$dir/declared" >"$dir/absent"
comm -12 "$dir/exported" "$dir/tachyon" >"$dir/clash"
if [ ! -s "$dir/declared" ]; then
    echo "no declaration was found in the headers"
    fail=1
fi
tell "exported, but in no public header" "$dir/extra"
tell "declared, but not exported" "$dir/absent"
tell "names that libtachyon exports too" "$dir/clash"
if ! readelf -d "$library" | grep -q 'SONAME.*\[librtray\.so\.[0-9]*\]'; then
    echo "no SONAME of the shape librtray.so.N"
    fail=1
fi
exit $fail
