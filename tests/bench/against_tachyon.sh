#!/bin/bash
# Frames of librt and of Tachyon (Debian: tachyon) on the same triangles, spheres or cylinders, camera and light, in one run, interleaved: 1000x700, one sample, one shadow
# ray a hit.
#   tests/bench/against_tachyon.sh RTRAY [RUNS]        prints CSV; LIBRT_SCENES names the folder of meshes
# Times are the renderers' own: what comes after the scene was read and its tree built. Timings decide nothing here.
set -euo pipefail
export LC_ALL=C
rtray=${1:?usage: against_tachyon.sh RTRAY [RUNS]}
runs=${2:-5}
here=$(cd "$(dirname "$0")" && pwd)
scenes=${LIBRT_SCENES:-$here/../../../shared/scenes}
command -v tachyon >/dev/null || { echo "tachyon is not installed: apt-get install tachyon"; exit 0; }
[ -r "$scenes/sponza.ply" ] || { echo "$scenes has no sponza.ply: set LIBRT_SCENES"; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# name mesh eye look_at fov light floor
views() {
  echo "sponza sponza 14.4499,6.89415,-1.18547 13.4563,6.78438,-1.15861 74.096 0,12,0"
  echo "sibenik sibenik 24,3,0 0,4,0 60 10,14,0"
  echo "stadium bunny -0.0168,0.125,0.33 -0.0168,0.108,0 35 0.3,0.6,0.6 100"
}

script() { # mesh eye look_at fov light floor
  local floor=""
  [ -n "${6:-}" ] && floor="rt.mesh { vertices = { {-$6, y, -$6}, {$6, y, -$6}, {$6, y, $6}, {-$6, y, $6} }, faces = { {1, 2, 3}, {1, 3, 4} }, material = matte },"
  cat <<LUA
local rt = require "rt"
local matte = rt.classic { color = {1, 1, 1}, diffusion = 0.9, ambient = 0 }
local y = 0.0329870000481606 -- the bunny's lowest vertex
return rt.scene {
  settings = { width = 1000, height = 700, samples = 1, integrator = "whitted" },
  camera = rt.camera { eye = {$2}, look_at = {$3}, fov = $4 },
  rt.point_light { at = {$5} },
  $floor
  rt.mesh { file = "$scenes/$1.ply", material = matte },
}
LUA
}

seconds_librt() { # script workers size
  "$rtray" render "$1" --trust --workers "$2" --size "$3" --json --quiet -o "$work/librt.png" | sed -n 's/.*"seconds":\([0-9.e+-]*\).*/\1/p'
}
seconds_tachyon() { # dat width height threads
  timeout 600 tachyon "$1" -numthreads "$4" -res "$2" "$3" -fullshade -o "$work/tachyon.tga" | sed -n 's/.*Ray Tracing Time: *\([0-9.]*\).*/\1/p'
}

# name librt-scene tachyon-scene size
compare() {
  local run workers
  for run in $(seq "$runs"); do
    for workers in 1 2; do
      echo "$1,$4,librt,$workers,$run,$(seconds_librt "$2" "$workers" "$4")"
      if [ "$1" != stadium ] || { [ "$run" = 1 ] && [ "$workers" = 1 ]; }; then # Tachyon's grid collapses there: a minute and a half for this
        echo "$1,$4,tachyon,$workers,$run,$(seconds_tachyon "$3" "${4%x*}" "${4#*x}" "$workers")"
      fi
    done
  done
}

echo "scene,size,program,workers,run,seconds"
for name in flake mirrors molecule protein; do
  lua5.4 "$here/shape_scene.lua" $name librt "$work/$name.lua"
  lua5.4 "$here/shape_scene.lua" $name tachyon "$work/$name.dat"
  compare $name "$work/$name.lua" "$work/$name.dat" 1000x700
done
while read -r name mesh eye look_at fov light floor; do
  lua5.4 "$here/tachyon_scene.lua" "$scenes/$mesh.ply" "$work/$name.dat" "$eye" "$look_at" "$fov" "$light" ${floor:+"$floor"}
  script "$mesh" "$eye" "$look_at" "$fov" "$light" ${floor:+"$floor"} >"$work/$name.lua"
  size=1000x700
  [ "$name" = stadium ] && size=300x300
  compare "$name" "$work/$name.lua" "$work/$name.dat" $size
done < <(views)
