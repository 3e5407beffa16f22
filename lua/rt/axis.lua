-- Axes of a sweep: `workers=1,2,4`, `ior=1:2.5:0.25`, `size=500x500,1000x700`. An axis is a parameter that the script declares, or a setting; its
-- values are texts, as a command line has them, each in one form.

local check = require "rt.check"
local json = require "rt.json"
local params = require "rt.params"
local settings = require "rt.settings"
local words = require "rt.words"

local axis = {}

local MOST = 100000 -- values of an axis, and points of a sweep

-- What is no setting of a render and yet an axis. `read` gives the value's one form, or nil and what is expected; `env` is set for the run's process.
axis.extra = {
  {
    name = "size", type = "size", help = "width and height of the image in pixels",
    read = function(text)
      local size = settings.read("size", text, "--over")
      return ("%dx%d"):format(size[1], size[2])
    end,
  },
  { name = "set", type = "text", help = "one of the script's sets", read = function(text) return text end },
  {
    name = "transport", type = "choice", choices = { "threads" }, help = "what carries the work",
    read = function(text) return text == "threads" and text or nil, "threads (this build has no other)" end,
  },
}

-- Settings that have no text.
local NO_AXIS = { crop = true }

-- The settings that can be axes: { name, type, help, choices, low, high, read }.
function axis.settings()
  local list = {}
  for _, row in ipairs(axis.extra) do
    list[#list + 1] = row
  end
  for _, row in ipairs(settings.list) do
    if not NO_AXIS[row.name] then
      list[#list + 1] = {
        name = row.name, type = row.kind, help = row.help, choices = row.choices, low = row.low, high = row.high,
        read = function(text)
          return axis.text(settings.read(row.name, text, "--over"))
        end,
      }
    end
  end
  return list
end

-- A value as the text of a command line: numbers as short as they read back.
function axis.text(value)
  if type(value) == "number" then
    return math.tointeger(value) and ("%d"):format(value) or json.number(value)
  elseif type(value) == "table" or type(value) == "userdata" then
    return ("{%s,%s,%s}"):format(axis.text(value[1] or value.x), axis.text(value[2] or value.y), axis.text(value[3] or value.z))
  end
  return tostring(value)
end

-- ---- from text to items ----

-- Raises about the command line's axis; the script has no part in it.
local function fault(name, message, ...)
  error({ status = 2, message = ("--over %s: "):format(words.quote(name)) .. message:format(...), usage = "sweep" }, 0)
end
axis.fault = fault

-- Items between commas; braces hold together, quotes as in CSV. Each is { text, quoted }.
local function split(name, text)
  local items, at = {}, 1
  repeat
    local item, stop
    if text:sub(at, at) == '"' then
      local parts, from = {}, at + 1
      while true do
        local quote = text:find('"', from, true) or fault(name, "a quote has no end in '%s'", words.quote(text:sub(at)))
        parts[#parts + 1] = text:sub(from, quote - 1)
        if text:sub(quote + 1, quote + 1) ~= '"' then
          stop = quote + 1
          break
        end
        parts[#parts + 1], from = '"', quote + 2
      end
      item = { table.concat(parts), true }
      if stop <= #text and text:sub(stop, stop) ~= "," then
        fault(name, "behind the quoted value %s a comma is expected", check.describe(item[1]))
      end
    elseif text:sub(at, at) == "{" then
      stop = (text:find("}", at, true) or fault(name, "a brace has no end in '%s'", words.quote(text:sub(at)))) + 1
      item = { text:sub(at, stop - 1) }
      if stop <= #text and text:sub(stop, stop) ~= "," then
        fault(name, "behind %s a comma is expected", words.quote(item[1]))
      end
    else
      stop = text:find(",", at, true) or #text + 1
      item = { text:sub(at, stop - 1) }
    end
    if item[1] == "" and not item[2] then
      fault(name, text == "" and "there are no values; give some, as in %s=1,2,4" or "a value between the commas is empty", words.quote(name))
    end
    items[#items + 1] = item
    at = stop + 1
  until stop > #text
  return items
end

-- ---- ranges ----

-- As a person writes the number: without the last bits of a sum like 3 * 0.1.
local function round(x)
  local short = tonumber(("%.15g"):format(x))
  return math.tointeger(short) or short
end

local function count_check(name, count, text)
  if count > MOST or count ~= count then
    fault(name, "'%s' is %s values; at most %d are taken", words.quote(text), count < 1e15 and ("%.0f"):format(count) or ("%.3g"):format(count), MOST)
  end
end

local function finite(name, text, what)
  local x = tonumber(text)
  if not x or x ~= x or x == math.huge or x == -math.huge then
    fault(name, "%s must be a number; got '%s'", what, words.quote(text))
  end
  return x
end

local function linear(name, text, a, b, step)
  if step == 0 then
    fault(name, "the step of '%s' is zero", words.quote(text))
  elseif (b < a) ~= (step < 0) and a ~= b then
    fault(name, "from %s by steps of %s one never comes to %s; the step needs the other sign", axis.text(a), axis.text(step), axis.text(b))
  end
  local count = math.floor((b - 0.0 - a) / step * (1 + 1e-12) + 1e-9) + 1 -- not b - a: of large integers it wraps
  count_check(name, count, text)
  local list = {}
  if math.type(a) == "integer" and math.type(b) == "integer" and math.type(step) == "integer" then
    for x = a, b, step do -- exact, also above 2^53
      list[#list + 1] = x
    end
    return list
  end
  for i = 0, count - 1 do
    list[i + 1] = round(a + i * step)
  end
  return list
end

local function geometric(name, text, a, b, factor)
  if factor <= 0 or factor == 1 or a == 0 or a * b <= 0 or (math.abs(b) - math.abs(a)) * (factor - 1) < 0 then
    fault(name, "from %s by factors of %s one never comes to %s", axis.text(a), axis.text(factor), axis.text(b))
  end
  local count = math.floor(math.log(b / a) / math.log(factor) + 1e-9) + 1
  count_check(name, count, text)
  local list = {}
  for i = 0, count - 1 do
    list[i + 1] = round(a * factor ^ i)
  end
  return list
end

-- The numbers of "A:B", "A:B:STEP", "A:B:*FACTOR"; nil when the text is no range.
local function range(name, text, step)
  local a, b, by = text:match "^([^:]*):([^:]*):([^:]*)$"
  if not a then
    a, b = text:match "^([^:]*):([^:]*)$"
  end
  if not a then
    if text:find(":", 1, true) then
      fault(name, "'%s' is no range; one is FROM:TO:STEP or FROM:TO:*FACTOR", words.quote(text))
    end
    return nil
  end
  a, b = finite(name, a, "the first value of a range"), finite(name, b, "the last value of a range")
  if by and by:sub(1, 1) == "*" then
    return geometric(name, text, a, b, finite(name, by:sub(2), "the factor of a range"))
  end
  return linear(name, text, a, b, by and finite(name, by, "the step of a range") or step or 1)
end

local NUMERIC = { number = true, integer = true }

-- ---- values ----

-- Calls a reader of the module; what it raises is about the axis.
local function guarded(name, f, ...)
  local ok, value, expected = pcall(f, ...)
  if not ok then
    if type(value) == "table" then
      error(value, 0)
    end
    fault(name, "%s", (tostring(value):gsub("^.-%-%-over: ", "", 1))) -- a place in a script says nothing about an axis
  elseif value == nil then
    fault(name, "%s is expected", expected)
  end
  return value
end

-- One value in its one form.
local function one(row, text)
  if row.read then
    return guarded(row.name, row.read, text)
  end
  local value = guarded(row.name, params.value_of, row, text, "--over")
  return (row.type == "file" or row.type == "color" and text:sub(1, 1) == "#") and text or axis.text(value)
end

local function expand(row, text)
  local list = {}
  for _, item in ipairs(split(row.name, text)) do
    local numbers = NUMERIC[row.type] and not item[2] and range(row.name, item[1], row.step)
    if numbers then
      for _, x in ipairs(numbers) do
        list[#list + 1] = one(row, axis.text(x))
      end
    elseif item[1] == "*" and not item[2] and (row.choices or row.type == "boolean") then
      table.move(row.choices or { "true", "false" }, 1, #(row.choices or { 1, 2 }), #list + 1, list)
    else
      list[#list + 1] = one(row, item[1])
    end
    count_check(row.name, #list, text)
  end
  return list
end

-- Texts of a list of Lua values, as rt.sweep takes them.
local function listed(row, values)
  local list = {}
  for i, value in ipairs(values) do
    if row.type == "size" and type(value) == "table" then
      value = ("%sx%s"):format(tostring(value[1]), tostring(value[2]))
    end
    list[i] = one(row, axis.text(value))
  end
  if #list == 0 then
    fault(row.name, "there are no values; give some, as in { 1, 2, 4 }")
  end
  return list
end

-- { name, kind, type, help, values } for a name and its values (a text, or a list of values). declared: the script's parameters.
function axis.new(name, values, declared)
  local known = {}
  for _, p in ipairs(declared) do
    known[p.name] = p
  end
  local row, kind = known[name], "parameter"
  if not row then
    kind = "setting"
    for _, s in ipairs(axis.settings()) do
      known[s.name] = s
    end
    row = known[name] or known[name:gsub("-", "_")]
    if not row or declared[row.name] then
      fault(name, "%s", (check.unknown_words("the sweep", name, known, "parameter or setting")))
    end
  end
  local list = type(values) == "table" and listed(row, values) or expand(row, values)
  return { name = row.name, kind = kind, type = row.type, help = row.help or "", values = list }
end

-- ---- points ----

local function label(axes, values)
  local parts = {}
  for i, a in ipairs(axes) do
    parts[i] = a.name .. "=" .. values[a.name]
  end
  return table.concat(parts, ", ")
end

local function zipped(axes)
  local points = {}
  for _, a in ipairs(axes) do
    if #a.values ~= #axes[1].values then
      fault(a.name, "--zip pairs the values, and here are %d of them, but %s has %d", #a.values, axes[1].name, #axes[1].values)
    end
  end
  for i = 1, #axes[1].values do
    local values = {}
    for _, a in ipairs(axes) do
      values[a.name] = a.values[i]
    end
    points[i] = values
  end
  return points
end

local function crossed(axes)
  local points = { {} }
  for _, a in ipairs(axes) do
    local more = {}
    for _, before in ipairs(points) do
      for _, value in ipairs(a.values) do
        local values = { [a.name] = value }
        for k, v in next, before do
          values[k] = v
        end
        more[#more + 1] = values
      end
    end
    points = more
  end
  return points
end

-- The points of the axes, in their order: { values = { axis = text }, label }.
function axis.points(axes, zip)
  local count, seen = 1, {}
  for _, a in ipairs(axes) do
    count = count * #a.values
    if seen[a.name] then
      fault(a.name, "the axis is given twice; its values can stand in one list")
    end
    seen[a.name] = true
  end
  if count > MOST and not zip then
    error({ status = 2, message = ("the axes make %.0f points; at most %d are taken"):format(count, MOST), usage = "sweep" }, 0)
  end
  local list, labels = {}, {}
  for i, values in ipairs(zip and #axes > 0 and zipped(axes) or crossed(axes)) do
    local text = label(axes, values)
    if labels[text] then
      fault(axes[#axes].name, "the point %s is there twice", words.quote(text))
    end
    labels[text] = true
    list[i] = { values = values, label = text }
  end
  return list
end

return axis
