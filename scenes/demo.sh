#!/bin/sh
# Renders every scene of this folder at its own settings. usage: demo.sh RTRAY OUT_FOLDER
set -eu
rtray=$1
out=$2
here=$(cd "$(dirname "$0")" && pwd)
meshes=${LIBRT_SCENES:-$here/../../shared/scenes}
mkdir -p "$out"
cd "$out"
failed=0

# render PICTURE ARGUMENTS...: one that fails does not keep the others from being made.
render() {
    picture=$1
    shift
    printf '== %s\n' "$picture"
    "$rtray" render "$@" -o "$picture" || failed=1
}

for scene in "$here"/*.lua "$here"/*.sdf; do
    name=$(basename "$scene")
    case $name in
    real.lua)
        for mesh in sponza sibenik bunny; do
            if [ -f "$meshes/$mesh.ply" ]; then
                render "$mesh.png" "$scene" -D "mesh=$meshes/$mesh.ply"
            else
                printf '== %s.png is left out: there is no %s.ply in %s\n' "$mesh" "$mesh" "$meshes"
            fi
        done
        ;;
    *.sdf) render "${name%.sdf}-sdf.png" "$scene" ;;
    *) render "${name%.lua}.png" "$scene" ;;
    esac
done
printf '\nThe pictures are in %s:\n' "$out"
ls -1 -- *.png
exit $failed
