-- scenes/flower.lua: the flowers of the paper's wall. flower.jpg is this picture: rtray render scenes/flower.lua -o scenes/flower.jpg
-- It repeats without a seam: what reaches over an edge is there again at the other one.
local rt = require "rt"

local EDGE = 12 -- the pattern repeats after so many units

local function paint(r, g, b) return rt.classic { color = {r, g, b}, diffusion = 0.9, specular = 0.15, shininess = 30 } end

local ball = rt.sphere { center = {0, 0, 0}, radius = 1 }

-- An ellipsoid of the given half axes, its inner end at the middle of the flower, raised by `tilt` degrees, turned to `angle`.
local function leaf(at, angle, tilt, long, wide, from, material)
  local shape = rt.scale(long, wide, 0.13 * wide + 0.05)
  local placed = rt.rotate({0, 0, 1}, angle) * rt.rotate({0, -1, 0}, tilt) * rt.translate(from + long, 0, 0) * shape
  return rt.instance { ball, transform = rt.translate(at[1], at[2], at[3]) * placed, material = material }
end

local function flower(x, y, z, size, turn, petals, color)
  local parts, at = {}, {x, y, z}
  for i = 0, 2 do
    parts[#parts + 1] = leaf({x, y, z - 0.5 * size}, turn + 40 + i * 120, -4, 0.95 * size, 0.3 * size, 0.7 * size, paint(0.16, 0.42, 0.14))
  end
  for i = 0, petals - 1 do
    local shade = 1 - 0.1 * (i % 2)
    local petal = paint(color[1] * shade, color[2] * shade, color[3] * shade)
    parts[#parts + 1] = leaf(at, turn + i * 360 / petals, 14 + 6 * (i % 2), 0.62 * size, 2.1 / petals * size, 0.2 * size, petal)
  end
  parts[#parts + 1] = rt.instance { ball, material = paint(0.95, 0.7, 0.1),
    transform = rt.translate(x, y, z + 0.2 * size) * rt.scale(0.36 * size, 0.36 * size, 0.24 * size) }
  return parts
end

local flowers = { -- x, y, z, size, turn, petals, colour
  { 2.6, 9.1, 1.0, 2.1, 10, 6, {0.86, 0.16, 0.2} }, { 8.4, 9.8, 1.2, 1.7, 0, 7, {0.95, 0.93, 0.88} },
  { 5.6, 5.4, 1.4, 2.3, 33, 8, {0.97, 0.62, 0.72} }, { 10.4, 5.9, 0.8, 1.6, 25, 5, {0.45, 0.35, 0.8} },
  { 1.2, 4.5, 0.9, 1.6, 50, 7, {0.98, 0.8, 0.25} }, { 3.4, 1.4, 1.1, 1.8, 18, 5, {0.95, 0.93, 0.88} },
  { 8.3, 1.7, 1.0, 2.0, 5, 6, {0.88, 0.3, 0.12} }, { 11.6, 11.6, 0.6, 1.4, 40, 6, {0.55, 0.55, 0.9} },
}

local repeated = {}
for _, f in ipairs(flowers) do
  for dx = -EDGE, EDGE, EDGE do
    for dy = -EDGE, EDGE, EDGE do
      local x, y, reach = f[1] + dx, f[2] + dy, 3 * f[4]
      repeated[#repeated + 1] = x > -reach and x < EDGE + reach and y > -reach and y < EDGE + reach
        and flower(x, y, f[3], f[4], f[5], f[6], f[7])
    end
  end
end

return rt.scene {
  settings = { width = 512, height = 512, samples = 64 },
  camera = rt.camera { projection = "orthographic", height = EDGE, eye = {EDGE / 2, EDGE / 2, 20}, look_at = {EDGE / 2, EDGE / 2, 0} },
  ambient = {0.3, 0.31, 0.34},
  rt.directional_light { direction = {0.5, -0.6, -1}, color = {0.75, 0.72, 0.66} },
  rt.plane { point = {0, 0, 0}, normal = {0, 0, 1}, material = paint(0.62, 0.78, 0.7) },
  repeated,
}
