-- Keys: values at times, and what lies between them.

local check = require "rt.check"
local class = require "rt.class"
local ease = require "rt.ease"
local quat = require "rt.quat"
local vec = require "rt.vec"

local keys = {}
local methods = {}
local meta = { __name = "rt.keys", __index = methods }
local WHO = "rt.keys"

local number = check.number()

-- ---- the kinds of values ----

local kinds = {}

kinds["a number"] = function(a, b, x)
  return a + (b - a) * x
end

kinds["a vector"] = function(a, b, x)
  return vec.make(a[1] + (b[1] - a[1]) * x, a[2] + (b[2] - a[2]) * x, a[3] + (b[3] - a[3]) * x)
end

kinds["a rotation"] = function(a, b, x)
  if x < 0 or x > 1 then -- an easing that overshoots: the turn goes on by as much
    local far = x < 0 and a:slerp(b, -x) or b:slerp(a, x - 1)
    return x < 0 and a * far:inverse() * a or b * far:inverse() * b
  end
  return a:slerp(b, x)
end

kinds["a list"] = function(a, b, x)
  local list = {}
  for i = 1, #a do
    list[i] = a[i] + (b[i] - a[i]) * x
  end
  return list
end

-- Values that have no between: they hold until the next key.
kinds["a choice"] = function(a, b, x)
  return x < 1 and a or b
end

-- The kind of a value, and the value as it is kept.
local function kind_of(value, who)
  if math.type(value) then
    return "a number", number(value, who, "the value")
  elseif quat.is(value) then
    return "a rotation", value
  elseif type(value) == "string" or type(value) == "boolean" or class.kind(value) then
    return "a choice", value
  elseif type(value) == "table" and math.type(value[1]) then
    if #value == 3 then
      return "a vector", vec.make(check.vec3(value, who, "the value"))
    end
    local list = {}
    for i = 1, #value do
      list[i] = number(value[i], who, ("the value[%d]"):format(i))
    end
    return "a list", list
  end
  return check.fail("%s: a value is a number, {x, y, z}, a colour, a list of numbers, an rt.quat, a text, a boolean or a description; got %s",
    who, check.describe(value))
end

-- ---- reading ----

local key_fields = { ease = ease.field }

local function read_key(k, i, common)
  local who = ("%s: key %d"):format(WHO, i)
  if type(k) ~= "table" or getmetatable(k) ~= nil or k[1] == nil or k[2] == nil then
    check.fail("%s must be {time, value} or {time, value, ease = 'smooth'}; got %s", who, check.describe(k))
  elseif k[3] ~= nil then
    check.fail("%s has a third value, %s; a vector stands in braces: {time, {x, y, z}}", who, check.describe(k[3]))
  end
  local o = check.fields(k, key_fields, who, true)
  if i == 1 and o.ease then
    check.fail("%s has an ease, which says how the value comes to a key from the one before; the first has none before it",
      who)
  end
  local kind, value = kind_of(k[2], who)
  return { time = number(k[1], who, "the time"), value = value, kind = kind, ease = o.ease or common }
end

local function check_neighbours(list)
  for i = 2, #list do
    local a, b = list[i - 1], list[i]
    if b.time < a.time then
      check.fail("%s: key %d is at %s, before key %d at %s; keys stand in the order of their times", WHO, i, tostring(b.time), i - 1,
        tostring(a.time))
    elseif a.kind ~= b.kind then
      check.fail("%s: key %d is %s and key %d %s; all keys are of one kind", WHO, i - 1, a.kind, i, b.kind)
    elseif a.kind == "a list" and #a.value ~= #b.value then
      check.fail("%s: key %d has %d numbers and key %d has %d", WHO, i, #b.value, i - 1, #a.value)
    end
  end
end

local fields = { ease = ease.field, loop = check.choice { "hold", "repeat", "mirror" } }

-- rt.keys { {0, a}, {0.5, b, ease = "smooth"}, {1, c}, ease = "linear", loop = "hold" }: a function of time. An ease says how the value comes to
-- its key. Two keys at one time are a jump. Before the first and after the last key the value holds, or runs again (loop).
function keys.make(t)
  check.plain_table(t, WHO, "rt.keys { {0, a}, {1, b} }")
  local o = check.fields(t, fields, WHO, true)
  local list = {}
  for _, key in ipairs(check.sorted_keys(t)) do
    if math.type(key) then
      if key ~= #list + 1 then
        check.fail("%s: key %d is missing", WHO, #list + 1)
      end
      list[key] = read_key(t[key], key, o.ease or ease.functions.linear)
    end
  end
  if #list == 0 then
    check.fail("%s: there is no key; it takes at least one, as {0, value}", WHO)
  end
  check_neighbours(list)
  if o.loop and o.loop ~= "hold" and list[#list].time == list[1].time then
    check.fail("%s: loop = '%s' needs keys at two times at least", WHO, o.loop)
  end
  return setmetatable({ list = list, loop = o.loop, between = kinds[list[1].kind] }, meta)
end

-- ---- values ----

-- The time within the keys' span that t stands for.
local function fold(self, t)
  local first, span = self.list[1].time, self.list[#self.list].time - self.list[1].time
  if not self.loop or self.loop == "hold" then
    return t
  end
  local turns = math.floor((t - first) / span)
  local rest = t - first - turns * span
  if self.loop == "mirror" and turns % 2 ~= 0 then
    rest = span - rest
  end
  return first + rest
end

-- keys(t), keys:at(t): the value at a time. Where two keys stand at one time, the later one holds from there on.
function methods.at(self, t)
  local list = self.list
  t = fold(self, number(t, "keys", "the time"))
  if t < list[1].time then
    return list[1].value
  end
  local low, high = 1, #list -- the last key at or before t
  while low < high do
    local middle = (low + high + 1) // 2
    if list[middle].time <= t then
      low = middle
    else
      high = middle - 1
    end
  end
  local a, b = list[low], list[low + 1]
  if not b or a.time == t then
    return a.value
  end
  local x = b.ease((t - a.time) / (b.time - a.time))
  if not math.type(x) or x ~= x then
    check.fail("keys: the ease of key %d returned %s; it must return a number", low + 1, check.describe(x))
  end
  return self.between(a.value, b.value, x)
end

meta.__call = methods.at

-- The times of the first and the last key.
function methods.span(self)
  return self.list[1].time, self.list[#self.list].time
end

function meta.__tostring(self)
  return ("rt.keys (%d keys of %s from %g to %g)"):format(#self.list, self.list[1].kind:gsub("^an? ", "") .. "s", self:span())
end

return keys
