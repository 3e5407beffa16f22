-- Traces rays of its own: a depth picture in letters. lua5.4 rays.lua [columns]

local rt = require "rt"

local columns = tonumber(arg and arg[1]) or 72
local rows = columns // 2

local scene = rt.scene {
  rt.torus { center = { 0, 0, 0 }, axis = { 0.3, 1, 0.8 }, major_radius = 1, minor_radius = 0.4 },
  rt.sphere { center = { 0, 0, 0 }, radius = 0.45 },
}

-- Eight numbers a ray: org, tmin, dir, tmax. All go through the scene in one call.
local rays = rt.buffer("f32", 8 * columns * rows)
for y = 0, rows - 1 do
  for x = 0, columns - 1 do
    local px, py = 3.2 * ((x + 0.5) / columns - 0.5), 3.2 * (0.5 - (y + 0.5) / rows)
    rays:set(8 * (y * columns + x) + 1, px, py, 4, 0, 0, 0, -1, math.huge)
  end
end
local t = scene:intersect(rays).t

local letters = "@%#*+=-:."
for y = 0, rows - 1 do
  local line = {}
  for x = 1, columns do
    local depth = t[y * columns + x]
    local k = math.floor((depth - 2.6) / 2 * #letters) + 1
    line[x] = depth == math.huge and " " or letters:sub(math.max(1, math.min(k, #letters)), math.max(1, math.min(k, #letters)))
  end
  print((table.concat(line):gsub("%s+$", "")))
end
