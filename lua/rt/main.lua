-- A script as a program: `lua5.4 scene.lua --size 1000x700 -o out.png`. Its options are rtray's for rendering, read by the settings' own rows.

local core = require "rt.core"
local check = require "rt.check"
local animation = require "rt.animation"
local outputs = require "rt.outputs"
local scene = require "rt.scene"
local settings = require "rt.settings"
local words = require "rt.words"

local SHORT = { ["-o"] = "--output", ["-s"] = "--size", ["-n"] = "--samples", ["-j"] = "--workers", ["-q"] = "--quiet", ["-h"] = "--help" }

local function usage(r)
  print(("usage: lua5.4 %s [-o FILE] [-D NAME=VALUE ...] [--set NAME] [--frame N] [--quiet] [--SETTING VALUE ...]"):format(r.path))
  print "settings:"
  print "  --size WxH            width and height at once"
  for _, row in ipairs(settings.list) do
    if row.kind ~= "crop" then
      print(("  --%-19s %s"):format(row.name:gsub("_", "-"), row.help))
    end
  end
  for i, p in ipairs(r.params) do
    print((i == 1 and "parameters:\n" or "") .. ("  -D %-19s %s"):format(p.name .. "=" .. tostring(p.value), p.help or p.type))
  end
end

-- The options: output, quiet, help, and settings by name.
local function parse(arguments)
  local o, i = { settings = {} }, 1
  local function fault(...)
    error("command line: " .. string.format(...), 0)
  end
  while arguments[i] do
    local option, text = arguments[i]:match "^(%-%-[^=]+)=(.*)$"
    option = option or SHORT[arguments[i]] or arguments[i]
    local name = option:gsub("^%-%-", ""):gsub("-", "_")
    if option == "--quiet" or option == "--help" then
      o[name] = true
    elseif not option:find "^%-D." then -- parameters were read when the module was loaded
      if not text then
        i = i + 1
        text = arguments[i] or fault("%s needs a value", option)
      end
      if option == "--output" then
        o.output = text
      elseif option == "--frame" then
        o.frame = text:find "^%d+$" and math.tointeger(tonumber(text)) or fault("--frame needs a whole number; got '%s'", words.quote(text))
      elseif option:sub(1, 2) == "--" and settings.fields[name] then
        o.settings[name] = settings.read(name, text, "command line")
      elseif option ~= "-D" and option ~= "--define" and option ~= "--set" then
        fault("'%s' is no option; --help lists them", words.quote(option))
      end
    end
    i = i + 1
  end
  return o
end

local function note(done)
  io.stderr:write(("\r%3d%%"):format(math.floor(done * 100)))
end

-- Prints a message and ends the program. The place of rt.main in the script says nothing about a command line.
local function stop(message, status)
  local place = core.where()
  if message:sub(1, #place) == place then
    message = message:sub(#place + 1)
  end
  io.stderr:write((message:gsub("\n.*", "")), "\n")
  os.exit(status, true)
end

local function render(value, r, o)
  if o.help then
    return usage(r)
  end
  r.settings = settings.check(o.settings, "command line")
  if animation.is(value) then
    if (o.frame or 0) >= value.frames then
      error(("%s: there is no frame %d; the animation has %d, 0 to %d"):format(r.path, o.frame, value.frames, value.frames - 1), 0)
    end
    value = value:scene_at(o.frame or 0)
  elseif not scene.is(value) then
    error(("%s: rt.main takes a scene or an animation; got %s"):format(r.path, check.describe(value)), 0)
  end
  local output = o.output or (r.path:match "([^/]*)$"):gsub("%.[^.]*$", "") .. ".png"
  outputs.check(output, "--output")
  local read = outputs.read_by(r, output)
  if read then
    error(("--output: '%s' is a file that the scene reads (%s); name another file"):format(words.quote(output), words.quote(read)), 0)
  end
  local shown = not o.quiet and core.is_terminal(2) -- a line that is written over is one on a terminal only
  local made, stats = value:render { progress = shown and note or nil }
  made:save(output)
  if not o.quiet then
    local width, height = made:size()
    io.stderr:write(shown and "\r" or "", ("%s: %d x %d, %d rays, %.2f s\n"):format(output, width, height, stats.rays, stats.seconds))
  end
end

return function(value, r)
  local parsed, o = pcall(parse, arg)
  if not parsed then
    stop(o, 2)
  end
  local ok, message = pcall(render, value, r, o)
  if not ok then
    stop(tostring(message), 1)
  end
  return value
end
