-- One run of a sweep, by request: what a script describes with some values, or one timed render. Requests and answers are plain tables, so that they
-- can go to a process of their own as JSON lines (sweep_run.serve) or be answered here.

local core = require "rt.core"
local axis = require "rt.axis"
local check = require "rt.check"
local guard = require "rt.guard"
local json = require "rt.json"
local run = require "rt.run"
local scene = require "rt.scene"
local settings = require "rt.settings"

local sweep_run = {}

local KINDS = { "camera", "shadow", "reflect", "refract", "diffuse", "ao" }

-- ---- values between processes ----

-- Bytes that are no UTF-8 would not come through JSON: such texts travel as hexadecimal digits.
local function pack(text)
  if utf8.len(text) then
    return text
  end
  return json.object():set("hex", (text:gsub(".", function(c)
    return ("%02x"):format(c:byte())
  end)))
end

local function unpack_text(value)
  if type(value) == "table" then
    return (value.hex:gsub("%x%x", function(digits)
      return string.char(tonumber(digits, 16))
    end))
  end
  return value
end

sweep_run.pack, sweep_run.unpack = pack, unpack_text

local function pack_pairs(list)
  local packed = {}
  for i, pair in ipairs(list or {}) do
    packed[i] = { pack(pair[1]), type(pair[2]) == "string" and pack(pair[2]) or pair[2] }
  end
  return packed
end

local function unpack_pairs(list)
  local unpacked = {}
  for i, pair in ipairs(list or {}) do
    unpacked[i] = { unpack_text(pair[1]), unpack_text(pair[2]) }
  end
  return unpacked
end

local TEXTS = { "kind", "scene", "set", "image", "raw", "measure", "label" }
local LISTS = { "parameters", "settings", "fixed" }

-- A request as one line.
function sweep_run.line_of(request)
  local o = json.object()
  for _, key in ipairs(TEXTS) do
    o:set(key, request[key] and pack(request[key]))
  end
  for _, key in ipairs(LISTS) do
    o:set(key, pack_pairs(request[key]))
  end
  return json.encode(o:set("seed", request.seed)) .. "\n"
end

local function request_of(line)
  local t, why = json.decode(line)
  if type(t) ~= "table" then
    error("the request is no JSON object: " .. tostring(why), 0)
  end
  local request = { seed = t.seed }
  for _, key in ipairs(TEXTS) do
    request[key] = unpack_text(t[key])
  end
  for _, key in ipairs(LISTS) do
    request[key] = unpack_pairs(t[key])
  end
  return request
end

-- ---- a script's scene ----

-- Crop is a table among texts.
local function setting_of(name, value)
  if type(value) ~= "string" then
    return value
  elseif name == "crop" then
    local x, y, w, h = value:match "^(%d+),(%d+),(%d+),(%d+)$"
    local n = function(text) return math.tointeger(tonumber(text)) end
    return { x = n(x), y = n(y), width = n(w), height = n(h) }
  end
  return settings.read(name, value, "sweep")
end

local function settings_of(request)
  local t = {}
  for _, list in ipairs { request.fixed or {}, request.settings or {} } do
    for _, pair in ipairs(list) do
      local value = setting_of(pair[1], pair[2])
      if pair[1] == "size" then
        t.width, t.height = value[1], value[2]
      else
        t[pair[1]] = value
      end
    end
  end
  return t
end

-- The scene and its run. request.scene is a path, or a function of the parameters' values.
local function open(request, more)
  local overrides, given = {}, settings_of(request)
  for _, pair in ipairs(request.parameters or {}) do
    overrides[pair[1]] = pair[2]
  end
  for name, value in next, more or {} do
    given[name] = value
  end
  if type(request.scene) == "function" then
    local r = run.new(nil, { settings = given })
    r.folder = run.current() and run.current().folder or ""
    local made = run.call(r, request.scene, request.values or overrides)
    if type(made) == "table" and getmetatable(made) == nil then
      made = run.call(r, scene.new, made)
    end
    return made, r
  end
  -- A path from a command line is relative to where the program runs, whatever script is running here.
  local load = require "rt.load"
  return load.load(run.absolute(request.scene), overrides, { set = request.set, settings = given, seed = request.seed or 0 })
end

local function check_scene(value, request)
  if not scene.is(value) then
    local what = type(request.scene) == "string" and request.scene or "the function"
    error(("%s gives %s; a sweep takes a script that returns a scene"):format(what, check.describe(value)), 0)
  end
  return value
end

-- The settings that hold, as pairs of texts in their order.
local function effective(made)
  local values, list = made:effective(), {}
  for _, row in ipairs(settings.list) do
    local value = values[row.name]
    if row.name == "crop" and value then
      value = ("%d,%d,%d,%d"):format(value.x, value.y, value.width, value.height)
    end
    if value ~= nil then
      list[#list + 1] = { row.name, axis.text(value) }
    end
  end
  return list
end

-- A parameter's declaration as plain values.
local function declared(p)
  return {
    name = p.name, type = p.type, min = p.min, max = p.max, step = p.step, choices = p.choices, help = p.help, default = axis.text(p.default),
  }
end

-- ---- requests ----

local answers = {}

-- What the script describes: { params, description, settings }.
function answers.describe(request)
  local made, r = open(request, { accel = "brute" }) -- no tree has a part in the hash
  check_scene(made, request)
  local answer = { params = {}, sets = check.sorted_keys(r.sets), description = made:hash(), settings = {} }
  for i, p in ipairs(r.params) do
    answer.params[i] = declared(p)
  end
  r.settings = settings_of(request)
  answer.settings = effective(made)
  if type(request.scene) ~= "function" then
    made:release()
  end
  return answer
end

local function measured_by(request, image, stats)
  if not request.measure then
    return {}
  end
  local f = request.measure
  if type(f) == "string" then
    local chunk, why = loadfile(f, "t")
    f = chunk and chunk() or error(why or f .. ": a measure file returns a function (image, stats, point)", 0)
    if type(f) ~= "function" then
      error(("%s: a measure file must return a function (image, stats, point) that gives { name = value }; it returns %s"):format(request.measure,
        check.describe(f)), 0)
    end
  end
  return sweep_run.columns_of(f, image, stats, sweep_run.point_of(request))
end

-- What a measure function is told of the point.
function sweep_run.point_of(request)
  local point = { label = request.label, values = {} }
  for _, list in ipairs { request.parameters or {}, request.settings or {} } do
    for _, pair in ipairs(list) do
      point.values[pair[1]] = tonumber(pair[2]) or pair[2]
    end
  end
  return point
end

-- Calls a measure function: its columns as pairs, by name.
function sweep_run.columns_of(f, image, stats, point)
  local got = f(image, stats, point)
  if type(got) ~= "table" then
    error(("measure must return a table { name = value }; it returned %s"):format(check.describe(got)), 0)
  end
  local list = {}
  for i, name in ipairs(check.sorted_keys(got)) do
    local value = got[name]
    if type(name) ~= "string" or not name:find "^[%a_][%w_]*$" then
      error(("measure: %s is no name of a column; it takes letters, digits and _"):format(check.describe(name)), 0)
    elseif type(value) ~= "number" and type(value) ~= "string" and type(value) ~= "boolean" then
      error(("measure: %s must be a number, a text or a boolean; got %s"):format(name, check.describe(value)), 0)
    end
    list[i] = { name, type(value) == "boolean" and tostring(value) or value }
  end
  return list
end

-- An image's pixels for another process; read by sweep_run.read_raw.
local function write_raw(image, path)
  local width, height = image:size()
  local file = assert(io.open(path .. ".part", "wb"))
  assert(file:write(("librt pixels %d %d\n"):format(width, height), core.image_bytes(image)))
  assert(file:close())
  assert(os.rename(path .. ".part", path))
end

-- The image again; nil when there is none.
function sweep_run.read_raw(path)
  local file = io.open(path, "rb")
  if not file then
    return nil
  end
  local width, height = (file:read "l" or ""):match "^librt pixels (%d+) (%d+)$"
  local bytes = width and file:read "a"
  file:close()
  return bytes and core.image_from(math.tointeger(tonumber(width)), math.tointeger(tonumber(height)), bytes) or nil
end

-- One render: the columns of a run.
function answers.run(request)
  local begun = core.clock()
  local made, r = open(request)
  check_scene(made, request)
  local ours <close> = type(request.scene) ~= "function" and made or nil -- a function may give the same scene again
  local loaded = core.clock()
  local values = made:effective()
  if values.accel == "auto" and values.tracer ~= "auto" then
    r.settings.accel = values.tracer -- only the structure that is used is built
  end
  made:commit()
  local committed = core.clock()
  local description = made:hash()
  local image, stats = made:render { progress = request.progress }
  local width, height = image:size()
  local busy = {}
  for i, w in ipairs(stats.per_worker) do
    busy[i] = w.busy_seconds
  end
  local usage = core.usage()
  local answer = {
    description = description, width = width, height = height, hash = image:hash(), per_worker = busy, seconds = stats.seconds,
    build_seconds = committed - loaded + stats.build_seconds, load_seconds = loaded - begun, rays = stats.rays,
    rays_per_second = stats.seconds > 0 and stats.rays / stats.seconds or 0, nodes = stats.nodes, tests = stats.tests, workers = stats.workers,
    memory_bytes = stats.memory, peak_memory_bytes = usage.max_rss, user_seconds = usage.user_seconds, system_seconds = usage.system_seconds,
    bytes_moved = stats.bytes_moved or 0,
  }
  for _, kind in ipairs(KINDS) do
    answer["rays_" .. kind] = stats["rays_" .. kind]
  end
  answer.measured = measured_by(request, image, stats)
  if request.image then
    local texts = type(request.scene) == "string" and guard.texts({ scene = made, run = r }, values, request) or {}
    for _, key in ipairs(check.sorted_keys(texts)) do
      image:set_text(key, texts[key])
    end
    image:set_text("Software", "librt " .. (core.version()))
    image:set_text("Point", utf8.len(request.label) and request.label or check.describe(request.label))
    image:set_text("Hash", answer.hash)
    guard.own(request.image)
    image:save(request.image)
  end
  if request.raw then
    write_raw(image, request.raw)
  end
  image:release()
  return answer, ours
end

-- Answers a request: the answer, or nil and a message.
function sweep_run.answer(request)
  guard.restart()
  local results = table.pack(pcall(answers[request.kind], request))
  if results[1] then
    return results[2]
  end
  local raised = guard.told(results[2])
  return nil, type(raised) == "table" and raised.message or tostring(raised)
end

-- ---- the other process ----

local RUN_KEYS = {
  "description", "width", "height", "hash", "seconds", "build_seconds", "load_seconds", "rays", "rays_camera", "rays_shadow", "rays_reflect",
  "rays_refract", "rays_diffuse", "rays_ao", "rays_per_second", "nodes", "tests", "workers", "memory_bytes", "peak_memory_bytes", "user_seconds",
  "system_seconds", "bytes_moved", "per_worker",
}
sweep_run.keys = RUN_KEYS

local PARAM_KEYS = { "name", "type", "min", "max", "step", "choices", "help", "default" }

local function encode_answer(answer)
  local o = json.object()
  for _, key in ipairs(RUN_KEYS) do
    o:set(key, answer[key])
  end
  if answer.params then
    local list = {}
    for i, p in ipairs(answer.params) do
      list[i] = json.object()
      for _, key in ipairs(PARAM_KEYS) do
        local value = p[key]
        list[i]:set(key, type(value) == "string" and pack(value) or value)
      end
    end
    o:set("params", list):set("settings", pack_pairs(answer.settings))
  end
  return o:set("measured", answer.measured and pack_pairs(answer.measured))
end

-- What came back as a line: as sweep_run.answer gives it.
function sweep_run.read_answer(line)
  local t, why = json.decode(line)
  if type(t) ~= "table" then
    return nil, "the run answered with something else than JSON: " .. tostring(why)
  elseif t.error then
    return nil, unpack_text(t.error)
  end
  t.settings, t.measured = t.settings and unpack_pairs(t.settings), t.measured and unpack_pairs(t.measured)
  for _, p in ipairs(t.params or {}) do
    for _, key in ipairs(PARAM_KEYS) do
      local value = p[key]
      p[key] = type(value) == "table" and value.hex and unpack_text(value) or value
    end
  end
  return t
end

-- Answers requests from standard input, a line each, on what standard output was when it started; what scripts print goes to standard error.
function sweep_run.serve(write)
  io.output(io.stderr)
  function _G.print(...)
    local texts = table.pack(...)
    for i = 1, texts.n do
      texts[i] = tostring(texts[i])
    end
    io.stderr:write(table.concat(texts, "\t"), "\n")
  end
  for line in io.stdin:lines() do
    local ok, request = pcall(request_of, line)
    local answer, why
    if ok then
      answer, why = sweep_run.answer(request)
    else
      why = request
    end
    write(json.encode(answer and encode_answer(answer) or json.object():set("error", pack(why))) .. "\n")
  end
end

return sweep_run
