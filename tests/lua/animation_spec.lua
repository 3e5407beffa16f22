-- Animations, keys, easings, rotations, paths.

local support = require "support"
local rt, raises = support.rt, support.raises

local function near(a, b, eps)
  if type(a) == "number" then
    return math.abs(a - b) <= (eps or 1e-9)
  end
  for i = 1, #b do
    if math.abs(a[i] - b[i]) > (eps or 1e-9) then
      return false
    end
  end
  return true
end

local function ball(t)
  return rt.scene { rt.sphere { center = { t, 0, 0 }, radius = 1 }, rt.point_light { at = { 3, 3, 3 } } }
end

describe("rt.animation", function()
  it("counts time from 0 to 1, or as a loop to the frame after the last", function()
    local a = rt.animation { frames = 5, fps = 10, scene = ball }
    assert.same({ 0.0, 0.0 }, { a:time(0) })
    assert.same({ 1.0, 0.4 }, { a:time(4) })
    local b = rt.animation { frames = 5, loop = true, scene = ball }
    assert.same({ 0.8, 4 / 24 }, { b:time(4) })
    assert.same({ 0.0, 0.0 }, { rt.animation { frames = 1, scene = ball }:time(0) })
    assert.equal("rt.animation (5 frames, 10 a second)", tostring(a))
  end)

  it("calls the function with t, frame and seconds, each time anew", function()
    local calls = {}
    local a = rt.animation { frames = 3, fps = 2, scene = function(...)
      calls[#calls + 1] = { ... }
      return ball((...))
    end }
    local first, last = a:scene_at(0), a:scene_at(2)
    assert.same({ { 0.0, 0, 0.0 }, { 1.0, 2, 1.0 } }, calls)
    assert.not_equal(first:hash(), last:hash())
    assert.equal(first:hash(), a:scene_at(0):hash())
    assert.equal(first:hash(), ball(0):hash())
  end)

  it("takes a list of objects for a scene", function()
    local a = rt.animation { frames = 1, scene = function() return { rt.sphere { center = { 0, 0, 0 }, radius = 1 } } end }
    assert.equal(1, a:scene_at(0):info().geometries)
  end)

  it("reports a mistake with the frame, and the line even of a tail call", function()
    local a = rt.animation { frames = 9, scene = function(t, frame)
      local radius = frame == 7 and -1 or 1
      return rt.scene { rt.sphere { center = { t, 0, 0 }, radius = radius } }
    end }
    a:scene_at(6)
    local message = support.message(a.scene_at, a, 7)
    assert.truthy(message:find "animation_spec%.lua:%d+: rt%.sphere: radius must be greater than 0; got %-1 %(frame 7, t = 0%.875%)$", message)
    a = rt.animation { frames = 2, scene = function(_, frame)
      return frame == 0 and ball(0) or rt.scene { camera = 1 }
    end }
    message = support.message(a.scene_at, a, 1)
    assert.truthy(message:find "animation_spec%.lua:%d+: rt%.scene: camera must be .* %(frame 1, t = 1%)$", message)
    a = rt.animation { frames = 2, scene = function() return nil + 1 end }
    assert.truthy(support.message(a.scene_at, a, 1):find "animation_spec%.lua:%d+: attempt to perform arithmetic .* %(frame 1, t = 1%)$")
    a = rt.animation { frames = 2, scene = function() end }
    assert.truthy(support.message(a.scene_at, a, 1):find "the scene function returned nothing; it must return a scene.* %(frame 1, t = 1%)$")
    a = rt.animation { frames = 2, scene = function() return rt.vec(1, 2, 3) end }
    assert.truthy(support.message(a.scene_at, a, 0):find "the scene function returned a rt%.vec; it must return a scene")
  end)

  it("checks what it is given", function()
    raises("rt.animation: frames is missing", function() rt.animation { scene = ball } end)
    raises("rt.animation: scene is missing", function() rt.animation { frames = 3 } end)
    raises("rt.animation: frames must be a whole number from 1 to 1000000; got 0",
      function() rt.animation { frames = 0, scene = ball } end)
    raises("rt.animation has no key 'fsp'; did you mean fps?", function() rt.animation { frames = 1, fsp = 3, scene = ball } end)
    raises("rt.animation: shutter must be greater than 0 and at most 1; got 2",
      function() rt.animation { frames = 1, shutter = 2, scene = ball } end)
    local a = rt.animation { frames = 3, scene = ball }
    raises("animation:scene_at: the frame must be a whole number from 0 to 2; got 3", function() a:scene_at(3) end)
    raises("animation:scene_at: the frame must be a whole number from 0 to 2; got -1", function() a:scene_at(-1) end)
  end)

  it("finds files and parameters of its script when a frame is described later", function()
    support.in_folder(function(folder)
      support.write(folder .. "/dot.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
      support.write(folder .. "/part.lua", "return 2.5")
      local script = support.write(folder .. "/a.lua", [[
local rt = require "rt"
local p = rt.params { big = 1 }
return rt.animation { frames = 2, scene = function(t)
  return rt.scene { settings = { samples = 3 }, rt.mesh { file = "dot.obj", transform = rt.scale(p.big + t + require "part") } }
end }]])
      local a, r = rt.load(script, { big = 2 }, { settings = { samples = 7 } })
      assert.equal("rt.animation", getmetatable(a).__name)
      local scene = a:scene_at(1)
      local _, high = scene:bounds()
      assert.is_true(near(high, { 5.5, 5.5, 0 }, 1e-5))
      assert.equal(7, scene:effective().samples)
      assert.truthy(table.concat(r.files, " "):find("dot.obj", 1, true))
      assert.is_nil(package.loaded.part)
    end)
  end)
end)

describe("rt.keys", function()
  it("interpolates numbers, vectors, colours, lists and rotations", function()
    local k = rt.keys { { 0, 1 }, { 0.5, 2 }, { 1, -2 } }
    assert.same({ 1, 1.5, 2, 0, -2 }, { k(0), k(0.25), k(0.5), k(0.75), k(1) })
    assert.same({ 1, -2 }, { k(-3), k(4) })
    assert.equal(rt.vec(0.5, 1, 1.5), rt.keys { { 0, { 0, 0, 0 } }, { 2, { 1, 2, 3 } } }(1))
    assert.equal(rt.vec(0.5, 0, 0), rt.keys { { 0, rt.srgb "#000000" }, { 1, rt.srgb "#ff0000" } }:at(0.5))
    assert.same({ 1, 2 }, rt.keys { { 0, { 0, 0 } }, { 1, { 2, 4 } } }(0.5))
    local turn = rt.keys { { 0, rt.quat() }, { 1, rt.quat({ 0, 1, 0 }, 90) } }
    assert.is_true(near(turn(1 / 3) * { 0, 0, 1 }, rt.rotate({ 0, 1, 0 }, 30) * { 0, 0, 1 }, 1e-6))
  end)

  it("holds what has no between, and jumps at equal times", function()
    local k = rt.keys { { 0, "day" }, { 1, "night" } }
    assert.same({ "day", "day", "night" }, { k(0), k(0.99), k(1) })
    k = rt.keys { { 0, 0 }, { 1, 1 }, { 1, 5 }, { 2, 6 } }
    assert.same({ 0.5, 5, 5.5 }, { k(0.5), k(1), k(1.5) })
    assert.is_true(k(1 - 1e-9) < 1)
  end)

  it("eases into a key, all keys, by curves and functions", function()
    local k = rt.keys { { 0, 0 }, { 1, 1, ease = "smooth" }, { 2, 2 } }
    assert.same({ 0.15625, 1.5 }, { k(0.25), k(1.5) })
    k = rt.keys { { 0, 0 }, { 1, 1 }, { 2, 2, ease = "linear" }, ease = "in" }
    assert.same({ 0.125, 1.5 }, { k(0.5), k(1.5) })
    k = rt.keys { { 0, 0 }, { 1, 10, ease = function(x) return x * x end } }
    assert.equal(2.5, k(0.5))
    k = rt.keys { { 0, 0 }, { 1, 1, ease = { 0.42, 0, 0.58, 1 } } }
    assert.is_true(near(k(0.25), 0.129161931, 1e-8)) -- as browsers compute ease-in-out
  end)

  it("runs again, also backwards", function()
    local k = rt.keys { { 1, 0 }, { 2, 1 }, loop = "repeat" }
    assert.same({ 0.25, 0.25, 0.25 }, { k(1.25), k(3.25), k(-0.75) })
    k = rt.keys { { 0, 0 }, { 1, 1 }, loop = "mirror" }
    assert.same({ 0.25, 0.75, 0.25, 0.25 }, { k(0.25), k(1.25), k(2.25), k(-0.25) })
    assert.same({ 0, 1 }, { k:span() })
  end)

  it("names the key that is wrong", function()
    raises("rt.keys: there is no key; it takes at least one, as {0, value}", function() rt.keys {} end)
    raises("rt.keys: key 2 is at 0.5, before key 1 at 1; keys stand in the order of their times",
      function() rt.keys { { 1, 0 }, { 0.5, 1 } } end)
    raises("rt.keys: key 1 is a number and key 2 a vector; all keys are of one kind", function() rt.keys { { 0, 1 }, { 1, { 1, 2, 3 } } } end)
    raises("rt.keys: key 2 has a third value, 3; a vector stands in braces: {time, {x, y, z}}",
      function() rt.keys { { 0, 1 }, { 1, 2, 3 } } end)
    raises("rt.keys: key 2: ease must be one of linear, smooth, smoother, in, out, in_out, step, overshoot, bounce, {x1, y1, x2, y2} or a function; "
      .. "got 'smoth' (did you mean smooth?)", function() rt.keys { { 0, 1 }, { 1, 2, ease = "smoth" } } end)
    raises("rt.keys: key 1 has an ease, which says how the value comes to a key from the one before; the first has none before it",
      function() rt.keys { { 0, 1, ease = "in" } } end)
    raises("rt.keys: key 2: ease[1] must be from 0 to 1, for time does not run backwards; got 2",
      function() rt.keys { { 0, 1 }, { 1, 2, ease = { 2, 0, 1, 1 } } } end)
    raises("rt.keys: key 2 is missing", function() rt.keys { { 0, 1 }, [3] = { 1, 2 } } end)
    raises("keys: the time is not a number (NaN); look for 0/0 or a root of a negative number", function() rt.keys { { 0, 1 } }(0 / 0) end)
    raises("rt.keys: loop = 'mirror' needs keys at two times at least", function() rt.keys { { 0, 1 }, loop = "mirror" } end)
  end)
end)

describe("rt.ease", function()
  it("begins at 0 and ends at 1", function()
    for _, name in ipairs { "linear", "smooth", "smoother", "in", "out", "in_out", "step", "overshoot", "bounce" } do
      assert.is_true(near(rt.ease(name, 0), 0, 1e-12) and near(rt.ease(name, 1), 1, 1e-12), name)
      assert.equal(rt.ease(name)(0.3), rt.ease(name, 0.3))
    end
    assert.same({ 0.0, 1.0 }, { rt.ease("smooth", -3), rt.ease("smooth", 4) })
    assert.is_true(rt.ease("overshoot", 0.7) > 1)
    assert.equal(0.5, rt.ease("in_out", 0.5))
  end)
end)

describe("rt.quat", function()
  it("turns as rt.rotate does", function()
    for i = 1, 40 do
      local axis = { rt.random("x", i) - 0.5, rt.random("y", i) - 0.5, rt.random("z", i) - 0.5 }
      local angle = 720 * rt.random("a", i) - 360
      local p = { 1, 2, 3 }
      local q, m = rt.quat(axis, angle), rt.rotate(axis, angle)
      assert.is_true(near(q * p, m * p, 1e-5))
      assert.is_true(near(q:transform() * p, m * p, 1e-5))
      assert.is_true(near(rt.rotate(q) * p, m * p, 1e-5))
      assert.is_true(near(q:inverse() * (q * p), p, 1e-9))
      assert.is_true(near(q * q * p, rt.rotate(axis, 2 * angle) * p, 1e-5))
    end
    assert.equal(rt.vec(1, 2, 3), rt.quat() * { 1, 2, 3 })
  end)

  it("takes one direction to another, also the opposite one", function()
    assert.is_true(near(rt.quat({ 0, 0, 2 }, { 3, 0, 0 }) * { 0, 0, 1 }, { 1, 0, 0 }))
    for _, d in ipairs { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } } do
      local q = rt.quat(d, { -d[1], -d[2], -d[3] })
      assert.is_true(near(q * d, { -d[1], -d[2], -d[3] }))
    end
  end)

  it("goes the shortest way at an even pace", function()
    local a, b = rt.quat({ 0, 0, 1 }, 10), rt.quat({ 0, 0, 1 }, 170)
    for i = 0, 16 do
      assert.is_true(near(a:slerp(b, i / 16) * { 1, 0, 0 }, rt.rotate({ 0, 0, 1 }, 10 + 10 * i) * { 1, 0, 0 }, 1e-6))
    end
    local c = rt.quat({ 0, 0, 1 }, 350) -- 20 degrees back, not 340 on
    assert.is_true(near(a:slerp(c, 0.5) * { 1, 0, 0 }, { 1, 0, 0 }, 1e-6))
  end)

  it("checks what it is given", function()
    raises("rt.quat: a quaternion of zeros is no rotation", function() rt.quat { 0, 0, 0, 0 } end)
    raises("rt.quat: the axis is zero and so has no direction", function() rt.quat({ 0, 0, 0 }, 3) end)
    raises("quat:slerp: the argument must be an rt.quat; got 3", function() rt.quat():slerp(3, 0.5) end)
  end)
end)

describe("rt.path", function()
  local square = { { 0, 0, 0 }, { 4, 0, 0 }, { 4, 4, 0 }, { 0, 4, 0 } }

  it("goes through its points, from 0 to 1", function()
    local p = rt.path { { 0, 0, 0 }, { 1, 2, 0 }, { 5, 2, 1 }, even = false }
    assert.is_true(near(p(0), { 0, 0, 0 }) and near(p(0.5), { 1, 2, 0 }) and near(p(1), { 5, 2, 1 }))
    assert.equal(p(1), p(3))
    square.closed = true
    local q = rt.path(square)
    for i = 0, 4 do
      assert.is_true(near(q(i / 4), square[i % 4 + 1], 1e-6))
      assert.is_true(near(q(i / 4 + 0.1), q(i / 4 + 1.1)))
    end
  end)

  it("is straight through points on a line, and even in length", function()
    local p = rt.path { { 0, 0, 0 }, { 1, 0, 0 }, { 10, 0, 0 } }
    assert.is_true(near(p:length(), 10, 1e-6))
    local last
    for i = 0, 50 do
      local at = p(i / 50)
      assert.is_true(near({ at[2], at[3] }, { 0, 0 }))
      assert.is_true(near(at[1], i / 5, 5e-3), at[1] .. " at " .. i)
      assert.is_true(last == nil or at[1] > last)
      last = at[1]
    end
    assert.is_true(near(p:direction(0.3), { 1, 0, 0 }))
  end)

  it("moves by small steps: no corner, no jump", function()
    local p = rt.path { { 0, 0, 0 }, { 0.1, 0, 0 }, { 0, 3, 0 }, { 5, 3, 2 }, { 5, 3, 2.1 } }
    local pace = p:length() / 400
    for i = 1, 400 do
      local step = (p(i / 400) - p((i - 1) / 400)):length()
      assert.is_true(step > 0.9 * pace and step < 1.1 * pace, i .. ": " .. step / pace)
    end
  end)

  it("gives cameras that look ahead, at a point or along another way", function()
    local p = rt.path { { 0, 0, 0 }, { 10, 0, 0 } }
    assert.is_true(near(p:camera(0.5).eye, { 5, 0, 0 }) and near(p:camera(0.5).look_at, { 6, 0, 0 }))
    assert.same({ 0, 0, -3 }, p:camera(0.5, { look_at = { 0, 0, -3 }, fov = 30 }).look_at)
    assert.equal(30, p:camera(0.5, { fov = 30 }).fov)
    local target = rt.keys { { 0, { 0, 0, -1 } }, { 1, { 0, 0, -3 } } }
    assert.is_true(near(p:camera(0.5, { look_at = target }).look_at, { 0, 0, -2 }))
    raises("path:camera: eye is the place on the way; leave it out", function() p:camera(0, { eye = { 0, 0, 0 } }) end)
  end)

  it("checks what it is given", function()
    raises("rt.path: a path has at least 2 points; got 1", function() rt.path { { 0, 0, 0 } } end)
    raises("rt.path: a closed path has at least 3 points; got 2", function() rt.path { { 0, 0, 0 }, { 1, 0, 0 }, closed = true } end)
    raises("rt.path: points 1 and 2 are the same; leave one out", function() rt.path { { 0, 0, 0 }, { 0, 0, 0 } } end)
    raises("rt.path: point 2 must be {x, y, z}; number 3 is missing", function() rt.path { { 0, 0, 0 }, { 1, 0 } } end)
  end)
end)

describe("rt.orbit and rt.look_at", function()
  it("circles the centre and comes back exactly", function()
    local o = rt.orbit { center = { 1, 0, 0 }, radius = 2, height = 3 }
    assert.is_true(near(o(0), { 1, 3, 2 }) and near(o(0.25), { 3, 3, 0 }))
    assert.equal(o(0), o(1))
    assert.is_true(near(o:direction(0), { 1, 0, 0 }))
    assert.same({ 1, 0, 0 }, o:camera(0.4).look_at)
    assert.is_true(near(o:length(), 4 * math.pi))
    local tilted = rt.orbit { radius = 1, axis = { 1, 0, 0 }, turns = -1, from = 90 }
    for i = 0, 8 do
      local p = tilted(i / 8)
      assert.is_true(near(p[1], 0, 1e-6) and near(p:length(), 1, 1e-6))
      assert.is_true(near(p:dot(tilted:direction(i / 8)), 0, 1e-6))
    end
  end)

  it("turns a thing towards a point", function()
    local m = rt.look_at({ 1, 2, 3 }, { 1, 2, -7 })
    assert.is_true(near(m * { 0, 0, 10 }, { 1, 2, -7 }, 1e-5))
    assert.is_true(near(m:direction { 0, 1, 0 }, { 0, 1, 0 }, 1e-6))
    assert.is_true(near(rt.look_at({ 0, 0, 0 }, { 0, 5, 0 }):direction { 0, 0, 1 }, { 0, 1, 0 }, 1e-6))
    raises("rt.look_at: from and to are the same point", function() rt.look_at({ 1, 1, 1 }, { 1, 1, 1 }) end)
  end)
end)
