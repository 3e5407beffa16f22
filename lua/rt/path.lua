-- Ways through space for cameras and things: curves through points, orbits, and what looks along them.

local core = require "rt.core"
local check = require "rt.check"
local new_camera = require("rt.camera").new
local quat = require "rt.quat"
local transform = require "rt.transform"
local vec = require "rt.vec"

local path = {}
local methods = {}
local meta = { __name = "rt.path", __index = methods }
local orbit_methods = {}
local orbit_meta = { __name = "rt.orbit", __index = orbit_methods }

local STEPS = 64 -- pieces in which a segment's length is measured

local number = check.number()

-- ---- curves through points ----

local function point_of(value, i)
  local p = vec.make(check.vec3(value, "rt.path", ("point %d"):format(i)))
  return p
end

-- Catmull-Rom with centripetal knots (Yuksel et al. 2011: no cusps and no loops within a segment), as Hermite segments.
local function segments_of(points, closed)
  local count = #points
  local function at(i)
    if closed then
      return points[(i - 1) % count + 1]
    elseif i < 1 then
      return 2 * points[1] - points[2]
    elseif i > count then
      return 2 * points[count] - points[count - 1]
    end
    return points[i]
  end
  local list = {}
  for i = 1, closed and count or count - 1 do
    local a, b, c, d = at(i - 1), at(i), at(i + 1), at(i + 2)
    local u, v, w = math.sqrt((b - a):length()), math.sqrt((c - b):length()), math.sqrt((d - c):length())
    u, w = u > 0 and u or v, w > 0 and w or v
    local before = v * ((b - a) / u - (c - a) / (u + v) + (c - b) / v)
    local after = v * ((c - b) / v - (d - b) / (v + w) + (d - c) / w)
    list[i] = { b, c, before, after }
  end
  return list
end

local function on_segment(s, x)
  local x2, x3 = x * x, x * x * x
  return (2 * x3 - 3 * x2 + 1) * s[1] + (3 * x2 - 2 * x3) * s[2] + (x3 - 2 * x2 + x) * s[3] + (x3 - x2) * s[4]
end

local function speed_on_segment(s, x)
  local x2 = x * x
  return (6 * x2 - 6 * x) * s[1] + (6 * x - 6 * x2) * s[2] + (3 * x2 - 4 * x + 1) * s[3] + (3 * x2 - 2 * x) * s[4]
end

-- The length up to each of the pieces.
local function measure(segments)
  local lengths, total = { [0] = 0.0 }, 0.0
  for i, s in ipairs(segments) do
    local from = s[1]
    for k = 1, STEPS do
      local to = on_segment(s, k / STEPS)
      total = total + (to - from):length()
      lengths[(i - 1) * STEPS + k], from = total, to
    end
  end
  return lengths, total
end

local fields = { closed = check.boolean, even = check.boolean }

-- rt.path { {0,1,5}, {3,1,0}, ..., closed = false, even = true }: a smooth curve through the points, a function of t from 0 to 1. even: equal times
-- are equal lengths; otherwise the points are at equal times. An open path stays at its ends, a closed one runs on.
function path.make(t)
  check.plain_table(t, "rt.path", "rt.path { {0, 1, 5}, {3, 1, 0} }")
  local o = check.fields(t, fields, "rt.path", true)
  local points = {}
  for _, key in ipairs(check.sorted_keys(t)) do
    if math.type(key) then
      if key ~= #points + 1 then
        check.fail("rt.path: point %d is missing", #points + 1)
      end
      points[key] = point_of(t[key], key)
      if key > 1 and points[key] == points[key - 1] then
        check.fail("rt.path: points %d and %d are the same; leave one out", key - 1, key)
      end
    end
  end
  local least = o.closed and 3 or 2
  if #points < least then
    check.fail("rt.path: %s path has at least %d points; got %d", o.closed and "a closed" or "a", least, #points)
  elseif o.closed and points[1] == points[#points] then
    check.fail("rt.path: a closed path returns by itself; leave the last point out, which is the first again")
  end
  local self = { segments = segments_of(points, o.closed), closed = o.closed, even = o.even ~= false }
  self.lengths, self.total = measure(self.segments)
  return setmetatable(self, meta)
end

-- The segment of t, and the place on it.
local function locate(self, t, who)
  t = number(t, who, "t")
  t = self.closed and t - math.floor(t) or t < 0 and 0.0 or t > 1 and 1.0 or t
  local place = t * #self.segments
  if self.even then
    local wanted, lengths = t * self.total, self.lengths
    local low, high = 0, #lengths - 1 -- the last piece that begins at or before the wanted length
    while low < high do
      local middle = (low + high + 1) // 2
      if lengths[middle] <= wanted then
        low = middle
      else
        high = middle - 1
      end
    end
    local piece = lengths[low + 1] - lengths[low]
    place = (low + (piece > 0 and (wanted - lengths[low]) / piece or 0)) / STEPS
  end
  local i = math.min(math.floor(place), #self.segments - 1)
  return self.segments[i + 1], place - i
end

-- path(t), path:at(t): the point at t.
function methods.at(self, t)
  return on_segment(locate(self, t, "path"))
end
meta.__call = methods.at

-- The unit direction in which the path runs at t.
function methods.direction(self, t)
  local s, x = locate(self, t, "path:direction")
  local speed = speed_on_segment(s, x)
  return (speed:length() > 0 and speed or s[2] - s[1]):normalize()
end

-- The length of the whole path.
function methods.length(self)
  return self.total
end

function meta.__tostring(self)
  return ("rt.path (%d segments, length %.4g)"):format(#self.segments, self.total)
end

-- ---- orbits ----

local orbit_fields = {
  center = check.vec3, radius = check.number { above = 0 }, height = number, from = number, turns = number, axis = check.direction,
}

-- rt.orbit { center = {0,0,0}, radius = 5, height = 1, from = 0, turns = 1, axis = {0,1,0} }: a circle around the axis, a function of t from 0 to 1.
-- `from` is an angle: 0 is on the side of +z, 90 of +x. Negative turns run the other way.
function path.orbit(t)
  check.plain_table(t, "rt.orbit", "rt.orbit { radius = 5, height = 1 }")
  local o = check.fields(t, orbit_fields, "rt.orbit")
  check.required(o, { "radius" }, "rt.orbit")
  o.center, o.height, o.from, o.turns = vec.make(o.center or { 0, 0, 0 }), o.height or 0, o.from or 0, o.turns or 1
  local tilt = quat.make({ 0, 1, 0 }, o.axis or { 0, 1, 0 })
  o.axis, o.start = tilt * { 0, 1, 0 }, tilt * { 0, 0, 1 }
  return setmetatable(o, orbit_meta)
end

local function turn(self, t, who)
  return transform.make(core.rotate(self.axis, self.from + 360 * self.turns * number(t, who, "t")))
end

-- orbit(t), orbit:at(t): the point at t.
function orbit_methods.at(self, t)
  return self.center + self.height * self.axis + self.radius * turn(self, t, "orbit"):direction(self.start)
end
orbit_meta.__call = orbit_methods.at

-- The unit direction in which the orbit runs at t.
function orbit_methods.direction(self, t)
  local out = turn(self, t, "orbit:direction"):direction(self.start)
  return (self.turns < 0 and -1 or 1) * self.axis:cross(out)
end

function orbit_methods.length(self)
  return 2 * math.pi * self.radius * math.abs(self.turns)
end

function orbit_meta.__tostring(self)
  return ("rt.orbit (radius %.4g, %.4g turns)"):format(self.radius, self.turns)
end

-- ---- looking ----

-- The camera of a path or orbit at t: rt.camera's keys; look_at may also be a function of t (a path, keys), and is, when left out, the orbit's centre
-- or what lies ahead.
local function camera(self, t, keys, who)
  local o = {}
  for key, value in next, check.plain_table(keys or {}, who, "{ look_at = {0, 0, 0}, fov = 40 }") do
    o[key] = value
  end
  if o.eye ~= nil then
    check.fail("%s: eye is the place on the way; leave it out", who)
  end
  o.eye = self:at(t)
  local target = o.look_at
  if target == nil then
    o.look_at = self.center or o.eye + self:direction(t)
  else
    local m = getmetatable(target)
    if type(target) == "function" or m and m.__call then
      o.look_at = target(t)
    end
  end
  return new_camera(o)
end

function methods.camera(self, t, keys)
  return camera(self, t, keys, "path:camera")
end

function orbit_methods.camera(self, t, keys)
  return camera(self, t, keys, "orbit:camera")
end

-- rt.look_at(from, to, up): the transform that puts a thing to `from` with its +z towards `to` and its +y upwards.
function path.look_at(from, to, up)
  local who = "rt.look_at"
  from, to = vec.make(check.vec3(from, who, "from")), vec.make(check.vec3(to, who, "to"))
  up = vec.make(up and check.direction(up, who, "up") or { 0, 1, 0 })
  if from == to then
    check.fail("%s: from and to are the same point", who)
  end
  local z = (to - from):normalize()
  local x = up:cross(z)
  if x:length() < 1e-6 * up:length() then -- straight up or down: any side will do, the same one each time
    x = (math.abs(z[1]) < 0.6 and vec.make(1, 0, 0) or vec.make(0, 0, 1)):cross(z)
  end
  x = x:normalize()
  local y = z:cross(x)
  return transform.make { x[1], y[1], z[1], from[1], x[2], y[2], z[2], from[2], x[3], y[3], z[3], from[3] }
end

return path
