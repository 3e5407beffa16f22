-- Scenes: renders, queries, facts, saving.

local support = require "support"
local rt, raises = support.rt, support.raises

describe("looks", function()
  it("that no ray touched change nothing", function()
    local function scene(color)
      return support.ball {
        rt.sphere { center = { 0, 1, 0 }, radius = 1, material = rt.classic { color = { 1, 0.2, 0.1 } } },
        rt.sphere { center = { 0, 1, 50 }, radius = 1, material = rt.classic { color = color } }, rt.point_light { at = { 3, 5, 4 } },
      }
    end
    local a, b = scene { 1, 0, 0 }, scene { 0, 1, 0 }
    local image, stats = a:render()
    local before, after, differing = a:looks(), b:looks(), 0
    assert.equal(before.rest, after.rest)
    assert.equal(#stats.touched, #before)
    for i, hash in ipairs(before) do
      if hash ~= after[i] then
        differing = differing + 1
        assert.is_false(stats.touched[i])
      end
    end
    assert.equal(1, differing)
    assert.not_equal(a:hash(), b:hash())
    assert.equal(image:hash(), b:render():hash())
  end)
end)

describe("a render", function()
  it("gives the picture", function()
    local scene = support.ball()
    local image, stats = scene:render()
    assert.same({ 32, 24 }, { image:size() })
    local r, g, b, a = image:pixel(16, 12)
    assert.is_true(r > g and g > 0 and b > 0)
    assert.equal(1, a)
    assert.equal(32 * 24, stats.rays_camera)
    assert.is_true(stats.rays > stats.rays_camera)
  end)

  it("has the same bits for any arrangement", function()
    local scene = support.ball()
    local hash = scene:render { workers = 1, tile = 64 }:hash()
    for _, tracer in ipairs { "kdtree", "octree", "brute" } do
      assert.equal(hash, scene:render { workers = 3, tile = 7, tracer = tracer, schedule = "static" }:hash())
    end
    assert.equal(hash, rt.render(scene):hash())
    assert.equal(hash, support.ball():render():hash())
    assert.not_equal(hash, scene:render { samples = 2 }:hash())
  end)

  it("shows the background of an empty scene", function()
    local image = rt.scene { background = { 0.25, 0.5, 0.75 } }:render { width = 4, height = 3, samples = 1 }
    assert.same({ 0.25, 0.5, 0.75 }, { table.unpack({ image:pixel(2, 1) }, 1, 3) })
  end)

  it("takes size, crop and the rest", function()
    local scene = support.ball()
    assert.same({ 10, 6 }, { scene:render { size = { 10, 6 } }:size() })
    local whole, part = scene:render(), scene:render { crop = { x = 8, y = 4, width = 10, height = 5 } }
    assert.same({ 10, 5 }, { part:size() })
    assert.same({ whole:pixel(10, 6) }, { part:pixel(2, 2) })
  end)

  it("frames what has no camera", function()
    local image = rt.scene { rt.sphere { center = { 100, 50, -20 }, radius = 3, material = rt.emissive { emission = { 1, 1, 1 } } } }:render {
      width = 16, height = 16, samples = 1,
    }
    assert.equal(1, (image:pixel(8, 8)))
    assert.equal(0, (image:pixel(0, 0)))
  end)

  it("works in a coroutine", function()
    local image = coroutine.wrap(function()
      return support.ball():render()
    end)()
    assert.equal(support.ball():render():hash(), image:hash())
  end)

  it("reports its progress on this thread and ends with what the report raises", function()
    local scene, calls, last = support.ball(), 0, -1
    scene:render {
      progress = function(done, job)
        calls = calls + 1
        assert(done >= last and done <= 1 and tostring(job):find "rt.job")
        last = done
      end,
    }
    assert.is_true(calls >= 1)
    assert.equal(1, last)
    local ok, raised = pcall(scene.render, scene, { progress = function() error("enough", 0) end })
    assert.is_false(ok)
    assert.equal("enough", raised)
    assert.equal(last, 1)
    scene:render()
  end)

  it("checks its options", function()
    local scene = support.ball()
    raises("scene:render has no setting 'sampels'; did you mean samples?", function() return scene:render { sampels = 1 }, nil end)
    raises("scene:render: samples must be a whole number from 1 to 65536; got 0", function() return scene:render { samples = 0 }, nil end)
    raises("scene:render: samples must be a whole number; got 1.5", function() return scene:render { samples = 1.5 }, nil end)
    raises("scene:render: progress must be a function; got 1", function() return scene:render { progress = 1 }, nil end)
    raises("rt.render: the first argument must be a scene; got 1", function() return rt.render(1), nil end)
  end)

  it("says what it needs when it may not have it", function()
    local scene = support.ball()
    local message = support.message(scene.render, scene, { width = 30000, height = 30000, memory_limit = 2 ^ 26 | 0 })
    assert.is_truthy(message:find "memory" or message:find "MiB", message)
    message = support.message(scene.render, scene, { width = 100000, height = 100000 })
    assert.is_truthy(message:find("scene_spec.lua:%d+: 100000 x 100000") or message:find("support.lua:%d+: 100000 x 100000"), message)
    assert.is_true(scene:memory() > 0)
  end)
end)

describe("a scene", function()
  it("checks its keys", function()
    raises("rt.scene has no key 'ambeint'; did you mean ambient?", function() return rt.scene { ambeint = { 0, 0, 0 } }, nil end)
    raises("rt.scene: camera must be a camera, as rt.camera { eye = ..., look_at = ... } gives it; got a table", function()
      return rt.scene { camera = { eye = { 0, 0, 0 } } }, nil
    end)
    raises("rt.scene takes one table, as in rt.scene { camera = ..., objects }; got nil", function() return rt.scene(), nil end)
  end)

  it("takes no assignment that would change nothing, and says what does", function()
    local scene = support.ball()
    local camera = rt.camera { eye = { 0, 0, 50 }, look_at = { 0, 0, 0 } }
    for _, row in ipairs {
      { "camera", "'camera' cannot be assigned to a made scene; scene:set_camera(rt.camera { ... }) sets it" },
      { "cammera", "'cammera' cannot be assigned to a made scene; did you mean camera? scene:set_camera(rt.camera { ... }) sets it" },
      { "background", "'background' cannot be assigned to a made scene; rt.scene { background = ... } takes it" },
      { 3, "item 3 cannot be assigned to a made scene; scene:add(object) adds one" },
      { "samples", "'samples' cannot be assigned to a made scene; it is a setting, as in scene.settings.samples or scene:render { samples = ... }" },
      { "zzzzzzzzz", "'zzzzzzzzz' cannot be assigned to a made scene; scene:set_camera and scene:add change one" },
    } do
      raises("rt.scene: " .. row[2], function() scene[row[1]] = camera end)
    end
    local framed = rt.scene { rt.point_light { at = { 3, 5, 4 } }, rt.sphere { center = { 0, 1, 0 }, radius = 1 } }
    local image = framed:render { width = 16, height = 12, samples = 1 }
    pcall(function() framed.camera = camera end)
    assert.equal(image:hash(), framed:render { width = 16, height = 12, samples = 1 }:hash())
  end)

  it("takes other settings", function()
    local scene = support.ball()
    scene.settings = { size = { 8, 6 }, samples = 2 }
    assert.same({ 8, 6 }, { scene:render():size() })
    scene.settings.sampels = 3
    raises("scene.settings has no setting 'sampels'; did you mean samples?", function() scene:render() end)
    scene.settings = 5
    raises("scene.settings must be a table, as { width = 800, samples = 4 }; got 5", function() scene:render() end)
  end)

  it("tells of itself", function()
    local scene = support.ball()
    local info = scene:info()
    assert.equal(1, info.shapes)
    assert.equal(1, info.planes)
    assert.equal(1, info.lights)
    assert.is_true(#info.trees >= 1)
    local low, high = scene:bounds()
    for i, corners in ipairs { { -1, 1 }, { 0, 2 }, { -1, 1 } } do -- a little around what is there
      assert.is_true(low[i] <= corners[1] and low[i] > corners[1] - 1e-4 and high[i] >= corners[2] and high[i] < corners[2] + 1e-4)
    end
    assert.equal(32, #scene:hash())
    assert.equal(scene:hash(), support.ball():hash())
    assert.not_equal(scene:hash(), support.ball { ambient = { 0.3, 0.3, 0.3 } }:hash())
    assert.same({ 0, 1, 5 }, scene:get_camera().eye)
  end)

  it("can be released twice, closed, and says so later", function()
    local scene = support.ball()
    do
      local closed <close> = support.ball()
      closed:hash()
    end
    scene:release()
    scene:release()
    raises("the scene has been released", function() return scene:hash(), nil end)
  end)

  it("keeps what its job needs", function()
    local job = support.ball():start()
    collectgarbage()
    collectgarbage()
    assert.equal("done", (job:wait()))
    assert.same({ 32, 24 }, { job:image():size() })
  end)

  it("builds no tree for a material, even when it is made anew", function()
    local function built(radius, ior)
      local material = rt.classic { refractiveness = ior, transparency = 1, diffusion = 0 }
      local info = rt.scene { rt.sphere { center = { 0.25, 0, 0 }, radius = radius, material = material } }:info()
      return info.built_trees
    end
    assert.equal(1, built(0.123, 1.5))
    assert.equal(0, built(0.123, 1.6))
    assert.equal(1, built(0.124, 1.6))
  end)

  it("is saved and loaded as a snapshot", function()
    support.in_folder(function(folder)
      local scene = support.ball()
      scene:save(folder .. "/ball.rts")
      local loaded = rt.load_snapshot(folder .. "/ball.rts")
      assert.equal(scene:hash(), loaded:hash())
      assert.equal(scene:render():hash(), loaded:render { width = 32, height = 24, samples = 1 }:hash())
      assert.equal(scene:hash(), rt.load(folder .. "/ball.rts"):hash())
      assert.is_truthy(support.message(loaded.add, loaded, rt.sphere { center = { 0, 0, 0 }, radius = 1 }))
      support.write(folder .. "/broken.rts", "not a snapshot")
      assert.is_truthy(support.message(rt.load_snapshot, folder .. "/broken.rts"):find("broken.rts", 1, true))
    end)
  end)
end)

describe("a ray", function()
  local scene = support.ball()

  it("finds the closest hit", function()
    local hit = scene:intersect { org = { 0, 1, 5 }, dir = { 0, 0, -2 } }
    assert.is_true(math.abs(hit.t - 2) < 1e-5)
    assert.equal("ball", hit.name)
    assert.equal(0, hit.geom_id)
    assert.is_true(math.abs(hit.position[3] - 1) < 1e-5)
    assert.is_true(math.abs(hit.ng[3] - 1) < 1e-5)
    assert.is_nil(scene:intersect { org = { 0, 1, 5 }, dir = { 0, 0, 1 } })
    assert.is_nil(scene:intersect { org = { 0, 1, 5 }, dir = { 0, 0, -1 }, tmax = 3.9 })
  end)

  it("finds all hits in order", function()
    local hits = scene:intersect_all { org = { 0, 1, 5 }, dir = { 0, -0.1, -1 } }
    assert.equal(3, #hits)
    assert.same({ "ball", "ball", "floor" }, { hits[1].name, hits[2].name, hits[3].name })
    assert.is_true(hits[1].t < hits[2].t and hits[2].t < hits[3].t)
    assert.equal(1, #scene:intersect_all({ org = { 0, 1, 5 }, dir = { 0, -0.1, -1 } }, 1))
  end)

  it("is occluded or not", function()
    assert.is_true(scene:occluded { org = { 0, 1, 5 }, dir = { 0, 0, -1 } })
    assert.is_false(scene:occluded { org = { 0, 1, 5 }, dir = { 0, 0, 1 } })
  end)

  it("comes in thousands by a buffer", function()
    local count = support.many(1000) + 20
    local rays = rt.buffer("f32", 8 * count)
    for i = 0, count - 1 do
      rays:set(8 * i + 1, 4 * rt.random("x", i) - 2, 3 * rt.random("y", i), 5, 0, 0, 0, -1, math.huge)
    end
    local hits, occluded = scene:intersect(rays), scene:occluded(rays)
    assert.equal(count, #hits.t)
    local found = 0
    for i = 0, count - 1 do
      local x, y = rays:get(8 * i + 1, 2)
      local one = scene:intersect { org = { x, y, 5 }, dir = { 0, 0, -1 } }
      assert.equal(one and one.t or math.huge, hits.t[i + 1])
      assert.equal(one and one.prim_id or 0xffffffff, hits.prim_id[i + 1])
      assert.equal(one and 1 or 0, occluded[i + 1])
      found = found + (one and 1 or 0)
    end
    assert.is_true(found > count // 10 and found < count)
  end)

  it("is checked", function()
    raises("scene:intersect_all: the count must be a whole number from 1 to 1024; got 0", function()
      return scene:intersect_all({ org = { 0, 0, 0 }, dir = { 0, 0, 1 } }, 0), nil
    end)
    raises("scene:intersect: dir is missing", function() return scene:intersect { org = { 0, 0, 0 } }, nil end)
    raises("scene:intersect: dir is zero and so has no direction", function()
      return scene:intersect { org = { 0, 0, 0 }, dir = { 0, 0, 0 } }, nil
    end)
    raises("scene:occluded has no key 'direction'; known are dir, mask, org, time, tmax, tmin", function()
      return scene:occluded { org = { 0, 0, 0 }, direction = { 0, 0, 1 } }, nil
    end)
    raises("rays must be a buffer of type f32 with 8 numbers a ray (org, tmin, dir, tmax); got rt.buffer(f32, 7)", function()
      return scene:intersect(rt.buffer("f32", 7)), nil
    end)
  end)
end)

describe("shapes of arrays", function()
  local function hit(shape, x, y)
    return rt.scene { shape }:intersect { org = { x, y, 5 }, dir = { 0, 0, -1 } }
  end

  it("are meshes, counted from 1 in lists and from 0 in buffers", function()
    local corners = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } }
    local m = rt.mesh { vertices = corners, faces = { { 1, 2, 3 }, { 1, 3, 4 } } }
    assert.equal(0, hit(m, 0.7, 0.2).prim_id)
    assert.equal(1, hit(m, 0.2, 0.7).prim_id)
    local flat = rt.buffer("f32", { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 })
    local n = rt.mesh { vertices = flat, faces = rt.buffer("u32", { 0, 1, 2, 0, 2, 3 }) }
    assert.equal(rt.scene { m }:hash(), rt.scene { n }:hash())
  end)

  it("may be smooth", function()
    local roof = { vertices = { { -1, 0, 0 }, { 0, 0, 1 }, { 1, 0, 0 }, { 0, 1, 0.5 } }, faces = { { 1, 2, 4 }, { 2, 3, 4 } } }
    local flat = hit(rt.mesh(roof), 0.01, 0.3)
    roof.smooth = true
    local smooth = hit(rt.mesh(roof), 0.01, 0.3)
    assert.same(flat.ng, smooth.ng)
    assert.is_true(math.abs(smooth.ns[1]) < 0.1 and math.abs(flat.ns[1]) > 0.3)
  end)

  it("are polyhedra", function()
    local p = rt.polyhedron { vertices = { { 0, 0, 0 }, { 2, 0, 0 }, { 2, 2, 0 }, { 1, 0.5, 0 }, { 0, 2, 0 } }, faces = { { 1, 2, 3, 4, 5 } } }
    assert.is_truthy(hit(p, 1, 0.25))
    assert.is_nil(hit(p, 1, 1.5))
    assert.is_truthy(hit(p, 0.2, 1.2))
  end)

  it("are many spheres, with a material each", function()
    local red, blue = rt.classic { color = { 1, 0, 0 } }, rt.classic { color = { 0, 0, 1 } }
    local s = rt.spheres { centers = { { 0, 0, 0 }, { 3, 0, 0 } }, radii = { 1, 0.5 }, materials = { red, blue } }
    assert.same({ 1, 0, 0 }, hit(s, 0, 0).color)
    assert.same({ 0, 0, 1 }, hit(s, 3, 0).color)
    assert.equal(1, hit(s, 3, 0).prim_id)
    assert.is_nil(hit(s, 3.7, 0))
  end)

  it("are many cylinders and cones, with a colour each", function()
    local ends = { from = { { 0, 0, 0 }, { 3, 0, 0 } }, to = { { 0, 2, 0 }, { 3, 2, 0 } }, colors = { { 1, 0, 0 }, { 0, 0, 1 } } }
    local function with(more)
      for key, value in pairs(ends) do
        more[key] = value
      end
      return more
    end
    local rods, tips = rt.cylinders(with { radii = { 1, 0.5 } }), rt.cones(with { radius = 1, to_radii = { 0, 0.5 } })
    assert.same({ 1, 0, 0 }, hit(rods, 0.9, 1).color)
    assert.same({ 0, 0, 1 }, hit(rods, 3, 1).color)
    assert.equal(1, hit(rods, 3.4, 1.9).prim_id)
    assert.is_nil(hit(rods, 3.6, 1))
    assert.equal(0, hit(tips, 0.4, 1).prim_id)
    assert.is_nil(hit(tips, 0.6, 1))
    assert.equal(1, hit(tips, 3.7, 1).prim_id)
  end)
end)

describe("100,000 spheres", function()
  it("are described and added; the time is told (half a second is the goal)", function()
    local best, count = math.huge, support.many(100000)
    for _ = 1, 3 do
      local start = os.clock()
      local list = {}
      for i = 1, count do
        list[i] = rt.sphere { center = { i % 317, i // 317, rt.random(i) }, radius = 0.3 }
      end
      local scene <close> = rt.scene(list)
      best = math.min(best, os.clock() - start)
      assert.truthy(scene.objects[count - 1])
      assert.is_nil(scene.objects[count])
    end
    print(("# %d spheres: %.3f s"):format(count, best))
  end)
end)
