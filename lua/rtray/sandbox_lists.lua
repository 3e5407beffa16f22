-- What a script in the sandbox has: the names of Lua's libraries and of the module rt.

local lists = {}

-- Names of each library: true: as it stands; false: a function that says why it is not there. What is not named is not there.
local LIBRARIES = {
  [""] = {
    assert = true, error = true, ipairs = true, next = true, pairs = true, pcall = true, rawequal = true, rawget = true, rawlen = true,
    rawset = true, select = true, tonumber = true, tostring = true, type = true, xpcall = true, _VERSION = true,
  },
  coroutine = {
    close = true, create = true, isyieldable = true, resume = true, running = true, status = true, wrap = true, yield = true,
  },
  math = {
    abs = true, acos = true, asin = true, atan = true, ceil = true, cos = true, deg = true, exp = true, floor = true, fmod = true, huge = true,
    log = true, max = true, maxinteger = true, min = true, mininteger = true, modf = true, pi = true, rad = true, random = true,
    randomseed = true, sin = true,
    sqrt = true, tan = true, tointeger = true, type = true, ult = true,
  },
  os = {
    clock = true, date = true, time = true,
    difftime = false, execute = false, exit = false, getenv = false, remove = false, rename = false, setlocale = false, tmpname = false,
  },
  io = { type = true, input = false, output = false, popen = false, read = false, tmpfile = false },
  string = {
    byte = true, char = true, find = true, format = true, gmatch = true, gsub = true, len = true, lower = true, match = true, pack = true,
    packsize = true, rep = true, reverse = true, sub = true, unpack = true, upper = true, dump = false,
  },
  table = { concat = true, insert = true, move = true, pack = true, remove = true, sort = true, unpack = true },
  utf8 = { char = true, charpattern = true, codepoint = true, codes = true, len = true, offset = true },
}
lists.LIBRARY_NAMES = { "coroutine", "io", "math", "os", "string", "table", "utf8" }

-- Names of the module rt. What is not named is not there: a part that starts programs or opens files past the renderer's context must not come in
-- unseen (a test asks for each name).
lists.MODULE = {
  version = true, build = true, scene = true, load_snapshot = true, render = true, camera = true, point_light = true, sphere_light = true,
  directional_light = true, classic = true, emissive = true, texture = true, sphere = true, spheres = true, plane = true, box = true, cylinder = true,
  cylinders = true, cone = true, cones = true, torus = true, mesh = true, polyhedron = true, group = true, instance = true, vec = true, srgb = true,
  transform = true, translate = true, scale = true, rotate = true, buffer = true, image = true, image_text = true, compare = true, random = true,
  contact_sheet = true, label_size = true, color_map = true,
  animation = true, motion = true, keys = true, ease = true, quat = true, path = true, orbit = true, look_at = true, params = true,
  load = true, main = true, configure = true, machine = true, counts = true, drop_kept = true, integrators = true,
  tracers = true, settings = true, on_log = true,
}

-- Of collectgarbage.
lists.COLLECT = { collect = true, count = true, step = true, isrunning = true, generational = true, incremental = true }

-- A function that says why it is not there.
local function not_there(name)
  return function()
    error(name .. " is not there for a script in the sandbox; `rtray --trust` runs one with everything", 2)
  end
end

lists.not_there = not_there

-- A library whose every name says why it is not there.
function lists.absent(name)
  return setmetatable({}, {
    __index = function(_, key)
      error(("%s.%s is not there for a script in the sandbox; `rtray --trust` runs one with everything"):format(name, tostring(key)), 2)
    end,
  })
end

-- The whitelisted names of a library.
function lists.pick(name, library)
  local names, picked = LIBRARIES[name], {}
  for key, there in next, names do
    local value = library[key]
    if there then
      picked[key] = value
    else
      picked[key] = not_there(name == "" and key or name .. "." .. key)
    end
  end
  return picked
end

return lists
