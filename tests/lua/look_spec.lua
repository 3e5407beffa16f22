-- Looking into scenes from Lua: the tables, the names, the refusals. What the numbers mean is tested in unit.look and unit.explain.

local support = require "support"
local rt = support.rt

local function place(i)
  return { rt.random("x", i), rt.random("y", i), rt.random("z", i) }
end

local function balls()
  local list = {}
  for i = 1, 80 do
    list[i] = rt.sphere { center = place(i), radius = 0.03, name = "ball " .. i, material = rt.classic { name = "paint " .. i } }
  end
  return list
end

local function scene()
  return rt.scene {
    settings = { width = 24, height = 16, samples = 2, leaf_size = 4 },
    camera = rt.camera { eye = { 0.5, 0.5, 4 }, look_at = { 0.5, 0.5, 0 }, fov = 20 },
    rt.point_light { at = { 3, 4, 5 }, name = "lamp" }, balls(),
  }
end

-- Calls f, and raises "stop" inside of the binding's function `name` at the `count`th call that a hook sees there: what an interrupt does.
local function interrupted(name, count, f)
  local core = require "rt.core"
  local original, seen = core[name], 0
  core[name] = function(...)
    debug.sethook(function()
      local called = debug.getinfo(2, "f").func
      seen = seen + (called ~= debug.sethook and called ~= original and 1 or 0)
      if seen == count then
        debug.sethook()
        error("stop", 0)
      end
    end, "c")
    local a, b = original(...)
    debug.sethook()
    return a, b
  end
  local ok, raised = pcall(f)
  debug.sethook()
  core[name] = original
  assert.same({ false, "stop" }, { ok, raised })
end

describe("an interrupt", function()
  it("ends what takes long, and the scene is as it was", function()
    local s = rt.scene {
      settings = { width = 24, height = 16, samples = 65536, shadow_samples = 16 }, rt.sphere_light { at = { 3, 4, 5 }, radius = 1 },
      camera = rt.camera { eye = { 0.5, 0.5, 4 }, look_at = { 0.5, 0.5, 0 }, fov = 20 }, balls(),
    }
    local hash, cells = s:hash(), #s:tree_cells { tracer = "kdtree" }
    interrupted("explain", 2, function() s:explain(12, 8, { sample = 0 }) end)
    interrupted("tree_cells", 1, function() s:tree_cells { tracer = "kdtree" } end)
    local rays = rt.buffer("f32", 8 * 20000)
    for i = 0, 19999 do
      rays[8 * i + 3], rays[8 * i + 7], rays[8 * i + 8] = 4, -1, 100
    end
    interrupted("ray_costs", 3, function() s:ray_costs(rays, { tracer = "kdtree" }) end)
    assert.same({ hash, cells }, { s:hash(), #s:tree_cells { tracer = "kdtree" } })
    assert.equal(65536, s:explain(12, 8, { sample = 0, shadow_samples = 1 }).samples)
  end)
end)

describe("trees", function()
  it("give their cells", function()
    local s = scene()
    for _, tracer in ipairs { "kdtree", "octree" } do
      local cells, volume, leaves = s:tree_cells { tracer = tracer }, 0, 0
      for _, c in ipairs(cells) do
        volume = volume + (c.high[1] - c.low[1]) * (c.high[2] - c.low[2]) * (c.high[3] - c.low[3])
        assert.equal(1, c.leaves)
        assert.is_nil(c.corners)
      end
      local box = s:tree_shape { tracer = tracer }
      local whole = (box.high[1] - box.low[1]) * (box.high[2] - box.low[2]) * (box.high[3] - box.low[3])
      assert.is_true(math.abs(volume / whole - 1) < 1e-5)
      for _, bar in ipairs(s:tree_leaves({ tracer = tracer }).depths) do
        leaves = leaves + bar.leaves
      end
      assert.equal(#cells, leaves)
      assert.equal(1, #s:tree_cells { tracer = tracer, max_depth = 0 })
      assert.is_true(#s:tree_cells { tracer = tracer, min_size = 0.6 } < #cells)
      local cut = s:tree_cells { tracer = tracer, cut = { point = { 0, 0, 0.5 }, normal = { 0, 0, 1 } } }
      assert.is_true(#cut > 1 and #cut < #cells)
      assert.equal(4, #cut[1].corners)
    end
    assert.is_nil(s:tree_shape { group = "top" })
    assert.same({}, s:tree_cells { group = "top" })
  end)

  it("are cut", function()
    local s = scene()
    local lines, ids = s:cut { cut = { point = { 0.5, 0.5, 0.5 }, normal = { 0, 0, 1 } } }
    assert.is_true(#lines > 0)
    assert.equal(#lines // 2, #ids)
    assert.equal(0xffffffff, ids[3])
    assert.is_true(math.abs(lines[3] - 0.5) < 1e-5)
  end)

  it("cost", function()
    local s = scene()
    local rays = rt.buffer("f32", { 0.5, 0.5, 4, 0, 0, 0, -1, 100, 9, 9, 9, 0, 0, 0, 1, 100 })
    local seen, blind = s:ray_costs(rays, { tracer = "octree" }), s:ray_costs(rays, { tracer = "octree", group = 0, blind = true })
    assert.is_true(seen.nodes[1] > 0 and seen.tests[1] <= blind.tests[1])
    assert.equal(0, blind.tests[2] + blind.leaves[2])
    assert.equal(80, s:ray_costs(rays, { tracer = "brute" }).tests[1])
  end)

  it("refuse what makes no sense", function()
    local s = scene()
    local function refused(words, f, ...)
      local ok, message = pcall(f, s, ...)
      assert.is_false(ok)
      assert.truthy(message:find(words, 1, true), message)
      assert.truthy(message:find "look_spec.lua:%d+:", message)
    end
    refused("group is 3; the scene has group 0 alone", s.tree_cells, { group = 3 })
    refused("walks no tree", s.tree_cells, { tracer = "brute" })
    refused("tracers", s.tree_cells, { tracers = "x" })
    refused("there is no tracer", s.tree_cells, { tracer = "x" })
    refused("scene:cut needs cut", s.cut, {})
    refused("point is missing", s.cut, { cut = { normal = { 0, 1, 0 } } })
    refused("rays must be a buffer", s.ray_costs, {})
    refused("blind", s.ray_costs, rt.buffer("f32", 8), { blind = 1 })
  end)
end)

describe("explain", function()
  it("names hits, lights and materials, and adds up", function()
    local s = scene()
    local image = s:render()
    local named = 0
    for y = 0, 15, 3 do
      for x = 0, 23, 2 do
        local told = s:explain(x, y)
        assert.equal(2, #told.roots)
        local sum = { 0, 0, 0 }
        for i, ray in ipairs(told.rays) do
          assert.equal(i, ray.index)
          for c = 1, 3 do
            sum[c] = sum[c] + ray.brought[c]
          end
          if ray.kind == "camera" and ray.hit then
            named = named + 1
            assert.equal(ray.hit.name:gsub("ball", "paint"), ray.hit.material_name)
            assert.equal(s.objects[ray.hit.geom_id], ray.hit.object)
            for _, child in ipairs(ray.children or {}) do
              assert.equal(ray.index, child.parent)
              assert.equal("lamp", child.light)
            end
          end
        end
        assert.same(told.sum, sum)
        local r, g, b = image:pixel(x, y)
        assert.same({ r, g, b }, { told.value[1], told.value[2], told.value[3] })
      end
    end
    assert.is_true(named > 5)
  end)

  it("names the bodies of lights and what stands in instances", function()
    local child = rt.scene { rt.box { low = { -1, -1, -1 }, high = { 1, 1, 1 }, name = "crate", material = rt.classic { name = "wood" } } }
    local s = rt.scene {
      settings = { width = 3, height = 3, samples = 1 }, camera = rt.camera { eye = { 0, 0, 9 }, look_at = { 0, 0, 0 }, fov = 1 },
      rt.instance { child, name = "box" }, rt.point_light { at = { 9, 9, 9 } },
      rt.sphere_light { at = { 0, 5, 0 }, radius = 1, visible = true, name = "sun" },
    }
    local hit = s:explain(1, 1).roots[1].hit
    assert.equal("crate", hit.name)
    assert.equal("box", hit.instance_name)
    assert.equal("wood", hit.material_name)
    s:set_camera(rt.camera { eye = { 0, 5, 9 }, look_at = { 0, 5, 0 }, fov = 1 })
    assert.equal("body of sun", s:explain(1, 1).roots[1].hit.name)
  end)

  it("refuses pixels that are not there", function()
    local s = scene()
    for _, bad in ipairs { { 24, 0 }, { 0, 16 }, { -1, 0 }, { 0.5, 0 }, { "a", 0 } } do
      assert.is_false((pcall(s.explain, s, bad[1], bad[2])))
    end
    assert.is_false((pcall(s.explain, s, 0, 0, { sample = 2 })))
    assert.is_false((pcall(s.explain, s, 0, 0, { smaple = 1 })))
    local told = s:explain(12, 8, { sample = 1, integrator = "path", samples = 8 })
    assert.equal(1, #told.roots)
    assert.equal(8, told.samples)
  end)
end)
