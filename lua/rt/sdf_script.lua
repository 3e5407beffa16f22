-- Writes an old scene definition as a Lua script that renders the same bits.

local scene = require "rt.sdf_scene"
local words = require "rt.words"

local script = {}

local FORMATS = { [15] = "%.15g", [16] = "%.16g", [17] = "%.17g" }

-- Shortest text that reads back as the same number, whatever the locale.
local function number(x)
  if x == math.floor(x) and x > -1e15 and x < 1e15 then
    return x == 0 and 1 / x < 0 and "-0.0" or ("%d"):format(x)
  end
  for digits = 15, 17 do
    local text = words.number(x, FORMATS[digits])
    if tonumber(text) == x then
      return text
    end
  end
  return nil
end

-- A Lua string literal; bytes that are no printable ASCII are written as escapes unless the text is UTF-8.
local function literal(text)
  local hidden = utf8.len(text) and '[%c"\\\127]' or '[%c"\\\127-\255]'
  return '"' .. text:gsub(hidden, function(c)
    return (c == '"' or c == "\\") and "\\" .. c or ("\\%03d"):format(c:byte())
  end) .. '"'
end

local function list(values)
  local parts = {}
  for i, v in ipairs(values) do
    parts[i] = type(v) == "table" and list(v) or number(v)
  end
  return "{" .. table.concat(parts, ", ") .. "}"
end

local function text_of(node)
  local parts = {}
  for i = 2, #node do
    local key, value = node[i][1], node[i][2]
    local text
    if type(value) == "table" then
      text = type(value[1]) == "string" and text_of(value) or list(value)
    else
      text = type(value) == "string" and literal(value) or number(value)
    end
    parts[#parts + 1] = key .. " = " .. text
  end
  return (node[1] == "" and "" or "rt." .. node[1] .. " ") .. "{ " .. table.concat(parts, ", ") .. " }"
end

-- The sink of a reader that writes the script of the file called `name` by write(text), part by part; texture_path(name) is the name of a
-- texture in the script.
function script.sink(name, texture_path, write)
  return {
    header = function(header)
      write(("-- Made from %s by `rtray convert`; it renders the same bits.\n"):format((name:gsub("[%c\127]", "?"))))
      write 'local rt = require "rt"\n\nreturn rt.scene {\n'
      write(("  settings = %s,\n  camera = %s,\n"):format(text_of(scene.settings), text_of(scene.camera(header))))
      write(("  ambient = %s,\n"):format(list(scene.ambient(header))))
      local light = scene.light(header)
      if light then
        write("  " .. text_of(light) .. ",\n")
      end
    end,
    object = function(object)
      write("  " .. text_of(scene.object(object, texture_path)) .. ",\n")
    end,
  }
end

-- Reads the file at `path` and gives the whole script to write(text).
function script.convert(path, texture_path, write)
  scene.read(path, script.sink(path:match "[^/]*$", texture_path, write))
  write "}\n"
end

return script
