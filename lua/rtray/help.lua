-- rtray help: written from the command table.

local commands = require "rtray.commands"
local cli = require "rtray.cli"
local types = require "rtray.types"
local words = require "rt.words"

local help = {}

help.statuses = {
  { 0, "done" }, { 1, "the scene or a file is at fault, or --limit ran out" }, { 2, "the command line" }, { 3, "the machine (disk, memory)" },
  { 4, "ran well and the answer is no (compare, verify, replay)" },
}

-- Lines of at most `width` columns, each after the first indented.
local function wrap(text, width, indent)
  local lines, line = {}, ""
  for word in text:gmatch "%S+" do
    if #line > 0 and #line + 1 + #word > width - indent then
      lines[#lines + 1], line = line, word
    else
      line = line == "" and word or line .. " " .. word
    end
  end
  lines[#lines + 1] = line
  return table.concat(lines, "\n" .. (" "):rep(indent))
end

local function argument_text(argument)
  local name = argument.name .. (argument.many and "..." or "")
  return argument.optional and "[" .. name .. "]" or name
end

function help.usage(command)
  local parts = { "rtray", command.spoken or command.name }
  for _, argument in ipairs(command.arguments) do
    parts[#parts + 1] = argument_text(argument)
  end
  if #command.options > 1 then
    parts[#parts + 1] = "[OPTIONS]"
  end
  return table.concat(parts, " ")
end

function help.of_option(option)
  local text = option.help
  if option.choices and option.type == "choice" and not text:find(option.choices[1], 1, true) then
    text = text .. ": " .. table.concat(option.choices, ", ")
  elseif option.type == "count" then
    text = ("%s (%d ... %d)"):format(text, option.low, option.high)
  end
  return text
end

function help.of(command)
  local out = { "usage: " .. help.usage(command), "", command.summary:sub(1, 1):upper() .. command.summary:sub(2) .. ".", "" }
  for paragraph in (command.text .. "\n\n"):gmatch "(.-)\n\n" do
    out[#out + 1] = wrap(paragraph, 100, 0)
    out[#out + 1] = ""
  end
  out[#out + 1] = "Options:"
  for _, option in ipairs(command.options) do
    local left = "  " .. table.concat(option.names, ", ") .. (option.value and " " .. option.value or "")
    out[#out + 1] = left .. (" "):rep(math.max(1, 30 - #left)) .. wrap(help.of_option(option), 100, 30)
  end
  out[#out + 1] = ""
  out[#out + 1] = #command.examples > 1 and "Examples:" or "Example:"
  for _, example in ipairs(command.examples) do
    out[#out + 1] = "  " .. example
  end
  return table.concat(out, "\n") .. "\n"
end

function help.overview()
  local out = { "usage: rtray COMMAND [ARGUMENTS] [OPTIONS]", "", "Renders scenes with librt.", "", "Commands:" }
  for _, command in ipairs(commands) do
    if not command.hidden then
      out[#out + 1] = ("  %-10s %s"):format(command.spoken or command.name, command.summary)
    end
  end
  out[#out + 1] = ""
  out[#out + 1] = "`rtray help COMMAND` tells more; `rtray --version` prints the version."
  local statuses = {}
  for i, row in ipairs(help.statuses) do
    statuses[i] = ("%d %s"):format(row[1], row[2])
  end
  out[#out + 1] = wrap("Exit status: " .. table.concat(statuses, "; ") .. ".", 100, 0)
  return table.concat(out, "\n") .. "\n"
end

-- The command called `name`, or a fault of the command line with the nearest one.
function help.find(name)
  local command = commands[name]
  if type(name) == "string" and command then
    return command
  end
  local names = {}
  for _, c in ipairs(commands) do
    names[#names + 1] = not c.hidden and c.name or nil
  end
  local near = words.nearest(name, names)
  cli.fault(nil, "there is no command %s%s", types.quote(name), near and "; did you mean " .. near .. "?" or "")
end

function help.run(_, _, arguments)
  local text = arguments[1] and help.of(help.find(arguments[1])) or help.overview()
  require("rtray.output").write(text)
  return 0
end

return help
