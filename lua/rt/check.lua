-- Checking what users write. A field's check is a function (value, who, key) that returns the value as the module keeps it (tables are copied, so
-- that a script may go on using its own) or raises a sentence with the script's file and line.

local core = require "rt.core"
local words = require "rt.words"

local check = {}

local type, math_type = type, math.type

-- A bound as it is, not rounded: 1048576, 0.5, 1e+12.
local function number(x)
  local whole, text = math.tointeger(x), words.number(x, "%g")
  return whole and math.abs(x) < 1e10 and tostring(whole) or tonumber(text) == x and text or words.number(x)
end
local FLOAT_MAX = 3.4028234e38
check.FLOAT_MAX = FLOAT_MAX
local NOTHING = 2.0 ^ -150 -- what is no larger becomes 0 in single precision, in which the library computes
check.NOTHING = NOTHING
local LARGEST = 1e12 -- coordinate or length that the library takes
check.LARGEST = LARGEST

local place -- where a fault is told to be, when that is not where the script is

function check.fail(...)
  error((place or core.where()) .. string.format(...), 0)
end

-- f(...), whose faults are those of another place; nil: where the script is.
function check.at(where, f, ...)
  local before = place
  place = where
  local ok, result, more = pcall(f, ...)
  place = before
  if not ok then
    error(result, 0)
  end
  return result, more
end
local fail = check.fail

-- The refusal of the library that a raised message tells: { status = "RT_ERROR_IO", text = the message without a place }; nil of another message, as
-- that of Ctrl-C or of Lua's own lack of memory.
function check.refusal(raised)
  local failure = core.last_failure()
  return failure and type(raised) == "string" and raised:sub(-#failure.text) == failure.text and failure or nil
end

-- A value as a message shows it.
function check.describe(value)
  local kind = type(value)
  if kind == "string" then
    return "'" .. words.quote(value) .. "'"
  elseif kind == "number" then
    return words.number(value)
  elseif kind == "boolean" or kind == "nil" then
    return tostring(value)
  end
  local meta = getmetatable(value)
  local name = type(meta) == "table" and rawget(meta, "__name")
  return "a " .. (type(name) == "string" and name or kind)
end
local describe = check.describe

-- The keys of a table in their order: numbers first.
function check.sorted_keys(t)
  local keys = {}
  for key in next, t do
    keys[#keys + 1] = key
  end
  table.sort(keys, function(a, b)
    if type(a) == type(b) and (type(a) == "number" or type(a) == "string") then
      return a < b
    elseif type(a) ~= type(b) then
      return type(a) < type(b)
    end
    return tostring(a) < tostring(b)
  end)
  return keys
end

-- Those that are strings.
function check.names(t)
  local names = {}
  for _, name in ipairs(check.sorted_keys(t)) do
    names[#names + 1] = type(name) == "string" and name or nil
  end
  return names
end

-- The sentence for a key that `known` does not have; `noun` says what such keys are called.
function check.unknown_words(who, key, known, noun)
  local names = check.names(known)
  local near = type(key) == "string" and words.nearest(key, names)
  local hint = near and "did you mean " .. near .. "?" or "known are " .. table.concat(names, ", ")
  return ("%s has no %s %s; %s"):format(who, noun, describe(key), hint)
end

function check.unknown(...)
  fail("%s", check.unknown_words(...))
end

-- ---- numbers ----

local function finite(value)
  return value == value and value <= FLOAT_MAX and value >= -FLOAT_MAX
end

local function expect_number(value, who, key)
  if not math_type(value) then
    fail("%s: %s must be a number; got %s", who, key, describe(value))
  elseif value ~= value then
    fail("%s: %s is not a number (NaN); look for 0/0 or a root of a negative number", who, key)
  elseif not finite(value) then
    fail("%s: %s is %s; it must be finite in single precision", who, key, words.number(value))
  end
end

-- "from 0 to 1", "greater than 0", ...
local function range_words(range)
  local low = range.low and "at least " .. number(range.low) or range.above and "greater than " .. number(range.above)
  local high = range.high and "at most " .. number(range.high) or range.below and "less than " .. number(range.below)
  if range.low and range.high then
    return "from " .. number(range.low) .. " to " .. number(range.high)
  end
  return low and high and low .. " and " .. high or low or high
end

local function single(x)
  return (string.unpack("f", string.pack("f", x)))
end

-- above and below hold in single precision, too.
local function outside(value, range)
  return range.low and value < range.low or range.above and value <= range.above + NOTHING or range.high and value > range.high
    or range.below and single(value) >= range.below
end

local function larger_than(most, value, who, key)
  fail("%s: %s must be at most %s in size; got %s", who, key, number(most), number(value))
end

-- 1e-60 is greater than 0, but not as the library takes it.
local function rounded_words(value, range)
  local inside = value > (range.above or -math.huge) and value < (range.below or math.huge)
    and value >= (range.low or value) and value <= (range.high or value)
  return inside and (", which is %s in single precision"):format(number(single(value))) or ""
end

-- range: low and high, or above and below, which are outside; most: the largest size, which is only spoken of when it is exceeded.
function check.number(range)
  range = range or {}
  local most = range.most or FLOAT_MAX
  return function(value, who, key)
    if not math_type(value) or not finite(value) then
      expect_number(value, who, key)
    end
    if outside(value, range) then
      fail("%s: %s must be %s; got %s%s", who, key, range_words(range), words.number(value), rounded_words(value, range))
    elseif value > most or value < -most then
      larger_than(most, value, who, key)
    end
    return value
  end
end

function check.integer(range)
  return function(value, who, key)
    local n = math_type(value) and math.tointeger(value)
    if not n then
      expect_number(value, who, key)
      fail("%s: %s must be a whole number; got %s", who, key, words.number(value))
    elseif outside(n, range) then
      fail("%s: %s must be a whole number %s; got %s", who, key, range_words(range), words.number(value))
    end
    return n
  end
end

-- ---- vectors ----

local function vec3_fault(value, who, key, what, most)
  if type(value) ~= "table" then
    fail("%s: %s must be %s; got %s", who, key, what, describe(value))
  end
  for i = 1, 3 do
    if value[i] == nil then
      fail("%s: %s must be %s; number %d is missing", who, key, what, i)
    end
    expect_number(value[i], who, ("%s[%d]"):format(key, i))
    if most and math.abs(value[i]) > most then
      larger_than(most, value[i], who, ("%s[%d]"):format(key, i))
    end
  end
  fail("%s: %s must be %s; it has %d values", who, key, what, #value)
end

local copy3 = core.copy3 -- in C, for it is most of the work of describing many things

function check.vec3(value, who, key)
  return copy3(value) or vec3_fault(value, who, key, "{x, y, z}")
end

-- A point of the scene.
function check.place(value, who, key)
  return copy3(value, LARGEST) or vec3_fault(value, who, key, "{x, y, z}", LARGEST)
end

local function vanishes(x)
  return x <= NOTHING and x >= -NOTHING
end

-- A vector that has a direction.
function check.direction(value, who, key)
  local v = check.vec3(value, who, key)
  if vanishes(v[1]) and vanishes(v[2]) and vanishes(v[3]) then
    fail("%s: %s is zero and so has no direction", who, key)
  end
  return v
end

-- What turns a text for a colour into one.
local function srgb_words(value)
  return ("; rt.srgb '%s' gives a color from a text"):format(value:find "^#%x%x%x%x%x%x$" and value or "#ff8000")
end

-- Raises for the text of a colour where a file's name is taken.
function check.no_color_text(value, who, key)
  if value:find "^#%x%x%x%x%x%x$" then
    fail("%s: %s is %s%s", who, key, describe(value), srgb_words(value))
  end
end

local function color_fault(value, who, key)
  if type(value) == "string" then
    fail("%s: %s must be {red, green, blue}; got %s%s", who, key, describe(value), srgb_words(value))
  end
  vec3_fault(value, who, key, "{red, green, blue}", LARGEST)
end

-- A colour whose parts are at least 0, at most `high`.
function check.color(high)
  return function(value, who, key)
    local copy = copy3(value, LARGEST) or color_fault(value, who, key)
    for i = 1, 3 do
      if copy[i] < 0 or high and copy[i] > high then
        fail("%s: %s[%d] must be %s; got %s", who, key, i, high and "from 0 to " .. number(high) or "at least 0", words.number(copy[i]))
      end
    end
    return copy
  end
end

function check.numbers(count, most)
  return function(value, who, key)
    if type(value) ~= "table" or #value ~= count then
      fail("%s: %s must be a table of %d numbers; got %s", who, key, count, type(value) == "table" and "a table of " .. #value or describe(value))
    end
    local copy = {}
    for i = 1, count do
      expect_number(value[i], who, ("%s[%d]"):format(key, i))
      if most and math.abs(value[i]) > most then
        larger_than(most, value[i], who, ("%s[%d]"):format(key, i))
      end
      copy[i] = value[i]
    end
    return copy
  end
end

-- ---- the rest ----

function check.boolean(value, who, key)
  if type(value) ~= "boolean" then
    fail("%s: %s must be true or false; got %s", who, key, describe(value))
  end
  return value
end

function check.string(value, who, key)
  if type(value) ~= "string" then
    fail("%s: %s must be a string; got %s", who, key, describe(value))
  elseif value == "" then
    fail("%s: %s is empty", who, key)
  elseif value:find("\0", 1, true) then
    fail("%s: %s has a NUL byte inside", who, key)
  end
  return value
end

function check.choice(names)
  return function(value, who, key)
    for _, name in ipairs(names) do
      if name == value then
        return value
      end
    end
    local near = type(value) == "string" and words.nearest(value, names)
    near = near and " (did you mean " .. near .. "?)" or ""
    return fail("%s: %s must be one of %s; got %s%s", who, key, table.concat(names, ", "), describe(value), near)
  end
end

function check.callable(value, who, key)
  if type(value) ~= "function" then
    fail("%s: %s must be a function; got %s", who, key, describe(value))
  end
  return value
end

-- A table that the user wrote in place: no object of the module.
function check.plain_table(value, who, example)
  if type(value) ~= "table" or getmetatable(value) ~= nil then
    fail("%s takes one table, as in %s; got %s", who, example, describe(value))
  end
  return value
end

-- Raises for the first key (in their order) that `fields` does not have.
function check.keys(t, fields, who, noun)
  for key in next, t do
    if fields[key] == nil then
      for _, k in ipairs(check.sorted_keys(t)) do
        if fields[k] == nil then
          check.unknown(who, k, fields, noun)
        end
      end
    end
  end
end

-- The checked copy of t. `skip_numbers` passes positional items over.
function check.fields(t, fields, who, skip_numbers)
  local copy = { a = nil, b = nil, c = nil, d = nil } -- room for four fields at once
  for key, value in next, t do
    local field = fields[key]
    if field then
      copy[key] = field(value, who, key)
    elseif not (skip_numbers and math_type(key)) then
      local named = {}
      for k in next, t do
        if not (skip_numbers and math_type(k)) then
          named[k] = true
        end
      end
      check.keys(named, fields, who, "key")
    end
  end
  return copy
end

function check.required(o, keys, who)
  for _, key in ipairs(keys) do
    if o[key] == nil then
      fail("%s: %s is missing", who, key)
    end
  end
end

return check
