-- What later scenes take over from earlier ones, and that a thousand renders in one process take no more memory than a hundred.

local support = require "support"
local rt = support.rt

local function since(f)
  local before = rt.counts()
  f()
  local after = rt.counts()
  for key, value in pairs(after) do
    after[key] = value - before[key]
  end
  return after
end

-- A bumpy sheet of n x n cells.
local function write_mesh(path, n)
  local file = assert(io.open(path, "w"))
  for y = 0, n do
    for x = 0, n do
      file:write(("v %g %g %g\n"):format(x / n, 0.1 * math.sin(x) * math.cos(y), y / n))
    end
  end
  for y = 0, n - 1 do
    for x = 1, n do
      local a = y * (n + 1) + x
      file:write(("f %d %d %d %d\n"):format(a, a + n + 1, a + n + 2, a + 1))
    end
  end
  file:close()
end

describe("what is kept", function()
  local folder, path

  setup(function()
    folder = os.tmpname() -- a file: its name with an ending is ours
    path = folder .. ".obj"
    write_mesh(path, 40)
  end)

  teardown(function()
    os.remove(path)
    os.remove(folder)
  end)

  local function scene(o)
    local sheet = rt.mesh { file = path }
    return rt.scene {
      settings = { width = 16, height = 12, samples = 1 },
      camera = rt.camera { eye = o.eye or {0.5, 1, 3}, look_at = {0.5, 0, 0.5} },
      rt.point_light { at = {1, 4, 2} },
      rt.instance { sheet, material = rt.classic { refractiveness = o.ior or 1.5, transparency = 0.3 } },
      rt.instance { sheet, transform = rt.translate(o.x or 2, 0, 0) },
    }
  end

  it("is a file's mesh and its tree", function()
    local first = since(function() scene({}):render() end)
    assert.same({ 1, 0, 1, 1 }, { first.files_read, first.files_kept, first.trees_built, first.top_trees_built })
    for _, change in ipairs { { eye = {1, 1, 3} }, { ior = 1.7 } } do
      local next_one = since(function() scene(change):render() end)
      assert.same({ 0, 1, 0, 0, 2 },
        { next_one.files_read, next_one.files_kept, next_one.trees_built, next_one.top_trees_built, next_one.trees_kept })
      assert.is_true(next_one.saved_seconds > 0)
    end
    local moved = since(function() scene({ x = 2.5 }):render() end)
    assert.same({ 0, 0, 1, 1 }, { moved.files_read, moved.trees_built, moved.top_trees_built, moved.trees_kept })
    local info = scene({ x = 3 }):info()
    assert.same({ 1, 1, 0 }, { info.built_trees, info.built_top_trees, info.kept_trees })
  end)

  it("is let go on request", function()
    scene({}):render()
    local held = rt.machine().memory
    collectgarbage()
    collectgarbage()
    rt.drop_kept()
    assert.is_true(rt.machine().memory < held)
    local again = since(function() scene({}):render() end)
    assert.same({ 1, 1 }, { again.files_read, again.trees_built })
  end)

  -- The most of the pages that are resident, and of what the renderer holds, over some renders.
  local function peaks(from, to)
    local resident, held = 0, 0
    for i = from, to do
      local image = scene({ ior = 1 + i % 100 / 100, x = 2 + i / 1000, eye = {0.5 + i / 1000, 1, 3} }):render()
      assert.is_true(image:stats().max[1] >= 0)
      if i % 10 == 0 then
        collectgarbage()
      end
      local statm = io.open "/proc/self/statm"
      if statm then
        resident = math.max(resident, math.tointeger(tonumber(statm:read("a"):match "^%d+ (%d+)")))
        statm:close()
      end
      held = math.max(held, rt.machine().memory)
    end
    return resident, held
  end

  it("does not grow: 1,000 renders in one process", function()
    local full = os.getenv "LIBRT_FULL" == "1"
    local count = full and 10000 or os.getenv "RT_TEST_SLOW" and 500 or 1000
    peaks(1, 200) -- what every process has once: the indices of refraction have come round, the heap is as wide as it gets
    local resident, held = peaks(201, 300)
    peaks(301, count - 100)
    local last_resident, last_held = peaks(count - 99, count)
    assert.is_true(last_held <= 1.01 * held, ("the renderer held %d bytes, at last %d"):format(held, last_held))
    if not os.getenv "RT_TEST_SLOW" then -- a sanitizer's own bookkeeping grows
      assert.is_true(last_resident <= 1.01 * resident, ("resident pages: %d, at last %d"):format(resident, last_resident))
    end
  end)
end)
