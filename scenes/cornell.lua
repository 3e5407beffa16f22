-- scenes/cornell.lua: a box with two blocks and a lamp, by path tracing: the walls light each other
local rt = require "rt"

local white, red, green = rt.classic { color = {0.73, 0.73, 0.73} }, rt.classic { color = {0.63, 0.06, 0.05} }, rt.classic { color = {0.14, 0.45, 0.09} }

local function wall(a, b, c, d, material)
  return rt.polyhedron { vertices = {a, b, c, d}, faces = { {1, 2, 3, 4} }, material = material }
end

-- A block standing on the floor: size x, y, z turned about +y and moved to (x, z).
local function block(size, turn, x, z)
  return rt.instance { rt.scene { rt.box { low = {-size[1] / 2, 0, -size[3] / 2}, high = {size[1] / 2, size[2], size[3] / 2}, material = white } },
    transform = rt.translate(x, 0, z) * rt.rotate({0, 1, 0}, turn) }
end

return rt.scene {
  settings = { width = 512, height = 512, samples = 64, integrator = "path", max_depth = 8 },
  camera = rt.camera { eye = {0, 1, 3.9}, look_at = {0, 1, 0}, fov = 38 },
  wall({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}, white),
  wall({-1, 2, 1}, {-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, white),
  wall({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1}, white),
  wall({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1}, red),
  wall({1, 0, 1}, {1, 2, 1}, {1, 2, -1}, {1, 0, -1}, green),
  block({0.6, 1.2, 0.6}, 18, -0.35, -0.35),
  block({0.6, 0.6, 0.6}, -17, 0.36, 0.35),
  rt.sphere_light { at = {0, 1.72, 0}, radius = 0.2, color = {1, 0.85, 0.6}, intensity = 12, falloff = "inverse_square" },
}
