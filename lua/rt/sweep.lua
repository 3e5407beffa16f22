-- rt.sweep { scene = "paper.lua", over = { ior = "1:2.5:0.25", workers = {1, 2} }, runs = 5, output = "report" }: renders a scene at every point of a
-- grid of parameters and settings, measures each several times, and keeps tables, images and facts in a folder. docs/sweep.md says what it promises.

local axis = require "rt.axis"
local check = require "rt.check"
local facts = require "rt.facts"
local presets = require "rt.sweep_presets"
local run = require "rt.run"
local settings = require "rt.settings"
local sweep_again = require "rt.sweep_again"
local sweep_folder = require "rt.sweep_folder"
local sweep_plan = require "rt.sweep_plan"
local sweep_work = require "rt.sweep_work"
local sweep_worker = require "rt.sweep_worker"
local words = require "rt.words"

local sweep = {}

-- ---- what is wanted ----

local function parameters_of(value)
  local list = {}
  for i, name in ipairs(check.sorted_keys(value or {})) do
    list[i] = { name, axis.text(value[name]) }
  end
  return list
end

local fields = {
  scene = function(value, who, key)
    return type(value) == "function" and value or check.string(value, who, key)
  end,
  over = function(value, who, key)
    return check.plain_table(value, who .. ": " .. key, "{ ior = '1:2:0.5', workers = {1, 2} }")
  end,
  runs = check.integer { low = 1, high = 100000 }, warmup = check.integer { low = 0, high = 1000 }, zip = check.boolean, in_process = check.boolean,
  measure = function(value, who, key)
    return type(value) == "function" and value or check.string(value, who, key)
  end,
  reference = check.string, output = check.string, set = check.string, seed = check.integer { low = math.mininteger, high = math.maxinteger },
  preset = check.choice { "jpvm", "strong", "weak", "structures", "tiles" }, images = check.boolean, timeout = check.number { above = 0 },
  report = check.boolean, restart = check.boolean, force = check.boolean, wait = check.boolean, progress = check.callable, note = check.callable,
  interrupted = check.callable,
  parameters = function(value, who, key) return check.plain_table(value, who .. ": " .. key, "{ ior = 1.5 }") end,
  settings = function(value) return require("rt.settings").check(value, "rt.sweep: settings") end,
  command = check.plain_table, title = check.string, dry = check.boolean,
}

-- The axes that are asked for, in their order: list items { name, values } first, then keys by name.
local function asked(over)
  local list = {}
  for _, pair in ipairs(over) do
    list[#list + 1] = pair
  end
  for _, name in ipairs(check.sorted_keys(over)) do
    if type(name) == "string" then
      local values = over[name]
      list[#list + 1] = { name, (type(values) == "string" or type(values) == "table") and values or { values } }
    end
  end
  return list
end

local function with_preset(list, preset, described)
  if not preset then
    return list
  end
  local numbers, named, all = {}, {}, {}
  for _, pair in ipairs(described.settings) do
    numbers[pair[1]] = tonumber(pair[2])
  end
  for _, pair in ipairs(list) do
    named[pair[1]] = pair
  end
  for _, pair in ipairs(preset.axes(numbers)) do
    all[#all + 1] = named[pair[1]] or pair
    named[pair[1]] = nil
  end
  for _, pair in ipairs(list) do
    all[#all + 1] = named[pair[1]] and pair or nil
  end
  return all
end

-- What kind the values of a function's parameter are: by the first of a list, or by how a text begins.
local function implied_type(values)
  local first = type(values) == "table" and values[1]
  if type(values) == "table" then
    return type(first) == "string" and "string" or type(first) == "boolean" and "boolean" or "number"
  end
  return values:find "^[+-]?%.?%d" and "number" or "string"
end

-- A function gets the axes' values by name; what is no setting's name is a parameter.
local function implied(list)
  local declared = {}
  local known = {}
  for _, row in ipairs(axis.settings()) do
    known[row.name] = true
  end
  for _, pair in ipairs(list) do
    if not known[pair[1]] then
      declared[#declared + 1] = { name = pair[1], type = implied_type(pair[2]) }
    end
  end
  return declared
end

local function title_of(s)
  local names = {}
  for i, a in ipairs(s.axes) do
    names[i] = a.name
  end
  return s.scene_name:match "[^/]*$" .. (#names > 0 and " over " .. table.concat(names, ", ") or "")
end

-- A path in a script is relative to the script.
local function path_of(path)
  local r = run.current()
  return r and path:sub(1, 1) ~= "/" and run.absolute(r.folder .. path) or path
end

local function prepare(t)
  local s = check.fields(t, fields, "rt.sweep")
  check.required(s, { "scene" }, "rt.sweep")
  local live = type(s.scene) == "function"
  s.over, s.count, s.warmup, s.images = asked(s.over or {}), s.runs, s.warmup or 0, s.images ~= false
  s.runs, s.keeper, s.note = {}, {}, s.note or function() end
  s.in_process = s.in_process or live
  s.preset = s.preset and presets[s.preset]
  s.zip = s.zip or s.preset and s.preset.zip or false
  if not s.in_process and not sweep_worker.can_spawn() then
    check.fail("rt.sweep: this is no rtray and no Lua interpreter, so runs have no processes of their own; in_process = true does without")
  end
  s.scene_name = live and "function" or s.scene
  s.base = {
    scene = live and s.scene or path_of(s.scene),
    parameters = parameters_of(s.parameters), fixed = {}, set = s.set, seed = s.seed, mode = s.in_process and "in-process" or "process",
    measure_file = type(s.measure) == "string" and s.measure or nil, measure_hash = sweep_plan.measure_hash(s.measure),
  }
  for _, name in ipairs(check.sorted_keys(s.settings or {})) do
    local value = s.settings[name]
    value = name == "crop" and ("%d,%d,%d,%d"):format(value.x, value.y, value.width, value.height) or value
    s.base.fixed[#s.base.fixed + 1] = { name, value }
  end
  if s.timeout and s.in_process then
    check.fail("rt.sweep: a timeout ends processes of runs, and with in_process there are none")
  elseif s.reference and not s.output then
    check.fail("rt.sweep: a reference is kept in the output folder; output is missing")
  end
  return s
end

-- Whether the sweep is there for its times: an axis leaves the picture as it is.
local function is_timed(axes)
  for _, a in ipairs(axes) do
    if a.kind == "setting" and settings.arrangement[a.name] then
      return true
    end
  end
  return false
end

-- A word when other work will be in the times.
local function warn_busy(s)
  local load, cpus = s.machine.load, s.machine.cpus
  if load and load > cpus / 2 and is_timed(s.axes) and not s.in_process then
    s.note(("other work is running (load %s on %d CPUs); times will be longer and less even than this machine's own"):format(
      words.number(load), cpus))
  end
end

-- Axes, points, keys.
local function plan(s)
  local described = { params = {}, settings = {} }
  if type(s.scene) ~= "function" then
    local request = { label = "" }
    local p = { values = {}, label = "" }
    sweep_plan.request(p, {}, s.base)
    for key, value in next, p.request do
      request[key] = value
    end
    request.kind = "describe"
    local answer, why = sweep_work.ask(s, request)
    described = answer or error({ status = 1, message = why }, 0)
  else
    described.params = implied(s.over)
  end
  s.axes = {}
  for i, pair in ipairs(with_preset(s.over, s.preset, described)) do
    if type(pair[1]) ~= "string" or type(pair[2]) ~= "string" and type(pair[2]) ~= "table" then
      check.fail("rt.sweep: over[%d] must be { name, values }", i)
    end
    s.axes[i] = axis.new(pair[1], pair[2], described.params)
  end
  s.points = axis.points(s.axes, s.zip)
  s.count = s.count or is_timed(s.axes) and 3 or 1
  s.title = s.title or title_of(s)
  if s.reference then
    sweep_plan.references(s.points, s.axes, s.reference)
  end
  sweep_plan.name_images(s.points, s.axes)
end

local function open_store(s)
  s.machine = facts.machine()
  if s.output then
    s.store = sweep_folder.open(s.output, s.scene_name, s)
    s.runs, s.machine, s.machines = s.store.runs, s.store.machine, s.store.machine_list
    if s.images then
      s.store:sub_folder "images"
    end
    if s.reference then
      s.store:sub_folder "reference"
    end
  else
    s.machines = { s.machine }
  end
  s.image_hash = function(p)
    local first = s.runs[p.key] and s.runs[p.key][1]
    return first and first.hash
  end
end

local function measure(s)
  sweep_work.describe(s)
  if s.store then
    sweep_again.keep(s)
  end
  sweep_work.work(s)
end

-- Tables and page of what was found until it ended; quickly, for somebody has pressed Ctrl-C.
local function leave(s)
  if s.store then
    local results = sweep_work.results_of(s)
    sweep_work.write_tables(s, results)
    if s.report ~= false then
      require("rt.report").write(s.output, { plots = false, sheets = false }, results)
    end
  end
end

local function execute(t)
  local s = prepare(t)
  local store <close> = setmetatable({}, { __close = function()
    sweep_worker.release(s.keeper)
    if s.store then
      s.store:release()
    end
  end })
  plan(s)
  if s.dry then
    return s
  end
  open_store(s)
  warn_busy(s)
  local ok, raised = pcall(measure, s)
  if not ok then
    pcall(leave, s) -- that it ends is the greater news
    error(raised, 0)
  end
  local results = sweep_work.results_of(s)
  sweep_work.write_tables(s, results)
  if s.store and s.report ~= false then
    results.report = require("rt.report").write(s.output, nil, results)
  end
  return results, store
end

-- The results as docs/sweep.md describes them for results.json. Raises { status, message } for the program.
sweep.execute = execute

-- rt.sweep { ... }: the results. What is wrong with the sweep raises a message; points that fail say so in the results.
function sweep.sweep(t)
  check.plain_table(t, "rt.sweep", "rt.sweep { scene = 'paper.lua', over = { ior = '1:2:0.5' } }")
  local ok, results = pcall(execute, t)
  if not ok then
    if type(results) == "table" and results.message then
      check.fail("rt.sweep: %s", (results.message:gsub("^%-%-over ", "over ")))
    end
    error(results, 0)
  end
  return (results)
end

return sweep
