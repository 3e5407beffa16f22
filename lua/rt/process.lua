-- Other programs: `process.spawn { "ffmpeg", "-i", "-", stdin = "pipe" }` starts one by its argument vector (no shell ever sees a name), with pipes,
-- limits and an end that cannot be missed: released, collected or orphaned, the child is gone. Waiting is done in short steps, so that
-- an interrupt comes through. The program knows this as sys.spawn and sys.run.

local core = require "rt.core"
local check = require "rt.check"

local process = {}
local methods = {}
local meta = { __name = "rt.process", __index = methods }

local STEP = 0.05 -- seconds between two chances for an interrupt

local mode = check.choice { "inherit", "null", "pipe" }
local count = check.integer { low = 0, high = math.maxinteger }
local fields = {
  stdin = mode, stdout = mode, stderr = check.choice { "inherit", "null", "pipe", "stdout" }, cwd = check.string, group = check.boolean,
  buffer = count,
  limits = function(value, who, key)
    return check.fields(value, { cpu = count, memory = count, file = count, files = count }, who .. ": " .. key)
  end,
  env = function(value)
    local list = {}
    for _, name in ipairs(check.sorted_keys(value)) do
      list[#list + 1] = name .. "=" .. tostring(value[name])
    end
    return list
  end,
}

-- process.spawn { program, argument, ..., stdin = "null", stdout = "inherit", stderr = "inherit" }: the running child, or nil, the system's reason
-- and its number (2: there is no such program). Streams are "inherit", "null", "pipe", and "stdout" for standard error. Further keys:
--   env = { NAME = "value" }   added to ours             cwd = "folder"
--   group = true               leads a process group: a terminal's Ctrl-C does not reach it, and kill reaches its own children
--   limits = { cpu = seconds, memory = bytes of address space, file = bytes, files = count }
--   buffer = bytes             of output that wait here until they are read; then the child waits
function process.spawn(t)
  local who = "process.spawn"
  local started = check.fields(t, fields, who, true)
  for i = 1, #t do
    started[i] = tostring(t[i])
  end
  local handle, why, number = core.process_start(started)
  if not handle then
    return nil, why, number
  end
  return setmetatable({ handle = handle, name = started[1] }, meta)
end

-- Writes all of `text` to the child's input, waiting as long as it takes. True; or nil and why when the child reads no more.
function methods.write(self, text)
  local first = 1
  while first <= #text do
    local taken, why = self.handle:feed(text, first)
    if not taken then
      return nil, why
    end
    first = first + taken
    if taken == 0 then
      self.handle:step(STEP, true)
    end
  end
  return true
end

-- Ends the child's input.
function methods.close_input(self)
  self.handle:close_input()
end

-- Steps until ready() gives something or the time is over.
local function await(self, seconds, ready)
  local till = seconds and core.clock() + seconds
  while true do
    local found, value = ready()
    if found then
      return value
    end
    local left = till and till - core.clock() or STEP
    if left <= 0 then
      return nil, "timeout"
    end
    self.handle:step(math.min(left, STEP))
  end
end

-- The next line of its output without its end, also a last one that has none; nil and "end" or "timeout" (seconds; nil: waits on).
function methods.line(self, seconds)
  local handle, ended = self.handle, false
  local line, why = await(self, seconds, function()
    local size, closed = handle:find_line()
    if size > 0 then
      return true, (handle:take(1, size):gsub("\n$", ""))
    end
    ended = closed
    return closed, nil
  end)
  return line, ended and "end" or why
end

-- The output that is here by now, at least a byte; nil and "end" or "timeout".
function methods.read(self, seconds, stream)
  local number = stream == "stderr" and 2 or 1
  local ended = false
  local text, why = await(self, seconds, function()
    local got, last = self.handle:take(number)
    if got ~= "" then
      return true, got
    elseif last then
      ended = true
      return true, nil
    end
  end)
  return text, ended and "end" or why
end

-- Waits for the end: { status, signal, seconds, user_seconds, system_seconds, max_rss }; nil when it still runs after `seconds`.
function methods.wait(self, seconds)
  return (await(self, seconds, function()
    local result = self.handle:result()
    return result, result
  end))
end

-- Feeds `input`, reads all output, waits; after `seconds` the child is killed. { out, err, timed_out, status, ... } as wait gives it.
function methods.communicate(self, input, seconds)
  local handle, first, out, err = self.handle, 1, {}, {}
  local till = seconds and core.clock() + seconds
  local timed_out
  while true do
    if input and first <= #input then
      local taken = handle:feed(input, first)
      first = taken and first + taken or math.huge
    end
    if input and first > #input then
      handle:close_input()
      input = nil
    end
    local ended = handle:step(STEP, input ~= nil)
    out[#out + 1], err[#err + 1] = handle:take(1), (handle:take(2))
    if ended then
      break
    elseif till and not timed_out and core.clock() > till then
      timed_out = true
      handle:kill "KILL"
    end
  end
  local result = handle:result()
  result.out, result.err, result.timed_out = table.concat(out), table.concat(err), timed_out or false
  return result
end

-- Sends "TERM" (or "KILL", "INT", "CONT").
function methods.kill(self, signal)
  self.handle:kill(signal or "TERM")
end

-- Asks it to end, and after `grace` seconds (1) makes it end. Its result.
function methods.stop(self, grace)
  self.handle:kill "TERM"
  local result = self:wait(grace or 1)
  if not result then
    self.handle:kill "KILL"
    result = self:wait()
  end
  return result
end

function methods.id(self)
  return self.handle:id()
end

-- Kills it when it still runs. Twice is fine.
function methods.release(self)
  self.handle:release()
end
meta.__close = methods.release

function meta.__tostring(self)
  return ("rt.process (%s)"):format(self.name)
end

-- process.run { program, argument, ... }: its standard output and exit status (128 + n after signal n); nil and why when it cannot be started.
function process.run(t)
  local copy = table.move(t, 1, #t, 1, {})
  copy.stdin, copy.stdout = t.stdin or "inherit", "pipe"
  local child <close>, why = process.spawn(copy)
  if not child then
    return nil, why
  end
  local result = child:communicate()
  return result.out, result.status
end

return process
