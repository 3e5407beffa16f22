-- --limit time=10s,memory=2G: what a scene may take, whether it is its script, a build or a render that takes it (limits.c). When time runs out the
-- program stops as it does after Ctrl-C: what is finished of a render is saved; inside of a call that cannot be stopped it ends half a second later,
-- and nothing more is written.

local sys = require "rtray.sys"

local limits = {}

local current = {} -- what holds now

-- Limits from now on, as types.lua reads them (nil: none). For each frame of a film and each point of a sweep anew: the time begins again.
function limits.start(limit)
  current = limit or {}
  sys.phase "in the render"
  sys.limit_memory(current.bytes or 0)
  if not sys.limit_time(current.seconds, current.time and ("the time limit of %s ran out"):format(current.time)) then
    error({ status = 3, message = "--limit time: the system gave no thread to watch the time" }, 0)
  end
end

function limits.stop()
  limits.start(nil)
end

-- The time ran out and what is finished is to be saved: `seconds` are given for that.
function limits.grace(seconds)
  sys.limit_grace(seconds)
end

local function is_memory(raised)
  local failure = require("rt.check").refusal(raised)
  return type(raised) == "string" and raised:find("not enough memory", 1, true) ~= nil or failure ~= nil and failure.status == "RT_ERROR_MEMORY"
end

-- The sentence about a limit that ran out, or nil; `raised` is the message that came of it. The limit is then no longer in the program's way.
function limits.told(raised)
  if sys.interrupted() == "time" then
    local text = sys.limit_words()
    sys.limit_time(nil)
    return text
  end
  local where = current.bytes and sys.memory_refused()
  if where and is_memory(raised) then
    sys.limit_memory(0)
    return ("the memory limit of %s ran out %s"):format(current.memory, where)
  end
  return nil
end

return limits
