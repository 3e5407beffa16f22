-- Cameras: where from and whereto, the lens, the shutter, and the way they go while it is open.

local check = require "rt.check"
local class = require "rt.class"

local FRAME_HEIGHT = 0.024 -- metres: of the film that f-numbers are about

local distance, positive = check.number { low = 0, high = check.LARGEST }, check.number { above = 0 }
local length = check.number { above = 0, most = check.LARGEST }

-- What may differ at the end of a camera's way.
local WAY = {
  eye = check.place, look_at = check.place, up = check.direction, fov = check.number { above = 0, below = 180 }, height = length,
  aperture = distance, f_stop = positive, focus_distance = check.number { above = 0, high = 1e12 }, focus_at = check.place,
}

local time = check.number { low = 0, high = 1 }

-- A number: how long from time 0 on the shutter is open; or both of its times.
local function shutter(value, who, key)
  if type(value) ~= "table" then
    return { 0, time(value, who, key) }
  end
  local pair = check.numbers(2)(value, who, key)
  time(pair[1], who, key .. "[1]")
  time(pair[2], who, key .. "[2]")
  if pair[1] > pair[2] then
    check.fail("%s: %s closes at %s, before it opens at %s", who, key, tostring(pair[2]), tostring(pair[1]))
  end
  return pair
end

local function corners(value, who, key)
  local n = check.integer { low = 0, high = 64 }(value, who, key)
  if n == 1 or n == 2 then
    check.fail("%s: %s must be a whole number from 3 to 64, or 0 for a round lens; got %d", who, key, n)
  end
  return n
end

-- How far along the view a point lies.
local function along(o, p, who)
  local d, l = 0, 0
  for k = 1, 3 do
    local view = o.look_at[k] - o.eye[k]
    d, l = d + view * (p[k] - o.eye[k]), l + view * view
  end
  d = d / math.sqrt(l)
  if d <= 0 then
    check.fail("%s: focus_at lies behind the camera; what is sharp is ahead of it", who)
  end
  return d
end

local SHARED = { "projection", "blades", "blade_rotation", "shutter" }

-- The camera's numbers as the library takes them.
local function resolve(o, who)
  if o.eye[1] == o.look_at[1] and o.eye[2] == o.look_at[2] and o.eye[3] == o.look_at[3] then
    check.fail("%s: eye and look_at are the same point", who)
  end
  local r = {
    eye = o.eye, look_at = o.look_at, up = o.up, fov = o.fov, height = o.height, aperture = o.aperture, focus_distance = o.focus_distance,
  }
  for _, key in ipairs(SHARED) do
    r[key] = o[key]
  end
  if o.shutter then
    r.shutter_open, r.shutter_close = o.shutter[1], o.shutter[2]
  end
  if o.f_stop then -- focal length of a lens that shows `fov` on the film, over twice the f-number
    r.aperture = FRAME_HEIGHT / 2 / math.tan(math.rad(o.fov or 50) / 2) / (2 * o.f_stop) / (o.unit or 1)
  end
  if o.focus_at then
    r.focus_distance = along(o, o.focus_at, who)
  end
  return r
end

local function check_pairs(o, who)
  if o.aperture and o.f_stop then
    check.fail("%s: aperture and f_stop both say how wide the lens is; give one", who)
  elseif o.focus_distance and o.focus_at then
    check.fail("%s: focus_distance and focus_at both say what is sharp; give one", who)
  end
end

local function check_kind(o, parallel, who)
  if o.height and not parallel then
    check.fail("%s: height belongs to projection = 'orthographic'; a pinhole camera has fov", who)
  elseif o.fov and parallel then
    check.fail("%s: fov belongs to a pinhole camera; an orthographic one has height", who)
  elseif o.f_stop and parallel then
    check.fail("%s: f_stop belongs to a pinhole camera; an orthographic one has an aperture", who)
  end
end

-- The camera at the end of its way: what motion does not name is as at the start.
local function at_end(o, motion)
  local e = {}
  for key, value in next, o do
    e[key] = value
  end
  if motion.aperture or motion.f_stop then
    e.aperture, e.f_stop = nil, nil
  end
  if motion.focus_distance or motion.focus_at then
    e.focus_distance, e.focus_at = nil, nil
  end
  for key in next, WAY do
    e[key] = motion[key] ~= nil and motion[key] or e[key]
  end
  return e
end

local fields = { projection = check.choice { "pinhole", "orthographic" }, unit = check.number { above = 0 }, blades = corners,
  blade_rotation = check.number { low = -1e6, high = 1e6 }, shutter = shutter }
for key, field in next, WAY do
  fields[key] = field
end
function fields.motion(value, who, key)
  if class.kind(value) == "camera" then
    return value
  end
  return check.fields(check.plain_table(value, who .. ": " .. key, "motion = { eye = {1, 1, 5} }"), WAY, who .. ": " .. key)
end

-- The camera's numbers, and those at the end of its way.
local function numbers(o, who)
  local parallel = o.projection == "orthographic"
  check_pairs(o, who)
  check_kind(o, parallel, who)
  if o.unit and not o.f_stop then
    check.fail("%s: unit says how many metres a scene unit is for f_stop, which is not given", who)
  end
  local motion = o.motion
  if not motion then
    return resolve(o, who)
  elseif (motion.projection or o.projection) ~= o.projection then
    check.fail("%s: motion has another projection; a camera keeps its own", who)
  end
  check_pairs(motion, who .. ": motion")
  check_kind(motion, parallel, who .. ": motion")
  return resolve(o, who), resolve(at_end(o, motion), who .. ": motion")
end

local camera = {}

-- rt.camera { eye = ..., look_at = ..., aperture = 0.05, focus_at = ..., shutter = 0.5, motion = { eye = ... } }
camera.new = class.new {
  name = "camera", kind = "camera", example = "rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0} }",
  fields = fields, required = { "eye", "look_at" },
  finish = function(o, _, who)
    numbers(o, who)
  end,
}

-- What the library takes for a camera as it is now: its numbers, and those at the end of its way or nil.
function camera.numbers(o)
  return check.at(o.place, numbers, class.checked(o), tostring(o))
end

return camera
