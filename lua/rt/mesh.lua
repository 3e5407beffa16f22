-- Meshes from files and arrays, polyhedra, groups and instances.

local check = require "rt.check"
local class = require "rt.class"
local run = require "rt.run"
local arrays = require "rt.arrays"
local shapes = require "rt.shapes"
local material = require "rt.material"
local transform = require "rt.transform"

local mesh = {}

local ARRAY_KEYS = { "vertices", "faces", "normals", "uvs", "colors", "materials" }
local FILE_KEYS = { "smooth_angle", "ignore_materials", "transform" }

local function finish_file(o, who)
  for _, key in ipairs(ARRAY_KEYS) do
    if o[key] ~= nil then
      check.fail("%s: file and %s do not go together", who, key)
    end
  end
  o.add, o.given, o.path = "add_mesh_file", o.file, run.resolve(o.file)
end

local function finish_arrays(o, t, who)
  for _, key in ipairs(FILE_KEYS) do
    if o[key] ~= nil then
      check.fail("%s: %s belongs to a mesh from a file%s", who, key, key == "transform" and "; rt.instance places this one" or "")
    end
  end
  if not o.vertices and not o.faces then
    check.fail("%s: give file, or vertices and faces", who)
  end
  check.required(o, { "vertices", "faces" }, who)
  local vertices, faces = #o.vertices // 3, #o.faces // 3
  arrays.same_count(o, who, "normals", 3, vertices, "vertices")
  arrays.same_count(o, who, "uvs", 2, vertices, "vertices")
  arrays.same_count(o, who, "colors", 3, vertices, "vertices")
  arrays.same_count(o, who, "materials", 1, faces, "faces")
  if o.smooth and o.normals then
    check.fail("%s: smooth makes normals, but normals are given", who)
  end
  if not arrays.is_buffer(t.faces) then -- a buffer's corners are the library's to check
    arrays.check_corners(o.faces, vertices, who, "faces")
  end
  o.add = "add_mesh"
end

-- rt.mesh { file = "bunny.ply", smooth = true } or { vertices = ..., faces = ... }
mesh.mesh = class.new {
  name = "mesh", kind = "shape", example = [[rt.mesh { file = "bunny.ply" }]],
  fields = shapes.fields {
    file = check.string, smooth = check.boolean, smooth_angle = check.number { low = 0, high = 180 }, ignore_materials = check.boolean,
    transform = transform.field, vertices = arrays.places, faces = arrays.triangles, normals = arrays.normals, uvs = arrays.uvs,
    colors = arrays.colors, materials = arrays.materials,
  },
  settles = { "file", "vertices", "faces", "normals", "uvs", "colors" },
  finish = function(o, t, who)
    if o.file then
      finish_file(o, who)
    else
      finish_arrays(o, t, who)
    end
  end,
}

-- rt.polyhedron { vertices = {{x, y, z}, ...}, faces = {{1, 2, 3, 4}, ...} }: faces of any number of corners.
mesh.polyhedron = class.new {
  name = "polyhedron", kind = "shape", example = "rt.polyhedron { vertices = {...}, faces = {{1, 2, 3, 4}, ...} }",
  fields = shapes.fields { vertices = arrays.places, faces = arrays.polygons }, required = { "vertices", "faces" },
  shared = { add = "add_polyhedron" }, settles = { "vertices", "faces" },
  finish = function(o, _, who)
    arrays.check_corners(o.faces.indices, #o.vertices // 3, who, "faces")
    o.face_sizes, o.indices = o.faces.sizes, o.faces.indices
  end,
}

-- Positional items as they stand; scene.lua walks them when the group or instance is added.
local function positional(t)
  local items = {}
  for key, value in next, t do
    if math.type(key) then
      items[key] = value
    end
  end
  return items
end

-- rt.group { object, ... }: a list with a name, and what several instances share.
mesh.group = class.new {
  name = "group", kind = "group", example = "rt.group { rt.sphere { ... }, ... }", fields = {}, items = true,
  finish = function(o, t)
    o.items = positional(t)
  end,
}

local rows_meta = {} -- of a motion that was checked: 12 numbers a place

-- Where an instance stands at the end of its way, or a list of the places it passes.
local function motion(value, who, key)
  local places = value
  if getmetatable(value) == rows_meta then
    return value
  elseif type(value) ~= "table" then
    check.fail("%s: %s must be a transform or a list of transforms; got %s", who, key, check.describe(value))
  elseif math.type(value[1]) then
    places = { value }
  elseif #value < 1 or #value > 1024 then
    check.fail("%s: %s must have 1 to 1024 transforms; it has %d", who, key, #value)
  end
  local rows = {}
  for i, place in ipairs(places) do
    table.move(transform.field(place, who, places == value and ("%s[%d]"):format(key, i) or key), 1, 12, #rows + 1, rows)
  end
  return setmetatable(rows, rows_meta)
end

function mesh.places(value)
  return motion(value, "rt.instance", "motion")
end

-- rt.instance { object or group or scene, transform = rt.translate(0, 1, 0) }
mesh.instance = class.new {
  name = "instance", kind = "instance", example = "rt.instance { bunny, transform = rt.translate(0, 1, 0) }",
  fields = {
    transform = transform.field, motion = motion, material = material.field, mask = check.integer { low = 0, high = 0xffffffff },
    user_id = check.integer { low = 0, high = 0xffffffff },
  },
  items = true, settles = { "motion" },
  finish = function(o, t, who)
    o.items = positional(t)
    if next(o.items) == nil then
      check.fail("%s: it places nothing; put an object first, as in rt.instance { bunny, transform = ... }", who)
    end
  end,
}

return mesh
