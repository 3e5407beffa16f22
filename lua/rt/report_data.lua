-- What a report shows, from results.json or what that was written from: every value is checked or left out, so that what comes after can trust it.

local json = require "rt.json"
local words = require "rt.words"

local data = {}

local MOST_BYTES = 1 << 30

local function list(value)
  return type(value) == "table" and value or {}
end

local function string_or(value, other)
  if type(value) == "string" then
    return json.utf8(value)
  elseif math.type(value) then
    return tostring(value)
  end
  return other
end

local function finite(value)
  return math.type(value) and value == value and math.abs(value) ~= math.huge and value + 0.0 or nil
end

local function strings(value)
  local copy = {}
  for i, item in ipairs(list(value)) do
    copy[i] = string_or(item, "?")
  end
  return copy
end

-- Numbers and texts of a { column: value }.
local function cells(value, columns)
  local copy = {}
  for _, column in ipairs(columns) do
    local v = list(value)[column.name]
    if column.type == "text" then
      copy[column.name] = string_or(v)
    else
      copy[column.name] = finite(v)
    end
  end
  return copy
end

-- Only files below the folder are shown: no address, no way out.
local function safe_image(path)
  if type(path) ~= "string" or path == "" or #path > 1024 or path:find "^/" or path:find "%z" or path:find "\\" then
    return nil
  end
  for part in path:gmatch "[^/]+" do
    if part == ".." or part == "." then
      return nil
    end
  end
  return path
end

local function read_axes(value)
  local axes = {}
  for _, a in ipairs(list(value)) do
    if type(a) == "table" and type(a.name) == "string" then
      axes[#axes + 1] = { name = a.name, kind = a.kind == "setting" and "setting" or "parameter", values = strings(a.values),
        help = string_or(a.help) }
    end
  end
  return axes
end

local function read_columns(value)
  local columns = {}
  for _, c in ipairs(list(value)) do
    if type(c) == "table" and type(c.name) == "string" then
      columns[#columns + 1] = {
        name = c.name, unit = string_or(c.unit, ""), help = string_or(c.help), per = c.per == "point" and "point" or "run",
        type = c.type == "text" and "text" or "number",
      }
    end
  end
  return columns
end

local function busy(value)
  local copy = {}
  for i, v in ipairs(list(value)) do
    copy[i] = finite(type(v) == "table" and v.busy_seconds or v) or 0
  end
  return copy
end

local function read_point(p, index, study)
  local point = {
    index = index, key = string_or(p.key, tostring(index)), values = {}, status = string_or(p.status, "missing"), message = string_or(p.message),
    image = safe_image(string_or(p.image)), map = safe_image(string_or(p.map)),
    width = finite(p.width), height = finite(p.height), hash = string_or(p.hash), runs = #list(p.runs),
    oversubscribed = p.oversubscribed == true, mixed = p.mixed == true, machine = math.tointeger(p.machine), per_worker = busy(p.per_worker),
    median = cells(p.median, study.columns), q1 = cells(p.q1, study.columns), q3 = cells(p.q3, study.columns),
    derived = cells(p.derived, study.columns),
  }
  local parts = {}
  for i, axis in ipairs(study.axes) do
    point.values[axis.name] = string_or(list(p.values)[axis.name], "")
    parts[i] = axis.name .. "=" .. point.values[axis.name]
  end
  point.label = #parts > 0 and table.concat(parts, ", ") or string_or(p.label, "the scene")
  return point
end

local function read_groups(value, study)
  local groups = {}
  for _, g in ipairs(list(value)) do
    if type(g) == "table" then
      local group = { kind = g.kind == "weak" and "weak" or "strong", baseline = study.by_key[string_or(g.baseline, "")], points = {}, fit = nil }
      for _, key in ipairs(strings(g.points)) do
        group.points[#group.points + 1] = study.by_key[key]
      end
      local fit = list(g.fit)
      if finite(fit.serial_seconds) and finite(fit.parallel_seconds) then
        group.fit = { serial = finite(fit.serial_seconds), parallel = finite(fit.parallel_seconds), fraction = finite(fit.serial_fraction),
          r2 = finite(fit.r2) }
      end
      groups[#groups + 1] = group
    end
  end
  return groups
end

-- The facts of a machine in their order, as { name, value }; lists and objects are told in words by report_facts.
local function machine(value)
  return type(value) == "table" and value or {}
end

-- The study of a sweep's results, or of a decoded results.json: the same, whichever it is made of.
function data.from(t, who)
  if type(t) ~= "table" then
    error(who .. " holds no object; it is not what a sweep writes", 0)
  elseif t.format ~= 1 then
    error(("%s has the format '%s'; this librt reads format 1"):format(who, words.quote(string_or(t.format, "none"))), 0)
  end
  local study = {
    title = string_or(t.title), command = strings(t.command), scene = string_or(t.scene, ""), version = string_or(t.version),
    build = string_or(t.build),
    zip = t.zip == true, mode = string_or(t.mode), preset = string_or(t.preset), runs = finite(t.runs), warmup = finite(t.warmup),
    reference = string_or(t.reference),
    axes = read_axes(t.axes), columns = read_columns(t.columns), points = {}, by_key = {}, conflicts = {}, machine = machine(t.machine),
    machines = {}, by_column = {},
  }
  for _, column in ipairs(study.columns) do
    study.by_column[column.name] = column
  end
  for i, p in ipairs(list(t.points)) do
    local point = read_point(list(p), i, study)
    study.points[i], study.by_key[point.key] = point, point
  end
  for i, c in ipairs(list(t.conflicts)) do
    study.conflicts[i] = string_or(list(c).message, "images differ that should be equal")
  end
  for i, m in ipairs(list(t.machines)) do
    study.machines[i] = machine(m)
  end
  study.groups = read_groups(t.groups, study)
  study.title = study.title or study.scene:match "[^/]*$"
  study.title = study.title ~= "" and study.title or "Sweep"
  return study
end

local function named(path)
  return "'" .. words.quote(path, 4096) .. "'"
end

-- Results as sweep_work.results_of gives them.
function data.of(results)
  local machine_facts = results.machine
  return data.from(setmetatable({ format = 1, version = machine_facts.version, build = machine_facts.build }, { __index = results }), "a sweep")
end

function data.read(path)
  local file, why = io.open(path, "rb")
  if not file then
    error(("%s cannot be read: %s; a report is made from the folder that `rtray sweep -o` has written"):format(named(path),
      tostring(why):gsub("^.*: ", "")), 0)
  end
  local content, fault = file:read(MOST_BYTES)
  file:close()
  if not content and fault then
    error(("%s cannot be read: %s"):format(named(path), fault), 0)
  end
  local value, reason = json.decode(content or "")
  if value == nil then
    error(("%s is no JSON: %s"):format(named(path), reason or "it is null"), 0)
  end
  return data.from(value, named(path))
end

-- A value of a point: the median of a column of runs, or what was derived.
function data.value(point, column)
  local v = point.median[column]
  if v == nil then
    v = point.derived[column]
  end
  return math.type(v) and v or nil
end

return data
