-- Bulk data in descriptions: a buffer, a flat list of numbers, or a list of tables. Lists become buffers.

local core = require "rt.core"
local check = require "rt.check"
local class = require "rt.class"

local arrays = {}

local fail, math_type = check.fail, math.type

local function is_buffer(value)
  local meta = getmetatable(value)
  return type(value) == "userdata" and type(meta) == "table" and meta.__name == "rt.buffer"
end
arrays.is_buffer = is_buffer

local function typed_buffer(value, type_name, who, key)
  if value:type() ~= type_name then
    fail("%s: %s must be a buffer of type %s; got one of type %s", who, key, type_name, value:type())
  end
  return value
end

-- A list of `width` numbers an item, or of tables of `width` numbers, as one flat list.
local function flatten(list, width, who, key)
  if type(list[1]) ~= "table" then
    return list
  end
  local flat, n = {}, 0
  for i, item in ipairs(list) do
    if type(item) ~= "table" or #item ~= width then
      fail("%s: %s[%d] must be a table of %d numbers; got %s", who, key, i, width,
        type(item) == "table" and "a table of " .. #item or check.describe(item))
    end
    for k = 1, width do
      n = n + 1
      flat[n] = item[k]
    end
  end
  return flat
end

local function check_list(value, who, key)
  if type(value) ~= "table" then
    fail("%s: %s must be a buffer or a list; got %s", who, key, check.describe(value))
  end
  local count = 0
  for _ in next, value do
    count = count + 1
  end
  if count ~= #value then
    fail("%s: %s must be a list without holes or names", who, key)
  end
end

-- A field of `width` finite numbers an item, of size `most` at most. range: as of check.number, low or above alone. What stands in a buffer may come
-- later: it is looked at by the library, and here when that has refused it (`again`).
function arrays.floats(width, most, range)
  range = range or {}
  range.most = most
  local number, least = check.number(range), range.low or range.above and range.above + check.NOTHING or -most
  local function check_each(list, nested, who, key)
    for i = 1, #list do
      local x = list[i]
      if not (math_type(x) and x > least and x <= most) then -- where it stands is put into words for these alone
        number(x, who, nested and ("%s[%d][%d]"):format(key, (i - 1) // width + 1, (i - 1) % width + 1) or ("%s[%d]"):format(key, i))
      end
    end
    return list
  end
  return function(value, who, key, again)
    if not is_buffer(value) then
      check_list(value, who, key)
      value = core.buffer("f32", check_each(flatten(value, width, who, key), type(value[1]) == "table", who, key))
    end
    if #typed_buffer(value, "f32", who, key) % width ~= 0 then
      fail("%s: %s needs %d numbers an item; it has %d numbers", who, key, width, #value)
    end
    return again and check_each(value, false, who, key) or value
  end
end

-- Vertex numbers in lists count from 1, as the list of vertices does; in a buffer they count from 0, as in C.
local function vertex(value, who, place, ...)
  local n = math_type(value) and math.tointeger(value)
  if not n or n < 1 or n > 0xffffffff then
    fail("%s: %s must be the number of a vertex, from 1; got %s", who, place:format(...), check.describe(value))
  end
  return n - 1
end

-- A field of triangles: corners of each.
function arrays.triangles(value, who, key)
  if not is_buffer(value) then
    check_list(value, who, key)
    for i, face in ipairs(value) do
      if type(face) == "table" and #face > 3 then
        fail("%s: %s[%d] has %d corners; rt.polyhedron takes such faces", who, key, i, #face)
      end
    end
    local flat = flatten(value, 3, who, key)
    local indices = {}
    for i = 1, #flat do
      indices[i] = vertex(flat[i], who, "%s[%d]", key, i)
    end
    value = core.buffer("u32", indices)
  end
  if #typed_buffer(value, "u32", who, key) % 3 ~= 0 then
    fail("%s: %s needs three corners a face; it has %d numbers", who, key, #value)
  end
  return value
end

local polygons_meta = {} -- of faces that were checked

-- Faces of any number of corners: the count of each and all corners in a row.
function arrays.polygons(value, who, key)
  if getmetatable(value) == polygons_meta then
    return value
  end
  check_list(value, who, key)
  local sizes, indices = {}, {}
  for i, face in ipairs(value) do
    if type(face) ~= "table" or #face < 3 or #face > 65535 then
      fail("%s: %s[%d] must be a list of at least 3 vertex numbers; got %s", who, key, i,
        type(face) == "table" and "a list of " .. #face or check.describe(face))
    end
    sizes[i] = #face
    for k = 1, #face do
      indices[#indices + 1] = vertex(face[k], who, "%s[%d][%d]", key, i, k)
    end
  end
  return setmetatable({ sizes = core.buffer("u32", sizes), indices = core.buffer("u32", indices) }, polygons_meta)
end

-- A list of materials, one an item.
function arrays.materials(value, who, key)
  check_list(value, who, key)
  local copy = {}
  for i = 1, #value do
    if class.kind(value[i]) ~= "material" then
      fail("%s: %s[%d] must be a material; got %s", who, key, i, check.describe(value[i]))
    end
    copy[i] = value[i]
  end
  return copy
end

arrays.places, arrays.colors = arrays.floats(3, check.LARGEST), arrays.floats(3, 1e6)
arrays.normals, arrays.uvs = arrays.floats(3, 1e18), arrays.floats(2, 1e9)

function arrays.same_count(o, who, key, width, count, of)
  local items = o[key]
  if items and #items ~= count * width then
    fail("%s: %s has %d items, but %s has %d", who, key, #items // width, of, count)
  end
end

-- Raises when a corner lies outside of the vertices.
function arrays.check_corners(indices, vertex_count, who, key)
  for i = 1, #indices do
    if indices[i] >= vertex_count then
      fail("%s: %s names vertex %d, but there are %d", who, key, indices[i] + 1, vertex_count)
    end
  end
end

return arrays
