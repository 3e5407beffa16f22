-- Values of options: each type reads a text and gives the value, or nil and what was expected.

local words = require "rt.words"

local types = {}

-- Names of files are shown whole.
function types.quote(text)
  return "'" .. words.quote(text, 4096) .. "'"
end

local readers = {}

function readers.text(_, text)
  if text == "" then
    return nil, "it is empty"
  end
  return text
end

readers.file = readers.text
readers.folder = readers.text

function readers.count(option, text)
  local value = text:find "^%d+$" and #text <= 18 and math.tointeger(tonumber(text))
  if not value or value < option.low or value > option.high then
    return nil, ("a whole number from %d to %d is expected"):format(option.low, option.high)
  end
  return value
end

function readers.number(option, text)
  local value = text:find "^[+-]?[%d.]+[eE]?[+-]?%d*$" and tonumber(text)
  if not value or value < option.low or value > option.high then
    return nil, ("a number from %g to %g is expected"):format(option.low, option.high)
  end
  return value + 0.0
end

-- Seeds are 64-bit patterns, decimal or 0x hexadecimal.
function readers.seed(_, text)
  local value = (text:find "^%d+$" or text:find "^0[xX]%x+$") and #text <= 19 and math.tointeger(tonumber(text))
  if not value then
    return nil, "a whole number from 0 to 2^63 - 1 is expected"
  end
  return value
end

function readers.size(_, text)
  local w, h = text:match "^(%d+)[xX](%d+)$"
  w, h = math.tointeger(tonumber(w)), math.tointeger(tonumber(h))
  if not w or not h or w < 1 or h < 1 or w > 1048576 or h > 1048576 then
    return nil, "WIDTHxHEIGHT is expected, each from 1 to 1048576, as in 1000x700"
  end
  return { w, h }
end

-- Part of an image: X,Y,WIDTH,HEIGHT in pixels from the top left.
function readers.crop(_, text)
  local x, y, w, h = text:match "^(%d+),(%d+),(%d+),(%d+)$"
  if not x or #text > 40 or tonumber(w) < 1 or tonumber(h) < 1 then
    return nil, "X,Y,WIDTH,HEIGHT in pixels is expected, as in 100,50,200,200"
  end
  local n = function(t)
    return math.tointeger(tonumber(t))
  end
  return { x = n(x), y = n(y), width = n(w), height = n(h) }
end

local UNITS = { [""] = 1, k = 2 ^ 10, m = 2 ^ 20, g = 2 ^ 30 }

local function decimal(text)
  return text:find "^[+-]?[%d.]+$" and tonumber(text) or text:find "^[+-]?[%d.]+[eE][+-]?%d+$" and tonumber(text) or nil
end

local function three(text)
  local x, y, z = text:match "^([^,]+),([^,]+),([^,]+)$"
  if not x then
    return nil
  end
  x, y, z = decimal(x), decimal(y), decimal(z)
  return x and y and z and { x + 0.0, y + 0.0, z + 0.0 }
end

function readers.point(_, text)
  local point = three(text)
  for i = 1, 3 do
    if not point or math.abs(point[i]) > 1e12 then
      return nil, "X,Y,Z is expected, as in 0,1.5,4"
    end
  end
  return point
end

-- A plane: AXIS=COORDINATE, AXIS=PART%, or NX,NY,NZ@PX,PY,PZ.
function readers.cut(_, text)
  local expected = "a plane is expected: y=1.5 (a coordinate), y=40% (of the tree's box) or NX,NY,NZ@PX,PY,PZ (normal, point)"
  local axis, at, percent = text:match "^([xyz])=([^%%]+)(%%?)$"
  if axis then
    local value = decimal(at)
    if not value or value ~= value or math.abs(value) > 1e12 then
      return nil, expected
    elseif percent == "%" and (value < 0 or value > 100) then
      return nil, "a part of the box is expected between 0% and 100%"
    end
    return { axis = axis, at = percent == "" and value + 0.0 or nil, part = percent == "%" and value / 100 or nil }
  end
  local normal, point = text:match "^([^@]+)@([^@]+)$"
  normal, point = normal and three(normal), point and three(point)
  if not normal or not point then
    return nil, expected
  elseif normal[1] == 0 and normal[2] == 0 and normal[3] == 0 then
    return nil, "the plane's normal is zero"
  end
  return { normal = normal, point = point }
end

-- The group of a tree, as the statistics call it: a number, with a part behind it where the group has several trees, or "top".
function readers.group(_, text)
  if #text <= 9 and (text == "top" or text:find "^%d+$" or text:find "^%d+%.%d+$") then
    return text
  end
  return nil, "a group is expected as the statistics name it: 0 (the scene's own geometry), 1, 0.1 (a part) or top"
end

-- Bytes, with K, M or G behind.
function readers.bytes(_, text)
  local digits, unit = text:match "^(%d+)([kKmMgG]?)i?[bB]?$"
  if not digits or #digits > 12 then
    return nil, "a number of bytes is expected, as in 512M or 2G"
  end
  return math.tointeger(tonumber(digits) * UNITS[unit:lower()])
end

local SECONDS = { [""] = 1, s = 1, ms = 0.001, m = 60, min = 60, h = 3600 }

-- time=10s,memory=2G: { seconds, bytes, time and memory as they were written }
function readers.limits(_, text)
  local limits = { text = text }
  for part in (text .. ","):gmatch "([^,]*)," do
    local name, value = part:match "^(%l+)=(.+)$"
    if name == "time" then
      local digits, unit = value:match "^(%d*%.?%d+)(%l*)$"
      local seconds = digits and SECONDS[unit] and tonumber(digits) * SECONDS[unit]
      if not seconds or seconds <= 0 or seconds > 1e8 then
        return nil, "a time is expected, as in time=10s, time=2m or time=500ms"
      end
      limits.seconds, limits.time = seconds, value
    elseif name == "memory" then
      local bytes, why = readers.bytes(nil, value)
      if not bytes or bytes < 2 ^ 20 then
        return nil, why or "at least 1M of memory is expected"
      end
      limits.bytes, limits.memory = bytes, value
    else
      return nil, "time=T, memory=M or both are expected, as in time=10s,memory=2G"
    end
  end
  return limits
end

function readers.choice(option, text)
  for _, choice in ipairs(option.choices) do
    if choice == text then
      return text
    end
  end
  local near = words.nearest(text, option.choices)
  return nil, (near and "did you mean " .. near .. "? " or "") .. "known are " .. table.concat(option.choices, ", ")
end

-- Frames: 0:119:2,7.
function readers.frames(_, text)
  return require("rtray.frames").read_ranges(text)
end

-- NAME=VALUE; the parameter's declaration decides what the value's text means.
function readers.define(_, text)
  local name, value = text:match "^([%a_][%w_]*)=(.*)$"
  if not name then
    return nil, "NAME=VALUE is expected, as in radius=100"
  end
  return { name = name, text = value }
end

-- NAME=VALUES; the sweep reads the values.
function readers.axis(_, text)
  local name, values = text:match "^([%a_][%w_-]*)=(.*)$"
  if not name then
    return nil, "NAME=VALUES is expected, as in workers=1,2,4 or ior=1:2.5:0.25"
  end
  return { name = name, text = values }
end

-- Lists of counts: 1,2,4.
function readers.counts(option, text)
  local list = {}
  for part in (text .. ","):gmatch "([^,]*)," do
    local value, why = readers.count(option, part)
    if not value then
      return nil, why .. " between commas"
    end
    list[#list + 1] = value
  end
  return list
end

-- Lists of choices: kdtree,octree.
function readers.choices(option, text)
  local list = {}
  for part in (text .. ","):gmatch "([^,]*)," do
    local value, why = readers.choice(option, part)
    if not value then
      return nil, why
    end
    list[#list + 1] = value
  end
  return list
end

function types.read(option, text)
  return readers[option.type](option, text)
end

return types
