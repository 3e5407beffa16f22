-- scenes/pool.lua: path tracing among diffuse, mirror and glass balls under a wide sky
local rt = require "rt"

local materials = {
  function(c) return rt.classic { color = c, diffusion = 0.9 } end,
  function(c) return rt.classic { color = c, diffusion = 0.1, reflectiveness = 0.85 } end,
  function() return rt.classic { color = {1, 1, 1}, diffusion = 0, transparency = 0.9, reflectiveness = 0.1, refractiveness = 1.45 } end,
}

local balls = {}
for i = -4, 4 do
  for j = -4, 4 do
    local r = 0.25 + 0.2 * rt.random("r", i, j)
    local c = { 0.2 + 0.7 * rt.random("red", i, j), 0.2 + 0.7 * rt.random("green", i, j), 0.2 + 0.7 * rt.random("blue", i, j) }
    local x, z = i + 0.5 * rt.random("x", i, j) - 0.25, j + 0.5 * rt.random("z", i, j) - 0.25
    local make = materials[1 + math.floor(3 * rt.random("kind", i, j))]
    balls[#balls + 1] = rt.sphere { center = {x, r, z}, radius = r, material = make(c) }
  end
end

return rt.scene {
  settings = { width = 800, height = 450, samples = 64, integrator = "path", max_depth = 8 },
  camera = rt.camera { eye = {4.5, 2.6, 8.5}, look_at = {0, 0.2, 0.4}, fov = 34 },
  background = {0.75, 0.8, 0.85}, background_top = {0.35, 0.55, 0.9},
  rt.directional_light { direction = {-1, -1.6, -0.6}, color = {0.8, 0.72, 0.6} },
  rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.45, 0.46, 0.45}, diffusion = 0.9 } },
  balls,
}
