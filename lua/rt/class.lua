-- Descriptions: checked tables that say what a thing is. A class has a name, the fields it may have and the ones it must have.

local check = require "rt.check"

local class = {}
local kinds = setmetatable({}, { __mode = "k" }) -- metatable -> kind: "shape", "light", "material", ...

local function to_string(meta)
  return function(o)
    return meta.__name .. (o.name and " '" .. o.name .. "'" or "")
  end
end

-- { name, kind, fields, required, example, items, finish }: a function that makes such descriptions, and their metatable.
-- items: positional items are kept unchecked in .items for finish(o, t, who), which may raise or complete the description.
function class.new(spec)
  local who = "rt." .. spec.name
  local meta = { __name = who }
  meta.__index = spec.methods
  meta.__tostring = to_string(meta)
  kinds[meta] = spec.kind
  spec.fields.name = check.string
  local fields, required, finish = spec.fields, spec.required or {}, spec.finish
  local checked_fields, checked_required = check.fields, check.required
  return function(t)
    check.plain_table(t, who, spec.example)
    local o = checked_fields(t, fields, who, spec.items)
    checked_required(o, required, who)
    if finish then
      finish(o, t, who)
    end
    return setmetatable(o, meta)
  end, meta
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
