-- Declared parameters. A script writes local p = rt.params { ior = { 1.5, min = 1, max = 2.5, help = "..." }, sets = { draft = { ... } } } and reads
-- p.ior. The command line wins over the chosen set, that over the default.

local check = require "rt.check"
local run = require "rt.run"
local settings = require "rt.settings"
local words = require "rt.words"

local params = {}

local fail = check.fail
local WHO = "rt.params"
local TYPES = { "number", "integer", "boolean", "choice", "color", "vector", "string", "file" }

-- ---- values by type: check(value, p, who) returns the value; read(text, p, who) reads it from a command line ----

-- "from 1 to 2.5", "at least 0", nil
local function range_words(p)
  local low, high = p.min and words.number(p.min), p.max and words.number(p.max)
  return low and high and "from " .. low .. " to " .. high or low and "at least " .. low or high and "at most " .. high
end

local function in_range(value, p, who)
  if p.min and value < p.min or p.max and value > p.max then
    fail("%s: %s must be %s; got %s", who, p.name, range_words(p), words.number(value))
  end
  return value
end

local number, color = check.number(), check.color(1)
local types = {}

types.number = {
  check = function(value, p, who) return in_range(number(value, who, p.name), p, who) end,
  read = function(text) return tonumber(text) end,
  words = "a number",
}
types.integer = {
  check = function(value, p, who)
    return in_range(check.integer({ low = math.mininteger, high = math.maxinteger })(value, who, p.name), p, who)
  end,
  read = function(text) return math.tointeger(tonumber(text)) end,
  words = "a whole number",
}
types.boolean = {
  check = function(value, p, who) return check.boolean(value, who, p.name) end,
  read = function(text) return ({ ["true"] = true, yes = true, ["1"] = true, ["false"] = false, no = false, ["0"] = false })[text] end,
  words = "true or false",
}
types.choice = {
  check = function(value, p, who) return check.choice(p.choices)(value, who, p.name) end,
  read = function(text) return text end,
}
types.string = {
  check = function(value, p, who)
    if type(value) ~= "string" then
      fail("%s: %s must be a string; got %s", who, p.name, check.describe(value))
    end
    return value
  end,
  read = function(text) return text end,
}
types.file = {
  check = function(value, p, who) return check.string(value, who, p.name) end,
  read = function(text) return text ~= "" and run.absolute(text) or text end,
}

-- "{1, 0.5, 0}" or "1,0.5,0"
local function read_three(text)
  local x, y, z = text:match "^%s*{?%s*([^,%s]+)%s*,%s*([^,%s]+)%s*,%s*([^,%s}]+)%s*}?%s*$"
  x, y, z = tonumber(x), tonumber(y), tonumber(z)
  return x and y and z and { x, y, z } or nil
end

types.vector = {
  check = function(value, p, who) return check.vec3(value, who, p.name) end,
  read = read_three,
  words = "three numbers, as 1,0,0",
}
types.color = {
  check = function(value, p, who) return color(value, who, p.name) end,
  read = function(text) return text:match "^#%x%x%x%x%x%x$" and require("rt.vec").srgb(text) or read_three(text) end,
  words = "three numbers from 0 to 1, as 1,0.5,0, or #rrggbb",
}

-- A value from a command line.
local function read(p, text, who)
  local value = types[p.type].read(text)
  if value == nil then
    local range = range_words(p)
    fail("%s: %s must be %s%s; got '%s'", who, p.name, types[p.type].words, range and " " .. range or "", words.quote(text))
  end
  return types[p.type].check(value, p, who)
end

-- The checked value of a text, for a declaration as rt.load lists it.
function params.value_of(p, text, who)
  return read(p, text, who)
end

-- ---- declarations ----

local function infer(default, p)
  if p.choices then
    return "choice"
  elseif type(default) == "table" then
    return "vector"
  end
  return type(default)
end

local keys = {
  type = check.choice(TYPES), min = number, max = number, step = check.number { above = 0 }, help = check.string, label = check.string,
  choices = function(value, who, key)
    if type(value) ~= "table" or #value == 0 then
      fail("%s: %s must be a list of strings; got %s", who, key, check.describe(value))
    end
    local copy = {}
    for i, choice in ipairs(value) do
      copy[i] = check.string(choice, who, ("%s[%d]"):format(key, i))
    end
    return copy
  end,
}

-- { default, key = ... }, or the default alone; {x, y, z} is a vector's.
local function split(entry)
  if type(entry) ~= "table" or getmetatable(entry) ~= nil or entry[2] ~= nil then
    return entry, {}
  end
  local named = {}
  for key, value in next, entry do
    if key ~= 1 then
      named[key] = value
    end
  end
  return entry[1], named
end

local function check_name(name)
  if type(name) ~= "string" or not name:find "^[%a_][%w_]*$" then
    fail("%s: a parameter's name must be a word of letters, digits and _; got %s", WHO, check.describe(name))
  elseif settings.fields[name] or settings.reserved[name] then
    fail("%s: '%s' is a setting's name; a parameter needs another", WHO, name)
  end
end

local function declare(name, entry)
  check_name(name)
  local who = WHO .. ": " .. name
  local default, named = split(entry)
  local p = check.fields(named, keys, who)
  p.name = name
  if default == nil then
    fail("%s: the default is missing; it stands first, as in { 1.5, min = 1 }", who)
  end
  p.type = p.type or infer(default, p)
  if not types[p.type] then
    fail("%s: the default must be a number, boolean, string or {x, y, z}; got %s", who, check.describe(default))
  elseif p.type == "choice" and not p.choices then
    fail("%s: choices are missing, as in choices = { 'red', 'green' }", who)
  elseif p.choices and p.type ~= "choice" then
    fail("%s: choices are for the type choice, and this is a %s", who, p.type)
  elseif (p.min or p.max or p.step) and p.type ~= "number" and p.type ~= "integer" then
    fail("%s: %s is for numbers, and this is a %s", who, p.min and "min" or p.max and "max" or "step", p.type)
  elseif p.type == "integer" and p.step and not math.tointeger(p.step) then
    fail("%s: the step of an integer must be a whole number; got %s", who, words.number(p.step))
  elseif p.min and p.max and p.min > p.max then
    fail("%s: min %s is above max %s", who, words.number(p.min), words.number(p.max))
  end
  p.default = types[p.type].check(default, p, WHO)
  return p
end

-- The sets with their parameters' values checked; the settings among them are told apart.
local function declare_sets(sets, by_name)
  local checked = {}
  if type(sets) ~= "table" then
    fail("%s: sets must be a table of sets, as { draft = { radius = 100 } }; got %s", WHO, check.describe(sets))
  end
  for _, name in ipairs(check.sorted_keys(sets)) do
    local who = ("%s: set %s"):format(WHO, check.describe(name))
    if type(name) ~= "string" or type(sets[name]) ~= "table" then
      fail("%s must be a table of values", who)
    end
    local set = { params = {}, settings = {} }
    for _, key in ipairs(check.sorted_keys(sets[name])) do
      local value = sets[name][key]
      if by_name[key] then
        set.params[key] = types[by_name[key].type].check(value, by_name[key], who)
      elseif settings.fields[key] then
        set.settings[key] = value
      else
        local known = {}
        for k in pairs(by_name) do known[k] = true end
        for k in pairs(settings.fields) do known[k] = true end
        check.unknown(who, key, known, "parameter or setting")
      end
    end
    set.settings = settings.check(set.settings, who)
    checked[name] = set
  end
  return checked
end

-- ---- the winner ----

local function choose(p, r)
  local override, set = r.overrides[p.name], r.set and r.sets[r.set]
  if override ~= nil then
    r.used[p.name] = true
    p.source = "command line"
    p.overruled = set and set.params[p.name] -- what the set would have given
    if type(override) == "string" then
      return read(p, override, "-D " .. p.name)
    end
    return types[p.type].check(override, p, "-D " .. p.name)
  elseif set and set.params[p.name] ~= nil then
    p.source = "set " .. r.set
    return set.params[p.name]
  end
  p.source = "default"
  return p.default
end

local function values_of(list)
  local values, known = {}, {}
  for _, p in ipairs(list) do
    values[p.name], known[p.name] = p.value, true
  end
  return setmetatable({}, { -- empty, so that assigning to a declared name is seen, too
    __name = "rt.params values",
    __index = function(_, key)
      if not known[key] then
        check.unknown(WHO, key, known, "parameter")
      end
      return values[key]
    end,
    __pairs = function()
      return next, values
    end,
    __newindex = function(_, key)
      fail("%s: %s cannot be assigned; parameters are set on the command line, by a set, or by their default", WHO, check.describe(key))
    end,
  })
end

function params.declare(t)
  check.plain_table(t, WHO, "rt.params { ior = { 1.5, min = 1, max = 2.5 } }")
  local r = run.current() or run.new(nil)
  local list, by_name = {}, {}
  for _, p in ipairs(r.params) do
    by_name[p.name] = p
  end
  for _, name in ipairs(check.sorted_keys(t)) do
    if name ~= "sets" then
      if by_name[name] then
        fail("%s: %s is declared twice", WHO, name)
      end
      local p = declare(name, t[name])
      by_name[name] = p
      list[#list + 1] = p
    end
  end
  for name, set in pairs(declare_sets(t.sets or {}, by_name)) do
    r.sets[name] = set
  end
  for _, p in ipairs(list) do
    p.value = choose(p, r)
    r.params[#r.params + 1] = p
  end
  return values_of(list)
end

-- Raises when the command line named a parameter or a set that the script has not declared.
function params.check_used(r)
  for _, name in ipairs(check.sorted_keys(r.overrides)) do
    if not r.used[name] then
      local known = {}
      for _, p in ipairs(r.params) do
        known[p.name] = true
      end
      if settings.fields[name] then
        error(("%s: -D %s: that is a setting, no parameter; --%s sets it"):format(r.path, name, name:gsub("_", "-")), 0)
      elseif next(known) == nil then
        error(("%s: -D %s: the script declares no parameters; rt.params { %s = ... } would"):format(r.path, name, name), 0)
      end
      error(r.path .. ": -D: " .. check.unknown_words("the script", name, known, "parameter"), 0)
    end
  end
  if r.set and not r.sets[r.set] then
    if next(r.sets) == nil then
      error(("%s: --set %s: the script declares no sets"):format(r.path, words.quote(r.set)), 0)
    end
    error(r.path .. ": --set: " .. check.unknown_words("the script", r.set, r.sets, "set"), 0)
  end
end

return params
