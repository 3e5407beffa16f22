-- JSON text of plain values. An object is a list of { key, value } pairs made by json.object, so that its order is the writer's.

local json = {}

local object = {}
object.__index = object

function object:set(key, value)
  if value ~= nil then
    self[#self + 1] = { key, value }
  end
  return self
end

function json.object()
  return setmetatable({}, object)
end

local function text(s)
  if not utf8.len(s) then -- bytes of a file name that are no UTF-8: each becomes the character of its number
    s = s:gsub("[\128-\255]", function(c)
      return utf8.char(c:byte())
    end)
  end
  return '"' .. s:gsub('[%c"\\\127]', function(c)
    return c == '"' and '\\"' or c == "\\" and "\\\\" or ("\\u%04x"):format(c:byte())
  end) .. '"'
end

-- Shortest decimal that reads back as the same number; JSON has no infinity and no NaN.
local function number(x)
  if math.type(x) == "integer" then
    return ("%d"):format(x)
  elseif x ~= x or x == math.huge or x == -math.huge then
    return "null"
  end
  for digits = 1, 17 do
    local s = ("%." .. digits .. "g"):format(x):gsub(",", ".")
    if tonumber(s) == x then
      return s
    end
  end
  return nil
end

function json.encode(value)
  local kind = type(value)
  if kind == "table" then
    local parts = {}
    if getmetatable(value) == object then
      for i, pair in ipairs(value) do
        parts[i] = text(pair[1]) .. ":" .. json.encode(pair[2])
      end
      return "{" .. table.concat(parts, ",") .. "}"
    end
    for i, item in ipairs(value) do
      parts[i] = json.encode(item)
    end
    return "[" .. table.concat(parts, ",") .. "]"
  elseif kind == "number" then
    return number(value)
  elseif kind == "boolean" then
    return tostring(value)
  elseif kind == "nil" then
    return "null"
  end
  return text(tostring(value))
end

return json
