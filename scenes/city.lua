-- scenes/city.lua: ambient occlusion over a thousand towers; every number comes from rt.random, so each run builds the same town
local rt = require "rt"

local towers = {}
for i = -16, 15 do
  for j = -16, 15 do
    local u, v, w = rt.random("height", i, j), rt.random("width", i, j), rt.random("depth", i, j)
    local far = math.sqrt(i * i + j * j) / 16
    local h = 0.3 + 5.5 * u ^ 3 * math.max(0, 1 - far)
    towers[#towers + 1] = rt.box { low = {i + 0.1 * v, 0, j + 0.1 * w}, high = {i + 0.55 + 0.35 * v, h, j + 0.55 + 0.35 * w} }
  end
end

return rt.scene {
  settings = { width = 960, height = 540, samples = 32, integrator = "ao", ao_distance = 4 },
  camera = rt.camera { eye = {-11, 8.5, 15}, look_at = {-0.5, 0.6, 0}, fov = 36 },
  background = {0.8, 0.85, 0.9}, background_top = {0.4, 0.55, 0.75},
  rt.plane { point = {0, 0, 0}, normal = {0, 1, 0} },
  towers,
}
