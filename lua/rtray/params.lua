-- rtray params SCRIPT: the declared parameters, and the sets.

local json = require "rtray.json"
local output = require "rtray.output"
local report = require "rtray.report"
local source = require "rtray.source"

local params = {}

local value_text = require("rt.axis").text

-- Where the value comes from, and whom it has beaten.
local function winner(p, set)
  return p.overruled ~= nil and ("%s, over set %s's %s"):format(p.source, set, value_text(p.overruled)) or p.source
end

local function step_words(p)
  return p.step and (" by %g"):format(p.step) or ""
end

local function limits(p)
  if p.choices then
    return table.concat(p.choices, " | ")
  elseif p.min and p.max then
    return ("%g ... %g"):format(p.min, p.max) .. step_words(p)
  elseif p.min then
    return ("%g or more"):format(p.min) .. step_words(p)
  elseif p.max then
    return ("%g or less"):format(p.max) .. step_words(p)
  end
  return p.step and ("by %g"):format(p.step) or ""
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
      rows[#rows + 1] = { p.name, p.type, value_text(p.value), value_text(p.default), limits(p), winner(p, run.set), p.help or "" }
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

-- What programs that make forms read: JSON Schema (2020-12) of the values that -D takes. A step begins at the minimum, so it is no
-- multipleOf; the units of colours are linear.
local SHAPES = {
  number = { "number" }, integer = { "integer" }, boolean = { "boolean" }, choice = { "string" }, string = { "string" },
  file = { "string", format = "path" }, vector = { "array", items = {} }, color = { "array", items = { low = 0, high = 1 }, format = "color" },
}

local function property(p)
  local shape = SHAPES[p.type]
  local o = json.object():set("type", shape[1]):set("title", p.label):set("description", p.help):set("format", shape.format)
    :set("enum", p.choices):set("minimum", p.min):set("maximum", p.max):set("x-step", p.step)
  if shape.items then
    o:set("items", json.object():set("type", "number"):set("minimum", shape.items.low):set("maximum", shape.items.high)):set("minItems", 3)
      :set("maxItems", 3)
  end
  return o:set("default", report.parameter(p.default))
end

local function schema(run)
  local properties = json.object()
  for _, p in ipairs(run.params) do
    properties:set(p.name, property(p))
  end
  return json.object():set("$schema", "https://json-schema.org/draft/2020-12/schema"):set("type", "object"):set("properties", properties)
    :set("additionalProperties", false)
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
  return json.object():set("params", list):set("sets", sets):set("schema", schema(run))
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
