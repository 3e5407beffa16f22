-- rtray params SCRIPT: the declared parameters, and the sets.

local json = require "rtray.json"
local output = require "rtray.output"
local report = require "rtray.report"
local source = require "rtray.source"

local params = {}

local function value_text(value)
  value = report.parameter(value)
  if type(value) == "table" then
    return ("%g,%g,%g"):format(value[1], value[2], value[3])
  end
  return tostring(value)
end

local function limits(p)
  if p.choices then
    return table.concat(p.choices, " | ")
  elseif p.min and p.max then
    return ("%g ... %g"):format(p.min, p.max)
  elseif p.min then
    return ("%g or more"):format(p.min)
  elseif p.max then
    return ("%g or less"):format(p.max)
  end
  return ""
end

local function sorted_names(t)
  local names = {}
  for name in pairs(t) do
    names[#names + 1] = name
  end
  table.sort(names)
  return names
end

local function print_text(run)
  if #run.params == 0 then
    output.print("the script declares no parameters")
  else
    local rows = { { "name", "type", "value", "default", "limits", "from", "help" } }
    for _, p in ipairs(run.params) do
      rows[#rows + 1] = { p.name, p.type, value_text(p.value), value_text(p.default), limits(p), p.source, p.help or "" }
    end
    output.table(rows, { true, true, false, false, true, true, true })
  end
  for _, name in ipairs(sorted_names(run.sets)) do
    local set, parts = run.sets[name], {}
    for _, kind in ipairs { set.params, set.settings } do
      for _, key in ipairs(sorted_names(kind)) do
        parts[#parts + 1] = key .. " = " .. value_text(kind[key])
      end
    end
    output.print("set %s: %s", name, table.concat(parts, ", "))
  end
end

local function as_json(run)
  local list, sets = {}, json.object()
  for i, p in ipairs(run.params) do
    list[i] = json.object():set("name", p.name):set("type", p.type):set("value", report.parameter(p.value))
      :set("default", report.parameter(p.default)):set("source", p.source):set("min", p.min):set("max", p.max):set("step", p.step)
      :set("choices", p.choices):set("label", p.label):set("help", p.help)
  end
  for _, name in ipairs(sorted_names(run.sets)) do
    local set, values = run.sets[name], json.object()
    for _, kind in ipairs { set.params, set.settings } do
      for _, key in ipairs(sorted_names(kind)) do
        values:set(key, report.parameter(kind[key]))
      end
    end
    sets:set(name, values)
  end
  return json.object():set("params", list):set("sets", sets)
end

function params.run(command, values, arguments)
  local run = source.open(arguments[1], values, command).run
  if values.json then
    output.print("%s", json.encode(as_json(run)))
  else
    print_text(run)
  end
  return 0
end

return params
