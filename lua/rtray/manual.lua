-- The manual pages, rtray(1) and one for each command, written from the command table like help and completions.

local commands = require "rtray.commands"
local help = require "rtray.help"
local output = require "rtray.output"

local manual = {}

-- Text for roff: no line may begin with a control character, backslashes and hyphens are themselves.
local function plain(text)
  return (text:gsub("\\", "\\e"):gsub("%-", "\\-"):gsub("\n([.'])", "\n\\&%1"):gsub("^([.'])", "\\&%1"))
end

local function title(name)
  return (".TH %s 1 \"\" \"librt %s\""):format(name:upper(), require("rt").version)
end

local function paragraphs(text)
  return (plain(text):gsub("\n\n+", "\n.PP\n"))
end

local function option(o)
  local names = {}
  for i, name in ipairs(o.names) do
    names[i] = "\\fB" .. plain(name) .. "\\fR"
  end
  return (".TP\n%s%s\n%s"):format(table.concat(names, ", "), o.value and " \\fI" .. plain(o.value) .. "\\fR" or "", plain(help.of_option(o)))
end

local function statuses(out)
  out[#out + 1] = ".SH EXIT STATUS"
  for _, row in ipairs(help.statuses) do
    out[#out + 1] = (".TP\n.B %d\n%s"):format(row[1], plain(row[2]))
  end
  out[#out + 1] = ".PP\nAfter SIGINT the shell sees 130, after SIGTERM 143."
end

local function shown()
  local list = {}
  for _, command in ipairs(commands) do
    list[#list + 1] = not command.hidden and command or nil
  end
  return list
end

-- rtray(1): the commands in a line each.
local function overview()
  local out = {
    title "rtray",
    ".SH NAME\nrtray \\- render scenes, films and studies with librt",
    ".SH SYNOPSIS\n.B rtray\n.I COMMAND\n[\\fIARGUMENTS\\fR] [\\fIOPTIONS\\fR]",
    ".SH DESCRIPTION\nScenes are Lua scripts, old scene definition files or mesh files. Each command has a page of its own, and\n.B rtray help\n"
      .. ".I COMMAND\ntells the same.",
    ".SH COMMANDS",
  }
  for _, command in ipairs(shown()) do
    out[#out + 1] = (".TP\n.BR rtray\\-%s (1)\n%s"):format(plain(command.name), plain(command.summary))
  end
  statuses(out)
  out[#out + 1] = ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nNothing is ever coloured, so it is honoured.\n.TP\n.B TERM\n"
    .. plain("With dumb, progress is a plain line every 10 seconds.") .. "\n.TP\n.B RT_ISA\n"
    .. plain("Instruction set of the hot loops, if not the best of the processor: generic, sse42, avx2, avx512, "
      .. "avx512_vbmi2 or neon. The pixels are the same.")
    .. "\n.TP\n.B RTRAY_CLAIM_SECONDS\n"
    .. plain("Seconds without a sign of life after which animate takes over a frame that a process of another machine has claimed; 60.")
  return table.concat(out, "\n") .. "\n"
end

local function page(command)
  local out = {
    title("rtray-" .. command.name),
    (".SH NAME\nrtray\\-%s \\- %s"):format(plain(command.name), plain(command.summary)),
    ".SH SYNOPSIS\n.nf\n" .. plain(help.usage(command)) .. "\n.fi",
    ".SH DESCRIPTION\n" .. paragraphs(command.text),
    ".SH OPTIONS",
  }
  for _, o in ipairs(command.options) do
    out[#out + 1] = option(o)
  end
  out[#out + 1] = ".SH EXAMPLES\n.nf"
  for _, example in ipairs(command.examples) do
    out[#out + 1] = plain(example)
  end
  out[#out + 1] = ".fi"
  statuses(out)
  out[#out + 1] = ".SH SEE ALSO\n.BR rtray (1)"
  return table.concat(out, "\n") .. "\n"
end

-- rtray manual [COMMAND]: one page; with -o FOLDER/, all of them.
function manual.run(_, values, arguments)
  if values.output and values.output:sub(-1) == "/" then
    local replace = require("rtray.files").replace
    replace(values.output .. "rtray.1", overview())
    for _, command in ipairs(shown()) do
      replace(("%srtray-%s.1"):format(values.output, command.name), page(command))
    end
    return 0
  end
  local text = arguments[1] and page(help.find(arguments[1])) or overview()
  if values.output and values.output ~= "-" then
    require("rtray.files").replace(values.output, text)
  else
    output.write(text)
  end
  return 0
end

return manual
