-- Descriptions: checked tables that say what a thing is. A class has a name, the fields it may have and the ones it must have.

local core = require "rt.core"
local check = require "rt.check"

local class = {}
local kinds = setmetatable({}, { __mode = "k" }) -- metatable -> kind: "shape", "light", "material", ...
local specs = setmetatable({}, { __mode = "k" }) -- metatable -> what class.new was given

local function to_string(meta)
  return function(o)
    return meta.__name .. (o.name and " '" .. o.name .. "'" or "")
  end
end

-- A script may give a description other values. That a new key is none of the kind's is seen here; a key that was given before is only looked at
-- when the description is used (class.checked).
local function assign(who, fields)
  return function(o, key, value)
    local field = fields[key] or check.unknown(who, key, fields, "key")
    if value ~= nil then
      value = field(value, tostring(o), key)
    end
    rawset(o, key, value)
  end
end

-- { name, kind, fields, required, example, items, shared, settles, finish }: a function that makes such descriptions, and their metatable. shared:
-- what all of them have; settles: the keys whose values are kept in another form than they are written in (class.settle).
-- items: positional items are kept unchecked in .items for finish(o, t, who), which may raise or complete the description.
function class.new(spec)
  local who = "rt." .. spec.name
  local meta = { __name = who }
  meta.__index = spec.shared
  meta.__newindex = assign(who, spec.fields)
  meta.__tostring = to_string(meta)
  kinds[meta], specs[meta] = spec.kind, spec
  spec.fields.name = check.string
  spec.required, spec.settles = spec.required or {}, spec.settles or {}
  local fields, required, finish = spec.fields, spec.required, spec.finish
  local checked_fields, checked_required, place = check.fields, check.required, core.place
  return function(t)
    check.plain_table(t, who, spec.example)
    local o = checked_fields(t, fields, who, spec.items)
    checked_required(o, required, who)
    if finish then
      finish(o, t, who)
    end
    o.place = place() -- where it was described, for who finds a fault in it later
    return setmetatable(o, meta)
  end, meta
end

-- A table as it was written has no metatable, what a field has made of one is a buffer or has one; of a file, `given` is the name that was read.
local function is_settled(o, value)
  if type(value) == "string" then
    return value == o.given
  end
  return type(value) ~= "table" or getmetatable(value) ~= nil
end

local function settle(o, spec)
  local who = tostring(o)
  for _, key in ipairs(spec.settles) do
    local value = rawget(o, key)
    if value ~= nil then
      o[key] = spec.fields[key](value, who, key)
    end
  end
  if not spec.items then
    spec.finish(o, o, who)
  end
end

-- Takes other values of the keys in `settles`, which a script may have given since, as the constructor would; it may have taken one away, too.
function class.settle(o)
  local spec = specs[getmetatable(o)]
  for _, key in ipairs(spec.required) do
    if rawget(o, key) == nil then
      return check.at(o.place, check.required, o, spec.required, tostring(o))
    end
  end
  for _, key in ipairs(spec.settles) do
    if not is_settled(o, rawget(o, key)) then
      return check.at(o.place, settle, o, spec)
    end
  end
end

-- The fields are told that they look again, when a buffer has its numbers.
local function checked(o)
  local spec, copy, who = specs[getmetatable(o)], {}, tostring(o)
  for _, key in ipairs(check.sorted_keys(spec.fields)) do
    local value = rawget(o, key)
    copy[key] = value ~= nil and spec.fields[key](value, who, key, true) or value
  end
  check.required(copy, spec.required, who)
  return copy
end

-- The values of a description as they are now, checked again; a fault is told with the place where it was described.
function class.checked(o)
  return check.at(o.place, checked, o)
end

-- What a script has made wrong in a description, as a sentence; nil: nothing, or it is none.
function class.fault(o)
  if class.kind(o) then
    local ok, message = pcall(class.checked, o)
    return not ok and message or nil
  end
end

-- The kind of a description, or nil for other values.
function class.kind(value)
  local meta = getmetatable(value)
  return meta and kinds[meta]
end

-- A field that takes descriptions of one kind.
function class.field(kind, example)
  return function(value, who, key)
    if class.kind(value) ~= kind then
      check.fail("%s: %s must be a %s, as %s; got %s", who, key, kind, example, check.describe(value))
    end
    return value
  end
end

return class
