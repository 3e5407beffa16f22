#!/bin/sh
# usage: reproducible.sh SOURCE_ROOT BUILD_FOLDER. A second build, of a copy of the sources in another folder at another time, gives the same
# files, byte for byte; and no file that was built names a folder of the build. Without LIBRT_FULL=1 the second build is of every
# fifth of the library's objects: the same rules for all, and minutes more.
set -eu
root=$1
binary=$2
CMAKE=${CMAKE:-cmake}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

copy="$dir/another place/of quite another length"
mkdir -p "$copy"
(cd "$root" && tar -cf - --exclude='./out*' --exclude=./.git .) | (cd "$copy" && tar -xf -)

# The same settings, without what names a path of the first build.
sed -n 's/^\(CMAKE_C_COMPILER\|CMAKE_BUILD_TYPE\|CMAKE_C_FLAGS\|LIBRT_[A-Z]*\):[A-Z]*=\(.*\)$/-D\1=\2/p' "$binary/CMakeCache.txt" |
    grep -v -e '^-DLIBRT_SCENES=' >"$dir/settings"
set --
while IFS= read -r setting; do
    set -- "$@" "$setting"
done <"$dir/settings"
second="$copy/out-second"
full=${LIBRT_FULL:-0}
[ "$full" != 0 ] && least=50 || least=22 # objects, fewer than there are
{
    "$CMAKE" -G Ninja -S "$copy" -B "$second" "$@" -DBUILD_TESTING=OFF -DLIBRT_EXAMPLES=OFF &&
        if [ "$full" != 0 ]; then
            "$CMAKE" --build "$second" -j "${JOBS:-2}"
        else
            ninja -C "$second" -t targets all | sed -n 's/^\(.*librt_objects\.dir.*\.o\):.*/\1/p' | sort | awk 'NR % 5 == 1' >"$dir/some" &&
                xargs "$CMAKE" --build "$second" -j "${JOBS:-2}" --target <"$dir/some"
        fi
} >"$dir/log" 2>&1 || {
    tail -n 20 "$dir/log"
    exit 1
}

(cd "$second" && find . -path '*/librt_objects.dir/*.o') >"$dir/again"
(
    cd "$binary"
    find lib bin -type f 2>/dev/null
) >"$dir/files" || true # there is no bin/ without Lua
if ! grep -q 'librtray\.so' "$dir/files" || ! grep -q 'librtray\.a' "$dir/files" || [ "$(wc -l <"$dir/again")" -lt "$least" ]; then
    echo "there is no library, or no second one"
    exit 1
fi
[ "$full" = 0 ] || cat "$dir/files" >>"$dir/again"
fail=0
while IFS= read -r file; do
    cmp "$second/$file" "$binary/$file" || fail=1
done <"$dir/again"
while IFS= read -r file; do
    if grep -a -q -F -e "$root" -e "$binary" "$binary/$file"; then
        printf '%s names a folder of the build:\n' "$file"
        strings "$binary/$file" | grep -F -e "$root" -e "$binary" | head -n 5
        fail=1
    fi
done <"$dir/files"
exit $fail
