-- Meshes as large as they come: ten million triangles with LIBRT_FULL=1, else ten thousand.

local support = require "support"
local rt = support.rt

local N = os.getenv "LIBRT_FULL" == "1" and not os.getenv "RT_TEST_SLOW" and 2237 or support.many(71)

-- A sphere of 2 N^2 triangles with bumps of two sizes.
local function bumpy()
  local vertices, faces = rt.buffer("f32", 3 * (N + 1) * (N + 1)), rt.buffer("u32", 6 * N * N)
  local at = 1
  for y = 0, N do
    local down = math.pi * y / N
    local wide, high = math.sin(down), math.cos(down)
    for x = 0, N do
      local turn = 2 * math.pi * x / N
      local r = 1 + 0.05 * math.sin(40 * down) * math.cos(30 * turn) + 0.002 * math.sin(700 * down + 900 * turn)
      vertices:set(at, r * wide * math.cos(turn), r * high, r * wide * math.sin(turn))
      at = at + 3
    end
  end
  at = 1
  for y = 0, N - 1 do
    for x = 0, N - 1 do
      local a = y * (N + 1) + x
      faces:set(at, a, a + 1, a + N + 1, a + 1, a + N + 2, a + N + 1)
      at = at + 6
    end
  end
  return rt.mesh { vertices = vertices, faces = faces, smooth = true }
end

describe("a large mesh", function()
  it("is built and rendered within 24 GiB, the same by every structure", function()
    local scene = rt.scene {
      settings = { width = 320, height = 224, samples = 1, integrator = "whitted", memory_limit = 24 << 30 },
      camera = rt.camera { eye = { 1.5, 1, 2.2 }, look_at = { 0, 0, 0 }, fov = 45 },
      rt.point_light { at = { 3, 5, 4 } },
      bumpy(),
    }
    local hash
    for _, tracer in ipairs { "bvh", "kdtree", "octree" } do
      local image = scene:render { tracer = tracer }
      hash = hash or image:hash()
      assert.equal(hash, image:hash())
    end
    assert.equal(2 * N * N, scene:info().triangles)
    assert.is_true(scene:intersect { org = { 0, 0, 9 }, dir = { 0, 0, -1 } }.t < 9)
  end)
end)
