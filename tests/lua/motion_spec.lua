-- Moving instances, and scenes made of two.

local support = require "support"
local rt = support.rt
local raises = support.raises

local function ball(t)
  return rt.sphere { center = t.center or { 0, 0, 0 }, radius = t.radius or 1, name = t.name, material = t.material }
end

-- The middle of what a ray from the side meets at a time, along x: two hits of a row.
local function span(scene, time, y, z)
  local hits = scene:intersect_all { org = { -100, y or 0, z or 0 }, dir = { 1, 0, 0 }, time = time }
  return hits[1] and hits[1].t - 100, hits[2] and hits[2].t - 100
end

local function close_to(want, got)
  assert.is_true(got ~= nil and math.abs(want - got) < 1e-3, ("%s, not %s"):format(tostring(got), tostring(want)))
end

describe("rt.instance with motion", function()
  it("stands where its places say", function()
    local scene = rt.scene {
      rt.instance { ball {}, transform = rt.translate(0, 0, 0), motion = { rt.translate(4, 0, 0), rt.translate(4, 6, 0) }, name = "b" },
    }
    close_to(-1, span(scene, 0))
    close_to(1, span(scene, 0.25))
    close_to(3, span(scene, 0.5))
    assert.is_nil(span(scene, 1))
    local hit = scene:intersect { org = { 4, 6, 9 }, dir = { 0, 0, -1 }, time = 1 }
    assert.equal("b", hit.name)
    close_to(1, hit.position[3])
    close_to(6, hit.position[2])
    assert.is_nil(scene:intersect { org = { 4, 6, 9 }, dir = { 0, 0, -1 } })
    local info = scene:info()
    assert.same({ 1, 3, false }, { info.moving_instances, info.motion_places, info.camera_moves })
  end)

  it("answers many rays, each at its time", function()
    local scene = rt.scene { rt.instance { ball {}, motion = rt.translate(8, 0, 0) } }
    local rays, times = rt.buffer("f32", 8 * 3), rt.buffer("f32", { 0, 0.5, 1 })
    for i = 0, 2 do
      rays:set(8 * i + 1, 4 * i, 0, 9, 0, 0, 0, -1, math.huge)
    end
    local hits = scene:intersect(rays, times)
    for i = 1, 3 do
      close_to(8, hits.t[i])
    end
    assert.equal(0xffffffff, scene:intersect(rays).prim_id[2])
    assert.equal(1, scene:occluded(rays, times)[3])
    raises("times must be a buffer of type f32 with 3 numbers, one a ray; got 7", function() return scene:intersect(rays, 7), nil end)
  end)

  it("says what is wrong", function()
    raises("rt.instance: motion must be a transform or a list of transforms; got 7", function() return rt.instance { ball {}, motion = 7 }, nil end)
    raises("rt.instance: motion must have 1 to 1024 transforms; it has 0", function() return rt.instance { ball {}, motion = {} }, nil end)
    local message = support.message(function() return rt.scene { rt.instance { ball {}, motion = rt.scale(-1, 1, 1) } }, nil end)
    assert.is_truthy(message:find("the places of motion mirror space at one place and not at the next", 1, true))
    raises("scene:intersect: time must be from 0 to 1; got 2", function()
      return rt.scene { ball {} }:intersect { org = { 0, 0, 9 }, dir = { 0, 0, -1 }, time = 2 }, nil
    end)
  end)
end)

describe("rt.motion", function()
  it("moves what has a name or is the same description", function()
    local still, lamp = ball { center = { 0, 50, 0 } }, rt.point_light { at = { 0, 9, 0 } }
    local function at(t)
      return rt.scene {
        still, lamp, ball { center = { 4 * t, 0, 0 }, radius = 1 + t, name = "ball" }, ball { center = { 0, 20 + t, 0 } },
        camera = rt.camera { eye = { t, 0, 9 }, look_at = { t, 0, 0 } }, settings = { samples = 2 },
      }
    end
    local scene = rt.motion(at(0), at(1))
    close_to(2 - 1.5, (span(scene, 0.5)))
    close_to(4 + 2, select(2, span(scene, 1)))
    close_to(-1, (span(scene, 0.7, 50))) -- stands still
    close_to(-1, (span(scene, 1, 20))) -- has no partner
    local info = scene:info()
    assert.same({ 1, 2, true, 1, 2 }, { info.moving_instances, info.motion_places, info.camera_moves, info.lights, scene.settings.samples })
    assert.equal("ball", scene:intersect({ org = { 0, 0, 9 }, dir = { 0, 0, -1 } }).name)
    assert.equal(0, rt.motion(at(0), at(0)):info().moving_instances)
    local one = at(0)
    assert.equal(one, rt.motion(one, one))
  end)

  -- Each shape is at time 1 what it is described to be there.
  it("takes every shape from its first place to its last", function()
    local cases = {
      { rt.box, { low = { 0, 0, 0 }, high = { 1, 1, 1 } }, { low = { 2, 1, 0 }, high = { 5, 2, 4 } } },
      { rt.cylinder, { from = { 0, 0, 0 }, to = { 0, 2, 0 }, radius = 0.5 }, { from = { 1, 1, 0 }, to = { 4, 1, 0 }, radius = 1 } },
      { rt.cone, { from = { 0, 0, 0 }, to = { 0, 2, 0 }, radius = 1, to_radius = 0.5 },
        { from = { 0, 3, 0 }, to = { 0, 0, 0 }, radius = 2, to_radius = 1 } },
      { rt.torus, { center = { 0, 0, 0 }, axis = { 0, 1, 0 }, major_radius = 1, minor_radius = 0.25 },
        { center = { 1, 2, 3 }, axis = { 1, 0, 1 }, major_radius = 2, minor_radius = 0.5 } },
      { rt.plane, { point = { 0, 0, 0 }, normal = { 0, 1, 0 } }, { point = { 0, 2, 0 }, normal = { 1, 1, 0 } } },
    }
    for _, case in ipairs(cases) do
      local function at(i)
        local t = { name = "it" }
        for key, value in pairs(case[i]) do
          t[key] = value
        end
        return rt.scene { case[1](t) }
      end
      local moving = rt.motion(at(2), at(3))
      assert.equal(1, moving:info().moving_instances)
      for time, other in pairs { [0] = at(2), [1] = at(3) } do
        local seen = 0
        for i = 1, 200 do
          local to = { 4 * rt.random("x", i), 3 * rt.random("y", i), 4 * rt.random("z", i) - 1 }
          local from = { 20 * rt.random("a", i) - 10, 9, 20 * rt.random("b", i) - 10 }
          local ray = { org = from, dir = { to[1] - from[1], to[2] - from[2], to[3] - from[3] } }
          local want = other:intersect(ray)
          ray.time = time
          local got = moving:intersect(ray)
          if want and got then
            seen = seen + (math.abs(want.t - got.t) < 1e-3 and 1 or 0)
          elseif want or got then
            seen = seen - 1
          end
        end
        assert.is_true(seen > 5)
      end
    end
  end)

  it("moves instances of equal things", function()
    local function at(t, size)
      local box = rt.box { low = { -1, -1, -1 }, high = { size or 1, 1, 1 } }
      return rt.scene { rt.instance { box, transform = rt.translate(6 * t, 0, 0), name = "door" } }
    end
    close_to(2, (span(rt.motion(at(0), at(1)), 0.5)))
    raises("'door': it places other things when the shutter closes than when it opens; what moves stays the same", function()
      return rt.motion(at(0), at(1, 2)), nil
    end)
  end)

  it("says what cannot be", function()
    local function two(a, b)
      return rt.motion(rt.scene { a }, rt.scene { b }), nil
    end
    raises("rt.motion: the second argument must be a scene; got 7", function() return rt.motion(rt.scene {}, 7), nil end)
    raises("'x': it is rt.sphere when the shutter opens and rt.box when it closes; what moves stays the same", function()
      return two(ball { name = "x" }, rt.box { low = { 0, 0, 0 }, high = { 1, 1, 1 }, name = "x" })
    end)
    raises("the name 'x' stands for 1 objects when the shutter opens and for 2 when it closes; what is to move needs a name of its own", function()
      return two(ball { name = "x" }, { ball { name = "x", radius = 2 }, ball { name = "x", radius = 3 } })
    end)
    local function mesh(n, x)
      local faces = { { 1, 2, 3 }, { 1, 3, 4 } }
      local corners = { { 0, 0, x }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } }
      return rt.mesh { vertices = corners, faces = { faces[1], n > 1 and faces[2] or nil }, name = "m" }
    end
    raises("'m': it has 2 faces when the shutter opens and 1 when it closes; what moves keeps its faces", function()
      return two(mesh(2, 0), mesh(1, 0))
    end)
    raises("'m': its vertices or faces differ between the shutter's open and close; a body of many numbers is not blurred, "
      .. "one that moves is an rt.instance", function() return two(mesh(2, 0), mesh(2, 1)) end)
    assert.equal(0, two(mesh(2, 0), mesh(2, 0)):info().moving_instances)
    local function rods(x, more)
      more = more or {}
      more.from, more.to, more.radius, more.name = { 0, 0, x }, { 0, 1, 0 }, 1, "r"
      return rt.cylinders(more)
    end
    raises("'r': its cylinders differ between the shutter's open and close; a body of many numbers is not blurred, one that moves is an rt.instance",
      function() return two(rods(0), rods(1)) end)
    raises("'r': its colors differs between the shutter's open and close; a body may move there, not change", function()
      return two(rods(0, { colors = { 1, 0, 0 } }), rods(1, { colors = { 1, 1, 0 } }))
    end)
    local red, blue = rt.classic { color = { 1, 0, 0 } }, rt.classic { color = { 0, 0, 1 } }
    assert.equal(0, two(rods(0, { materials = { red } }), rods(0, { materials = { blue } })):info().moving_instances)
    assert.equal(0, two(rods(0), rods(0, { material = red })):info().moving_instances)
    assert.equal(1, two(rt.instance { rods(0), name = "i" }, rt.instance { rods(0), transform = rt.translate(1, 0, 0), name = "i" }):info()
      .moving_instances)
  end)

  it("serves an animation with a shutter", function()
    local film = rt.animation {
      frames = 3, shutter = 0.5, scene = function(t) return rt.scene { ball { center = { 8 * t, 0, 0 }, name = "b" } } end,
    }
    close_to(4 + 2 - 1, (span(film:scene_at(1), 1)))
    close_to(4 - 1, (span(film:scene_at(1), 0)))
  end)
end)
