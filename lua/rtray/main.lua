-- Entry of the program: finds the command, runs it, turns what it raises into a sentence and an exit status.

local commands = require "rtray.commands"
local cli = require "rtray.cli"
local help = require "rtray.help"
local inputs = require "rtray.inputs"
local output = require "rtray.output"
local faults = require "rtray.faults"
local words = require "rt.words"

local function dispatch(argv)
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
  local skip = first == "bench" and argv[2] == "rays" and 2 or 1 -- two words for one command
  local command = help.find(skip == 2 and "bench-rays" or first)
  local values, arguments = cli.parse(command, argv, skip + 1)
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
