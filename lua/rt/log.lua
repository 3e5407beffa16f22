-- What the library has to say (a missing texture, degenerate faces) arrives on threads that never enter Lua; here the calling one delivers it.

local core = require "rt.core"
local check = require "rt.check"

local log = {}

local function default(level, message)
  if level == "warning" or level == "error" then
    warn("rt: ", message, "\n")
  end
end

local handler = default

-- rt.on_log(f): f(level, message) is called for each line from now on; nil brings back the default, Lua's warn. Returns the one before.
function log.on_log(f)
  if f ~= nil then
    check.callable(f, "rt.on_log", "the argument")
  end
  local before = handler
  handler = f or default
  return before ~= default and before or nil
end

function log.deliver()
  local lines = core.take_log()
  for _, line in ipairs(lines or {}) do
    handler(line[1], line[2])
  end
end

return log
