-- The run of a script: where its files lie, what the command line asks of it. This file also stands between a script and the module on the
-- stack: C looks for the script's line no further up than here (common.c).

local core = require "rt.core"
local guard = require "rt.guard"

local run = {}
local current
local program -- the run of the script that lua5.4 was started with

-- path: the script's file; folder: what relative names in it are relative to, "" or with a final slash.
function run.new(path, options)
  return {
    path = path, folder = path and path:match "^(.*/)[^/]*$" or "",
    overrides = options and options.overrides or {},  -- parameters by name, texts or values
    set = options and options.set,                     -- name of the chosen set
    settings = options and options.settings or {},     -- what the command line sets
    params = {}, sets = {}, used = {},
    files = {}, -- what the script named or required, besides itself
  }
end

function run.current()
  return current
end

-- A file name in a script is relative to the script.
function run.resolve(name)
  if current and name:sub(1, 1) ~= "/" and name ~= "-" then
    name = current.folder .. name
  end
  if current then
    current.files[#current.files + 1] = name
  end
  return name
end

-- A file name from the command line is relative to where the program runs.
function run.absolute(name)
  return name:sub(1, 1) == "/" and name or core.cwd() .. "/" .. name
end

-- Calls f(...) as part of run r. package.path is headed by the script's folder meanwhile; modules found there do not outlive the run.
function run.call(r, f, ...)
  local before_run, before_path = current, package.path
  local loaded, own = {}, r.folder .. "?.lua;" .. r.folder .. "?/init.lua"
  for name in next, package.loaded do
    loaded[name] = true
  end
  package.path = own .. ";" .. before_path
  current = r
  guard.depth(1)
  local results = table.pack(pcall(f, ...))
  guard.depth(-1, r)
  current, package.path = before_run, before_path
  for name in next, package.loaded do
    local file = type(name) == "string" and not loaded[name] and not package.preload[name] and package.searchpath(name, own)
    if file then
      package.loaded[name] = nil
      r.files[#r.files + 1] = file
    end
  end
  if not results[1] then
    local raised = results[2]
    if type(raised) ~= "string" then
      raised = ("%s: the script raised a %s instead of a message"):format(tostring(r.path), type(raised))
    end
    error(raised, 0)
  end
  return table.unpack(results, 2, results.n)
end

-- The function that asked for the module: past C and the module's own.
local function requirer()
  local level = 2
  while true do
    local info = debug.getinfo(level, "S")
    if not info or info.what ~= "C" and info.source:sub(1, 4) ~= "=rt/" then
      return info
    end
    level = level + 1
  end
end

-- When the module is first required by the script that lua5.4 was started with, that script is a program whose command line is `arg`.
function run.detect_program()
  local info = requirer()
  local arguments = rawget(_G, "arg")
  if current or not info or info.what ~= "main" or type(arguments) ~= "table" or info.source ~= "@" .. tostring(arguments[0]) then
    return
  end
  local r = run.new(arguments[0])
  program = r
  local i = 1
  while arguments[i] do
    local option, text = tostring(arguments[i]), arguments[i + 1]
    if option == "-D" or option == "--define" then
      option, i = "-D" .. tostring(text), i + 1
    elseif option == "--set" then
      option, i = "--set=" .. tostring(text), i + 1
    end
    local name, value = option:match "^%-D([%a_][%w_]*)=(.*)$"
    if name then
      r.overrides[name] = value
    end
    r.set = option:match "^%-%-set=(.*)$" or r.set
    i = i + 1
  end
  current = r
end

-- "file:line: " of the last `return` within a function, whose tail call took it from the stack; of its head when there is none.
function run.place_of(f)
  local info = debug.getinfo(f, "S")
  local path = info.source:match "^@(.*)$"
  if not path then
    return ""
  end
  local last
  local file = guard.open(path)
  if file then
    local number = 0
    for line in file:lines() do
      number = number + 1
      if number >= info.linedefined and number <= info.lastlinedefined and (line:find "^%s*return%f[%W]" or line:find "%f[%w]return%f[%W].*end") then
        last = number
      end
    end
    file:close()
  end
  return ("%s:%d: "):format(path, last or info.linedefined)
end

function run.is_program(r)
  return r == program
end

-- `return rt.scene { ... }` is a tail call, which takes the script from the stack: its place is then that last `return`.
core.on_lost_place(function()
  if not current or not current.path then
    return ""
  elseif current.inner then -- an animation's scene function runs
    return run.place_of(current.inner)
  end
  local last
  local file = guard.open(current.path)
  if file then
    local number = 0
    for line in file:lines() do
      number = number + 1
      if line:find "^return%f[%W]" then
        last = number
      end
    end
    file:close()
  end
  return last and ("%s:%d: "):format(current.path, last) or current.path .. ": "
end)

return run
