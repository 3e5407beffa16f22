-- What was raised, as { status, message }: 1 the scene or a file, 2 the command line, 3 the machine.

local check = require "rt.check"
local limits = require "rtray.limits"
local sys = require "rtray.sys"

local faults = {}

local MACHINE = { RT_ERROR_MEMORY = true, RT_ERROR_MEMORY_LIMIT = true, RT_ERROR_THREAD = true }

-- Reasons of the system that are the machine's: in the module's messages by number, in our own by their words.
local REASONS = { "not enough memory" }
for _, failure in ipairs(sys.failures()) do
  REASONS[#REASONS + 1] = failure.text
  REASONS[#REASONS + 1] = ("(errno %d)"):format(failure.number)
end

local function is_machine(message)
  local failure = check.refusal(message)
  if failure and MACHINE[failure.status] then
    return true
  end
  for _, reason in ipairs(REASONS) do
    if message:find(reason, 1, true) then
      return true
    end
  end
  return false
end

-- A fault of the program's own: a plain table, for a script's may have functions in it.
local function is_fault(raised)
  return type(raised) == "table" and getmetatable(raised) == nil and type(raised.message) == "string"
    and math.type(raised.status) == "integer" and raised.status > 0
end

function faults.of(raised)
  local ran_out = limits.told(raised)
  if ran_out then
    return { status = 1, message = ran_out }
  elseif is_fault(raised) then
    return raised
  elseif type(raised) ~= "string" then
    return { status = 1, message = ("the script raised a %s instead of a message"):format(type(raised)) }
  elseif sys.interrupted() then
    return { status = 1, message = "interrupted" }
  end
  return { status = is_machine(raised) and 3 or 1, message = raised }
end

return faults
