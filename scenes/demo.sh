#!/bin/sh
# Renders every scene of this folder at its own settings. usage: demo.sh RTRAY OUT_FOLDER
set -eu
rtray=$1
out=$2
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$out"
cd "$out"
for scene in "$here"/*.lua "$here"/*.sdf; do
    [ -f "$scene" ] || continue
    name=$(basename "$scene")
    case $name in
    *.sdf) picture=${name%.sdf}-sdf.png ;;
    *) picture=${name%.lua}.png ;;
    esac
    printf '== %s\n' "$name"
    "$rtray" render "$scene" -o "$picture"
done
printf '\nThe pictures are in %s:\n' "$out"
ls -1 -- *.png
