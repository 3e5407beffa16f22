-- What was raised, as { status, message }: 1 the scene or a file, 2 the command line, 3 the machine.

local sys = require "rtray.sys"

local faults = {}

local MACHINE = { "not enough memory", "could not be had", "memory limit", "RT_ERROR_MEMORY", "RT_ERROR_THREAD" }
for _, reason in ipairs(sys.failures()) do
  MACHINE[#MACHINE + 1] = reason
end

local function is_machine(message)
  for _, sign in ipairs(MACHINE) do
    if message:find(sign, 1, true) then
      return true
    end
  end
  return false
end

function faults.of(raised)
  if type(raised) == "table" and raised.status then
    return raised
  end
  local message = tostring(raised)
  if sys.interrupted() then
    return { status = 1, message = "interrupted" }
  end
  return { status = is_machine(message) and 3 or 1, message = message }
end

return faults
