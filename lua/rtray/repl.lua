-- rtray repl: reads Lua lines. On a terminal it prompts; from a pipe it reads to the end, and a line that fails ends it with status 1.

local sys = require "rtray.sys"
local output = require "rtray.output"
local faults = require "rtray.faults"

local repl = {}

-- The chunk of `text`: as an expression when it is one. nil and "more" when it only lacks lines.
local function compile(text, name)
  local chunk = load("return " .. text, name, "t")
  if chunk then
    return chunk
  end
  local why
  chunk, why = load(text, name, "t")
  if not chunk and why:find "near <eof>$" then
    return nil, "more"
  end
  return chunk, why
end

local function show(results)
  if results.n > 0 then
    local parts = {}
    for i = 1, results.n do
      parts[i] = tostring(results[i])
    end
    output.write(table.concat(parts, "\t") .. "\n")
  end
end

-- Runs a chunk; false and the message when it raised.
local function run(chunk)
  sys.defer(false)
  local results = table.pack(xpcall(chunk, function(raised)
    return faults.of(raised).message
  end))
  sys.defer(true)
  if not results[1] then
    return false, results[2]
  end
  table.move(results, 2, results.n, 1)
  results.n = results.n - 1
  show(results)
  return true
end

local function read_line(prompt, terminal)
  if terminal then
    output.write(prompt)
  end
  return io.read "L"
end

local function loop(terminal)
  local text, number = nil, 0
  while true do
    local line = read_line(text and ">> " or "> ", terminal)
    if sys.interrupted() then
      if sys.interrupted() ~= "SIGINT" or not terminal then
        return 1
      end
      sys.forgive() -- Ctrl-C drops the line
      text, line = nil, "\n"
      output.write "\n"
    end
    if not line then
      if terminal then
        output.write "\n"
      end
      if text then
        output.note("rtray repl: the input ends inside of a statement")
        return 1
      end
      return 0
    end
    number = number + 1
    text = (text or "") .. line
    local chunk, why = compile(text, "=line " .. number)
    if chunk or why ~= "more" then
      text = nil
      local ok = chunk ~= nil
      if chunk then
        ok, why = run(chunk)
      end
      if not ok then
        output.note("%s", why)
        if sys.interrupted() == "SIGINT" and terminal then
          sys.forgive()
        elseif not terminal then
          return 1
        end
      end
    end
  end
end

function repl.run(_, values, arguments)
  local rt = require "rt"
  _G.rt = rt
  if arguments[1] then
    _G.scene = require("rtray.source").open(arguments[1], values).scene
    require("rtray.limits").stop()
  end
  local terminal = sys.is_terminal(0) and sys.is_terminal(1)
  if terminal then
    output.print("rtray %s, %s; the module is in rt%s; Ctrl-D ends", rt.version, _VERSION, arguments[1] and ", the scene in scene" or "")
  end
  sys.guard_own()
  sys.defer(true)
  return loop(terminal)
end

return repl
