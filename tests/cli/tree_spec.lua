-- rtray tree and rtray pixel: numbers that agree with each other, drawings that are well formed, sentences for bad input.

local support = require "support"
local cjson = require "cjson"
local rtray = support.rtray

local EVIL = [[a "b" <script>alert(1)</script> & $(touch x) %d 'c']]

-- Balls in a box of glass over a floor, two instances of a shape, names that mean something to a shell or to XML.
local SCENE = [==[
local rt = require "rt"
local evil = [[a "b" <script>alert(1)</script> & $(touch x) %d 'c']]
local balls = {}
for i = 1, 200 do
  balls[i] = rt.sphere { center = {2 * rt.random("x", i) - 1, rt.random("y", i), 2 * rt.random("z", i) - 1}, radius = 0.05 }
end
local child = rt.torus { center = {0, 0, 0}, axis = {0, 1, 0}, major_radius = 0.3, minor_radius = 0.1, name = "ring" }
return rt.scene {
  settings = { width = 60, height = 40, samples = 3 },
  camera = rt.camera { eye = {0, 2, 5}, look_at = {0, 0.5, 0}, fov = 40 },
  ambient = {0.1, 0.1, 0.1}, background = {0.3, 0.5, 0.8},
  rt.point_light { at = {3, 5, 2}, name = evil }, rt.sphere_light { at = {-3, 4, 2}, radius = 0.4, visible = true },
  rt.plane { point = {0, -0.2, 0}, normal = {0, 1, 0}, name = "floor" },
  rt.box { low = {-1.2, -0.1, -1.2}, high = {1.2, 1.1, 1.2}, name = evil,
    material = rt.classic { transparency = 0.8, refractiveness = 1.1, reflectiveness = 0.2, diffusion = 0, name = "glass" } },
  rt.instance { child, transform = rt.translate(2, 0.3, 0), name = "left one" }, rt.instance { child, transform = rt.translate(-2, 0.3, 0) },
  balls,
}
]==]

local scene, folder

setup(function()
  folder = support.folder()
  scene = support.write(folder .. "/box.lua", SCENE)
end)

local function json(args)
  args[#args + 1] = "--json"
  local r = rtray(args)
  assert.equal(0, r.status, r.err)
  return cjson.decode(r.out)
end

local function well_formed(path)
  local text = support.read(path)
  assert.truthy(text:find("^<svg xmlns="), path)
  assert.falsy(text:find("<script", 1, true), path)
  assert.falsy(text:find "[^%d]nan" or text:find "[^%a]inf[^%a]", path)
  if os.execute "command -v xmllint >/dev/null 2>&1" then
    local r = support.shell("xmllint --noout " .. support.quote(path))
    assert.equal(0, r.status, r.err)
  end
  return text
end

describe("tree", function()
  it("prints what info prints, and more", function()
    local r = rtray { "tree", scene }
    assert.equal(0, r.status, r.err)
    local info = rtray({ "info", scene }).out
    for row in info:gmatch "\n([ko][dc]t%w+ [^\n]+)" do
      local words = row:gsub("[%d.]+ s ", "", 1):gsub("%s+", " ") -- all but the time of the build
      assert.truthy(r.out:gsub("[%d.]+ s ", ""):gsub(" +", " "):find(words, 1, true), words)
    end
    for _, word in ipairs { "leaves by depth", "leaves by references", "camera rays, 60x40", "predicted", "\nbrute", "##" } do
      assert.truthy(r.out:find(word, 1, true), word)
    end
  end)

  it("gives numbers that agree", function()
    local o = json { "tree", scene }
    assert.equal("0", o.group)
    assert.equal(3, #o.leaves)
    local trees = {}
    for _, t in ipairs(o.trees) do
      trees[t.name .. (math.tointeger(t.group) or t.group) .. (t.part > 0 and "." .. math.tointeger(t.part) or "")] = t
    end
    assert.truthy(trees.kdtreetop and trees.octree1 and trees.bvh0)
    for _, h in ipairs(o.leaves) do
      for _, bars in ipairs { h.depths, h.sizes } do
        local leaves, references = 0, 0
        for _, bar in ipairs(bars) do
          leaves, references = leaves + bar.leaves, references + bar.references
        end
        assert.equal(trees[h.name .. "0"].leaves, leaves)
        assert.equal(trees[h.name .. "0"].references, references)
      end
      assert.equal(trees[h.name .. "0"].empty_leaves, h.sizes[1].leaves)
      assert.equal(trees[h.name .. "0"].depth, h.depths[#h.depths].low)
    end
    for _, m in ipairs(o.model) do
      assert.is_true(math.abs(m.measured / m.predicted - 1) < 0.05, m.name .. ": " .. m.measured .. " for " .. m.predicted)
      assert.is_true(m.first_hit < m.measured and m.lines > 1000)
    end
    assert.equal(4, #o.camera_rays)
    for _, c in ipairs(o.camera_rays) do
      assert.equal(2400, c.rays)
      assert.is_true(c.tests.mean <= c.tests.max and c.tests.p95 <= c.tests.max)
    end
    assert.equal(0, o.camera_rays[1].nodes.max)
    assert.is_true(o.camera_rays[2].tests.mean < o.camera_rays[1].tests.mean / 4)
  end)

  it("draws cells, leaves and costs", function()
    local out = folder .. "/out 1"
    local name = support.write(folder .. "/" .. EVIL:gsub("/", "_") .. ".lua", SCENE)
    local o = json { "tree", name, "-o", out, "--cut", "y=15%", "--color", "references" }
    assert.equal(12, #o.files)
    assert.equal(3, #o.cuts)
    for _, path in ipairs(o.files) do
      assert.is_true(support.exists(path), path)
      if path:find "%.svg$" then
        well_formed(path)
      end
    end
    for _, c in ipairs(o.cuts) do
      assert.is_true(c.cells > 10 and c.drawn <= c.cells and c.pieces > 100)
    end
    local cells = support.read(out .. "/cells-octree.svg")
    assert.truthy(cells:find("&lt;script&gt;alert(1)&lt;_script&gt; &amp; $(touch x) %d &#39;c&#39;", 1, true))
    assert.truthy(support.read(out .. "/cost-kdtree.svg"):find("data:image/png;base64,iVBOR", 1, true))
    assert.equal(0, rtray({ "compare", out .. "/cost-kdtree.png", out .. "/cost-kdtree.png" }).status)
  end)

  it("cuts along any plane, and other groups", function()
    local out = folder .. "/out2"
    for _, plane in ipairs { "x=0", "z=0.25", "1,1,0.5@0,0.5,0", "y=100%" } do
      assert.is_true(json({ "tree", scene, "-o", out, "--cut", plane, "--tracers", "octree" }).cuts[1].cells > 0, plane)
    end
    local o = json { "tree", scene, "-o", out, "--group", "1", "--tracers", "kdtree" }
    assert.equal("1", o.group)
    assert.is_true(o.cuts[1].pieces >= 100)
    o = json { "tree", scene, "-o", out, "--group", "top", "--tracer", "kdtree" }
    assert.equal("top", o.group)
    assert.equal(0, #o.model)
  end)

  it("draws the parts of a group", function()
    local path = support.write(folder .. "/parts.lua", [[
local rt = require "rt"
local balls = {}
for i = 1, 100 do
  balls[i] = rt.sphere { center = {0.01 * rt.random("x", i), 0.01 * rt.random("y", i), 0.01 * rt.random("z", i)}, radius = 0.0003 }
end
return rt.scene { settings = { width = 20, height = 15 }, rt.box { low = {-5000, -1, -5000}, high = {5000, -0.5, 5000} }, balls }]])
    local o = json { "tree", path, "-o", folder .. "/out4", "--group", "0.1", "--tracers", "kdtree" }
    assert.equal("0.1", o.group)
    assert.is_true(o.cuts[1].cells > 2 and o.cuts[1].cells < 200)
    assert.is_true(math.abs(o.model[1].measured / o.model[1].predicted - 1) < 0.05)
  end)

  it("draws the same bytes again", function()
    local a, b = folder .. "/same1", folder .. "/same2"
    assert.equal(0, rtray({ "tree", scene, "-o", a }).status)
    assert.equal(0, rtray({ "tree", scene, "-o", b }).status)
    for _, name in ipairs { "cells-kdtree.svg", "cells-octree.svg", "leaves.svg", "cost-kdtree.svg", "cost-octree.png" } do
      assert.equal(support.read(a .. "/" .. name), support.read(b .. "/" .. name), name)
    end
  end)

  it("says what is wrong", function()
    local function refused(status, args, words)
      local r = rtray(args)
      assert.equal(status, r.status, r.out)
      assert.truthy(r.err:find(words, 1, true), r.err)
    end
    refused(2, { "tree", scene, "--cut", "w=1" }, "a plane is expected")
    refused(2, { "tree", scene, "--cut", "x=1e99" }, "a plane is expected")
    refused(2, { "tree", scene, "--cut", "x=101%" }, "between 0% and 100%")
    refused(2, { "tree", scene, "--cut", "0,0,0@0,0,0" }, "the plane's normal is zero")
    refused(2, { "tree", scene, "--cut", "1,nan,0@0,0,0" }, "a plane is expected")
    refused(2, { "tree", scene, "--group", "5" }, "there is no such tree; there are 0, ")
    refused(2, { "tree", scene, "--group", "-1" }, "a group is expected")
    refused(2, { "tree", scene, "--tracers", "grid" }, "known are")
    refused(1, { "tree", scene, "--cut", "y=50", "-o", folder .. "/out3" }, "the plane y = 50 does not meet the tree, which has y = ")
    refused(1, { "tree", scene, "-o", scene }, "is a file; name a folder")
    refused(1, { "tree", scene, "-o", folder .. "/gone/deep" }, "cannot be made")
    local empty = support.write(folder .. "/empty.lua", 'return require "rt".scene {}')
    refused(1, { "tree", empty }, "has no tree")
  end)
end)

describe("pixel", function()
  it("sums up to the pixel that render gives", function()
    local image = folder .. "/p.hdr"
    for _, integrator in ipairs { "whitted", "path", "ao" } do
      assert.equal(0, rtray({ "render", scene, "-q", "-o", image, "--integrator", integrator }).status)
      for _, where in ipairs { "30,20", "0,0", "59,39", "22,18" } do
        local o = json { "pixel", scene, where, "--integrator", integrator }
        local sum, cameras = { 0, 0, 0 }, 0
        for i, ray in ipairs(o.rays) do
          assert.equal(i - 1, ray.ray)
          assert.is_true(ray.parent == nil and ray.kind == "camera" or ray.parent < ray.ray)
          cameras = cameras + (ray.kind == "camera" and 1 or 0)
          for c = 1, 3 do
            sum[c] = sum[c] + ray.brought[c]
          end
        end
        assert.equal(3, cameras)
        assert.same(o.sum, sum)
        for c = 1, 3 do
          local value = string.unpack("<f", string.pack("<f", sum[c] * o.unit / o.samples))
          assert.equal(value, string.unpack("<f", string.pack("<f", o.value[c])))
        end
      end
    end
  end)

  it("names what is there", function()
    local r = rtray { "pixel", scene, "30,20", "--all" }
    assert.equal(0, r.status, r.err)
    for _, word in ipairs { "camera ray, depth 0", "rt.box 'a \"b\" <script>", "material 'glass'", "mirror ray", "refracted ray", "sample 2",
      "units of 2^-28", "to light 'a \"b\"" } do
      assert.truthy(r.out:find(word, 1, true), word .. "\n" .. r.out)
    end
    local found = {}
    for x = 0, 59, 5 do
      for _, ray in ipairs(json({ "pixel", scene, x .. ",25" }).rays) do
        if ray.hit then
          found[ray.hit.instance_name or ray.hit.name or ""] = ray.hit
        end
      end
    end
    assert.equal("ring", found["left one"].name)
    assert.equal(0, found["left one"].instance)
    assert.truthy(found.floor)
  end)

  it("tells one sample, and few of many", function()
    local o = json { "pixel", scene, "30,20", "--sample", "1" }
    for _, ray in ipairs(o.rays) do
      assert.equal(1, ray.sample)
    end
    local r = rtray { "pixel", scene, "30,20", "-n", "50" }
    assert.truthy(r.out:find("4 of 50 samples are told", 1, true))
    assert.equal(3, select(2, rtray({ "pixel", scene, "30,20" }).out:gsub("\nsample %d", "")))
    r = rtray { "pixel", scene, "30,20", "--integrator", "normal" }
    assert.equal(0, r.status)
    assert.falsy(r.out:find("film", 1, true))
  end)

  it("draws its rays, and tells what they cost in each structure", function()
    local path = folder .. "/rays.svg"
    local o = json { "pixel", scene, "30,20", "--sample", "1", "--svg", path, "--tracers", "brute,kdtree,octree" }
    local text = well_formed(path)
    assert.truthy(text:find("sample 1, " .. #o.rays .. " rays", 1, true))
    assert.equal(#o.rays, select(2, text:gsub('<line [^\n]*stroke%-width="1.6"', "")))
    assert.equal(3, #o.costs)
    local tests = {}
    for _, c in ipairs(o.costs) do
      assert.equal(#o.rays, c.rays)
      tests[c.tracer] = c.tests
    end
    assert.is_true(tests.kdtree < tests.brute / 4)
    local r = rtray { "pixel", scene, "30,20", "--svg", folder .. "/gone/x.svg" }
    assert.equal(1, r.status)
    assert.equal("", r.out)
  end)

  it("takes a frame of an animation", function()
    local path = support.write(folder .. "/moves.lua", [[
local rt = require "rt"
return rt.animation { frames = 3, scene = function(t)
  return rt.scene { settings = { width = 8, height = 8, samples = 1 }, camera = rt.camera { eye = {0, 0, 5 + t}, look_at = {0, 0, 0} },
    rt.sphere { center = {0, 0, 0}, radius = 1 } }
end }]])
    assert.is_true(math.abs(json({ "pixel", path, "4,4", "--frame", "2" }).rays[1].hit.t - 5.1) < 0.1)
    assert.is_true(math.abs(json({ "pixel", path, "4,4" }).rays[1].hit.t - 4.1) < 0.1)
    assert.equal(1, #json({ "tree", path, "--frame", "1", "--tracer", "kdtree" }).trees)
  end)

  it("is ended by a signal", function()
    local place = support.folder()
    support.write(place .. "/long.lua", (support.read(scene):gsub("^", "io.stderr:write 'it runs'\n")))
    for _, args in ipairs { { "pixel", "long.lua", "30,20", "-n", "65536", "--shadow-samples", "4096" },
      { "tree", "long.lua", "--size", "8000x6000" } } do
      local r = support.ended(args, "INT", 'grep -q "it runs" "$LOG"', place)
      assert.same({ true, 130 }, { r.met, r.status }, r.err)
      assert.truthy(r.err:find(args[1] .. ": interrupted", 1, true), r.err)
    end
  end)

  it("is strict about its place", function()
    for _, where in ipairs { "30", "30,", ",20", "a,b", "30,20,1", "-1,2", "1.5,2", "30, 20", "0x1,2", "99999999999999999999,1" } do
      local r = rtray { "pixel", scene, "--", where }
      assert.equal(2, r.status, where)
      assert.truthy(r.err:find("X,Y in pixels from the top left is expected", 1, true), r.err)
    end
    local r = rtray { "pixel", scene, "60,10" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("pixel 60,10 lies outside of the image of 60x40; the last one is 59,39", 1, true), r.err)
    r = rtray { "pixel", scene, "1,1", "--sample", "3" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("the pixel has samples 0 to 2", 1, true), r.err)
    assert.equal(2, rtray({ "pixel", scene }).status)
  end)
end)
