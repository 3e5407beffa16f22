-- Renders in progress.

local core = require "rt.core"
local check = require "rt.check"
local log = require "rt.log"

local job = {}
local methods = {}
local meta = { __name = "rt.job", __index = methods }

-- handle: of job.c; scene: kept alive by the job.
function job.new(handle, scene)
  return setmetatable({ handle = handle, scene = scene, taken = nil }, meta)
end

function meta.__tostring(self)
  return ("rt.job (%s)"):format(self.released and "released" or (self.handle:poll()))
end

-- State ("running", "done", "cancelled", "failed") and progress 0 ... 1, without waiting.
function methods.poll(self)
  return self.handle:poll()
end

-- Waits at most `seconds` (nil: to the end) in steps through which an interrupt comes. each(progress, job) is called after every step; what it raises
-- ends the job and is raised here. Returns state and progress; a failed job raises why.
function methods.wait(self, seconds, each)
  local left = seconds and check.number { low = 0 }(seconds, "job:wait", "the time") or math.huge
  local state, progress
  repeat
    local before = core.clock()
    state, progress = self.handle:step(math.min(left, 1))
    log.deliver()
    left = left - (core.clock() - before)
    if each then
      local ok, raised = pcall(each, progress, self)
      if not ok then
        self:release()
        error(raised, 0)
      end
    end
  until state ~= "running" or left <= 0
  if state == "failed" then
    self.handle:raise()
  end
  return state, progress
end

-- Ends within 100 ms; finished tiles stay.
function methods.cancel(self)
  self.handle:cancel()
end

-- for tile in job:tiles() do ... end: finished tiles { x, y, width, height } in the order of finishing, until the job ends.
function methods.tiles(self)
  return function()
    while true do
      local running = self.handle:poll() == "running"
      local tile = self.handle:next_tile()
      if tile then
        return tile
      elseif not running then
        self:wait(0)
        return nil
      end
      self:wait(0.02)
    end
  end
end

-- The image when the job has ended (unfinished tiles of a cancelled one are transparent); before, with preview = true, a copy of what is finished,
-- else nil.
function methods.image(self)
  if self.taken then
    return self.taken
  elseif self.handle:poll() == "running" then
    return self.handle:preview()
  end
  self.taken = self.handle:take()
  return self.taken
end

-- Rays, times and what each worker did.
function methods.stats(self)
  return self.handle:stats()
end

function methods.release(self)
  self.released = true
  self.handle:release()
end
meta.__close = methods.release

return job
