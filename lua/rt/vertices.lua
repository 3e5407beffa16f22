-- Meshes whose vertices move: the same triangles elsewhere.

local core = require "rt.core"
local arrays = require "rt.arrays"
local check = require "rt.check"
local class = require "rt.class"

local vertices = {}

local WHO = "scene:set_vertices"
local EXAMPLE = "{ vertices = buffer, normals = buffer }"
local fields = { vertices = arrays.places, normals = arrays.normals, smooth = check.boolean }
local MOVES = { add_mesh = true, add_mesh_file = true, add_polyhedron = true }

-- The geometries of the object, by their numbers, and the object itself where its name was given.
local function find(self, wanted)
  local ids, object = {}, nil
  for id, o in pairs(self.objects) do
    if o == wanted or o.name and o.name == wanted then
      if object and object ~= o then
        check.fail("%s: several objects of the scene are called %s; give the one that is meant", WHO, check.describe(wanted))
      end
      ids[#ids + 1], object = id, o
    end
  end
  table.sort(ids)
  return ids, object
end

local function stands_in_a_child(self, wanted)
  for _, child in ipairs(self.children) do
    if #find(child, wanted) > 0 then
      return true
    end
  end
  return false
end

local function not_found(self, wanted)
  local what = class.kind(wanted) and tostring(wanted) or check.describe(wanted)
  if stands_in_a_child(self, wanted) then
    check.fail("%s: %s stands in what an instance places; hold that as a scene, local part = rt.scene { mesh }, place it by rt.instance { part }, " ..
      "and move it by part:set_vertices", WHO, what)
  end
  if type(wanted) ~= "string" and class.kind(wanted) ~= "shape" then
    check.fail("%s: the first argument must be a mesh of the scene, or its name; got %s", WHO, what)
  end
  check.fail("%s: %s is not in the scene; put it there by scene:add", WHO, what)
end

-- The arrays as the library takes them, and whether it is to make normals of the faces.
local function arrays_of(object, t)
  local o = check.fields(check.plain_table(t, WHO, EXAMPLE), fields, WHO)
  check.required(o, { "vertices" }, WHO)
  if object.vertices and #o.vertices ~= #object.vertices then
    check.fail("%s: vertices has %d items, but the mesh has %d; a mesh with other triangles is a new object", WHO, #o.vertices // 3,
      #object.vertices // 3)
  end
  arrays.same_count(o, WHO, "normals", 3, #o.vertices // 3, "vertices")
  if o.smooth and o.normals then
    check.fail("%s: smooth makes normals, but normals are given", WHO)
  elseif o.smooth == nil and object.smooth and object.file and not o.normals then
    check.fail("%s: the mesh's normals were made of its file (smooth = true); give normals for the new vertices, smooth = true to make them of " ..
      "its faces, or smooth = false to keep those of the old", WHO)
  end
  local smooth = o.smooth or o.smooth == nil and object.smooth and not o.normals
  return { vertices = o.vertices, normals = o.normals, smooth = smooth or nil }
end

-- scene:set_vertices(mesh or name, { vertices = ..., normals = ..., smooth = true }): the mesh's vertices stand elsewhere from the next render or
-- query on. A mesh that was made of arrays with smooth = true gets new normals; others keep those they have unless some are given or smooth is true.
-- Those of a mesh from a file stand where its transform put them.
local function set_vertices(self, wanted, t)
  local ids, object = find(self, wanted)
  if #ids == 0 then
    not_found(self, wanted)
  elseif not MOVES[object.add] then
    check.fail("%s: %s has no vertices; only meshes and polyhedra have", WHO, tostring(object))
  elseif object.file and #ids > 1 then
    check.fail("%s: %s is %d geometries in the scene, each with vertices of its own; only a mesh that is one can be moved", WHO,
      tostring(object), #ids)
  end
  local moved = arrays_of(object, t)
  self.dirty = true
  for _, id in ipairs(ids) do
    core.set_vertices(self.handle, id, moved)
  end
  return self
end

function vertices.install(methods)
  methods.set_vertices = set_vertices
end

return vertices
