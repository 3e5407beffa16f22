-- A sheet of water that moves: one scene whose mesh gets other vertices for each frame. lua5.4 waves.lua [frames] [file with %d]

local rt = require "rt"

local frames, file = tonumber(arg and arg[1]) or 24, arg and arg[2] or "waves-%d.png"
local N = 200

local vertices, faces = rt.buffer("f32", 3 * (N + 1) * (N + 1)), rt.buffer("u32", 6 * N * N)
for i = 0, N * N - 1 do
  local a = i // N * (N + 1) + i % N
  faces:set(6 * i + 1, a, a + N + 1, a + 1, a + 1, a + N + 1, a + N + 2)
end

-- Rings around two drops, and a swell.
local function flow(t)
  for i = 0, (N + 1) * (N + 1) - 1 do
    local x, z = 8 * (i % (N + 1)) / N - 4, 8 * (i // (N + 1)) / N - 4
    local r, s = math.sqrt((x + 1) ^ 2 + z ^ 2), math.sqrt((x - 2) ^ 2 + (z - 1) ^ 2)
    local y = 0.12 * math.cos(6 * (r - t)) / (1 + r) + 0.08 * math.cos(7 * (s - t)) / (1 + s) + 0.06 * math.sin(1.5 * z + 2 * t)
    vertices:set(3 * i + 1, x, y, z)
  end
  return vertices
end

local water = rt.mesh {
  vertices = flow(0), faces = faces, smooth = true,
  material = rt.classic { color = { 0.1, 0.35, 0.5 }, diffusion = 0.5, reflectiveness = 0.5, specular = 0.5, shininess = 200 },
}
local scene = rt.scene {
  settings = { width = 320, height = 200, samples = 4 },
  camera = rt.camera { eye = { 0, 2.5, 6 }, look_at = { 0, 0, 0 }, fov = 40 },
  background = { 0.8, 0.85, 0.9 }, background_top = { 0.3, 0.5, 0.8 },
  rt.directional_light { direction = { -1, -1, -1 } }, water,
}

for frame = 1, frames do
  if frame > 1 then
    scene:set_vertices(water, { vertices = flow(frame / 12) })
  end
  scene:render():save((file:gsub("%%d", frame)))
end
local counts = rt.counts()
print(("%d frames, %d trees built, %d refitted"):format(frames, counts.trees_built, counts.trees_refitted))
