-- Positional items: lists to any depth, holes, false, and what is no item.

local support = require "support"
local rt, raises = support.rt, support.raises

local function ball(x)
  return rt.sphere { center = { x, 0, 0 }, radius = 0.4, name = "ball " .. x }
end

local function shapes(scene)
  return scene:info().shapes
end

-- Names of what a ray from far -x passes through, in the scene's order of adding.
local function order(scene)
  local names = {}
  for id = 0, scene:info().geometries - 1 do
    names[#names + 1] = scene.objects[id].name
  end
  return table.concat(names, ", ")
end

describe("items", function()
  it("may be lists to any depth, and false", function()
    local scene = rt.scene { ball(1), { ball(2), { { ball(3) }, false }, {} }, false, ball(4) }
    assert.equal("ball 1, ball 2, ball 3, ball 4", order(scene))
  end)

  it("are walked in ascending order, past holes", function()
    local list = { [7] = ball(7), [-3] = ball(-3), [1] = ball(1), [100] = ball(100), [2] = nil }
    assert.equal("ball -3, ball 1, ball 7, ball 100", order(rt.scene { list }))
    assert.equal("ball 1, ball 2", order(rt.scene { nil, ball(1), nil, ball(2) }))
    assert.equal("ball 0, ball 1", order(rt.scene { { [0] = ball(0), ball(1) } }))
  end)

  it("may be nested deeper than a stack", function()
    local list = { ball(1) }
    for _ = 1, support.many(200000) do
      list = { list }
    end
    assert.equal(1, shapes(rt.scene(list)))
    local group = rt.group { ball(1) }
    for _ = 1, support.many(100000) do
      group = rt.group { group }
    end
    assert.equal(1, shapes(rt.scene { group }))
  end)

  it("may be the same object twice", function()
    local b = ball(1)
    assert.equal(2, shapes(rt.scene { b, b }))
  end)

  it("can be added later", function()
    local scene = rt.scene { ball(1) }
    assert.equal(1, shapes(scene))
    scene:add(ball(2), { ball(3), false })
    assert.equal(3, shapes(scene))
  end)

  it("are groups, too", function()
    assert.equal("ball 1, ball 2, ball 3", order(rt.scene { rt.group { ball(1), { ball(2) } }, ball(3) }))
  end)

  it("are told apart by position and type", function()
    raises("rt.scene: item 2 is 'x'; an item is an object, a list of items or false", function()
      return rt.scene { ball(1), "x" }, nil
    end)
    raises("rt.scene: item 1.2.1 is 5; an item is an object, a list of items or false", function()
      return rt.scene { { ball(1), { 5 } } }, nil
    end)
    raises("rt.scene: item 1 is true; an item is an object, a list of items or false", function()
      return rt.scene { true }, nil
    end)
    raises("rt.scene: item 1 is a rt.vec; an item is an object, a list of items or false", function()
      return rt.scene { rt.vec(1, 2, 3) }, nil
    end)
    raises("rt.scene: item 1 is a rt.camera; an item is an object, a list of items or false; it has a key of its own", function()
      return rt.scene { rt.camera { eye = { 0, 0, 1 }, look_at = { 0, 0, 0 } } }, nil
    end)
    raises("rt.scene: item 1 is a rt.scene; an item is an object, a list of items or false; rt.instance { scene } places a scene", function()
      return rt.scene { rt.scene {} }, nil
    end)
    raises("rt.scene: item 1 has a key 'sphere'; a list of items has numbers only", function()
      return rt.scene { { sphere = ball(1) } }, nil
    end)
    raises("scene:add: argument 2 is nil; an item is an object, a list of items or false", function()
      return rt.scene {}:add(ball(1), nil), nil
    end)
  end)

  it("are named when the library refuses them", function()
    local message = support.message(rt.scene, { ball(1), { rt.mesh { file = "/nowhere/x.ply", name = "statue" } } })
    assert.is_truthy(message:find "^tests/lua/items_spec.lua:%d+: item 2.1 %(rt.mesh 'statue'%): .*/nowhere/x.ply", message)
    message = support.message(rt.scene, { rt.mesh { vertices = rt.buffer("f32", 9), faces = rt.buffer("u32", { 0, 1, 3 }) } })
    assert.is_truthy(message:find "item 1 %(rt.mesh%): .*3", message)
  end)

  it("may not contain themselves", function()
    local list = {}
    list[1] = { list }
    raises("rt.scene: item 1.1.1 is a list that contains itself", function()
      return rt.scene { list }, nil
    end)
  end)
end)

describe("an instance", function()
  it("is held once for many places", function()
    local group = rt.group { ball(0), rt.box { low = { 0, 0, 0 }, high = { 1, 1, 1 } } }
    local list = {}
    for i = 1, 10 do
      list[i] = rt.instance { group, transform = rt.translate(2 * i, 0, 0), name = "copy " .. i }
    end
    local scene = rt.scene { list }
    assert.equal(10, scene:info().instances)
    local hit = scene:intersect { org = { 6, 0, 5 }, dir = { 0, 0, -1 } }
    assert.equal("copy 3", hit.name)
    assert.equal(2, hit.inst_id)
    assert.is_true(math.abs(hit.t - 4.6) < 1e-4)
  end)

  it("places scenes, and sees what is added to them later", function()
    local child = rt.scene { ball(0) }
    local scene = rt.scene { rt.instance { child, transform = rt.translate(0, 5, 0) } }
    local ray = { org = { 3, 5, 5 }, dir = { 0, 0, -1 } }
    assert.is_nil(scene:intersect(ray))
    child:add(ball(3))
    assert.is_truthy(scene:intersect(ray))
  end)

  it("places shapes only", function()
    raises("rt.instance: item 1 is a rt.point_light; an instance places one scene, or shapes and groups of them", function()
      return rt.scene { rt.instance { rt.point_light { at = { 0, 0, 0 } } } }, nil
    end)
    raises("rt.instance: item 1 is a rt.instance; an instance places one scene, or shapes and groups of them", function()
      return rt.scene { rt.instance { rt.instance { ball(1) } } }, nil
    end)
  end)
end)
