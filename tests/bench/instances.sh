#!/bin/sh
# What instances and distance cost, beside Embree's instances: sponza and a bunny as they stand and placed, by each tracer, in blocks and one ray a
# call; at the end the best of librt / the best of Embree MEDIUM. usage: instances.sh RTRAY [NAME [OPTIONS...]]
#
# NAME is what the machine is called; OPTIONS go to `rtray bench-rays` behind the others. LIBRT_SCENES names the folder of meshes. The CSV goes to
# tests/bench/results/rays-instances-NAME.csv. Timings decide nothing here.
set -eu
export LC_ALL=C
rtray=${1:?usage: instances.sh RTRAY [NAME [OPTIONS...]]}
name=${2:-unnamed}
shift
[ $# -eq 0 ] || shift
here=$(cd "$(dirname "$0")" && pwd)
scenes=${LIBRT_SCENES:-$here/../../../shared/scenes}
out=$here/results/rays-instances-$name.csv
if [ ! -r "$scenes/sponza.ply" ] || [ ! -r "$scenes/bunny.ply" ]; then
    echo "$scenes has no sponza.ply or bunny.ply: set LIBRT_SCENES"
    exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# row WHAT MESH COUNT CAMERA...
row() {
    what=$1
    mesh=$2
    count=$3
    shift 3
    first=1
    [ ! -e "$work/all.csv" ] || first=
    echo "$what"
    "$rtray" bench-rays "$here/instance_scene.lua" -D "mesh=$scenes/$mesh.ply" -D "count=$count" --trust "$@" --against embree --embree-qualities medium \
        --tracers kdtree,bvh --inputs blocks,one --builds 0 --repeats 3 --machine "$name" --quiet -o "$work/one.csv" >/dev/null
    awk -F, -v OFS=, -v what="$what" -v first="$first" '
        NR == 1 { if (first) print; next }
        { $3 = what; print }' "$work/one.csv" >>"$work/all.csv"
    rm "$work/one.csv"
}

row "sponza placed once" sponza 1 --eye 14.4499,6.89415,-1.18547 --at 13.4563,6.78438,-1.15861 --fov 74.096 "$@"
row "bunny placed once" bunny 1 --eye -.0168,.125,.33 --at -.0168,.108,0 --fov 35 "$@"
row "bunny placed 10 times" bunny 10 --eye .16,.57,.45 --at -.05,.25,-.15 --fov 40 "$@"
row "bunny placed 400 times" bunny 400 --eye 1.2,2.05,3.4 --at 0,.25,0 "$@"
row "bunny placed 5000 times" bunny 5000 --eye 4.2,6.55,11.9 --at 0,.25,0 "$@"
row "bunny from afar" bunny 0 --eye -.0168,.45,6.6 --at -.0168,.108,0 --fov 1.8 "$@"
row "bunny placed once from afar" bunny 1 --eye -.0168,.45,6.6 --at -.0168,.108,0 --fov 1.8 "$@"
mv "$work/all.csv" "$out"

awk -F, '
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    {
        key = $at["scene"] "," $at["set"]
        if (!(key in seen)) { seen[key] = 1; order[++n] = key }
        rate = $at["mrays"] + 0
        if ($at["program"] == "librt" && $at["input"] == "one") { if (rate > one[key]) one[key] = rate }
        else if ($at["program"] == "librt") { if (rate > best[key]) best[key] = rate }
        else if ($at["robust"] == 0) {
            if (rate > theirs[key]) theirs[key] = rate
            if ($at["tracer"] == "single") single[key] = rate
        }
        differ += $at["program"] == "librt" ? $at["differ"] + $at["brute_differ"] : 0
    }
    END {
        print "scene,set,librt,embree,ratio,one a call / single"
        for (i = 1; i <= n; i++) {
            k = order[i]
            printf "%s,%.1f,%.1f,%.2f,%.2f\n", k, best[k], theirs[k], best[k] / theirs[k], one[k] / single[k]
        }
        print differ + 0 " hits differ"
    }' "$out"
