-- The environments that scripts of the program run in, one for each run.

local core = require "rt.core"
local sys = require "rtray.sys"
local lists = require "rtray.sandbox_lists"
local missing = require "rt.missing"
local run = require "rt.run"
local texts = require "rtray.sandbox_texts"
local words = require "rt.words"

local env_of = {}

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
  for _, name in ipairs(lists.LIBRARY_NAMES) do
    loaded[name] = env[name]
  end

  local function compile(path)
    local text, why = texts.read(path)
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
    local text, why = texts.read(name)
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
    local base = r.folder .. name:gsub("%.", "/"):gsub("^/+", "") -- never from the root folder: what is there is not to be told
    for i, path in ipairs { base .. ".lua", base .. "/init.lua" } do
      if texts.of(path) or sys.stat(path) == "file" then
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

  io_table.stdout = texts.facade(texts.stream)
  io_table.stderr = texts.facade(function() return io.stderr end)
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
    rt[name] = lists.MODULE[name] and rt[name] or lists.not_there("rt." .. name)
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
  return missing.guess(rt)
end

-- The whitelist: an environment for the run r, and the function that loads a file into it.
function env_of.sandboxed(r)
  local env = lists.pick("", _G)
  for _, name in ipairs(lists.LIBRARY_NAMES) do
    env[name] = lists.pick(name, _G[name])
  end
  env._G = env
  env.print = texts.print
  env.debug, env.package = lists.absent "debug", lists.absent "package"
  function env.warn(...)
    local text = table.concat { ... }
    if text:sub(1, 1) ~= "@" then
      texts.write(io.stderr, "Lua warning: " .. text .. "\n")
    end
  end
  function env.collectgarbage(what, ...)
    what = what == nil and "collect" or what
    if not lists.COLLECT[what] then
      error(("collectgarbage '%s' is not there for a script in the sandbox"):format(words.quote(tostring(what))), 2)
    end
    return collectgarbage(what, ...)
  end
  add_metatables(env)
  add_files(env, env.io)
  return add_loaders(env, r, sandboxed_rt(), function(name, tried)
    error(("%smodule '%s' not found:%s\n\ta script in the sandbox requires rt and .lua files below its folder; --trust allows more"):format(
      core.where(), words.quote(name), tried), 0)
  end)
end

-- Everything, but in tables that are not the program's.
function env_of.trusted(r)
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
  if texts.stream() ~= io.stdout then
    env.print = texts.print
  end
  local compile = add_loaders(env, r, copy_rt(), function(name)
    local ok, value, more = pcall(require, name)
    if not ok then
      local nowhere = type(value) == "string" and value:find "^module '.-' not found:"
      error(nowhere and core.where() .. value or value, 0)
    end
    return value, more
  end)
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

return env_of
