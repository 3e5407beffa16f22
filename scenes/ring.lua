-- scenes/ring.lua: one gear-like solid, instanced sixty times: the memory of one, the picture of many
local rt = require "rt"

-- A star-shaped prism as one polyhedron: concave faces are fine.
local function star(points, inner, height)
  local vertices, top, bottom, faces = {}, {}, {}, {}
  local n = 2 * points
  for k = 0, n - 1 do
    local r, t = k % 2 == 0 and 1 or inner, k * math.pi / points
    vertices[k + 1] = {r * math.cos(t), height / 2, r * math.sin(t)}
    vertices[n + k + 1] = {r * math.cos(t), -height / 2, r * math.sin(t)}
  end
  for k = 1, n do
    top[k], bottom[k] = n + 1 - k, n + k
    faces[#faces + 1] = {k, k % n + 1, n + k % n + 1, n + k}
  end
  faces[#faces + 1], faces[#faces + 2] = top, bottom
  return rt.polyhedron { vertices = vertices, faces = faces }
end

local solid = rt.scene { star(6, 0.55, 0.5) }
local ring = {}
for i = 0, 59 do
  local t = i / 60 * 360
  local c = 0.5 + 0.5 * math.cos(math.rad(t))
  ring[#ring + 1] = rt.instance { solid,
    transform = rt.rotate({0, 1, 0}, t) * rt.translate(5, 0.9 * math.sin(math.rad(3 * t)), 0) * rt.rotate({0, 0, 1}, 4 * t) * rt.scale(0.55),
    material = rt.classic { color = {0.25 + 0.65 * c, 0.4, 0.9 - 0.65 * c}, diffusion = 0.75, reflectiveness = 0.12, specular = 0.4, shininess = 60 } }
end

return rt.scene {
  settings = { width = 960, height = 540, samples = 16 },
  camera = rt.camera { eye = {0, 5.5, 11.5}, look_at = {0, -0.3, 0}, fov = 38 },
  ambient = {0.16, 0.16, 0.18},
  background = {0.93, 0.93, 0.95}, background_top = {0.6, 0.68, 0.8},
  rt.sphere_light { at = {-4, 10, 6}, radius = 1, color = {0.9, 0.88, 0.82} },
  rt.plane { point = {0, -1.7, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.62, 0.62, 0.64}, diffusion = 0.85, reflectiveness = 0.1 } },
  ring,
}
