-- What a script of the program can reach. A script runs in an environment of its own, made anew for each run, so that nothing it does to a global or
-- a library reaches the program. In the sandbox (the default) the environment is a whitelist (sandbox_lists.lua), and guard.c judges every
-- file that is opened on the script's behalf; --trust gives the script all libraries.

local limits = require "rtray.limits"
local sys = require "rtray.sys"
local guard = require "rt.guard"
local env_of = require "rtray.sandbox_env"
local texts = require "rtray.sandbox_texts"
local words = require "rt.words"

local sandbox = {}

sandbox.print_to, sandbox.stand_in, sandbox.stands_in, sandbox.text = texts.print_to, texts.stand_in, texts.of, texts.text

local strings, dump = getmetatable "", string.dump

local trust = false

function guard.load(r)
  local compile = trust and env_of.trusted(r) or env_of.sandboxed(r)
  local chunk, why = compile(r.path)
  if not chunk and type(why) == "string" and texts.of(r.path) == nil and not why:find(r.path, 1, true) then
    why = r.path .. ": " .. why
  end
  return chunk, why
end

function guard.open(path)
  local text = texts.of(path)
  if text then
    return texts.file(text)
  elseif sys.guard_on() then
    return sys.guard_open(path, "rb")
  end
  return io.open(path, "rb")
end

guard.phase, guard.own = sys.phase, sys.guard_own

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
  for _ = 1, 200 do -- scripts reach the run, and could make a ring of it
    local outer = rawget(outermost, "outer")
    outermost = type(outer) == "table" and outer or outermost
  end
  local list = sandbox.reads(outermost)
  for _, path in ipairs(sys.guard_reads()) do
    list[path] = list[path] or true
  end
  for path, text in next, texts.take_scripts() do
    list[path] = text
  end
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
  guard.texts = function(opened, settings, request)
    return require("rtray.report").texts_of_sweep(opened, settings, request)
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
