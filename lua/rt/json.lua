-- JSON: text of plain values, and back. An object is written from a list of { key, value } pairs made by json.object, so that its order is the
-- writer's; it is read as a plain table. null is read as nil.

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

-- Written as null, where a key shall be there without a value.
json.null = setmetatable({}, { __name = "json.null" })

-- Bytes of a file name that are no UTF-8: each becomes the character of its number.
function json.utf8(s)
  if utf8.len(s) then
    return s
  end
  return (s:gsub("[\128-\255]", function(c)
    return utf8.char(c:byte())
  end))
end

local function text(s)
  s = json.utf8(s)
  if s:find '[%c"\\\127]' then
    s = s:gsub('[%c"\\\127]', function(c)
      return c == '"' and '\\"' or c == "\\" and "\\\\" or ("\\u%04x"):format(c:byte())
    end)
  end
  return '"' .. s .. '"'
end

local FORMATS = { "%.15g", "%.16g", "%.17g" } -- %g drops zeros at the end: of up to 15 digits the first is the shortest

-- Shortest decimal that reads back as the same number; JSON has no infinity and no NaN.
local function number(x)
  if math.type(x) == "integer" then
    return ("%d"):format(x)
  elseif x ~= x or x == math.huge or x == -math.huge then
    return "null"
  end
  local s
  for i = 1, 3 do
    s = FORMATS[i]:format(x)
    s = s:find(",", 1, true) and s:gsub(",", ".") or s -- a locale's
    if tonumber(s) == x then
      break
    end
  end
  return s
end
json.number = number

-- Appends the value's text to the list of n parts: their new number. keys: texts of keys met, which are few and come again and again.
local function append(parts, n, value, keys)
  local kind = type(value)
  if value == json.null or kind == "nil" then
    parts[n + 1] = "null"
  elseif kind == "table" then
    local is_object = getmetatable(value) == object
    n = n + 1
    parts[n] = is_object and "{" or "["
    for i, item in ipairs(value) do
      if i > 1 then
        n = n + 1
        parts[n] = ","
      end
      if is_object then
        local key = item[1]
        local shown = keys[key]
        if not shown then
          shown = text(key) .. ":"
          keys[key] = shown
        end
        n = n + 1
        parts[n], item = shown, item[2]
      end
      n = append(parts, n, item, keys)
    end
    parts[n + 1] = is_object and "}" or "]"
  elseif kind == "number" then
    parts[n + 1] = number(value)
  elseif kind == "string" then
    parts[n + 1] = text(value)
  else
    parts[n + 1] = kind == "boolean" and tostring(value) or text(tostring(value))
  end
  return n + 1
end

function json.encode(value)
  local parts = {}
  append(parts, 0, value, {})
  return table.concat(parts)
end

-- ---- reading ----

local DEEPEST = 64
local byte = string.byte
local QUOTE, COMMA, COLON, BRACKET, BRACE = byte('",:]}', 1, 5)
local ESCAPES = { b = "\b", f = "\f", n = "\n", r = "\r", t = "\t", ['"'] = '"', ["\\"] = "\\", ["/"] = "/" }

local function fault(at, what)
  error({ json = ("byte %d: %s"):format(at, what) }, 0)
end

-- A \uXXXX at `at`, a pair of surrogates as one character: the character, and where it ends.
local function unicode(s, at)
  local code = tonumber(s:match("^%x%x%x%x", at) or fault(at, "\\u needs four hexadecimal digits"), 16)
  local low = code >= 0xD800 and code < 0xDC00 and s:match("^\\u(%x%x%x%x)", at + 4)
  low = low and tonumber(low, 16)
  if low and low >= 0xDC00 and low < 0xE000 then
    return utf8.char(0x10000 + (code - 0xD800) * 0x400 + low - 0xDC00), at + 10
  end
  return utf8.char(code), at + 4
end

local function read_text(s, at)
  local parts, from = nil, at + 1
  while true do
    local stop = s:find('["\\]', from) or fault(at, "a text has no end")
    if not parts then
      if byte(s, stop) == QUOTE then
        return s:sub(from, stop - 1), stop + 1
      end
      parts = {}
    end
    parts[#parts + 1] = s:sub(from, stop - 1)
    if s:sub(stop, stop) == '"' then
      return table.concat(parts), stop + 1
    end
    local letter = s:sub(stop + 1, stop + 1)
    if letter == "u" then
      parts[#parts + 1], from = unicode(s, stop + 2)
    else
      parts[#parts + 1], from = ESCAPES[letter] or fault(stop, "an unknown escape"), stop + 2
    end
  end
end

local read

local function skip(s, at)
  local mark = byte(s, at)
  return mark and mark > 0x20 and at or s:match("^[ \t\r\n]*()", at)
end

-- Behind an entry of a list that `close` ends: where the next one begins, or nil and where the list has ended.
local function next_entry(s, at, close)
  at = skip(s, at)
  local mark = byte(s, at)
  if mark == close then
    return nil, at + 1
  elseif mark ~= COMMA then
    fault(at, "a comma or " .. string.char(close) .. " is missing")
  end
  return skip(s, at + 1)
end

local function read_array(s, at, depth)
  local list, count, stop = {}, 0
  at = skip(s, at + 1)
  if byte(s, at) == BRACKET then
    return list, at + 1
  end
  repeat
    count = count + 1
    list[count], at = read(s, at, depth)
    at, stop = next_entry(s, at, BRACKET)
  until not at
  return list, stop
end

local function read_object(s, at, depth)
  local t, key, stop = {}
  at = skip(s, at + 1)
  if byte(s, at) == BRACE then
    return t, at + 1
  end
  repeat
    if byte(s, at) ~= QUOTE then
      fault(at, "a key is missing")
    end
    key, at = read_text(s, at)
    at = skip(s, at)
    if byte(s, at) ~= COLON then
      fault(at, "a colon is missing")
    end
    t[key], at = read(s, at + 1, depth)
    at, stop = next_entry(s, at, BRACE)
  until not at
  return t, stop
end

-- Strictly as the standard has it, which is less than Lua reads.
local function read_number(s, at)
  local first, stop = s:match("^-?()%d+()", at)
  if byte(s, first) == 0x30 and stop > first + 1 then
    fault(at, "a number begins with 0")
  end
  local mark = byte(s, stop)
  if mark == 0x2E then -- .
    stop = stop + #(s:match("^%.%d+", stop) or fault(stop, "no digit behind the point"))
    mark = byte(s, stop)
  end
  if mark == 0x65 or mark == 0x45 then -- e, E
    stop = stop + #(s:match("^[eE][+-]?%d+", stop) or fault(stop, "no digit in the exponent"))
  end
  return tonumber(s:sub(at, stop - 1)), stop
end

local WORDS = { { "true", true }, { "false", false }, { "null", nil } }

function read(s, at, depth)
  at = skip(s, at)
  local mark = s:sub(at, at)
  if depth > DEEPEST then
    fault(at, "values lie too deep in each other")
  elseif mark == "{" then
    return read_object(s, at, depth + 1)
  elseif mark == "[" then
    return read_array(s, at, depth + 1)
  elseif mark == '"' then
    return read_text(s, at)
  end
  if s:find("^-?%d", at) then
    return read_number(s, at)
  end
  for _, word in ipairs(WORDS) do
    if s:sub(at, at + #word[1] - 1) == word[1] then
      return word[2], at + #word[1]
    end
  end
  return fault(at, "no value")
end

-- The value of a JSON text; nil and why when it is none.
function json.decode(s)
  local ok, value, at = pcall(read, s, 1, 1)
  if ok and skip(s, at) > #s then
    return value
  elseif ok then
    return nil, ("byte %d: something stands behind the value"):format(at)
  elseif type(value) == "table" then
    return nil, value.json
  end
  error(value, 0)
end

return json
