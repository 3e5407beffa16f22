-- scenes/glass.lua: coloured glass tints its shadow
local rt = require "rt"

local p = rt.params { ior = { 1.5, min = 1, max = 2.5, help = "index of refraction" } }

local function glass(r, g, b)
  return rt.classic { color = {r, g, b}, refractiveness = p.ior, transparency = 0.88, reflectiveness = 0.12, diffusion = 0, specular = 0.9, shininess = 400 }
end

local balls = {}
for i = 0, 6 do
  local turn = math.rad(i * 360 / 7)
  local function wave(k) return 0.35 + 0.65 * (0.5 + 0.5 * math.cos(turn - k * 2 * math.pi / 3)) end
  balls[#balls + 1] = rt.sphere { center = {2.1 * math.cos(turn), 0.62, 2.1 * math.sin(turn)}, radius = 0.62, material = glass(wave(0), wave(1), wave(2)) }
end

return rt.scene {
  settings = { width = 800, height = 500, samples = 16, max_depth = 10 },
  camera = rt.camera { eye = {0, 3.6, 7.5}, look_at = {0, 0.35, 0}, fov = 36 },
  ambient = {0.14, 0.14, 0.15},
  background = {0.9, 0.92, 0.95}, background_top = {0.45, 0.6, 0.8},
  rt.sphere_light { at = {-3, 7, -3}, radius = 0.5, color = {1, 0.97, 0.9} },
  rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.8, 0.79, 0.76}, diffusion = 0.9 } },
  balls,
  rt.torus { center = {0, 0.45, 0}, axis = {0, 1, 0}, major_radius = 0.8, minor_radius = 0.32, material = glass(0.95, 0.97, 1) },
}
