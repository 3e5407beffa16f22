-- scenes/helix.lua: two strands and their rungs, as a molecule model: many spheres as one shape, many cylinders between
local rt = require "rt"

local p = rt.params { turns = { 2.5, min = 0.5, max = 12 }, pairs = { 26, min = 2, max = 400 } }

local bases = { rt.classic { color = {0.85, 0.25, 0.2}, specular = 0.5, shininess = 80 }, rt.classic { color = {0.95, 0.75, 0.25}, specular = 0.5, shininess = 80 },
  rt.classic { color = {0.25, 0.6, 0.35}, specular = 0.5, shininess = 80 }, rt.classic { color = {0.25, 0.45, 0.8}, specular = 0.5, shininess = 80 } }
local rail = rt.classic { color = {0.75, 0.75, 0.8}, diffusion = 0.6, reflectiveness = 0.25, specular = 0.8, shininess = 150 }

local rungs, centers, radii = { from = {}, to = {}, materials = {}, radius = 0.06 }, {}, {}
local function rung(from, to, material)
  local i = #rungs.from + 1
  rungs.from[i], rungs.to[i], rungs.materials[i] = {from.x, from.y, from.z}, {to.x, to.y, to.z}, material
end
for i = 0, p.pairs - 1 do
  local s = i / (p.pairs - 1)
  local t, y = s * p.turns * 2 * math.pi, 6 * s - 3
  local a = rt.vec(math.cos(t), y, math.sin(t))
  local b = rt.vec(-a.x, y, -a.z)
  local kind = 1 + math.floor(4 * rt.random("base", i))
  rung(a, (a + b) / 2, bases[kind])
  rung(b, (a + b) / 2, bases[(kind + 1) % 4 + 1])
  for k = 0, 3 do  -- the strands: four beads a pair
    local q = (i + k / 4) / (p.pairs - 1)
    local u = q * p.turns * 2 * math.pi
    centers[#centers + 1] = {math.cos(u), 6 * q - 3, math.sin(u)}
    centers[#centers + 1] = {-math.cos(u), 6 * q - 3, -math.sin(u)}
    radii[#radii + 1], radii[#radii + 2] = 0.17, 0.17
  end
end

return rt.scene {
  settings = { width = 540, height = 810, samples = 16 },
  camera = rt.camera { eye = {4.4, 1.2, 8.6}, look_at = {0, 0.05, 0}, fov = 42 },
  ambient = {0.18, 0.18, 0.2},
  background = {0.12, 0.13, 0.17}, background_top = {0.03, 0.03, 0.06},
  rt.sphere_light { at = {6, 7, 7}, radius = 0.8, color = {0.95, 0.93, 0.88} },
  rt.point_light { at = {-7, 1, 3}, color = {0.15, 0.2, 0.3} },
  rt.cylinders(rungs), rt.spheres { centers = centers, radii = radii, material = rail },
}
