-- Meshes whose vertices move: pictures, what is refitted, and what is refused.

local support = require "support"
local rt, message = support.rt, support.message

-- f raises a sentence that holds `part`.
local function raises(part, f)
  local text = message(f)
  assert(text:find(part, 1, true), ("expected: %s\n     got: %s"):format(part, text))
end

local N = 24

-- The corners of a sheet over [-1, 1]^2 at the height that f gives.
local function corners(f)
  local v = rt.buffer("f32", 3 * (N + 1) * (N + 1))
  for y = 0, N do
    for x = 0, N do
      local px, py = 2 * x / N - 1, 2 * y / N - 1
      v:set(3 * (y * (N + 1) + x) + 1, px, py, f(px, py))
    end
  end
  return v
end

local function flat()
  return 0
end

local function wave(t)
  return function(x, y)
    return 0.2 * math.sin(4 * x + t) + 0.1 * math.cos(5 * y + t)
  end
end

local function sheet(extra)
  local faces = rt.buffer("u32", 6 * N * N)
  for y = 0, N - 1 do
    for x = 0, N - 1 do
      local a = y * (N + 1) + x
      faces:set(6 * (y * N + x) + 1, a, a + 1, a + N + 1, a + 1, a + N + 2, a + N + 1)
    end
  end
  local t = { vertices = corners(wave(0)), faces = faces, name = "sheet" }
  for key, value in pairs(extra or {}) do
    t[key] = value
  end
  return rt.mesh(t)
end

local function scene_of(mesh)
  return rt.scene {
    camera = rt.camera { eye = { 1, -2, 3 }, look_at = { 0, 0, 0 } }, settings = { width = 64, height = 48, samples = 1 },
    mesh, rt.directional_light { direction = { 1, 2, -3 } },
  }
end

local function picture(scene, tracer)
  return scene:render { tracer = tracer }:hash()
end

local function counts(scene)
  local i = scene:info()
  return { i.built_trees, i.kept_trees, i.refitted_trees }
end

describe("scene:set_vertices", function()
  it("moves a mesh, and refits its tree", function()
    local mesh = sheet()
    local scene = scene_of(mesh)
    local before, work = picture(scene), rt.counts().trees_refitted
    for t = 1, 4 do
      assert.equal(scene, scene:set_vertices(mesh, { vertices = corners(wave(t)) }))
      local moved = picture(scene)
      assert.same({ 0, 0, 1 }, counts(scene))
      assert.equal(moved, picture(scene, "brute"))
      assert.equal(moved, picture(scene_of(sheet { vertices = corners(wave(t)) })))
      assert.not_equal(before, moved)
    end
    assert.equal(4, rt.counts().trees_refitted - work)
    scene:set_vertices("sheet", { vertices = corners(wave(0)) })
    assert.equal(before, picture(scene))
    assert.same({ 0, 1, 0 }, counts(scene))
  end)

  it("builds where it is told to, and where the tree has become bad", function()
    local mesh = sheet()
    local scene = scene_of(mesh)
    scene.settings.refit = 0
    scene:commit()
    scene:set_vertices(mesh, { vertices = corners(wave(1.5)) })
    assert.same({ 1, 0, 0 }, counts(scene))
    scene.settings.refit = nil
    local seed = 1
    scene:commit():set_vertices(mesh, { vertices = corners(function()
      seed = seed * 16807 % 2147483647
      return 2 * seed / 2147483647
    end) })
    assert.same({ 1, 0, 0 }, counts(scene))
    raises("refit", function() scene:render { refit = -1 } end)
    raises("refit is 0.5; it must be 0 (trees are always built) or from 1 to 1e6", function() scene:render { refit = 0.5 } end)
  end)

  it("gives a smooth mesh new normals, and others those that are given", function()
    local function normal(scene)
      return scene:intersect { org = { 0.31, 0.33, 5 }, dir = { 0, 0, -1 } }.ns
    end
    local slope = corners(function(x) return x end)
    local mesh = sheet { vertices = corners(flat), smooth = true }
    local scene = scene_of(mesh)
    assert.near(1, normal(scene)[3], 1e-6)
    scene:set_vertices(mesh, { vertices = slope })
    assert.near(math.sqrt(0.5), normal(scene)[3], 1e-6)
    scene:set_vertices(mesh, { vertices = slope, smooth = false })
    for i = 1, #mesh.faces do -- what the script does with its buffer afterwards is not the scene's
      mesh.faces[i] = 0
    end
    scene:set_vertices(mesh, { vertices = corners(flat) })
    assert.near(1, normal(scene)[3], 1e-6)
    mesh = sheet()
    scene = scene_of(mesh)
    local up = {}
    for i = 1, (N + 1) ^ 2 do
      up[i] = { 0, 1, 0 }
    end
    scene:set_vertices(mesh, { vertices = slope, normals = up })
    assert.same({ 0, 1, 0 }, normal(scene))
    scene:set_vertices(mesh, { vertices = corners(flat) })
    assert.same({ 0, 1, 0 }, normal(scene))
    scene:set_vertices(mesh, { vertices = slope, smooth = true })
    assert.near(math.sqrt(0.5), normal(scene)[3], 1e-6)
  end)

  it("moves what an instance places in a scene of its own", function()
    local mesh = sheet { vertices = corners(flat) }
    local part = rt.scene { mesh }
    local scene = scene_of(rt.instance { part, transform = rt.translate(0, 0, 1) })
    local function height()
      return 5 - scene:intersect { org = { 0.31, 0.33, 5 }, dir = { 0, 0, -1 } }.t
    end
    assert.equal(1, height())
    part:set_vertices(mesh, { vertices = corners(function() return 0.5 end) })
    assert.equal(1.5, height())
    assert.equal(1, part:info().refitted_trees)
    raises("rt.mesh 'sheet' stands in what an instance places", function() scene:set_vertices(mesh, { vertices = corners(flat) }) end)
  end)

  it("says what is wrong, and leaves the scene as it was", function()
    local mesh, ball = sheet(), rt.sphere { center = { 0, 0, 3 }, radius = 1, name = "ball" }
    local scene = scene_of { mesh, ball, sheet() }
    local hash = scene:hash()
    local bad = corners(flat)
    bad[5] = 0 / 0
    local function refused(sentence, what, moved)
      raises(sentence, function() scene:set_vertices(what, moved) end)
    end
    refused("positions[1] (part 1) is", mesh, { vertices = bad })
    refused("vertices has 2 items, but the mesh has 625", mesh, { vertices = { { 0, 0, 0 }, { 1, 1, 1 } } })
    refused("vertices[2] must be a table of 3 numbers", mesh, { vertices = { { 0, 0, 0 }, { 1, 1 } } })
    refused("vertices is missing", mesh, { normals = corners(flat) })
    refused("normals has 1 items, but vertices has 625", mesh, { vertices = corners(flat), normals = { 0, 0, 1 } })
    refused("smooth makes normals, but normals are given", mesh, { vertices = corners(flat), normals = corners(flat), smooth = true })
    refused("vertexes", mesh, { vertexes = corners(flat) })
    refused("rt.sphere 'ball' has no vertices", ball, { vertices = corners(flat) })
    refused("'sheets' is not in the scene", "sheets", { vertices = corners(flat) })
    refused("several objects of the scene are called 'sheet'; give the one that is meant", "sheet", { vertices = corners(flat) })
    refused("is not in the scene", sheet(), { vertices = corners(flat) })
    refused("the first argument must be a mesh of the scene, or its name; got 7", 7, {})
    refused("or its name; got nil", nil, { vertices = corners(flat) })
    assert.equal(hash, scene:hash())
  end)

  it("moves polyhedra, and meshes from files that are one geometry", function()
    local tent = rt.polyhedron { vertices = { { -1, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { -1, 1, 0 } }, faces = { { 1, 2, 3, 4 } } }
    support.in_folder(function(folder)
      local path = folder .. "/square.ply"
      local f <close> = assert(io.open(path, "w"))
      f:write("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n",
        "property list uchar int vertex_indices\nend_header\n-1 -1 1\n1 -1 1\n1 0 1\n-1 0 1\n4 0 1 2 3\n")
      f:close()
      local square = rt.mesh { file = path }
      local scene, other = rt.scene { tent, square }, rt.scene { square } -- which share the file's arrays
      local function height(s, y)
        return 9 - s:intersect { org = { 0.2, y, 9 }, dir = { 0, 0, -1 } }.t
      end
      scene:set_vertices(tent, { vertices = { { -1, 0, 3 }, { 1, 0, 3 }, { 1, 1, 3 }, { -1, 1, 3 } } })
      scene:set_vertices(square, { vertices = { { -1, -1, 2 }, { 1, -1, 2 }, { 1, 0, 2 }, { -1, 0, 2 } } })
      assert.same({ 3, 2, 1 }, { height(scene, 0.4), height(scene, -0.4), height(other, -0.4) })
      raises("vertex_count is 3, but the mesh has 4 vertices", function()
        scene:set_vertices(square, { vertices = { 0, 0, 0, 1, 1, 1, 2, 2, 2 } })
      end)
      local slope = { { -1, 0, 3 }, { 1, 0, 3 }, { 1, 1, 4 }, { -1, 1, 4 } }
      local function normal(s, y)
        return s:intersect { org = { 0.2, y, 9 }, dir = { 0, 0, -1 } }.ns[3]
      end
      scene:set_vertices(tent, { vertices = slope, smooth = true })
      assert.near(math.sqrt(0.5), normal(scene, 0.4), 1e-6)
      local round = rt.mesh { file = path, smooth = true }
      local smooth = rt.scene { round }
      raises("normals were made of its file (smooth = true); give normals", function() smooth:set_vertices(round, { vertices = slope }) end)
      smooth:set_vertices(round, { vertices = slope, smooth = true })
      assert.near(math.sqrt(0.5), normal(smooth, 0.4), 1e-6)
      smooth:set_vertices(round, { vertices = { { -1, 0, 3 }, { 1, 0, 3 }, { 1, 1, 3 }, { -1, 1, 3 } }, smooth = false })
      assert.near(math.sqrt(0.5), normal(smooth, 0.4), 1e-6)
    end)
  end)
end)
