-- Renders for a given time at most, showing the tiles that are done, and saves what there is. lua5.4 progress.lua [seconds] [file]

local rt = require "rt"

local seconds, file = tonumber(arg and arg[1]) or 2, arg and arg[2] or "progress.png"

local balls = {}
for i = 1, 400 do
  local function at(axis) return 8 * rt.random("ball", i, axis) - 4 end
  balls[i] = rt.sphere {
    center = { at "x", at "y", at "z" }, radius = 0.2 + 0.3 * rt.random("radius", i),
    material = rt.classic { color = { rt.random("r", i), rt.random("g", i), 1 }, reflectiveness = 0.3, diffusion = 0.7 },
  }
end
local scene = rt.scene { balls, rt.sphere_light { at = { 6, 9, 8 }, radius = 1 }, ambient = { 0.2, 0.2, 0.2 }, background = { 0.7, 0.8, 0.9 } }

local job <close> = scene:start { width = 640, height = 400, samples = 64 }
local finish = os.time() + seconds
for _ in job:tiles() do
  local _, done = job:poll()
  io.stderr:write(("\r%3d%%"):format(math.floor(100 * done)))
  if os.time() >= finish then
    job:cancel()
  end
end
io.stderr:write "\n"
local stats = job:stats()
job:image():save(file)
print(("%s: %d of %d tiles, %d rays"):format(file, stats.tiles_done, stats.tiles, stats.rays))
