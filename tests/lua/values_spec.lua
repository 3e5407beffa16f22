-- Vectors, transforms, buffers, random numbers.

local support = require "support"
local rt, raises = support.rt, support.raises

describe("rt.vec", function()
  it("computes", function()
    local a, b = rt.vec(1, 2, 3), rt.vec { 4, 5, 6 }
    assert.same({ 5, 7, 9 }, { (a + b):unpack() })
    assert.same({ -3, -3, -3 }, { (a - b):unpack() })
    assert.same({ 2, 4, 6 }, { (2 * a):unpack() })
    assert.same({ 0.5, 1, 1.5 }, { (a / 2):unpack() })
    assert.same({ -1, -2, -3 }, { (-a):unpack() })
    assert.equal(32, a:dot(b))
    assert.same({ -3, 6, -3 }, { a:cross(b):unpack() })
    assert.equal(5, rt.vec(3, 4, 0):length())
    assert.equal(rt.vec(2.5, 3.5, 4.5), a:lerp(b, 0.5))
    assert.equal(2, a.y)
    assert.equal("{1, 2, 3}", tostring(a))
    assert.same({ 7, 7, 7 }, { rt.vec(7):unpack() })
  end)

  it("turns screen colours into linear ones", function()
    local c = rt.srgb "#ff8000"
    assert.equal(1, c.r)
    assert.is_true(math.abs(c.g - 0.2158605) < 1e-6)
    assert.equal(0, c.b)
    assert.equal(rt.srgb "#808080", rt.srgb(128 / 255, 128 / 255, 128 / 255))
  end)
end)

describe("a transform", function()
  it("composes from the right", function()
    local m = rt.translate(1, 0, 0) * rt.rotate({ 0, 0, 1 }, 90) * rt.scale(2)
    local p = m * { 1, 0, 0 }
    assert.is_true((p - { 1, 2, 0 }):length() < 1e-6)
    assert.is_true((m:direction { 1, 0, 0 } - { 0, 2, 0 }):length() < 1e-6)
  end)

  it("is the identity without arguments", function()
    assert.equal(rt.transform { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0 }, rt.transform())
    assert.equal(rt.translate { 1, 2, 3 }, rt.translate(1, 2, 3))
    assert.equal(rt.scale(2), rt.scale { 2, 2, 2 })
  end)
end)

describe("rt.buffer", function()
  it("holds numbers, counted from 1", function()
    local b = rt.buffer("f32", { 1, 2.5, -3 })
    assert.equal(3, #b)
    assert.equal(2.5, b[2])
    b[2] = 7
    assert.same({ 1, 7, -3 }, { b:get(1, 3) })
    b:set(2, 8, 9)
    assert.same({ 1, 8, 9 }, { b:get(1, 3) })
    assert.same({ 4, 4, 4 }, { b:fill(4):get(1, 3) })
    assert.equal("rt.buffer(f32, 3)", tostring(b))
    assert.equal("f32", b:type())
  end)

  it("reads and gives raw bytes", function()
    local b = rt.buffer("u32", string.pack("<I4I4", 1, 0xffffffff))
    assert.equal(0xffffffff, b[2])
    assert.equal(string.pack("<I4I4", 1, 0xffffffff), b:bytes())
  end)

  it("has bounds and types", function()
    local b = rt.buffer("u8", 2)
    raises("element 3 is outside of the buffer's 1 ... 2", function() return b[3], nil end)
    raises("element 0 is outside of the buffer's 1 ... 2", function() b[0] = 1 end)
    raises("element 2 is outside of the buffer's 1 ... 2", function() b:set(2, 1, 2) end)
    raises("element 1 must be a whole number from 0 to 255; got 256", function() b[1] = 256 end)
    raises("element 1 must be a number; got a string", function() b[1] = "1" end)
    raises("a buffer has no field 'x'", function() return b.x, nil end)
    raises("a buffer of type u32 needs a multiple of 4 bytes; the string has 3", function() return rt.buffer("u32", "abc"), nil end)
    raises("a buffer needs a count, a list of numbers or a string of bytes; got -1", function() return rt.buffer("f32", -1), nil end)
    raises("a buffer of 4611686018427387904 values is too large", function() return rt.buffer("f32", 1 << 62), nil end)
  end)

  it("takes its size from the collector's account", function()
    collectgarbage()
    local before = collectgarbage "count"
    local b = rt.buffer("f32", 1 << 18)
    assert.is_true(collectgarbage "count" - before > 1000)
    assert.equal(1 << 18, #b)
  end)
end)

describe("rt.random", function()
  it("is a function of its keys", function()
    assert.equal(rt.random("leaf", 3), rt.random("leaf", 3))
    assert.equal(rt.random(3), rt.random(3.0))
    assert.not_equal(rt.random("leaf", 3), rt.random("leaf", 4))
    assert.not_equal(rt.random("leaf", 3), rt.random(3, "leaf"))
    assert.not_equal(rt.random("3"), rt.random(3))
  end)

  it("is the same everywhere", function()
    assert.equal("0x1.d8911f5b2115dp-1", ("%a"):format(rt.random("a", 1)))
  end)

  it("fills [0, 1) evenly", function()
    local bins = {}
    for i = 1, 10 do
      bins[i] = 0
    end
    for i = 1, 10000 do
      local x = rt.random("bin", i)
      assert.is_true(x >= 0 and x < 1)
      local k = math.floor(x * 10) + 1
      bins[k] = bins[k] + 1
    end
    for i = 1, 10 do -- a binomial of mean 1000 and deviation 30
      assert.is_true(bins[i] > 850 and bins[i] < 1150, "bin " .. i .. ": " .. bins[i])
    end
  end)
end)
