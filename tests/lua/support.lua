-- What the specs share. RT_TEST_GC=incremental|generational runs them with a collector that hardly ever rests.

local mode = os.getenv "RT_TEST_GC"
if mode == "incremental" then
  collectgarbage("incremental", 1, 1000)
elseif mode == "generational" then
  collectgarbage("generational", 1, 1)
end

local busy = mode ~= nil

local support = { rt = require "rt" }

support.scenes = os.getenv "LIBRT_SCENES" or "../shared/scenes"

-- n, or far less when the collector takes its time at every step.
function support.many(n)
  return busy and n // 200 or n
end

-- The message that f raises; fails when it raises none, or no string.
function support.message(f, ...)
  local ok, message = pcall(f, ...)
  assert(not ok, "nothing was raised")
  assert(type(message) == "string", "the message is a " .. type(message))
  return message
end

-- Asserts that f raises exactly `sentence`, after a place in the calling file.
function support.raises(sentence, f, ...)
  local message = support.message(f, ...)
  local place, rest = message:match "^([^:]+_spec%.lua:%d+): (.*)$"
  assert(place, "no place of a spec in: " .. message)
  assert(rest == sentence, ("expected: %s\n     got: %s"):format(sentence, rest))
end

-- A new folder for f(folder); it is removed afterwards.
function support.in_folder(f)
  local name = os.tmpname()
  os.remove(name)
  assert(os.execute("mkdir '" .. name .. "'"))
  local ok, message = pcall(f, name)
  os.execute("rm -r '" .. name .. "'")
  if not ok then
    error(message, 0)
  end
end

function support.write(path, text)
  local file = assert(io.open(path, "wb"))
  file:write(text)
  file:close()
  return path
end

-- A small scene: a ball over a floor under a lamp.
function support.ball(more)
  local rt = support.rt
  local t = {
    settings = { width = 32, height = 24, samples = 1, workers = 2, tile = 8 },
    camera = rt.camera { eye = { 0, 1, 5 }, look_at = { 0, 1, 0 }, fov = 45 },
    ambient = { 0.2, 0.2, 0.2 },
    rt.point_light { at = { 3, 5, 4 } },
    rt.sphere { center = { 0, 1, 0 }, radius = 1, name = "ball", material = rt.classic { color = { 1, 0.2, 0.1 } } },
    rt.plane { point = { 0, 0, 0 }, normal = { 0, 1, 0 }, name = "floor" },
  }
  for key, value in pairs(more or {}) do
    t[key] = value
  end
  return rt.scene(t)
end

return support
