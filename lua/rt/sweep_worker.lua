-- Who answers the requests of a sweep: processes of their own, fresh for each timed run and one for all descriptions, or this process.

local core = require "rt.core"
local process = require "rt.process"
local sweep_run = require "rt.sweep_run"

local sweep_worker = {}

-- What starts a run's process in the place of its command: one row a value of the axis `transport`.
local LAUNCHERS = {
  threads = function(command) return command end,
}

local SERVE = [[
package.path, package.cpath = os.getenv "RT_SWEEP_PATH", os.getenv "RT_SWEEP_CPATH"
require "rt"
local out = io.stdout
out:setvbuf "full"
require("rt.sweep_run").serve(function(line) out:write(line) out:flush() end)]]

-- The command of a process that answers requests: this program, or this Lua interpreter; nil where neither is running.
local function own_command()
  local program = core.program() or (type(arg) == "table" and arg[-1])
  if not program then
    return nil
  elseif package.loaded["rtray.sys"] then
    return { program, "answer", table.unpack(require("rt.guard").arguments) }
  elseif (program:match "[^/]*$"):find "^lua" then
    return { program, "-e", SERVE, env = { RT_SWEEP_PATH = package.path, RT_SWEEP_CPATH = package.cpath } }
  end
end

function sweep_worker.can_spawn()
  return own_command() ~= nil
end

local function start(transport)
  local command = LAUNCHERS[transport or "threads"](own_command())
  command.stdin, command.stdout = "pipe", "pipe"
  local child, why = process.spawn(command)
  if not child then
    error({ status = 3, message = "a process for a run could not be started: " .. why }, 0)
  end
  return child
end

-- Why a process gave no answer.
local function ending(result)
  if result.signal == 9 then
    return "the run's process was killed (out of memory?)"
  elseif result.signal then
    return ("the run's process was ended by signal %d"):format(result.signal)
  end
  return ("the run's process ended with status %d and no answer"):format(result.status)
end

local function late(seconds)
  return ("the run took longer than --timeout %g s"):format(seconds)
end

-- Asks a fresh process, which then ends: the answer, or nil and why.
function sweep_worker.fresh(request, o)
  local child <close> = start(request.transport)
  local result = child:communicate(sweep_run.line_of(request), o.timeout)
  if result.timed_out then
    return nil, late(o.timeout)
  end
  local line = result.out:match "^([^\n]*)\n"
  if not line then
    return nil, ending(result)
  end
  local answer, why = sweep_run.read_answer(line)
  if answer then
    answer.process_seconds = result.seconds
  end
  return answer, why
end

-- Asks the process that answers all descriptions; a new one after it has died. `keeper` is a table that holds it.
function sweep_worker.kept(keeper, request, o)
  keeper.child = keeper.child or start()
  local child = keeper.child
  local line, why = nil, "end"
  if child:write(sweep_run.line_of(request)) then
    line, why = child:line(o.timeout)
  end
  if line then
    return sweep_run.read_answer(line)
  end
  keeper.child = nil
  if why == "timeout" then
    child:release()
    return nil, late(o.timeout)
  end
  child:close_input()
  local result = child:wait()
  child:release()
  return nil, ending(result)
end

-- Ends the kept process.
function sweep_worker.release(keeper)
  if keeper.child then
    keeper.child:release()
    keeper.child = nil
  end
end

return sweep_worker
