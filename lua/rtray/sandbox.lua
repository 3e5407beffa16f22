-- What a script of the program can reach. A script runs in an environment of its own, made anew for each run, so that nothing it does to a global or
-- a library reaches the program. In the sandbox (the default) the environment is the whitelist below, and guard.c judges every file that is opened
-- on the script's behalf; --trust gives the script all libraries.

local limits = require "rtray.limits"
local sys = require "rtray.sys"
local guard = require "rt.guard"
local run = require "rt.run"
local words = require "rt.words"

local sandbox = {}

-- ---- the whitelist ----

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
local LIBRARY_NAMES = { "coroutine", "io", "math", "os", "string", "table", "utf8" }

-- Names of the module rt. What is not named is not there: a part that starts programs or opens files past the renderer's context must not come in
-- unseen (a test asks for each name).
local MODULE = {
  version = true, build = true, scene = true, load_snapshot = true, render = true, camera = true, point_light = true, sphere_light = true,
  directional_light = true, classic = true, emissive = true, texture = true, sphere = true, spheres = true, plane = true, box = true, cylinder = true,
  cone = true, torus = true, mesh = true, polyhedron = true, group = true, instance = true, vec = true, srgb = true, transform = true,
  translate = true, scale = true, rotate = true, buffer = true, image = true, image_text = true, compare = true, random = true, contact_sheet = true,
  label_size = true, animation = true, keys = true, ease = true, quat = true, path = true, orbit = true, look_at = true, params = true, load = true,
  main = true, configure = true, machine = true, counts = true, drop_kept = true, integrators = true, tracers = true, settings = true, on_log = true,
}

local COLLECT = { collect = true, count = true, step = true, isrunning = true, generational = true, incremental = true }

local function not_there(name)
  return function()
    error(name .. " is not there for a script in the sandbox; `rtray --trust` runs one with everything", 2)
  end
end

-- A library whose every name says why it is not there.
local function absent(name)
  return setmetatable({}, {
    __index = function(_, key)
      error(("%s.%s is not there for a script in the sandbox; `rtray --trust` runs one with everything"):format(name, tostring(key)), 2)
    end,
  })
end

-- ---- what scripts print ----

local stream = io.stdout

-- Standard output carries an image or JSON: what scripts print goes to standard error.
function sandbox.print_to(file)
  stream = file
end

-- A script must not steer the user's terminal.
local function write(file, text)
  if sys.is_terminal(file == io.stdout and 1 or 2) then
    text = words.visible(text)
  end
  return file:write(text)
end

-- Two methods of a file that is the program's.
local function facade(file)
  local self = {}
  function self.write(_, ...)
    for i = 1, select("#", ...) do
      local text = select(i, ...)
      if type(text) ~= "string" and type(text) ~= "number" then
        error(("bad argument #%d to 'write' (string expected, got %s)"):format(i, type(text)), 2)
      end
      write(file(), tostring(text))
    end
    return self
  end
  function self.flush()
    file():flush()
    return self
  end
  function self.setvbuf()
    return true
  end
  return self
end

local function print_to_stream(...)
  local texts = table.pack(...)
  for i = 1, texts.n do
    texts[i] = tostring(texts[i])
  end
  write(stream, table.concat(texts, "\t") .. "\n")
end

-- ---- texts that stand in for files: the scripts inside of an image (replay) ----

local texts = {} -- absolute path -> text

function sandbox.stand_in(path, text)
  texts[run.absolute(path)] = text
end

local function text_of(path)
  return texts[run.absolute(path)]
end
sandbox.stands_in = text_of

-- What guard.open gives for a text: the methods of a file that readers use.
local function text_file(text)
  local at = 1
  return {
    read = function(_, n)
      if at > #text then
        return n == "a" and "" or nil
      end
      local part = text:sub(at, n == "a" and #text or at + n - 1)
      at = at + #part
      return part
    end,
    lines = function()
      return text:gmatch "([^\n]*)\n?"
    end,
    close = function()
      return true
    end,
  }
end

local scripts = {} -- path -> text, of scripts read since a run ended

-- The text of a script's file, or nil and the reason.
local function read(path)
  local file, why = guard.open(path)
  if not file then
    return nil, why
  end
  local text
  text, why = file:read "a"
  file:close()
  scripts[path] = text
  return text, text == nil and ("%s: %s"):format(path, tostring(why)) or nil
end

-- The text of a file of the program's, or nil.
function sandbox.text(path)
  local file = not text_of(path) and io.open(path, "rb")
  local text = text_of(path) or file and file:read "a"
  if file then
    file:close()
  end
  return text
end

-- ---- environments ----

-- The name of a chunk decides what counts as the module's own (guard.c, common.c).
local function chunk_name(name, text)
  if type(name) ~= "string" then
    return type(text) == "string" and text or "=(load)"
  end
  return (name:gsub("^=rt", "=script rt"):gsub("^=line", "=script line"))
end

-- load, loadfile, dofile, require in env, for the run r; rt is the script's copy of the module. outside(name): what require gives for a module
-- that is not the script's own. Returns the function that loads a file.
local function add_loaders(env, r, rt, outside)
  local loaded = { _G = env, rt = rt }
  for _, name in ipairs(LIBRARY_NAMES) do
    loaded[name] = env[name]
  end

  local function compile(path)
    local text, why = read(path)
    if not text then
      return nil, why
    end
    text = text:gsub("^\xEF\xBB\xBF", ""):gsub("^#[^\n]*", "")
    return load(text, "@" .. path, "t", env)
  end

  function env.load(chunk, name, _, ...)
    local own = select("#", ...) > 0
    if own then
      return load(chunk, chunk_name(name, chunk), "t", (...))
    end
    return load(chunk, chunk_name(name, chunk), "t", env)
  end

  function env.loadfile(path, _, ...)
    local name = run.resolve(path)
    local text, why = read(name)
    if not text then
      return nil, why
    elseif select("#", ...) > 0 then
      return load(text, "@" .. name, "t", (...))
    end
    return compile(name)
  end

  function env.dofile(path)
    local chunk, why = compile(run.resolve(path))
    if not chunk then
      error(why, 0)
    end
    return chunk()
  end

  local busy = {}

  -- The module's file below the script's folder, or nil and what was tried.
  local function find(name)
    local tried = {}
    local base = r.folder .. name:gsub("%.", "/")
    for i, path in ipairs { base .. ".lua", base .. "/init.lua" } do
      if text_of(path) or sys.stat(path) == "file" then
        return path
      end
      tried[i] = ("\n\tno file '%s'"):format(path)
    end
    return nil, table.concat(tried)
  end

  function env.require(name)
    if type(name) ~= "string" then
      error(("bad argument #1 to 'require' (string expected, got %s)"):format(type(name)), 2)
    elseif loaded[name] ~= nil then
      return loaded[name]
    elseif busy[name] then
      error(("module '%s' requires itself"):format(words.quote(name)), 2)
    end
    local path, tried = find(name)
    if not path then
      return outside(name, tried)
    end
    local chunk, why = compile(path)
    if not chunk then
      error(("error loading module '%s' from file '%s':\n\t%s"):format(words.quote(name), path, why), 2)
    end
    r.files[#r.files + 1] = path
    r.modules = r.modules or {}
    r.modules[#r.modules + 1] = path
    busy[name] = true
    local value = chunk(name, path)
    busy[name] = nil
    loaded[name] = value == nil and true or value
    return loaded[name], path
  end

  return compile
end

local metas = setmetatable({}, { __mode = "k" }) -- metatables that scripts have set

-- Metatables of the module's objects and of strings are the program's.
local function add_metatables(env)
  function env.getmetatable(value)
    local meta = getmetatable(value)
    if type(meta) ~= "table" or metas[meta] then
      return meta
    end
    local name = rawget(meta, "__name")
    return { __name = type(name) == "string" and name or nil }
  end

  function env.setmetatable(t, meta)
    if type(t) ~= "table" or meta ~= nil and type(meta) ~= "table" then
      return setmetatable(t, meta) -- raises as it does
    end
    local old = getmetatable(t)
    if type(old) == "table" and not metas[old] then
      error("the metatable of " .. tostring(rawget(old, "__name") or "this value") .. " cannot be changed in the sandbox", 2)
    elseif meta and rawget(meta, "__gc") ~= nil then
      error("__gc is not there for a script in the sandbox: a finalizer would run at any time; use a variable with <close>", 2)
    end
    setmetatable(t, meta)
    if meta then
      metas[meta] = true
    end
    return t
  end
end

-- Names of files that are read are relative to the script, of files that are written to the output folder.
local function add_files(env, io_table)
  local function name_of(path, mode)
    if type(path) ~= "string" then
      error(("a file name must be a string; got a %s"):format(type(path)), 3)
    elseif (mode or "r"):find "^rb?$" then
      return run.resolve(path)
    end
    return path
  end

  function io_table.open(path, mode)
    return sys.guard_open(name_of(path, mode), mode)
  end

  function io_table.lines(path, ...)
    if path == nil then
      error("io.lines needs a file name for a script in the sandbox; standard input is not there", 2)
    end
    local file, why = sys.guard_open(name_of(path))
    if not file then
      error(why, 2)
    end
    local next_line = file:lines(...)
    return function()
      local found = table.pack(next_line())
      if found[1] == nil and io.type(file) == "file" then
        file:close()
      end
      return table.unpack(found, 1, found.n)
    end
  end

  io_table.stdout = facade(function() return stream end)
  io_table.stderr = facade(function() return io.stderr end)
  function io_table.write(...)
    return io_table.stdout:write(...)
  end
  function io_table.close(file)
    return file:close()
  end
  env.io = io_table
end

local function copy_rt()
  local copy = {}
  for name, value in next, require "rt" do
    copy[name] = value
  end
  return copy
end

-- A table of the settings' rows is shared with the program; the handler of the log is the program's.
local function sandboxed_rt()
  local rt = copy_rt()
  for name in next, rt do
    rt[name] = MODULE[name] and rt[name] or not_there("rt." .. name)
  end
  local settings, on_log = rt.settings, rt.on_log
  function rt.settings()
    local list = settings()
    for _, row in ipairs(list) do
      row.choices = row.choices and table.move(row.choices, 1, #row.choices, 1, {})
    end
    return list
  end
  local own
  function rt.on_log(f)
    local before = own
    own = nil
    on_log(f)
    own = f
    return before
  end
  return rt
end

local function pick(name, library)
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

local function sandboxed(r)
  local env = pick("", _G)
  for _, name in ipairs(LIBRARY_NAMES) do
    env[name] = pick(name, _G[name])
  end
  env._G = env
  env.print = print_to_stream
  env.debug, env.package = absent "debug", absent "package"
  function env.warn(...)
    local text = table.concat { ... }
    if text:sub(1, 1) ~= "@" then
      write(io.stderr, "Lua warning: " .. text .. "\n")
    end
  end
  function env.collectgarbage(what, ...)
    what = what == nil and "collect" or what
    if not COLLECT[what] then
      error(("collectgarbage '%s' is not there for a script in the sandbox"):format(words.quote(tostring(what))), 2)
    end
    return collectgarbage(what, ...)
  end
  add_metatables(env)
  add_files(env, env.io)
  return add_loaders(env, r, sandboxed_rt(), function(name, tried)
    error(("module '%s' not found:%s\n\ta script in the sandbox requires rt and .lua files below its folder; --trust allows more"):format(
      words.quote(name), tried), 3)
  end)
end

-- Everything, but in tables that are not the program's.
local function trusted(r)
  local env = {}
  for name, value in next, _G do
    if type(value) == "table" and name ~= "package" then
      local copy = {}
      for key, item in next, value do
        copy[key] = item
      end
      value = copy
    end
    env[name] = value
  end
  env._G = env
  if stream ~= io.stdout then
    env.print = print_to_stream
  end
  local compile = add_loaders(env, r, copy_rt(), require)
  local load_any, loadfile_any = load, loadfile
  function env.load(chunk, name, mode, ...)
    return load_any(chunk, name, mode, select("#", ...) > 0 and (...) or env)
  end
  function env.loadfile(path, mode, ...)
    return loadfile_any(path, mode, select("#", ...) > 0 and (...) or env)
  end
  function env.dofile(path)
    local chunk, why = loadfile_any(path, nil, env)
    if not chunk then
      error(why, 0)
    end
    return chunk()
  end
  return compile
end

-- ---- switching it on ----

local strings, dump = getmetatable "", string.dump

local trust = false

function guard.load(r)
  local compile = trust and trusted(r) or sandboxed(r)
  local chunk, why = compile(r.path)
  if not chunk and type(why) == "string" and text_of(r.path) == nil and not why:find(r.path, 1, true) then
    why = r.path .. ": " .. why
  end
  return chunk, why
end

function guard.open(path)
  local text = text_of(path)
  if text then
    return text_file(text)
  elseif sys.guard_on() then
    return sys.guard_open(path, "rb")
  end
  return io.open(path, "rb")
end

guard.phase = sys.phase

local phases = {}

local reads = setmetatable({}, { __mode = "k" }) -- run -> { [path] = text of a script, or true }

-- What the script of a run and those that it loaded have read: { [path] = text of a script | true }. Kept apart from the run, which scripts reach.
function sandbox.reads(r)
  reads[r] = reads[r] or {}
  return reads[r]
end

function guard.depth(change, r)
  sys.guard_depth(change)
  if change > 0 then
    phases[#phases + 1] = sys.phase "in the script"
    return
  end
  sys.phase(table.remove(phases))
  local outermost = r
  for _ = 1, 200 do
    outermost = outermost.outer or outermost
  end
  local list = sandbox.reads(outermost)
  for _, path in ipairs(sys.guard_reads()) do
    list[path] = list[path] or true
  end
  for path, text in next, scripts do
    list[path] = text
  end
  scripts = {}
end

local function folder_of(path)
  return path:match "^(.*/)[^/]*$" or "."
end

-- The options of `values` that guard, as a command line has them, for another process.
function sandbox.arguments(values)
  local list = {}
  for _, define in ipairs(values.define or {}) do
    list[#list + 1] = "-D" .. define.name .. "=" .. define.text
  end
  if values.trust then
    list[#list + 1] = "--trust"
  end
  for _, folder in ipairs(values.allow_read or {}) do
    list[#list + 1] = "--allow-read=" .. folder
  end
  if values.limit then
    list[#list + 1] = "--limit=" .. values.limit.text
  end
  return list
end

-- Takes the options: { trust, allow_read = { folders }, define = { { name, text } }, output } for the scene at `path`. Raises a fault of the command
-- line when a folder is none.
function sandbox.configure(path, values, fault)
  trust = values.trust == true
  sys.guard_on(not trust)
  strings.__metatable, string.dump = nil, dump -- luacheck: ignore 122
  if not trust then
    strings.__metatable = false -- its __index is the program's string library
    string.dump = nil -- luacheck: ignore 122
  end
  sys.guard_file(path)
  local folder = folder_of(path)
  if sys.real_path(folder) ~= "/" then -- a scene in the root folder opens no machine
    sys.guard_folder(folder)
  end
  for _, name in ipairs(values.allow_read or {}) do
    local ok, why = sys.guard_open_folder(name)
    if not ok then
      fault("--allow-read '%s': %s", words.quote(name, 4096), why)
    end
  end
  for _, define in ipairs(not values.stranger and values.define or {}) do -- of replay they are the image's
    if sys.stat(define.text) == "file" then
      sys.guard_file(define.text)
    end
  end
  guard.restart = function()
    limits.start(values.limit)
  end
  guard.told = function(raised)
    return limits.told(raised) or raised
  end
  guard.arguments = sandbox.arguments(values)
  table.move({ "--", path }, 1, 2, #guard.arguments + 1, guard.arguments)
  guard.restart()
  local output = values.output or values.folder
  if output and output ~= "-" then
    sys.guard_output(sys.stat(output) == "folder" and output or folder_of(output))
  end
end

return sandbox
