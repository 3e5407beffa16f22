-- What a command reads: the files on its command line, and those that its scene has read so far. It writes over none of them, for who names one as
-- the output has no other copy of it.

local outputs = require "rt.outputs"
local sandbox = require "rtray.sandbox"
local types = require "rtray.types"

local inputs = {}

local READ = { scene = true, file = true } -- types of arguments

local command, named, scene = nil, {}, nil

-- A command begins, as cli.parse gives it.
function inputs.begin(row, values, arguments)
  command, named, scene = row.spoken or row.name, {}, nil
  for i, path in ipairs(arguments) do
    local argument = row.arguments[math.min(i, #row.arguments)]
    named[#named + 1] = argument and READ[argument.type] and path or nil
  end
  for _, option in ipairs(row.options) do
    local given = option.reads and values[option.key] or nil
    for _, path in ipairs(type(given) == "table" and given or { given }) do
      named[#named + 1] = path
    end
  end
end

-- From now on the files that this run has read count, no longer those of a run before (of a film's last frame).
function inputs.opened(run)
  scene = run
end

local function refuse(path, input, what)
  local other = input ~= path and (" (%s)"):format(types.quote(input)) or ""
  error({ status = 2, usage = command, message = ("the output %s is %s%s; name another file"):format(types.quote(path), what, other) }, 0)
end

-- Raises when the output `path` is one of them.
function inputs.check(path)
  local mark = path ~= "-" and outputs.mark(path)
  if not mark then
    return
  end
  for _, input in ipairs(named) do
    if outputs.mark(input) == mark then
      refuse(path, input, "the input itself")
    end
  end
  local read = {}
  for _, input in ipairs(scene and scene.files or {}) do
    read[#read + 1] = input
  end
  for input in pairs(scene and sandbox.reads(scene) or {}) do -- in any order: at most one name is told
    read[#read + 1] = input
  end
  table.sort(read)
  for _, input in ipairs(read) do
    if outputs.mark(input) == mark then
      refuse(path, input, "a file that the scene reads")
    end
  end
end

return inputs
