-- Affine maps: tables of 12 numbers, the rows of a 3x4 matrix. a * b does b first, then a.

local core = require "rt.core"
local check = require "rt.check"
local vec = require "rt.vec"
local words = require "rt.words"

local transform = {}
local methods = {}
local meta = { __name = "rt.transform", __index = methods }

local function wrap(t)
  return setmetatable(t, meta)
end

local numbers, limited = check.numbers(12), check.numbers(12, check.LARGEST)

-- A field that takes a transform or 12 numbers.
function transform.field(value, who, key)
  return wrap(limited(value, who, key))
end

-- rt.transform() is the identity; rt.transform {12 numbers} takes rows.
function transform.make(rows)
  if rows == nil then
    return wrap(core.scale { 1, 1, 1 })
  end
  return wrap(numbers(rows, "rt.transform", "the argument"))
end

local function three(who, x, y, z)
  if y == nil and z == nil then
    return check.vec3(type(x) == "number" and who == "rt.scale" and { x, x, x } or x, who, "the argument")
  end
  return check.vec3({ x, y, z }, who, "the argument")
end

-- rt.translate(x, y, z) or rt.translate {x, y, z}
function transform.translate(x, y, z)
  return wrap(core.translate(three("rt.translate", x, y, z)))
end

-- rt.scale(s), rt.scale(x, y, z) or rt.scale {x, y, z}
function transform.scale(x, y, z)
  local by = three("rt.scale", x, y, z)
  if by[1] == 0 or by[2] == 0 or by[3] == 0 then
    check.fail("rt.scale: a factor of 0 flattens everything")
  end
  return wrap(core.scale(by))
end

-- rt.rotate(axis, degrees), right-handed; rt.rotate(q) of an rt.quat
function transform.rotate(axis, degrees)
  local m = getmetatable(axis)
  if degrees == nil and type(m) == "table" and m.__name == "rt.quat" then
    return axis:transform()
  end
  local angle = check.number()(degrees, "rt.rotate", "the angle")
  return wrap(core.rotate(check.direction(axis, "rt.rotate", "the axis"), angle))
end

function meta.__mul(a, b)
  if getmetatable(a) ~= meta then
    check.fail("a transform stands left of *; got %s", check.describe(a))
  elseif getmetatable(b) == meta then
    return wrap(core.multiply(a, b))
  end
  return methods.point(a, b)
end

-- Where a point goes.
function methods.point(m, p)
  p = check.vec3(p, "transform:point", "the argument")
  local x, y, z = p[1], p[2], p[3]
  return vec.make(m[1] * x + m[2] * y + m[3] * z + m[4], m[5] * x + m[6] * y + m[7] * z + m[8], m[9] * x + m[10] * y + m[11] * z + m[12])
end

-- Where a direction goes: without the translation.
function methods.direction(m, d)
  d = check.vec3(d, "transform:direction", "the argument")
  local x, y, z = d[1], d[2], d[3]
  return vec.make(m[1] * x + m[2] * y + m[3] * z, m[5] * x + m[6] * y + m[7] * z, m[9] * x + m[10] * y + m[11] * z)
end

function meta.__eq(a, b)
  for i = 1, 12 do
    if a[i] ~= b[i] then
      return false
    end
  end
  return true
end

function meta.__tostring(m)
  local rows = {}
  for i = 1, 12 do
    rows[i] = words.number(m[i], "%.9g")
  end
  return "rt.transform {" .. table.concat(rows, ", ") .. "}"
end

return transform
