-- Completions for bash, zsh and fish, written from the command table.

local commands = require "rtray.commands"
local output = require "rtray.output"
local cli = require "rtray.cli"
local types = require "rtray.types"

local completion = {}

local function visible()
  local list = {}
  for _, command in ipairs(commands) do
    if not command.hidden then
      list[#list + 1] = command
    end
  end
  return list
end

local function names_of(list)
  local names = {}
  for _, command in ipairs(list) do
    names[#names + 1] = command.name
  end
  return table.concat(names, " ")
end

local function spellings(command)
  local names = {}
  for _, option in ipairs(command.options) do
    for _, name in ipairs(option.names) do
      names[#names + 1] = name
    end
  end
  return names
end

local function takes_file(option)
  return option.type == "file" or option.type == "folder"
end

local function bash()
  local out = {
    "# bash completion for rtray, written by `rtray completion bash`",
    "_rtray()",
    "{",
    "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}",
    "    COMPREPLY=()",
    "    if [ \"$COMP_CWORD\" -eq 1 ]; then",
    ("        COMPREPLY=($(compgen -W '%s --help --version' -- \"$cur\"))"):format(names_of(visible())),
    "        return",
    "    fi",
    "    case $command:$prev in",
    ("    help:*) COMPREPLY=($(compgen -W '%s' -- \"$cur\")); return ;;"):format(names_of(visible())),
  }
  local function add(...)
    out[#out + 1] = string.format(...)
  end
  for _, command in ipairs(visible()) do
    for _, option in ipairs(command.options) do
      for _, name in ipairs(option.names) do
        if option.choices then
          add("    %s:%s) COMPREPLY=($(compgen -W '%s' -- \"$cur\")); return ;;", command.name, name, table.concat(option.choices, " "))
        elseif option.value and not takes_file(option) then
          add("    %s:%s) return ;;", command.name, name)
        elseif option.value then
          add("    %s:%s) compopt -o filenames; COMPREPLY=($(compgen -f -- \"$cur\")); return ;;", command.name, name)
        end
      end
    end
  end
  add "    esac"
  add "    if [ \"${cur#-}\" != \"$cur\" ]; then"
  add "        case $command in"
  for _, command in ipairs(visible()) do
    add("        %s) COMPREPLY=($(compgen -W '%s' -- \"$cur\")) ;;", command.name, table.concat(spellings(command), " "))
  end
  add "        esac"
  add "        return"
  add "    fi"
  add "    local IFS=$'\\n'"
  add "    compopt -o filenames"
  add "    COMPREPLY=($(compgen -f -- \"$cur\"))"
  add "}"
  add "complete -F _rtray rtray"
  return table.concat(out, "\n") .. "\n"
end

-- Text inside single quotes of a shell, and inside the brackets of zsh's _arguments.
local function quoted(text)
  return "'" .. text:gsub("'", "'\\''") .. "'"
end

local function zsh_option(option, name, others)
  local escaped = option.help:gsub("[%[%]:\\]", "\\%0")
  local action = ""
  if option.value then
    local values = takes_file(option) and "_files" or option.choices and "(" .. table.concat(option.choices, " ") .. ")" or " "
    action = (":%s:%s"):format(option.value:gsub("[:=]", " "), values)
  end
  local head = option.many and "*" or "(" .. others .. ")"
  return quoted(("%s%s[%s]%s"):format(head, name, escaped, action))
end

local function zsh()
  local out = { "#compdef rtray", "# zsh completion for rtray, written by `rtray completion zsh`", "", "_rtray() {" }
  local function add(...)
    out[#out + 1] = string.format(...)
  end
  add "  local -a commands"
  add "  commands=("
  for _, command in ipairs(visible()) do
    add("    %s", quoted(command.name .. ":" .. command.summary:gsub(":", "\\:")))
  end
  add "  )"
  add "  if (( CURRENT == 2 )); then"
  add "    _describe -t commands 'rtray command' commands"
  add "    return"
  add "  fi"
  add "  local command=$words[2]"
  add "  shift words"
  add "  (( CURRENT-- ))"
  add "  case $command in"
  for _, command in ipairs(visible()) do
    add("    %s)", command.name)
    add "      _arguments -s \\"
    for _, option in ipairs(command.options) do
      for _, name in ipairs(option.names) do
        add("        %s \\", zsh_option(option, name, table.concat(option.names, " ")))
      end
    end
    if command.arguments[1] and command.arguments[1].type == "command" then
      add("        '1:command:(%s)'", names_of(visible()))
    else
      add "        '*:file:_files'"
    end
    add "      ;;"
  end
  add "  esac"
  add "}"
  add ""
  add "_rtray \"$@\""
  return table.concat(out, "\n") .. "\n"
end

local function fish()
  local out = { "# fish completion for rtray, written by `rtray completion fish`" }
  local function add(...)
    out[#out + 1] = string.format(...)
  end
  add "complete -c rtray -n __fish_use_subcommand -f -l version -d 'print the version'"
  for _, command in ipairs(visible()) do
    add("complete -c rtray -n __fish_use_subcommand -f -a %s -d %s", command.name, quoted(command.summary))
  end
  add("complete -c rtray -n '__fish_seen_subcommand_from help' -f -a '%s'", names_of(visible()))
  for _, command in ipairs(visible()) do
    for _, option in ipairs(command.options) do
      local parts = { ("complete -c rtray -n '__fish_seen_subcommand_from %s'"):format(command.name) }
      for _, name in ipairs(option.names) do
        parts[#parts + 1] = name:sub(1, 2) == "--" and "-l " .. name:sub(3) or "-s " .. name:sub(2)
      end
      if option.choices then
        parts[#parts + 1] = ("-x -a '%s'"):format(table.concat(option.choices, " "))
      elseif option.value then
        parts[#parts + 1] = takes_file(option) and "-r" or "-x"
      end
      parts[#parts + 1] = "-d " .. quoted(option.help)
      add("%s", table.concat(parts, " "))
    end
  end
  return table.concat(out, "\n") .. "\n"
end

local SHELLS = { bash = bash, zsh = zsh, fish = fish }

function completion.run(command, values, arguments)
  local write = SHELLS[arguments[1]]
  if not write then
    cli.fault(command, "%s is no shell that completions are written for; known are bash, zsh, fish", types.quote(arguments[1]))
  end
  local text = write()
  if values.output and values.output ~= "-" then
    require("rtray.files").replace(values.output, text)
  else
    output.write(text)
  end
  return 0
end

return completion
