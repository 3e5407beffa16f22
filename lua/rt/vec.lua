-- rt.vec: points, directions and colours with arithmetic. A vec is a table {x, y, z} like any other, so it can stand wherever one is expected.

local core = require "rt.core"
local check = require "rt.check"
local words = require "rt.words"

local vec = {}
local methods = {}
local meta = { __name = "rt.vec" }
local NAMES = { x = 1, y = 2, z = 3, r = 1, g = 2, b = 3 }

local function new(x, y, z)
  return setmetatable({ x, y, z }, meta)
end
core.set_vec_meta(meta)

function meta.__index(v, key)
  local i = NAMES[key]
  return i and rawget(v, i) or methods[key]
end

function meta.__newindex(_, key)
  check.fail("a vec is a value: its %s is not assigned, a new vec is made", tostring(key))
end

-- The three numbers of an operand: a table of three numbers, or one number for all.
local function parts(value, what)
  if type(value) == "number" then
    return value, value, value
  elseif type(value) == "table" and math.type(value[1]) and math.type(value[2]) and math.type(value[3]) then
    return value[1], value[2], value[3]
  end
  return check.fail("%s must be a number or {x, y, z}; got %s", what, check.describe(value))
end

local function operator(symbol, f)
  local what = "an operand of vec " .. symbol
  return function(a, b)
    local ax, ay, az = parts(a, what)
    local bx, by, bz = parts(b, what)
    return new(f(ax, bx), f(ay, by), f(az, bz))
  end
end

meta.__add = operator("+", function(a, b) return a + b end)
meta.__sub = operator("-", function(a, b) return a - b end)
meta.__mul = operator("*", function(a, b) return a * b end)
meta.__div = operator("/", function(a, b) return a / b end)

function meta.__unm(a)
  return new(-a[1], -a[2], -a[3])
end

function meta.__eq(a, b)
  return a[1] == b[1] and a[2] == b[2] and a[3] == b[3]
end

function meta.__tostring(a)
  return ("{%s, %s, %s}"):format(words.number(a[1], "%.9g"), words.number(a[2], "%.9g"), words.number(a[3], "%.9g"))
end

function methods.dot(a, b)
  local x, y, z = parts(b, "vec:dot's argument")
  return a[1] * x + a[2] * y + a[3] * z
end

function methods.cross(a, b)
  local x, y, z = parts(b, "vec:cross's argument")
  return new(a[2] * z - a[3] * y, a[3] * x - a[1] * z, a[1] * y - a[2] * x)
end

function methods.length(a)
  return math.sqrt(a[1] * a[1] + a[2] * a[2] + a[3] * a[3])
end

function methods.normalize(a)
  local length = methods.length(a)
  if not (length > 0 and length < math.huge) then
    check.fail("a vec of length %s has no direction", words.number(length))
  end
  return new(a[1] / length, a[2] / length, a[3] / length)
end

-- a at t = 0, b at t = 1.
function methods.lerp(a, b, t)
  local x, y, z = parts(b, "vec:lerp's argument")
  return new(a[1] + (x - a[1]) * t, a[2] + (y - a[2]) * t, a[3] + (z - a[3]) * t)
end

function methods.unpack(a)
  return a[1], a[2], a[3]
end

-- rt.vec(x, y, z), rt.vec {x, y, z}, rt.vec(s)
function vec.make(x, y, z)
  if y == nil and z == nil then
    return new(parts(x, "rt.vec's argument"))
  elseif math.type(x) and math.type(y) and math.type(z) then
    return new(x, y, z)
  end
  return check.fail("rt.vec takes three numbers, one number or {x, y, z}")
end

local function linear(c)
  return c <= 0.04045 and c / 12.92 or ((c + 0.055) / 1.055) ^ 2.4
end

-- Are all from 0 to `most`? NaN is not.
local function up_to(most, r, g, b)
  return r >= 0 and r <= most and g >= 0 and g <= most and b >= 0 and b <= most
end

-- What is said of numbers outside; those of 0 to 255 are told as what was meant.
local function not_srgb(r, g, b)
  local meant = ""
  if up_to(255, r, g, b) then
    local hex = ("#%02x%02x%02x"):format(math.floor(r + 0.5), math.floor(g + 0.5), math.floor(b + 0.5))
    meant = ("; of 0 to 255 they are rt.srgb '%s', or each over 255"):format(hex)
  end
  check.fail("rt.srgb takes numbers from 0 to 1; got %s, %s, %s%s", words.number(r), words.number(g), words.number(b), meant)
end

-- rt.srgb("#ff8000"), rt.srgb(1, 0.5, 0): a colour as screens and pickers give it, turned into the linear one the renderer computes with.
function vec.srgb(r, g, b)
  if type(r) == "string" and g == nil then
    local hex = r:match "^#(%x%x%x%x%x%x)$"
    if not hex then
      check.fail("rt.srgb: '#rrggbb' is expected; got %s", check.describe(r))
    end
    local n = tonumber(hex, 16)
    r, g, b = (n >> 16) / 255, (n >> 8 & 255) / 255, (n & 255) / 255
  elseif not (math.type(r) and math.type(g) and math.type(b)) then
    check.fail("rt.srgb takes '#rrggbb' or three numbers from 0 to 1")
  elseif not up_to(1, r, g, b) then
    not_srgb(r, g, b)
  end
  return new(linear(r), linear(g), linear(b))
end

return vec
