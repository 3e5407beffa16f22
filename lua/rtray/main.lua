-- Entry of the program: finds the command, runs it, turns what it raises into a sentence and an exit status.

local commands = require "rtray.commands"
local cli = require "rtray.cli"
local help = require "rtray.help"
local inputs = require "rtray.inputs"
local output = require "rtray.output"
local faults = require "rtray.faults"
local words = require "rt.words"

-- Two words for one command, also behind help.
local function joined(argv)
  local at = argv[1] == "help" and 2 or 1
  if argv[at] ~= "bench" or argv[at + 1] ~= "rays" then
    return argv
  end
  local list = table.move(argv, 1, #argv, 1, {})
  list[at] = "bench-rays"
  table.remove(list, at + 1)
  return list
end

local function dispatch(argv)
  argv = joined(argv)
  local first = argv[1]
  if first == nil then
    output.note("%s", (help.overview():gsub("\n$", "")))
    return 2
  elseif first == "-h" or first == "--help" then
    output.write(help.overview())
    return 0
  elseif first == "--version" then
    return require("rtray.info").version()
  elseif first:sub(1, 1) == "-" then
    cli.fault(nil, "a command stands first, and %s is an option; `rtray help` lists the commands", first)
  end
  local command = help.find(first)
  local values, arguments = cli.parse(command, argv, 2)
  if values.help then
    output.write(help.of(command))
    return 0
  end
  inputs.begin(command, values, arguments)
  return require(command.module)[command.entry or "run"](command, values, arguments)
end

local function run(argv)
  local status = dispatch(argv)
  output.finish()
  return status
end

return function(argv)
  local ok, result = xpcall(run, faults.of, argv)
  if ok then
    return result
  end
  if type(result) ~= "table" then -- Lua calls no handler when memory is lacking
    result = faults.of(result)
  end
  local where = commands[argv[1]] and "rtray " .. argv[1] or "rtray"
  output.note("%s: %s", where, words.visible(result.message))
  if result.status == 2 then
    output.note("Try `rtray help%s`.", result.usage and " " .. result.usage or "")
  end
  return result.status
end
