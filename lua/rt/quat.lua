-- Rotations as unit quaternions {x, y, z, w}: they turn into each other evenly, which the numbers of a matrix do not.

local core = require "rt.core"
local check = require "rt.check"
local vec = require "rt.vec"
local transform = require "rt.transform"

local quat = {}
local methods = {}
local meta = { __name = "rt.quat", __index = methods }
local WHO = "rt.quat"

function quat.is(value)
  return getmetatable(value) == meta
end

local function new(x, y, z, w)
  return setmetatable({ x, y, z, w }, meta)
end

local function unit(x, y, z, w, who)
  local length = math.sqrt(x * x + y * y + z * z + w * w)
  if length <= 1e-12 then
    check.fail("%s: a quaternion of zeros is no rotation", who)
  end
  return new(x / length, y / length, z / length, w / length)
end

-- The shortest turn that takes the direction a to b.
local function between(a, b)
  a, b = vec.make(a):normalize(), vec.make(b):normalize()
  local c, d = a:cross(b), a:dot(b)
  if d < -0.999999 then -- opposite: about any axis square to a
    local axis = math.abs(a[1]) < 0.6 and a:cross { 1, 0, 0 } or a:cross { 0, 1, 0 }
    return unit(axis[1], axis[2], axis[3], 0, WHO)
  end
  return unit(c[1], c[2], c[3], 1 + d, WHO)
end

local four = check.numbers(4)

-- rt.quat() is no turn; rt.quat(axis, degrees) a right-handed turn; rt.quat(from, to) the shortest one between two directions;
-- rt.quat {x, y, z, w} takes the numbers.
function quat.make(a, b)
  if a == nil and b == nil then
    return new(0.0, 0.0, 0.0, 1.0)
  elseif b == nil then
    local n = four(a, WHO, "the argument")
    return unit(n[1], n[2], n[3], n[4], WHO)
  elseif type(b) == "table" then
    return between(check.direction(a, WHO, "the first direction"), check.direction(b, WHO, "the second direction"))
  end
  local axis, angle = check.direction(a, WHO, "the axis"), check.number()(b, WHO, "the angle")
  local half = core.rotate({ 0, 0, 1 }, angle / 2) -- its cosine and sine
  local n = vec.make(axis):normalize()
  return unit(n[1] * half[5], n[2] * half[5], n[3] * half[5], half[1], WHO)
end

function meta.__mul(a, b)
  if not quat.is(a) then
    check.fail("a rotation stands left of *; got %s", check.describe(a))
  elseif not quat.is(b) then
    return methods.point(a, b)
  end
  local ax, ay, az, aw, bx, by, bz, bw = a[1], a[2], a[3], a[4], b[1], b[2], b[3], b[4]
  return new(aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz)
end

-- Where a point goes.
function methods.point(q, p)
  p = vec.make(check.vec3(p, "quat:point", "the argument"))
  local u = vec.make(q[1], q[2], q[3])
  local t = 2 * u:cross(p)
  return p + q[4] * t + u:cross(t)
end

-- The turn back.
function methods.inverse(q)
  return new(-q[1], -q[2], -q[3], q[4])
end

-- The rt.transform of the rotation.
function methods.transform(q)
  local a, b, c = q:point { 1, 0, 0 }, q:point { 0, 1, 0 }, q:point { 0, 0, 1 }
  return transform.make { a[1], b[1], c[1], 0, a[2], b[2], c[2], 0, a[3], b[3], c[3], 0 }
end

local function middle(ax, ay, az, aw, bx, by, bz, bw)
  local x, y, z, w = ax + bx, ay + by, az + bz, aw + bw
  local length = math.sqrt(x * x + y * y + z * z + w * w)
  return x / length, y / length, z / length, w / length
end

-- From q at t = 0 to r at t = 1 on the shortest way, at an even pace. The arc is halved until it is so short that the chord tells the same: exact
-- roots alone, the same bits on every machine, where sines would not give them.
function methods.slerp(q, r, t)
  if not quat.is(r) then
    check.fail("quat:slerp: the argument must be an rt.quat; got %s", check.describe(r))
  end
  t = check.number()(t, "quat:slerp", "t")
  local ax, ay, az, aw, bx, by, bz, bw = q[1], q[2], q[3], q[4], r[1], r[2], r[3], r[4]
  if ax * bx + ay * by + az * bz + aw * bw < 0 then
    bx, by, bz, bw = -bx, -by, -bz, -bw
  end
  t = t < 0 and 0.0 or t > 1 and 1.0 or t
  for _ = 1, 16 do
    local mx, my, mz, mw = middle(ax, ay, az, aw, bx, by, bz, bw)
    if t < 0.5 then
      bx, by, bz, bw, t = mx, my, mz, mw, 2 * t
    else
      ax, ay, az, aw, t = mx, my, mz, mw, 2 * t - 1
    end
  end
  return unit(ax + (bx - ax) * t, ay + (by - ay) * t, az + (bz - az) * t, aw + (bw - aw) * t, "quat:slerp")
end

function meta.__eq(a, b)
  return a[1] == b[1] and a[2] == b[2] and a[3] == b[3] and a[4] == b[4]
end

function meta.__tostring(q)
  return ("rt.quat {%.9g, %.9g, %.9g, %.9g}"):format(q[1], q[2], q[3], q[4])
end

return quat
