local support = require "support"
local rtray = support.rtray

local function render(scene, path, ...)
  local r = rtray { "render", scene, "-q", "-o", path, ... }
  assert.equal(0, r.status, r.err)
  return path
end

describe("compare", function()
  it("answers by its status and in words", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local a, b = render(scene, folder .. "/a.png"), render(scene, folder .. "/b.png", "-D", "radius=1.1")
    assert.equal(0, rtray({ "compare", a, a }).status)
    local r = rtray { "compare", a, b, "--map", folder .. "/map.png" }
    assert.equal(4, r.status)
    for _, word in ipairs { "differing pixels", "first", "largest difference", "mean squared error", "PSNR" } do
      assert.truthy(r.out:find(word, 1, true), word)
    end
    assert.is_true(support.exists(folder .. "/map.png"))
    r = rtray { "compare", a, b, "-q" }
    assert.equal(4, r.status)
    assert.equal("", r.out)
    local object = require("cjson").decode(rtray({ "compare", a, b, "--json" }).out)
    assert.is_false(object.equal)
    assert.equal(1200, object.pixels)
    assert.is_true(object.differing > 0 and object.max > 0)
    assert.equal(0, rtray({ "compare", a, b, "--tolerance", "1" }).status)
    assert.equal(0, require("cjson").decode(rtray({ "compare", a, a, "--json" }).out).differing)
  end)

  it("prints and maps one metric", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local a, b = render(scene, folder .. "/a.png"), render(scene, folder .. "/b.png", "-D", "radius=1.1")
    local all = rtray({ "compare", a, b, "--json" }).out
    local maps = {}
    for _, metric in ipairs { "psnr", "ssim", "flip" } do
      maps[metric] = folder .. "/" .. metric .. ".png"
      local r = rtray { "compare", a, b, "--metric", metric, "--map", maps[metric] }
      assert.equal(4, r.status, r.err)
      assert.is_true(math.abs(tonumber(r.out) - require("cjson").decode(all)[metric]) < 1e-4, r.out)
    end
    assert.equal("0\n", rtray({ "compare", a, a, "--metric", "flip" }).out)
    assert.equal("infinite\n", rtray({ "compare", a, a, "--metric", "psnr" }).out)
    assert.not_equal(support.read(maps.ssim), support.read(maps.flip))
    local flip = support.read(maps.flip)
    for scale, same in pairs { magma = true, viridis = false, grey = false, none = false } do
      assert.equal(4, rtray({ "compare", a, b, "--metric", "flip", "--map", maps.flip, "--scale", scale }).status)
      assert.equal(same, support.read(maps.flip) == flip, scale)
    end
    local far = tonumber(rtray({ "compare", a, b, "--metric", "flip", "--ppd", "20" }).out)
    assert.is_true(far > 0 and far ~= tonumber(rtray({ "compare", a, b, "--metric", "flip" }).out))
    assert.equal(0, rtray({ "compare", a, b, "--metric", "flip", "--tolerance", "0.5" }).status)
    assert.equal(4, rtray({ "compare", a, b, "--metric", "flip", "--tolerance", "0.0001" }).status)
    assert.equal(0, rtray({ "compare", a, b, "--metric", "ssim", "--tolerance", "0.9" }).status)
    for _, words in ipairs { { "--metric", "psnr", "--tolerance", "0.5" }, { "--scale", "magma" }, { "--metric", "ssim", "--ppd", "30" },
      { "--ppd", "0" }, { "--metric", "lpips" }, { "--map", folder .. "/x.png", "--scale", "jet" } } do
      assert.equal(2, rtray({ "compare", a, b, table.unpack(words) }).status)
    end
  end)

  it("says when sizes differ, and fails on what is no image", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local a, b = render(scene, folder .. "/a.png"), render(scene, folder .. "/b.png", "--size", "20x30")
    local r = rtray { "compare", a, b }
    assert.equal(4, r.status)
    assert.truthy(r.out:find("is 40x30", 1, true) and r.out:find("is 20x30", 1, true))
    assert.equal(1, rtray({ "compare", a, scene }).status)
    assert.equal(1, rtray({ "compare", a, folder .. "/gone.png" }).status)
    assert.equal(1, rtray({ "compare", a, folder }).status)
  end)
end)

describe("verify", function()
  it("prints one hash for every arrangement", function()
    local r = rtray { "verify", support.source .. "/scenes/paper.lua", "--size", "50x35", "-n", "1" }
    assert.equal(0, r.status, r.out .. r.err)
    local hash, rows = r.out:match "one image, (%x+), in 48 arrangements; one description in two processes", 0
    assert.truthy(hash, r.out)
    for line in r.out:gmatch "\n([bko]%w+ +%d+ [^\n]+)" do
      local count = select(2, line:gsub(hash:sub(1, 12), ""))
      assert.equal(3, count, line)
      rows = rows + 1
    end
    assert.equal(16, rows)
    for _, workers in ipairs { 1, 2, 3, 8 } do
      assert.truthy(r.out:find("octree +" .. workers .. " "))
    end
  end)

  it("gives the hash that render gives", function()
    local scene = support.small()
    local cjson = require "cjson"
    local a = cjson.decode(rtray({ "verify", scene, "--json", "--size", "30x20", "-n", "1", "--workers", "1,2", "--tiles", "8" }).out)
    local b = cjson.decode(rtray({ "render", scene, "--json", "--size", "30x20", "-n", "1", "-o", "/dev/null", "--format", "bmp" }).out)
    assert.equal(b.hash, a.hash)
    assert.equal(8, #a.renders)
    assert.is_true(a.equal and a.same_description)
  end)

  it("lets the cost view differ between structures, and only there", function()
    local path = support.write(support.folder() .. "/balls.lua", [[
local rt = require "rt"
local balls = {}
for i = 1, 20 do balls[i] = rt.sphere { center = {i % 5, i // 5, i % 3}, radius = 0.4 } end
return rt.scene { settings = { width = 20, height = 15, leaf_size = 4 }, balls }]])
    local r = rtray { "verify", path, "--integrator", "cost", "--workers", "1,3", "--tiles", "8,64" }
    assert.equal(0, r.status, r.out)
    assert.truthy(r.out:find("one image of each structure", 1, true), r.out)
    local hashes = {}
    for tracer, hash in r.out:gmatch "\n(%w+) +%d+ +(%x+)" do
      hashes[tracer] = hash
    end
    assert.not_equal(hashes.brute, hashes.octree)
  end)

  it("finds a script that describes another scene each time", function()
    local folder = support.folder()
    local path = support.write(folder .. "/s.lua", [[
local rt = require "rt"
local radius = 1
for _ in tostring({}):gmatch "[a-f]" do radius = radius + 0.01 end
radius = radius + (tonumber(tostring({}):match "0x(%x+)" or "1", 16) % 1000003) * 1e-6
return rt.scene { settings = { width = 8, height = 8 }, rt.sphere { center = {0, 0, 0}, radius = radius } }
]])
    local r = rtray { "verify", path, "--workers", "1", "--tiles", "8" }
    assert.equal(4, r.status, r.out)
    assert.truthy(r.out:find("in a second process", 1, true))
    assert.truthy(r.out:find("pairs", 1, true))
  end)

  it("leaves brute force out of large scenes, and says so", function()
    local folder = support.folder()
    local path = support.write(folder .. "/s.lua", [[
local rt = require "rt"
local n = 10001
local centers, radii = {}, {}
for i = 0, n - 1 do centers[#centers + 1] = {i % 100, i // 100, 0} radii[i + 1] = 0.4 end
return rt.scene { settings = { width = 16, height = 16, samples = 1 }, rt.spheres { centers = centers, radii = radii } }
]])
    local r = rtray { "verify", path, "--workers", "1,2", "--tiles", "8" }
    assert.equal(0, r.status, r.out .. r.err)
    assert.truthy(r.out:find("brute force is left out: 10,001 primitives", 1, true), r.out)
    assert.falsy(r.out:find "\nbrute +%d")
    assert.truthy(rtray({ "verify", path, "--workers", "1", "--tiles", "8", "--tracers", "brute,octree" }).out:find "\nbrute +%d")
  end)
end)

describe("bench", function()
  it("times builders and renders, and writes a CSV of every run", function()
    local folder = support.folder()
    local r = rtray { "bench", support.small(folder, "a,b.lua"), "--runs", "2", "--workers", "1,2", "-o", folder .. "/x.csv" }
    assert.equal(0, r.status, r.err)
    for _, pattern in ipairs { "medians of 2 runs", "kdtree exact", "kdtree binned", "octree", "speedup", "rays/s" } do
      assert.truthy(r.out:find(pattern, 1, true), pattern)
    end
    local lines = {}
    for line in support.read(folder .. "/x.csv"):gmatch "([^\r\n]*)\r\n" do
      lines[#lines + 1] = line
    end
    assert.equal(1 + 2 * (7 + 6), #lines)
    assert.truthy(lines[1]:find("^scene,kind,structure,builder,workers,width,height,samples,run,seconds,"))
    assert.truthy(lines[2]:find('^"[^"]*a,b.lua",build,kdtree,exact,', 1), lines[2])
    -- No arrangement comes twice: on one CPU, too, where the counts are 1 and 1.
    assert.equal(10, #require("cjson").decode(rtray({ "bench", support.small(), "--runs", "1", "--workers", "2,2", "--json", "-q" }).out).results)
    assert.equal(13, #require("cjson").decode(rtray({ "bench", support.small(), "--runs", "1", "--workers", "1,2", "--json", "-q" }).out).results)
  end)

  it("writes its rows to standard output for -o -", function()
    local folder = support.folder()
    local r = rtray { "bench", support.small(folder), "--runs", "1", "--workers", "1", "-q", "-o", "-", cwd = folder }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find "^scene,kind,structure,", r.out)
    assert.is_false(support.exists(folder .. "/-"))
    assert.equal(2, rtray({ "bench", support.small(folder), "-o", "-", "--json" }).status)
  end)

  it("reports a fault before the first run", function()
    local r = rtray { "bench", support.write(support.folder() .. "/s.lua", "error 'bad'") }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("bad", 1, true))
  end)
end)

describe("repl", function()
  local function repl(input, ...)
    local args = { "repl", ... }
    return support.shell("printf %s " .. support.quote(input) .. " | " .. support.command(args))
  end

  it("prints the values of expressions, joins lines of a statement", function()
    local r = repl "1 + 1\nrt.version\nfor i = 1, 2 do\n  print(i)\nend\nx = 5\nx, x * 2"
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find "^2\n%d+%.%d+%.%d+\n1\n2\n5\t10\n$", r.out)
  end)

  it("has the scene", function()
    local r = repl("scene\n#scene:hash()\n", support.small())
    assert.equal("rt.scene\n32\n", r.out)
  end)

  it("ends with status 1 at a fault when nobody types", function()
    local r = repl "print 'a'\nnosuch()\nprint 'b'\n"
    assert.equal(1, r.status)
    assert.equal("a\n", r.out)
    assert.truthy(r.err:find("^line 2:1: attempt to call a nil value"), r.err)
    assert.equal(1, repl("for i = 1, 2 do\n").status)
    assert.equal(0, repl("").status)
  end)
end)
