-- What goes between scripts of the program and the world as text: what they print, and scripts that stand in memory in the place of files.

local sys = require "rtray.sys"
local guard = require "rt.guard"
local run = require "rt.run"
local words = require "rt.words"

local texts = {}

-- ---- what scripts print ----

local stream = io.stdout

-- Standard output carries an image or JSON: what scripts print goes to standard error.
function texts.print_to(file)
  stream = file
end

function texts.stream()
  return stream
end

-- A script must not steer the user's terminal.
local function write(file, text)
  if sys.is_terminal(file == io.stdout and 1 or 2) then
    text = words.visible(text)
  end
  return file:write(text)
end

texts.write = write

-- Two methods of a file that is the program's.
function texts.facade(file)
  local self = {}
  function self.write(_, ...)
    for i = 1, select("#", ...) do
      local text = select(i, ...)
      if type(text) ~= "string" and type(text) ~= "number" then
        error(("bad argument #%d to 'write' (string expected, got %s)"):format(i, type(text)), 2)
      end
      write(file(), tostring(text))
    end
    return self
  end
  function self.flush()
    file():flush()
    return self
  end
  function self.setvbuf()
    return true
  end
  return self
end

-- The script's print.
function texts.print(...)
  local parts = table.pack(...)
  for i = 1, parts.n do
    parts[i] = tostring(parts[i])
  end
  write(stream, table.concat(parts, "\t") .. "\n")
end

-- ---- texts that stand in for files: the scripts inside of an image (replay) ----

local stand_ins = {} -- absolute path -> text

function texts.stand_in(path, text)
  stand_ins[run.absolute(path)] = text
end

local function text_of(path)
  return stand_ins[run.absolute(path)]
end
texts.of = text_of

-- What guard.open gives for a text: the methods of a file that readers use.
function texts.file(text)
  local at = 1
  return {
    read = function(_, n)
      if at > #text then
        return n == "a" and "" or nil
      end
      local part = text:sub(at, n == "a" and #text or at + n - 1)
      at = at + #part
      return part
    end,
    lines = function()
      return text:gmatch "([^\n]*)\n?"
    end,
    close = function()
      return true
    end,
  }
end

local scripts = {} -- path -> text, of scripts read since a run ended

-- The text of a script's file, or nil and the reason.
function texts.read(path)
  local file, why = guard.open(path)
  if not file then
    return nil, why
  end
  local text
  text, why = file:read "a"
  file:close()
  scripts[path] = text
  return text, text == nil and ("%s: %s"):format(path, tostring(why)) or nil
end

-- The scripts read since the last call: { [path] = text }.
function texts.take_scripts()
  local taken = scripts
  scripts = {}
  return taken
end

-- The text of a file of the program's, or nil.
function texts.text(path)
  local file = not text_of(path) and io.open(path, "rb")
  local text = text_of(path) or file and file:read "a"
  if file then
    file:close()
  end
  return text
end

return texts
