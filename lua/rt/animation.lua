-- Animations: a function of time that returns scenes.

local check = require "rt.check"
local run = require "rt.run"
local scene = require "rt.scene"

local animation = {}
local methods = {}
local meta = { __name = "rt.animation", __index = methods }

function animation.is(value)
  return getmetatable(value) == meta
end

local fields = {
  frames = check.integer { low = 1, high = 1000000 }, fps = check.number { above = 0, high = 1000 }, loop = check.boolean,
  shutter = check.number { above = 0, high = 1 }, scene = check.callable, name = check.string,
}

-- rt.animation { frames = 120, fps = 24, loop = true, shutter = 0.5, scene = function(t, frame, seconds) return rt.scene { ... } end }
function animation.new(t)
  local who = "rt.animation"
  check.plain_table(t, who, "rt.animation { frames = 120, scene = function(t) return rt.scene { ... } end }")
  local o = check.fields(t, fields, who)
  check.required(o, { "frames", "scene" }, who)
  return setmetatable({
    frames = o.frames, fps = o.fps or 24, loop = o.loop or false, once = o.loop == false, shutter = o.shutter, name = o.name,
    describe = o.scene, run = run.current(),
  }, meta)
end

local number = check.number()

-- animation:time(frame): t and seconds. A loop's t is frame / frames, so that the frame after the last is the first again; otherwise t is
-- frame / (frames - 1), which reaches 1. Frames may have a fraction, as the shutter's close has.
function methods.time(self, frame)
  frame = number(frame, "animation:time", "the frame")
  local last = self.loop and self.frames or self.frames - 1
  return last > 0 and frame / last or 0.0, frame / self.fps
end

-- What the function describes at `place` (a frame, perhaps with a fraction).
local function describe(self, frame, place)
  local t, seconds = self:time(place)
  local value
  if self.run then
    local before = self.run.inner
    self.run.inner = self.describe
    local ok, result = pcall(run.call, self.run, self.describe, t, frame, seconds)
    self.run.inner = before
    if not ok then
      error(result, 0)
    end
    value = result
  else
    value = self.describe(t, frame, seconds)
  end
  if type(value) == "table" and getmetatable(value) == nil then
    value = scene.new(value)
  end
  if not scene.is(value) then
    error(("%sthe scene function returned %s; it must return a scene, as in `return rt.scene { ... }`"):format(run.place_of(self.describe),
      value == nil and "nothing" or check.describe(value)), 0)
  end
  return value
end

-- The scene of a frame, 0 ... frames - 1: what the function describes, or with a shutter, what moves between the frame's begin and the shutter's
-- close. An error names the frame.
function methods.scene_at(self, frame)
  frame = check.integer { low = 0, high = self.frames - 1 }(frame, "animation:scene_at", "the frame")
  local where = ""
  local ok, result = pcall(function()
    local open = describe(self, frame, frame)
    if not self.shutter then
      return open
    end
    where = ", the shutter's close"
    local close = describe(self, frame, frame + self.shutter)
    where = ", between the shutter's open and close"
    return require("rt.motion").join(open, close)
  end)
  if not ok and type(result) == "string" then
    local t = self:time(frame)
    result = ("%s (frame %d, t = %.6g%s)"):format(result, frame, t, where)
  end
  if not ok then
    error(result, 0)
  end
  return result
end

function meta.__tostring(self)
  return ("%s (%d frames, %g a second)"):format(self.name and "rt.animation '" .. self.name .. "'" or "rt.animation", self.frames, self.fps)
end

return animation
