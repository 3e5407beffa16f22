-- usage: lua5.4 tests/fuzz/snapshots.lua FOLDER. Writes the snapshot files the fuzzing begins with, small ones of each kind; to be run again when the
-- format's version changes (LUA_CPATH names the built module: out-release/lib/lua/5.4/?.so).
local rt = require "rt"
local folder = assert(arg[1], "usage: snapshots.lua FOLDER")

local function shapes(accel)
  local child = rt.group { rt.sphere { center = {0, 0, 0}, radius = 0.5 }, rt.box { low = {0.6, 0, 0}, high = {1, 1, 1} } }
  return rt.scene {
    settings = { accel = accel },
    camera = rt.camera { eye = {5, 1, 12}, look_at = {5, 0, 0}, aperture = 0.1, blades = 5, motion = { eye = {6, 1, 12} } },
    rt.sphere { center = {1, 0, 0}, radius = 1 },
    rt.cylinder { from = {3, 0, 0}, to = {3, 1, 0}, radius = 0.5 },
    rt.cone { from = {5, 0, 0}, to = {5, 1, 0}, radius = 0.5 },
    rt.torus { center = {7, 0, 0}, axis = {0, 1, 0}, major_radius = 1, minor_radius = 0.25 },
    rt.plane { point = {0, -1, 0}, normal = {0, 1, 0} },
    rt.instance { child, transform = rt.translate(10, 0, 0) * rt.rotate({1, 2, 3}, 30), motion = rt.translate(12, 0, 0) },
    rt.instance { child, transform = rt.translate(0, 0, 3) * rt.scale(2, -1, 1), material = rt.classic { color = {1, 0, 0} } },
    rt.sphere_light { at = {3, 6, 4}, radius = 0.5 },
  }
end

-- Sixty-four balls that are tiny against the floor: a group of two parts.
local function parts()
  local centers = {}
  for i = 0, 63 do
    centers[i + 1] = {i % 4 * 0.01, i // 4 % 4 * 0.01, i // 16 * 0.01}
  end
  return rt.scene {
    settings = { accel = "kdtree,octree,bvh" },
    rt.spheres { centers = centers, radius = 0.002 },
    rt.box { low = {-1000, -1, -1000}, high = {1000, 0, 1000} },
  }
end

local function mesh()
  local image = rt.image { width = 2, height = 2, pixel = function(x, y) return x, y, 0.5 end }
  return rt.scene {
    settings = { accel = "kdtree,octree,bvh" },
    rt.mesh {
      vertices = { {-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0} }, faces = { {1, 2, 3}, {1, 3, 4} },
      uvs = { {0, 0}, {1, 0}, {1, 1}, {0, 1} }, normals = { {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1} },
      colors = { {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1} }, material = rt.classic { texture = image },
    },
    rt.point_light { at = {1, 2, 3} },
  }
end

-- Enough triangles for trees of several nodes.
local function sheet()
  local vertices, faces = {}, {}
  for i = 0, 35 do
    vertices[i + 1] = { i % 6, i // 6, math.sin(i) }
  end
  for i = 0, 24 do
    local a = i // 5 * 6 + i % 5 + 1
    faces[2 * i + 1], faces[2 * i + 2] = { a, a + 1, a + 6 }, { a + 1, a + 7, a + 6 }
  end
  return rt.scene { settings = { accel = "kdtree,octree,bvh", leaf_size = 8 }, rt.mesh { vertices = vertices, faces = faces } }
end

for _, item in ipairs {
  { "empty", rt.scene {} }, { "mesh", mesh() }, { "sheet", sheet() }, { "octree", shapes("octree,kdtree,bvh") }, { "shapes", shapes("kdtree") },
  { "parts", parts() },
} do
  item[2]:save(folder .. "/" .. item[1])
end
