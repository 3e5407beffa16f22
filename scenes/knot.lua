-- scenes/knot.lua: a mesh made in the script: a tube along a torus knot, with smooth normals
local rt = require "rt"

local p = rt.params { p = { 2, min = 1, max = 9 }, q = { 3, min = 1, max = 9 } }

local along, around, radius = 480, 32, 0.33

local function point(s)
  local t = 2 * math.pi * s
  local r = 2 + math.cos(p.q * t) * 0.85
  return rt.vec(r * math.cos(p.p * t), r * math.sin(p.p * t), -0.85 * math.sin(p.q * t))
end

local vertices, normals, faces = {}, {}, {}
for i = 0, along - 1 do
  local c, ahead = point(i / along), point((i + 1e-3) / along)
  local t = (ahead - c):normalize()
  local a = t:cross(rt.vec(0, 0, 1)):normalize()
  local b = t:cross(a)
  for k = 0, around - 1 do
    local w = 2 * math.pi * k / around
    local n = a * math.cos(w) + b * math.sin(w)
    vertices[#vertices + 1], normals[#normals + 1] = c + n * radius, n
    local i2, k2 = (i + 1) % along, (k + 1) % around
    local a1, b1, b2, a2 = i * around + k + 1, i2 * around + k + 1, i2 * around + k2 + 1, i * around + k2 + 1
    faces[#faces + 1], faces[#faces + 2] = {a1, b1, b2}, {a1, b2, a2}
  end
end

return rt.scene {
  settings = { width = 720, height = 720, samples = 16 },
  camera = rt.camera { eye = {1.5, 2.5, 9.5}, look_at = {0, -0.1, 0}, fov = 40 },
  ambient = {0.12, 0.12, 0.14},
  background = {0.16, 0.18, 0.24}, background_top = {0.05, 0.06, 0.1},
  rt.sphere_light { at = {5, 7, 8}, radius = 1, color = {1, 0.95, 0.85} },
  rt.point_light { at = {-8, -2, 4}, color = {0.2, 0.25, 0.4} },
  rt.plane { point = {0, -3.6, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.3, 0.3, 0.34}, diffusion = 0.8, reflectiveness = 0.2 } },
  rt.mesh { vertices = vertices, normals = normals, faces = faces,
    material = rt.classic { color = {0.85, 0.5, 0.3}, diffusion = 0.7, reflectiveness = 0.15, specular = 0.6, shininess = 90 } },
}
