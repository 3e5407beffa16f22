#!/bin/bash
# What materials cost: one mesh in strips of 1 or 64 materials, plain or textured, whitted, one light, 1000x700; the same hits in each. CPU time of the worker.
#   tests/bench/materials.sh RTRAY [RUNS]        prints CSV; LIBRT_SCENES names the folder of meshes. Timings decide nothing here.
set -euo pipefail
export LC_ALL=C
rtray=${1:?usage: materials.sh RTRAY [RUNS]}
runs=${2:-5}
here=$(cd "$(dirname "$0")" && pwd)
scenes=${LIBRT_SCENES:-$here/../../../shared/scenes}
[ -r "$scenes/sponza.ply" ] || { echo "$scenes has no sponza.ply: set LIBRT_SCENES"; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat >"$work/scene.lua" <<LUA
local rt = require "rt"
local p = rt.params { materials = { 1, min = 1, max = 64 }, textured = { false } }
-- A floor of 64 x 64 quads, each square of another material in turn, seen from above and along: neighbours differ, but not every pixel.
local pictures = {}
for i = 1, p.materials do
  pictures[i] = p.textured and rt.texture { image = rt.image { width = 64, height = 64, pixel = function(x, y)
    return (x * 37 + i * 61) % 64 / 64, (y * 17 + x) % 64 / 64, 0.5
  end } } or nil
end
local looks, parts = {}, {}
for i = 1, p.materials do
  looks[i] = rt.classic { color = {0.4 + i / 128, 0.8, 0.6}, diffusion = 0.9, ambient = 0.1, texture = pictures[i] }
  parts[i] = { vertices = {}, uvs = {}, faces = {} }
end
for y = 0, 63 do
  for x = 0, 63 do
    local m = parts[(x * 5 + y * 3) % p.materials + 1]
    local n = #m.vertices
    for _, c in ipairs { {0, 0}, {1, 0}, {1, 1}, {0, 1} } do
      m.vertices[#m.vertices + 1] = {x + c[1] - 32, 0.3 * math.sin(x + c[1]) * math.cos(y + c[2]), y + c[2] - 32}
      m.uvs[#m.uvs + 1] = {c[1], c[2]}
    end
    m.faces[#m.faces + 1] = {n + 1, n + 3, n + 2}
    m.faces[#m.faces + 1] = {n + 1, n + 4, n + 3}
  end
end
local scene = {
  settings = { width = 1000, height = 700, samples = 1, integrator = "whitted" },
  camera = rt.camera { eye = {0, 22, 34}, look_at = {0, 0, 0}, fov = 50 },
  rt.point_light { at = {10, 30, 10} },
}
for i, m in ipairs(parts) do
  scene[#scene + 1] = rt.mesh { vertices = m.vertices, uvs = m.uvs, faces = m.faces, material = looks[i] }
end
return rt.scene(scene)
LUA

echo "materials,textured,run,cpu_seconds"
for run in $(seq "$runs"); do
  for textured in false true; do
    for materials in 1 64; do
      s=$("$rtray" render "$work/scene.lua" --trust -D materials=$materials -D textured=$textured --workers 1 --json --quiet -o "$work/out.png" |
        sed -n 's/.*"cpu_seconds":\([0-9.e+-]*\).*/\1/p')
      echo "$materials,$textured,$run,$s"
    done
  done
done
