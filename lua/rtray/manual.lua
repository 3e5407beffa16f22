-- The manual page rtray(1), written from the command table like help and completions.

local commands = require "rtray.commands"
local help = require "rtray.help"
local output = require "rtray.output"

local manual = {}

-- Text for roff: no line may begin with a control character, backslashes and hyphens are themselves.
local function plain(text)
  return (text:gsub("\\", "\\e"):gsub("%-", "\\-"):gsub("\n([.'])", "\n\\&%1"):gsub("^([.'])", "\\&%1"))
end

local function option(o)
  local names = {}
  for i, name in ipairs(o.names) do
    names[i] = "\\fB" .. plain(name) .. "\\fR"
  end
  return (".TP\n%s%s\n%s"):format(table.concat(names, ", "), o.value and " \\fI" .. plain(o.value) .. "\\fR" or "", plain(help.of_option(o)))
end

local function section(command, out)
  out[#out + 1] = (".SS \"%s\""):format(plain(help.usage(command)))
  out[#out + 1] = plain(command.text)
  for _, o in ipairs(command.options) do
    if o.key ~= "help" then
      out[#out + 1] = option(o)
    end
  end
  out[#out + 1] = ".PP\n.nf"
  for _, example in ipairs(command.examples) do
    out[#out + 1] = "    " .. plain(example)
  end
  out[#out + 1] = ".fi"
end

function manual.text()
  local out = {
    (".TH RTRAY 1 \"\" \"librt %s\""):format(require("rt").version),
    ".SH NAME\nrtray \\- render scenes with librt",
    ".SH SYNOPSIS\n.B rtray\n.I COMMAND\n[\\fIARGUMENTS\\fR] [\\fIOPTIONS\\fR]",
    ".SH COMMANDS",
  }
  for _, command in ipairs(commands) do
    if not command.hidden then
      section(command, out)
    end
  end
  out[#out + 1] = ".SH EXIT STATUS"
  for _, row in ipairs(help.statuses) do
    out[#out + 1] = (".TP\n.B %d\n%s"):format(row[1], plain(row[2]))
  end
  out[#out + 1] = ".PP\nAfter SIGINT the shell sees 130, after SIGTERM 143."
  out[#out + 1] = ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nNothing is ever coloured, so it is honoured.\n.TP\n.B TERM\n"
    .. plain("With dumb, progress is a plain line every 10 seconds.")
  return table.concat(out, "\n") .. "\n"
end

function manual.run(_, values)
  local text = manual.text()
  if values.output and values.output ~= "-" then
    require("rtray.files").replace(values.output, text)
  else
    output.write(text)
  end
  return 0
end

return manual
