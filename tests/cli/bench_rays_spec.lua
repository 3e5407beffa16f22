local support = require "support"
local rtray = support.rtray

local QUICK = { "--size=24x16", "--repeats=1", "--least=0", "--builds=1", "-q" }

local function run(...)
  local args = { "bench", "rays", ... }
  table.move(QUICK, 1, #QUICK, #args + 1, args)
  return rtray(args)
end

local function rows_of(path)
  local rows, names = {}, nil
  for line in support.read(path):gmatch "([^\r\n]*)\r\n" do
    local cells = {}
    for cell in (line .. ","):gmatch "([^,]*)," do
      cells[#cells + 1] = cell
    end
    if not names then
      names = cells
    else
      assert.equal(#names, #cells, line)
      rows[#rows + 1] = {}
      for i, name in ipairs(names) do
        rows[#rows][name] = cells[i]
      end
    end
  end
  return rows
end

describe("bench rays", function()
  it("shows the sets that were measured before Ctrl-C, and writes their rows alone", function()
    local folder = support.folder()
    support.small(folder)
    local r = support.long_enough(function(n) -- for the signal to come before the second set has been measured as well
      os.remove(folder .. "/x.csv")
      local tried = support.ended({ "bench", "rays", "small.lua", "--size=64x48", "--least=0.01", "--repeats=" .. n // 16, "--sets=primary,diffuse",
        "--tracers=bvh", "--inputs=blocks", "-o", "x.csv" }, "INT", 'grep -q "diffuse is measured" "$LOG"', folder)
      return tried.met and not tried.out:find("diffuse", 1, true) and tried or nil
    end)
    assert.equal(130, r.status, r.err)
    assert.truthy(r.out:find("small primary, 3072 rays", 1, true), r.out)
    local rows = rows_of(folder .. "/x.csv")
    assert.same({ 1, "primary" }, { #rows, rows[1].set })
  end)

  it("measures a script's scene with every tracer, and no hit differs", function()
    local folder = support.folder()
    local csv = folder .. "/x.csv"
    local r = run(support.small(folder), "-o", csv, "--machine", "here", "--check", "4294967295")
    assert.equal(0, r.status, r.err)
    assert.equal("", r.err)
    for _, word in ipairs { "small primary, 384 rays", "small random", "kdtree", "brute", "Mrays/s" } do
      assert.truthy(r.out:find(word, 1, true), word)
    end
    local sets, checksums = {}, {}
    for _, row in ipairs(rows_of(csv)) do
      sets[row.set] = (sets[row.set] or 0) + 1
      assert.equal("here", row.machine)
      assert.equal("0", row.differ)
      assert.equal("0", row.brute_differ)
      assert.equal(row.rays, row.brute_rays)
      assert.is_true(tonumber(row.mrays) > 0 and tonumber(row.mrays_low) <= tonumber(row.mrays_high))
      assert.equal(checksums[row.set] or row.checksum, row.checksum)
      checksums[row.set] = row.checksum
    end
    assert.same({ primary = sets.primary, shadow = sets.primary, diffuse = sets.primary, ao = sets.primary, random = sets.primary }, sets)
    assert.is_true(sets.primary >= 4)
  end)

  it("writes ray sets that trace alike when they are read again", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local a, b = folder .. "/a.csv", folder .. "/b.csv"
    assert.equal(0, run(scene, "--dump", folder, "--sets", "diffuse", "-o", a).status)
    assert.equal(0, run(scene, "--rays", folder .. "/small-diffuse.rays", "-o", b).status)
    assert.equal(rows_of(a)[1].checksum, rows_of(b)[1].checksum)
    local text = support.read(folder .. "/small-diffuse.rays")
    assert.equal("RTRAYS\r\n", text:sub(1, 8))
    local path = support.write(folder .. "/bad.rays", text:sub(1, -2) .. string.char(text:byte(-1) ~ 1))
    local r = run(scene, "--rays", path)
    assert.equal(1, r.status)
    assert.truthy(r.err:find("damaged", 1, true), r.err)
  end)

  it("says what is wrong, and ends by it", function()
    local folder = support.folder()
    for _, case in ipairs {
      { 2, "a scene is missing" },
      { 2, "there is no tracer \"spoon\"; there are auto, ", support.small(folder), "--tracers", "spoon" },
      { 2, "--sets 'none'", "x.ply", "--sets", "none" },
      { 1, "gone.ply cannot be read", folder .. "/gone.ply" },
      { 1, "bad", support.write(folder .. "/s.lua", "error 'bad'") },
      { 1, "has no camera called small", support.small(folder), "--camera", support.write(folder .. "/c.json", "{}") },
    } do
      local r = run(table.unpack(case, 3))
      assert.equal(case[1], r.status, r.err)
      assert.truthy(r.err:find(case[2], 1, true), r.err)
      assert.truthy(r.err:find("^rtray bench"), r.err)
    end
  end)

  -- Two meshes that are placed, one of them twice and stretched, above triangles of the scene's own.
  local PLACED = [[
local rt = require "rt"
local function tent(height)
  return rt.mesh {
    vertices = { {-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0.1, height, 0.2} },
    faces = { {1, 2, 5}, {2, 3, 5}, {3, 4, 5}, {4, 1, 5} },
  }
end
local low, high = tent(0.5), tent(2)
return rt.scene {
  camera = rt.camera { eye = {0, 3, 8}, look_at = {0, 0.5, 0}, fov = 50 },
  rt.mesh { vertices = { {-9, -0.1, -9}, {9, -0.1, -9}, {9, -0.1, 9}, {-9, -0.1, 9} }, faces = { {1, 2, 3}, {1, 3, 4} } },
  rt.instance { low, transform = rt.translate(-2, 0, 0) * rt.rotate({0, 1, 0}, 30) },
  rt.instance { high },
  rt.instance { low, transform = rt.translate(2.5, 0, -1) * rt.scale(1, 3, 0.7)MORE },
}
]]

  local function placed(folder, name, more)
    return support.write(folder .. "/" .. name, (PLACED:gsub("MORE", more or "", 1)))
  end

  it("holds instances against Embree, and its hits are ours", function()
    local folder = support.folder()
    local csv = folder .. "/x.csv"
    local r = run(placed(folder, "placed.lua"), "--against", "embree", "--tracers", "bvh", "-o", csv)
    if r.status == 3 and r.err:find("--against embree: ", 1, true) then
      pending "Embree 3 is not installed"
      return
    end
    assert.equal(0, r.status, r.err)
    local hits, count = {}, 0
    for _, row in ipairs(rows_of(csv)) do
      local rays = tonumber(row.rays)
      if row.program == "librt" then
        hits[row.set] = tonumber(row.hits)
        assert.is_true(row.set == "shadow" or hits[row.set] > 0, row.set)
      else
        count = count + 1
        assert.is_true(math.abs(hits[row.set] - tonumber(row.hits)) <= rays / 100, row.set .. " " .. row.tracer .. ": " .. row.hits)
        assert.is_true(tonumber(row.differ) <= rays / 100, row.set .. " " .. row.tracer .. ": " .. row.differ)
        assert.is_true(tonumber(row.tree_bytes) > 0 and tonumber(row.build_seconds) > 0)
      end
    end
    assert.equal(5 * 4 * 4, count) -- sets, interfaces, qualities with ROBUST and without
    for _, case in ipairs {
      { "holds an instance that moves (2)", placed(folder, "moving.lua", ", motion = rt.translate(1, 0, 0)") },
      { "holds more than triangles (shapes: 1, planes: 1)", support.small(folder) },
    } do
      r = run(case[2], "--against", "embree", "--tracers", "bvh", "--sets", "primary")
      assert.equal(1, r.status, r.err)
      assert.truthy(r.err:find(case[1], 1, true), r.err)
    end
  end)

  it("keeps what it has measured when a later scene cannot be read", function()
    local folder = support.folder()
    local csv = folder .. "/x.csv"
    local r = run(support.small(folder), folder .. "/gone.ply", "--sets", "primary", "-o", csv)
    assert.equal(1, r.status, r.err)
    assert.truthy(r.err:find("gone.ply cannot be read", 1, true), r.err)
    assert.is_true(#rows_of(csv) >= 4)
  end)

  it("defines its ray sets in its help", function()
    local text = rtray({ "bench", "rays", "--help" }).out:gsub("%s+", " ")
    for _, word in ipairs { "8 x 8 pixels", "splitmix64", "bytes_per_triangle", "--against NAME", "usage: rtray bench rays [SCENE...]" } do
      assert.truthy(text:find(word, 1, true), word)
    end
  end)
end)
