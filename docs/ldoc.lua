-- Turns lua/rt.d.lua, the one description of the module (for the Lua language server), into what LDoc reads.
-- usage: lua5.4 docs/ldoc.lua lua/rt.d.lua OUT.lua

local source, target = ...
assert(source and target, "usage: ldoc.lua RT.D.LUA OUT.LUA")

local function html(text)
  return (text:gsub("[&<>]", { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;" }))
end

-- A type and the text behind it: types may have blanks inside brackets, behind a comma, a colon or a bar.
local function split_type(text)
  local depth, i = 0, 1
  while i <= #text do
    local c = text:sub(i, i)
    if c:find "[%(%[{<]" then
      depth = depth + 1
    elseif c:find "[%)%]}>]" then
      depth = depth - 1
    elseif c == '"' then
      i = text:find('"', i + 1, true) or #text
    elseif c == " " and depth == 0 and not text:sub(1, i - 1):find "[:,|]$" and not text:sub(i):find "^%s*|" then
      return text:sub(1, i - 1), text:sub(i + 1)
    end
    i = i + 1
  end
  return text, ""
end

-- name[?] type text, as a sentence with the type in it
local function named(rest)
  local name, optional, tail = rest:match "^(%S-)(%??) (.*)$"
  if not name then
    return rest, false, ""
  end
  local type_text, text = split_type(tail)
  return name, optional == "?", ("<code>%s</code> %s"):format(html(type_text), html(text))
end

local out, block, class = {}, {}, nil

local function put(...)
  out[#out + 1] = string.format(...)
end

local function take_block()
  local lines = block
  block = {}
  return lines
end

local function tags_of(lines)
  local text, tags = {}, {}
  for _, line in ipairs(lines) do
    local tag, rest = line:match "^@(%w+)%s*(.*)$"
    if tag then
      tags[#tags + 1] = { tag, rest }
    else
      text[#text + 1] = html(line)
    end
  end
  return table.concat(text, " "), tags
end

local function write_function(name, lines)
  local text, tags = tags_of(lines)
  put("--- %s", text ~= "" and text or name:gsub("^.*[:.]", "") .. ".")
  put("-- @function %s", name)
  for _, t in ipairs(tags) do
    if t[1] == "param" then
      local param, optional, words = named(t[2])
      put("-- @param%s %s %s", optional and "[opt]" or "", param, words)
    elseif t[1] == "return" then
      local type_text, rest = split_type(t[2])
      put("-- @return <code>%s</code> %s", html(type_text), html(rest))
    end
  end
  put ""
end

-- A table of keys; classes without fields are known by their methods.
local function write_table(lines)
  local text, tags = tags_of(lines)
  local fields = {}
  for _, t in ipairs(tags) do
    if t[1] == "class" then
      class = t[2]
    elseif t[1] == "field" then
      fields[#fields + 1] = t[2]
    end
  end
  if #fields == 0 or not class then
    return
  end
  local name, parent = class:match "^([%w_.]+)%s*:?%s*([%w_.]*)"
  put("--- %s%s", text ~= "" and text or "Keys.", parent ~= "" and (" Also the keys of %s."):format(parent) or "")
  put("-- @table %s", name)
  for _, field in ipairs(fields) do
    local key, optional, words = named(field)
    put("-- @field %s %s%s", key:gsub("[%[%]]", ""), optional and "(optional) " or "", words)
  end
  put ""
end

put "--- Scenes, pictures, films and studies from Lua."
put "-- Made from rt.d.lua, which the Lua language server reads."
put("-- @module rt\n")
for line in io.lines(source) do
  local doc = line:match "^%-%-%-(.*)$"
  local section = line:match "^%-%- %-%-%-%- (.-) %-%-%-%-$"
  if doc then
    if doc:match "^@class" and #block > 0 and tags_of(block) == "" then
      write_table(take_block()) -- classes one after another
    end
    block[#block + 1] = (doc:gsub("^ ", ""))
  elseif section then
    put("--- %s\n-- @section %s\n", section:sub(1, 1):upper() .. section:sub(2), (section:gsub("%W", "_")))
  else
    local name = line:match "^function ([%w_.:]+)%("
    if name then
      write_function((name:gsub("^rt%.", "")), take_block())
    elseif #block > 0 then
      write_table(take_block())
    end
    class = nil
  end
end
local file = assert(io.open(target, "w"))
assert(file:write(table.concat(out, "\n"), "\n"))
assert(file:close())
