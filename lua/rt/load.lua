-- Running scene scripts, and showing mesh files.

local core = require "rt.core"
local check = require "rt.check"
local guard = require "rt.guard"
local run = require "rt.run"
local params = require "rt.params"
local settings = require "rt.settings"
local scene = require "rt.scene"
local words = require "rt.words"

local load = {}

local KINDS = { lua = true, sdf = true, rts = true, ply = true, obj = true, stl = true }
local ENDINGS = "known are .lua, .sdf, .ply, .obj, .stl and .rts (a saved scene)"

local function useless(path, value)
  if value == nil then
    error(path .. ": the script returns nothing; its last line must return a scene, as in `return rt.scene { ... }`", 0)
  elseif type(value) ~= "table" and type(value) ~= "function" then
    error(("%s: the script returns %s; it must return a scene, as in `return rt.scene { ... }`"):format(path, check.describe(value)), 0)
  end
end

-- A list of objects is a scene without a word about camera and light.
local function as_scene(value)
  if type(value) == "table" and getmetatable(value) == nil then
    return scene.new(value)
  end
  return value
end

local function run_script(r)
  local chunk, message = guard.load(r)
  if not chunk then
    if not message:find(r.path, 1, true) then -- Lua names no file for bytecode, for one
      message = r.path .. ": " .. message
    end
    error(message, 0)
  end
  local value = run.call(r, chunk)
  if value == nil then
    value = r.main_value
  end
  useless(r.path, value)
  return value
end

local option_fields = {
  set = check.string, seed = check.integer { low = math.mininteger, high = math.maxinteger },
  settings = function(value, who) return settings.check(value, who .. ": settings") end,
}

local function no_params(r, what)
  for _, name in ipairs(check.sorted_keys(r.overrides)) do
    error(("-D %s: %s declares no parameters"):format(name, what), 0)
  end
  if r.set then
    error(("--set %s: %s declares no sets"):format(words.quote(r.set), what), 0)
  end
end

-- Makes r the run of a script within `outer`: the command line reaches scripts that scripts load.
local function enter(r, outer)
  r.outer = outer
  for name, value in pairs(outer and outer.settings or {}) do
    if r.settings[name] == nil then
      r.settings[name] = value
    end
  end
  while outer do
    if outer.path == r.path then
      check.fail("%s loads itself", words.quote(r.path))
    end
    outer = outer.outer
  end
end

-- The value of the file of run r.
local function value_of(r, path, ending)
  if ending == "lua" then
    local value = run_script(r)
    params.check_used(r)
    return run.call(r, as_scene, value) -- a table of the script's may have functions of its own
  end
  no_params(r, "a file of this kind")
  if ending == "rts" then
    return run.call(r, scene.load_snapshot, run.absolute(path))
  elseif ending == "sdf" then
    r.folder = ""
    return run.call(r, require("rt.sdf_scene").load, require "rt", path)
  end
  return run.call(r, require("rt.present").load, run.absolute(path), path)
end

-- What a script that loads a file which cannot be opened is told: its own line. The file alone has none.
local function not_there(path)
  local where = core.where()
  local file, why = guard.open(path)
  if file then
    file:close()
  elseif where ~= "" then
    return ("%srt.load: %s"):format(where, why)
  end
end

-- rt.load(path, { ior = 1.7 }, { set = "draft", settings = { samples = 1 }, seed = 0 }): what the script returns, and the run: path, params (a list
-- of { name, type, value, default, source, min, max, step, choices, help }) and sets. Parameters may be given as texts, as on a command line.
-- Mesh files, old scene definitions and saved scenes give a scene.
function load.load(path, overrides, options)
  check.string(path, "rt.load", "the path")
  local given = check.fields(check.plain_table(options or {}, "rt.load", "{ set = 'draft' }"), option_fields, "rt.load")
  given.overrides = {}
  for key, value in next, check.plain_table(overrides or {}, "rt.load", "{ ior = 1.7 }") do
    given.overrides[check.string(key, "rt.load", "a parameter's name")] = value
  end
  path = run.resolve(path)
  local r = run.new(path, given)
  enter(r, run.current())
  if given.seed then
    math.randomseed(given.seed)
  end
  local ending = (path:match "%.([^./]*)$" or ""):lower()
  if not KINDS[ending] then
    check.fail("%s: the file's kind is not known by its ending; %s", words.quote(path), ENDINGS)
  end
  local ok, value = pcall(value_of, r, path, ending)
  if not ok then
    error(not_there(path) or value, 0)
  end
  return value, r
end

-- rt.main(value) at the end of a script: under rtray and rt.load it only hands the value on; started as `lua5.4 scene.lua ...`, the script becomes a
-- program with rtray's options for rendering.
function load.main(value)
  local r = run.current()
  if not (r and run.is_program(r)) then
    if r then
      r.main_value = value
    end
    return value
  end
  useless(r.path, value)
  params.check_used(r)
  return require("rt.main")(as_scene(value), r)
end
return load
