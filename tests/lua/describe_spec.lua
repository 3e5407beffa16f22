-- Constructors: what they keep, and the sentence for each fault.

local support = require "support"
local rt, raises = support.rt, support.raises

local nan = 0 / 0

describe("a description", function()
  it("keeps copies", function()
    local center = { 1, 2, 3 }
    local s = rt.sphere { center = center, radius = 2, name = "ball" }
    center[1] = 9
    assert.equal(1, s.center[1])
    assert.equal(2, s.radius)
    assert.equal("rt.sphere 'ball'", tostring(s))
  end)

  it("takes the library's bounds", function()
    local far, thin = { 0, 1e12, 0 }, 1e-45
    assert.equal(3, rt.scene {
      rt.sphere { center = far, radius = 1e12 }, rt.cylinder { from = { 0, 0, 0 }, to = far, radius = thin },
      rt.spheres { centers = { far, { -1e12, 0, 0 } }, radii = { 1e12, thin } },
    }:info().geometries)
  end)

  it("takes what rt.vec computes", function()
    local s = rt.sphere { center = rt.vec(1, 2, 3) * 2 + { 1, 0, 0 }, radius = 1 }
    assert.same({ 3, 4, 6 }, { s.center:unpack() })
  end)

  it("works in coroutines", function()
    local s = coroutine.wrap(function()
      coroutine.yield()
      return rt.sphere { center = { 0, 0, 0 }, radius = 1 }
    end)
    s()
    assert.equal(1, s().radius)
  end)
end)

-- Each row: lines of e.lua, s being a sphere of line 1, and the sentence.
local changes = {
  { "s.radus = 3", "e.lua:2: rt.sphere has no key 'radus'; did you mean radius?" },
  { "s[1] = 3", "e.lua:2: rt.sphere has no key 1; known are center, mask, material, name, radius, user_id, uv_transform" },
  { "s.mask = -1", "e.lua:2: rt.sphere 'ball': mask must be a whole number from 0 to 4294967295; got -1" },
  { "s.radius = -1\nrt.scene { s }", "e.lua:1: rt.sphere 'ball': radius must be greater than 0; got -1 (item 1, rt.sphere 'ball')" },
  { "s.center = 'x'\nrt.scene { { false, s } }", "e.lua:1: rt.sphere 'ball': center must be {x, y, z}; got 'x' (item 1.2, rt.sphere 'ball')" },
  { "s.radius = -1\nrt.scene { rt.instance { s } }", "e.lua:1: rt.sphere 'ball': radius must be greater than 0; got -1 (item 1, rt.instance)" },
  { "local m = rt.classic { color = {1, 1, 1} }\nm.color = {0, 9, 0}\ns.material = m\nrt.scene { s }",
    "e.lua:2: rt.classic: color[2] must be from 0 to 1; got 9 (item 1, rt.sphere 'ball')" },
  { "local l = rt.point_light { at = {0, 5, 0} }\nl.at = 5\nrt.scene { s, l }",
    "e.lua:2: rt.point_light: at must be {x, y, z}; got 5 (item 2, rt.point_light)" },
  { "s.radius = nil\nrt.scene { s }", "e.lua:1: rt.sphere 'ball': radius is missing (item 1, rt.sphere 'ball')" },
  { "local l = rt.point_light { at = {0, 5, 0} }\nl.at = nil\nrt.scene { s, l }", "e.lua:2: rt.point_light: at is missing (item 2, rt.point_light)" },
  { "local m = rt.emissive { emission = {1, 1, 1} }\nm.emission = nil\ns.material = m\nrt.scene { s }",
    "e.lua:2: rt.emissive: emission is missing (item 1, rt.sphere 'ball')" },
  { "local c = rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0}, fov = 40 }\nc.fov = 400\nrt.scene { s, camera = c }",
    "e.lua:2: rt.camera: fov must be greater than 0 and less than 180; got 400" },
  { "local i = rt.instance { s, motion = { rt.scale(1), rt.scale(2) }, mask = 1 }\ni.mask = -1\nrt.scene { i }",
    "e.lua:2: rt.instance: mask must be a whole number from 0 to 4294967295; got -1 (item 1, rt.instance)" },
  { "local p = rt.polyhedron { vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0}, faces = {{1, 2, 3}}, mask = 1 }\np.mask = -1\nrt.scene { p }",
    "e.lua:2: rt.polyhedron: mask must be a whole number from 0 to 4294967295; got -1 (item 1, rt.polyhedron)" },
}

describe("a description that is changed", function()
  it("takes other values", function()
    local s = rt.sphere { center = { 0, 0, 0 }, radius = 1 }
    s.radius, s.material, s.name = 2, rt.classic { color = { 1, 0, 0 } }, "ball"
    local hit = rt.scene { s }:intersect { org = { 0, 0, 9 }, dir = { 0, 0, -1 } }
    assert.equal(7, hit.t)
    assert.equal("ball", hit.name)
    s.material = nil
    s.material = nil -- it is not there
    local c = rt.camera { eye = { 0, 0, 5 }, look_at = { 0, 0, 0 }, fov = 50, shutter = 0.5 }
    c.fov, c.shutter, c.motion = 40, 0.25, { eye = { 0, 1, 5 } }
    local seen = rt.scene { camera = c }:get_camera()
    assert.same({ 40, 0.25, 1 }, { seen.fov, seen.shutter[2], seen.motion.eye[2] })
  end)

  it("takes other lists and files, too", function()
    local function count(o, key)
      return rt.scene { o }:info()[key]
    end
    local balls = rt.spheres { centers = { 0, 0, 0 }, radii = { 1 } }
    balls.centers, balls.radii = { { 0, 0, 0 }, { 5, 0, 0 } }, { 1, 2 }
    assert.equal(2, count(balls, "shapes"))
    balls.radii = { 1 }
    raises("rt.spheres: radii has 1 items, but centers has 2", rt.scene, { balls })
    local roof = rt.polyhedron { vertices = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0 }, faces = { { 1, 2, 3 } } }
    roof.faces = { { 1, 2, 4, 3 } }
    assert.equal(2, count(roof, "triangles"))
    local mesh = rt.mesh { vertices = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, faces = { 1, 2, 3 } }
    mesh.faces = { { 1, 2, 3 }, { 3, 2, 1 } }
    assert.equal(2, count(mesh, "triangles"))
    local moved = rt.instance { mesh, motion = rt.translate(1, 0, 0) }
    moved.motion = { rt.translate(1, 0, 0), rt.translate(0, 2, 0) }
    assert.equal(3, count(moved, "motion_places")) -- and where it stands
    support.in_folder(function(folder)
      local file = rt.mesh { file = support.write(folder .. "/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n") }
      file.file = support.write(folder .. "/b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n")
      assert.equal(2, count(file, "triangles"))
    end)
  end)

  for _, row in ipairs(changes) do
    it("says " .. row[2], function()
      local code = "local rt = ... local s = rt.sphere { center = {0, 0, 0}, radius = 1, name = 'ball' }\n" .. row[1]
      local chunk = assert(load(code, "@e.lua"))
      assert.equal(row[2], support.message(chunk, rt))
    end)
  end
end)

local ORIGINS, ENDS = { { 0, 0, 0 }, { 1, 0, 0 } }, { { 0, 1, 0 }, { 1, 1, 0 } }

-- Each row: the call and its sentence.
local faults = {
  { function() return rt.sphere { center = { 0, 1, 0 }, radus = 1 }, nil end, "rt.sphere has no key 'radus'; did you mean radius?" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = 1, xyz = 2 }, nil end,
    "rt.sphere has no key 'xyz'; known are center, mask, material, name, radius, user_id, uv_transform" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = 1, 5 }, nil end,
    "rt.sphere has no key 1; known are center, mask, material, name, radius, user_id, uv_transform" },
  { function() return rt.sphere { center = { 0, 1, 0 } }, nil end, "rt.sphere: radius is missing" },
  { function() return rt.sphere {}, nil end, "rt.sphere: center is missing" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = -1 }, nil end, "rt.sphere: radius must be greater than 0; got -1" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = "1" }, nil end, "rt.sphere: radius must be a number; got '1'" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = math.huge }, nil end,
    "rt.sphere: radius is inf; it must be finite in single precision" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = 1e39 }, nil end,
    "rt.sphere: radius is 1e+39; it must be finite in single precision" },
  { function() return rt.sphere { center = { 0, nan, 0 }, radius = 1 }, nil end,
    "rt.sphere: center[2] is not a number (NaN); look for 0/0 or a root of a negative number" },
  { function() return rt.sphere { center = { 0, 1 }, radius = 1 }, nil end, "rt.sphere: center must be {x, y, z}; number 3 is missing" },
  { function() return rt.sphere { center = { 0, 1, 2, 3 }, radius = 1 }, nil end, "rt.sphere: center must be {x, y, z}; it has 4 values" },
  { function() return rt.sphere { center = 5, radius = 1 }, nil end, "rt.sphere: center must be {x, y, z}; got 5" },
  { function() return rt.sphere { center = { 0, "1", 2 }, radius = 1 }, nil end, "rt.sphere: center[2] must be a number; got '1'" },
  { function() return rt.sphere { center = { 0, 1, 2 }, radius = 1, material = { 1, 0, 0 } }, nil end,
    "rt.sphere: material must be a material, as rt.classic { ... } gives it; got a table" },
  { function() return rt.sphere { center = { 0, 1, 2 }, radius = 1, mask = -1 }, nil end,
    "rt.sphere: mask must be a whole number from 0 to 4294967295; got -1" },
  { function() return rt.sphere { center = { 0, 1, 2 }, radius = 1, name = "" }, nil end, "rt.sphere: name is empty" },
  { function() return rt.sphere(3), nil end, "rt.sphere takes one table, as in rt.sphere { center = {0, 1, 0}, radius = 1 }; got 3" },
  { function() return rt.sphere(rt.vec(1, 2, 3)), nil end,
    "rt.sphere takes one table, as in rt.sphere { center = {0, 1, 0}, radius = 1 }; got a rt.vec" },
  { function() return rt.plane { point = { 0, 0, 0 }, normal = { 0, 0, 0 } }, nil end, "rt.plane: normal is zero and so has no direction" },
  { function() return rt.box { low = { 0, 0, 0 }, high = { 1, 0, 1 } }, nil end,
    "rt.box: low must be below high on each axis; y goes from 0 to 0" },
  { function() return rt.cylinder { from = { 0, 0, 0 }, to = { 0, 0, 0 }, radius = 1 }, nil end, "rt.cylinder: from and to are the same point" },
  { function() return rt.cone { from = { 0, 0, 0 }, to = { 0, 1, 0 }, radius = 0 }, nil end, "rt.cone: radius and to_radius are both 0" },
  { function() return rt.torus { center = { 0, 0, 0 }, axis = { 0, 1, 0 }, major_radius = 1, minor_radius = 1 }, nil end,
    "rt.torus: minor_radius must be less than major_radius; got 1 and 1" },
  { function() return rt.classic { color = { 0, 0, 2 } }, nil end, "rt.classic: color[3] must be from 0 to 1; got 2" },
  { function() return rt.classic { diffusion = 1.5 }, nil end, "rt.classic: diffusion must be from 0 to 1; got 1.5" },
  { function() return rt.classic { colour = { 1, 1, 1 } }, nil end, "rt.classic has no key 'colour'; did you mean color?" },
  { function() return rt.classic { texture = 5 }, nil end,
    "rt.classic: texture must be a file's name, a texture as rt.texture { file = ... } or an image; got 5" },
  { function() return rt.emissive {}, nil end, "rt.emissive: emission is missing" },
  { function() return rt.texture {}, nil end, "rt.texture: give either file or image" },
  { function() return rt.texture { file = "a\0b" }, nil end, "rt.texture: file has a NUL byte inside" },
  { function() return rt.texture { file = "a.png", wrap = "clam" }, nil end,
    "rt.texture: wrap must be one of repeat, clamp; got 'clam' (did you mean clamp?)" },
  { function() return rt.point_light { at = { 0, 0, 0 }, color = { -1, 0, 0 } }, nil end, "rt.point_light: color[1] must be at least 0; got -1" },
  { function() return rt.sphere_light { at = { 0, 0, 0 }, radius = 0 }, nil end, "rt.sphere_light: radius must be greater than 0; got 0" },
  { function() return rt.directional_light {}, nil end, "rt.directional_light: direction is missing" },
  { function() return rt.camera { eye = { 0, 0, 0 } }, nil end, "rt.camera: look_at is missing" },
  { function() return rt.camera { eye = { 0, 0, 0 }, look_at = { 0, 0, 0 } }, nil end, "rt.camera: eye and look_at are the same point" },
  { function() return rt.camera { eye = { 0, 0, 0 }, look_at = { 0, 0, 1 }, fov = 180 }, nil end,
    "rt.camera: fov must be greater than 0 and less than 180; got 180" },
  { function() return rt.spheres { centers = { 1, 2 }, radius = 1 }, nil end, "rt.spheres: centers needs 3 numbers an item; it has 2 numbers" },
  { function() return rt.spheres { centers = { { 1, 2, 3 } } }, nil end, "rt.spheres: give either radii, one a sphere, or radius, one for all" },
  { function() return rt.spheres { centers = { { 1, 2, 3 } }, radii = { 1, 2 } }, nil end, "rt.spheres: radii has 2 items, but centers has 1" },
  { function() return rt.spheres { centers = rt.buffer("u32", 3), radius = 1 }, nil end,
    "rt.spheres: centers must be a buffer of type f32; got one of type u32" },
  { function() return rt.spheres { centers = { { 1, 2, 3 }, { 4, 0 / 0, 6 } }, radius = 1 }, nil end,
    "rt.spheres: centers[2][2] is not a number (NaN); look for 0/0 or a root of a negative number" },
  { function() return rt.cylinders { from = { { 0, 0, 0 } }, radius = 1 }, nil end, "rt.cylinders: to is missing" },
  { function() return rt.cylinders { from = { { 0, 0, 0 } }, to = { { 0, 1, 0 } } }, nil end,
    "rt.cylinders: give either radii, one a cylinder, or radius, one for all" },
  { function() return rt.cylinders { from = { { 0, 0, 0 } }, to = { { 0, 1, 0 }, { 1, 1, 1 } }, radius = 1 }, nil end,
    "rt.cylinders: to has 2 items, but from has 1" },
  { function() return rt.cones { from = { { 0, 0, 0 } }, to = { { 0, 1, 0 } }, radius = 1, to_radii = { 1, 2 } }, nil end,
    "rt.cones: to_radii has 2 items, but from has 1" },
  { function() return rt.cones { from = { { 0, 0, 0 } }, to = { { 0, 1, 0 } }, radius = 1, to_radii = { 1 }, to_radius = 1 }, nil end,
    "rt.cones: give either to_radii, one a cone, or to_radius, one for all; 0 without both" },
  { function() return rt.cones { from = { 1, 2, 3, 4, 5, 6 }, to = { 1, 2, 0, 4, 5, 6 }, radius = 1 }, nil end,
    "rt.cones: from and to of cone 2 are the same point" },
  { function() return rt.cones { from = { 1, 2, 3 }, to = { 1, 2, 0 }, radius = 0 }, nil end, "rt.cones: radius and to_radius are both 0" },
  { function() return rt.cones { from = { 1, 2, 3 }, to = { 1, 2, 0 }, radius = 1, to_radii = { -1 } }, nil end,
    "rt.cones: to_radii[1] must be at least 0; got -1" },
  { function() return rt.cylinders { from = { 1, 2, 3, 4, 5, 6 }, to = { 1, 2, 0, 4, 5, 0 }, radii = { 1, 0 } }, nil end,
    "rt.cylinders: radii[2] must be greater than 0; got 0" },
  { function() return rt.cylinders { from = { 1, 2, 1e300 }, to = { 1, 2, 0 }, radius = 1 }, nil end,
    "rt.cylinders: from[3] is 1e+300; it must be finite in single precision" },
  { function() return rt.spheres { centers = { 1, 2, 3 }, radii = { 1e39 } }, nil end,
    "rt.spheres: radii[1] is 1e+39; it must be finite in single precision" },
  { function() return rt.spheres { centers = { 1, 2, "3" }, radius = 1 }, nil end, "rt.spheres: centers[3] must be a number; got '3'" },
  { function() return rt.scene { rt.cones { from = { 1, 2, 3 }, to = { 1, 2, 0 }, radii = { 0 } } }, nil end,
    "item 1 (rt.cones): cone 1 has radius 0 at both ends; one must be greater" },
  { function() return rt.spheres { centers = ORIGINS, radii = { 1, 1e-60 } }, nil end,
    "rt.spheres: radii[2] must be greater than 0; got 1e-60, which is 0 in single precision" },
  { function() return rt.spheres { centers = ORIGINS, radii = { 1, 1e13 } }, nil end,
    "rt.spheres: radii[2] must be at most 1e+12 in size; got 1e+13" },
  { function() return rt.cylinders { from = { { 0, 0, 0 }, { -1e13, 0, 0 } }, to = ORIGINS, radius = 1 }, nil end,
    "rt.cylinders: from[2][1] must be at most 1e+12 in size; got -1e+13" },
  { function() return rt.scene { rt.cones { from = ORIGINS, to = ENDS, radii = { 1, 1e-60 }, to_radii = { 1, 1e-60 } } }, nil end,
    "item 1 (rt.cones): cone 2 has radius 0 at both ends; one must be greater" },
  { function() return rt.cylinder { from = { 0, 0, 0 }, to = { 0, 1, 0 }, radius = 1e-60 }, nil end,
    "rt.cylinder: radius must be greater than 0; got 1e-60, which is 0 in single precision" },
  { function() return rt.cone { from = { 0, 0, 0 }, to = { 0, 1, 0 }, radius = 1e-60 }, nil end, "rt.cone: radius and to_radius are both 0" },
  { function() return rt.sphere { center = { 0, 1e13, 0 }, radius = 1 }, nil end,
    "rt.sphere: center[2] must be at most 1e+12 in size; got 1e+13" },
  { function() return rt.sphere { center = { 0, 1, 0 }, radius = 2e12 }, nil end, "rt.sphere: radius must be at most 1e+12 in size; got 2e+12" },
  { function() return rt.plane { point = { 0, 0, 0 }, normal = { 0, 1e-60, 0 } }, nil end, "rt.plane: normal is zero and so has no direction" },
  { function() return rt.camera { eye = { 0, 0, 0 }, look_at = { 0, 0, 1 }, fov = 179.9999999 }, nil end,
    "rt.camera: fov must be greater than 0 and less than 180; got 179.9999999, which is 180 in single precision" },
  { function() return rt.mesh { vertices = ENDS, faces = {}, colors = { { 1, 1, 1 }, { 1, 2e6, 1 } } }, nil end,
    "rt.mesh: colors[2][2] must be at most 1000000 in size; got 2000000" },
  { function() return rt.scene { rt.spheres { centers = ORIGINS, radii = rt.buffer("f32", { 1, 0 }) } }, nil end,
    "rt.spheres: radii[2] must be greater than 0; got 0.0 (item 1, rt.spheres)" },
  { function() return rt.scene { rt.mesh { vertices = rt.buffer("f32", { 0, 0, 0, 2e12, 0, 0 }), faces = {} } }, nil end,
    "rt.mesh: vertices[4] must be at most 1e+12 in size; got 1999999991808.0 (item 1, rt.mesh)" },
  { function()
    local from = rt.buffer("f32", 6)
    local bars = rt.cylinders { from = from, to = ENDS, radius = 1 }
    from:set(4, 1, 1, 0) -- after it was described
    return rt.scene { bars }, nil
  end,
    "item 1 (rt.cylinders): from and to of cylinder 2 are the same point" },
  { function() return rt.mesh {}, nil end, "rt.mesh: give file, or vertices and faces" },
  { function() return rt.mesh { vertices = { { 0, 0, 0 } } }, nil end, "rt.mesh: faces is missing" },
  { function() return rt.mesh { file = "x.ply", faces = { { 1, 2, 3 } } }, nil end, "rt.mesh: file and faces do not go together" },
  { function() return rt.mesh { vertices = { { 0, 0, 0 } }, faces = { { 1, 1, 0 } } }, nil end,
    "rt.mesh: faces[3] must be the number of a vertex, from 1; got 0" },
  { function() return rt.mesh { vertices = { { 0, 0, 0 } }, faces = { { 1, 1, 1, 1 } } }, nil end,
    "rt.mesh: faces[1] has 4 corners; rt.polyhedron takes such faces" },
  { function() return rt.mesh { vertices = { { 0, 0, 0 } }, faces = { { 1, 1, 2 } } }, nil end,
    "rt.mesh: faces names vertex 2, but there are 1" },
  { function() return rt.mesh { vertices = { { 0, 0 } }, faces = {} }, nil end,
    "rt.mesh: vertices[1] must be a table of 3 numbers; got a table of 2" },
  { function() return rt.mesh { vertices = { 1, 2, nil, 4 }, faces = {} }, nil end,
    "rt.mesh: vertices must be a list without holes or names" },
  { function() return rt.polyhedron { vertices = { { 0, 0, 0 } }, faces = { { 1, 1, 2 } } }, nil end,
    "rt.polyhedron: faces names vertex 2, but there are 1" },
  { function() return rt.polyhedron { vertices = { { 0, 0, 0 } }, faces = { { 1, 1 } } }, nil end,
    "rt.polyhedron: faces[1] must be a list of at least 3 vertex numbers; got a list of 2" },
  { function() return rt.instance {}, nil end,
    "rt.instance: it places nothing; put an object first, as in rt.instance { bunny, transform = ... }" },
  { function() return rt.instance { rt.group {}, transform = { 1, 2, 3 } }, nil end,
    "rt.instance: transform must be a table of 12 numbers; got a table of 3" },
  { function() return rt.vec(1, 2), nil end, "rt.vec takes three numbers, one number or {x, y, z}" },
  { function() return rt.vec(1, 2, 3) + "x", nil end, "an operand of vec + must be a number or {x, y, z}; got 'x'" },
  { function() return rt.vec(0, 0, 0):normalize(), nil end, "a vec of length 0.0 has no direction" },
  { function() rt.vec(1, 2, 3).w = 4 end, "a vec is a value: its w is not assigned, a new vec is made" },
  { function() return rt.srgb(255, 127.6, 0), nil end,
    "rt.srgb takes numbers from 0 to 1; got 255, 127.6, 0; of 0 to 255 they are rt.srgb '#ff8000', or each over 255" },
  { function() return rt.srgb(0, 0, 300), nil end, "rt.srgb takes numbers from 0 to 1; got 0, 0, 300" },
  { function() return rt.classic { color = "#ff0000" }, nil end,
    "rt.classic: color must be {red, green, blue}; got '#ff0000'; rt.srgb '#ff0000' gives a color from a text" },
  { function() return rt.point_light { at = { 0, 0, 0 }, color = "white" }, nil end,
    "rt.point_light: color must be {red, green, blue}; got 'white'; rt.srgb '#ff8000' gives a color from a text" },
  { function() return rt.scene { background = "#ff0000" }, nil end,
    "rt.scene: background is '#ff0000'; rt.srgb '#ff0000' gives a color from a text" },
  { function() return rt.srgb "red", nil end, "rt.srgb: '#rrggbb' is expected; got 'red'" },
  { function() return rt.rotate({ 0, 0, 0 }, 90), nil end, "rt.rotate: the axis is zero and so has no direction" },
  { function() return rt.scale(0), nil end, "rt.scale: a factor of 0 flattens everything" },
  { function() return rt.random(), nil end, "rt.random needs at least one key: the same keys give the same number" },
  { function() return rt.random({}), nil end, "rt.random: key 1 must be a number or a string; got a table" },
  { function() return rt.load(5), nil end, "rt.load: the path must be a string; got 5" },
  { function() return rt.on_log(5), nil end, "rt.on_log: the argument must be a function; got 5" },
  { function() return rt.image { width = 0, height = 1 }, nil end, "rt.image: width must be a whole number from 1 to 1048576; got 0" },
  { function() return rt.compare(1, 2), nil end, "rt.compare: the first argument must be an image, as rt.image gives it; got 1" },
}

describe("a fault is a sentence with its place:", function()
  for _, row in ipairs(faults) do
    it(row[2], function()
      raises(row[2], row[1])
    end)
  end

  it("names the same key whatever the order of the table", function()
    raises("rt.classic has no key 'aaa'; known are alpha_cut, alpha_texture, ambient, color, diffusion, name, opaque_shadow, "
      .. "reflectiveness, refractiveness, shininess, specular, texture, transparency", function()
      return rt.classic { zzz = 1, aaa = 2, mmm = 3 }, nil
    end)
  end)
end)
