-- Reads a command line against a command's row in commands.lua. A fault raises { status = 2, message = ..., usage = command }.

local words = require "rt.words"
local types = require "rtray.types"

local cli = {}

local function fault(command, message, ...)
  error({ status = 2, message = message:format(...), usage = command and (command.spoken or command.name) }, 0)
end
cli.fault = fault

-- Options of a command by every spelling, and the spellings in order of the table, for hints.
local function index(command)
  local by_name, names = {}, {}
  for _, option in ipairs(command.options) do
    for _, name in ipairs(option.names) do
      by_name[name] = option
      names[#names + 1] = name
    end
  end
  return by_name, names
end

local function unknown(command, name, names)
  local near = words.nearest(name, names)
  fault(command, "unknown option %s%s", types.quote(name), near and "; did you mean " .. near .. "?" or "")
end

local function store(command, values, option, name, text)
  local value = true
  if option.value then
    local why
    value, why = types.read(option, text)
    if value == nil then
      fault(command, "%s %s: %s", name, types.quote(text), why)
    end
  end
  if option.many then
    local list = values[option.key] or {}
    list[#list + 1] = value
    values[option.key] = list
  else
    values[option.key] = value
  end
end

-- "--name", "--name=value", "-o", "-ovalue": the option, its name as written, and the value written behind it.
local function split(command, arg, by_name, names)
  local name, text = arg:match "^(%-%-[^=]+)=(.*)$"
  if not name and arg:sub(1, 2) ~= "--" and #arg > 2 then
    name, text = arg:sub(1, 2), arg:sub(3)
  end
  name = name or arg
  local option = by_name[name]
  if not option then
    unknown(command, name, names)
  end
  if text and not option.value then
    fault(command, "%s takes no value, but %s stands behind it", name, types.quote(text))
  end
  return option, name, text
end

local function check_count(command, given)
  local least, most = 0, 0
  for _, argument in ipairs(command.arguments) do
    least = least + (argument.optional and 0 or 1)
    most = argument.many and math.huge or most + 1
  end
  for i, text in ipairs(given) do
    if text == "" and command.arguments[i] then
      fault(command, "%s is empty", command.arguments[i].name)
    end
  end
  if #given < least then
    fault(command, "%s is missing", command.arguments[#given + 1].name)
  elseif #given > most then
    fault(command, "%s is one argument too many", types.quote(given[most + 1]))
  end
end

-- args[first...] for `command`: the option values by key, and the list of arguments.
function cli.parse(command, args, first)
  local by_name, names = index(command)
  local values, given = {}, {}
  local i, only_arguments = first, false
  while i <= #args do
    local arg = args[i]
    i = i + 1
    if only_arguments or arg == "-" or arg:sub(1, 1) ~= "-" or arg == "" then
      given[#given + 1] = arg
    elseif arg == "--" then
      only_arguments = true
    else
      local option, name, text = split(command, arg, by_name, names)
      if option.value and not text then
        text = args[i]
        i = i + 1
        if text == nil then
          fault(command, "%s needs a value: %s", name, option.value)
        end
      end
      store(command, values, option, name, text)
    end
  end
  values.words = args
  if not values.help then
    check_count(command, given)
  end
  return values, given
end

return cli
