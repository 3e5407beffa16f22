local support = require "support"
local rtray = support.rtray

local function script(text)
  return support.write(support.folder() .. "/s.lua", text)
end

describe("a script", function()
  it("at fault ends with status 1 and its line", function()
    for text, message in pairs {
      ["return rt.scene {"] = "s.lua:1:",
      ["\nerror 'no luck'"] = "s.lua:2: no luck",
      ["x = nil + 1"] = "s.lua:1: attempt to perform arithmetic",
      ["local x = 1"] = "the script returns nothing",
      ["return 5"] = "it must return a scene",
      ["local rt = require 'rt'\nlocal s = rt.sphere { center = {0,0,0}, radius = -1 }\nreturn s"] = "s.lua:2: ",
      ["local rt = require 'rt'\nlocal s = rt.sphere { center = {0,0,0}, raduis = 1 }\nreturn s"] = "did you mean radius?",
      ["\nlocal x = require 'nosuch'"] = "s.lua:2: module 'nosuch' not found",
      ["local rt = require 'rt'\nlocal x = rt.load 'gone.lua'"] = "s.lua:2: rt.load: ",
      ["error({})"] = "",
    } do
      local r = rtray { "render", script(text), "-o", "x.png" }
      assert.equal(1, r.status, text .. r.err)
      assert.truthy(r.err:find(message, 1, true), r.err)
      assert.equal("", r.out)
    end
  end)

  it("that is trusted says where it requires what is not there", function()
    local r = rtray { "info", script "local x = 1\nx = require 'nosuch'", "--trust" }
    assert.truthy(r.err:find("s.lua:2: module 'nosuch' not found", 1, true), r.err)
  end)

  it("that is no text, a folder, missing or of an unknown kind is refused", function()
    local folder = support.folder()
    local r = rtray { "render", folder }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("it is a folder", 1, true))
    r = rtray { "info", "/dev/zero" } -- never ends
    assert.equal(1, r.status)
    assert.truthy(r.err:find("it is a device or a pipe", 1, true), r.err)
    r = rtray { "render", folder .. "/gone.lua" }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("No such file", 1, true))
    r = rtray { "render", support.write(folder .. "/x.lua", "\27Lua\84\0") }
    assert.equal(1, r.status)
    r = rtray { "render", support.write(folder .. "/x.blend", "x") }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("known are .lua, .sdf, .ply, .obj, .stl", 1, true), r.err)
  end)

  it("finds its modules and files beside itself, wherever the program runs", function()
    local folder = support.folder()
    support.write(folder .. "/part.lua", "return 2")
    local path = support.write(folder .. "/s.lua", (support.SMALL:gsub("radius = p.radius", "radius = require 'part'")))
    local r = rtray { "render", path, "-q", "-o", folder .. "/x.png", cwd = "/" }
    assert.equal(0, r.status, r.err)
  end)

  it("may write to standard output, in order", function()
    local r = rtray { "params", script "print 'first'\nreturn require 'rt'.scene {}" }
    assert.equal("first\nthe script declares no parameters\n", r.out)
    assert.equal(3, rtray({ "describe", script "print 'first'\nreturn require 'rt'.scene {}", tail = ">/dev/full" }).status)
  end)
end)

describe("params", function()
  it("lists parameters and sets", function()
    local r = rtray { "params", support.small(), "--set", "large" }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find "radius +number +2 +1 +0.1 ... 2 +set large +radius of the ball", r.out)
    assert.truthy(r.out:find("set large: radius = 2", 1, true), r.out)
  end)

  it("gives a schema as JSON", function()
    local cjson = require "cjson"
    local object = cjson.decode(rtray({ "params", support.small(), "--json", "-D", "radius=0.25" }).out)
    local p = object.params[1]
    assert.same({ "radius", "number", 0.25, 1, 0.1, 2, "command line" }, { p.name, p.type, p.value, p.default, p.min, p.max, p.source })
    assert.equal(2, object.sets.large.radius)
    local folder = support.folder()
    local path = support.write(folder .. "/x.lua", [[
      local rt = require "rt"
      rt.params { n = { 3, type = "integer", min = 1, max = 9, step = 2, label = "N" }, mood = { "day", choices = { "day", "night" } },
        tint = { {1, 0.5, 0}, type = "color" }, way = {0, 1, 2}, lit = true, look = { "a.png", type = "file" }, word = "x" }
      return rt.scene {}]])
    local schema = cjson.decode(rtray({ "params", path, "--json" }).out).schema
    local unit = { type = "number", minimum = 0, maximum = 1 }
    assert.same({
      n = { type = "integer", title = "N", minimum = 1, maximum = 9, ["x-step"] = 2, default = 3 },
      mood = { type = "string", enum = { "day", "night" }, default = "day" },
      tint = { type = "array", format = "color", items = unit, minItems = 3, maxItems = 3, default = { 1, 0.5, 0 } },
      way = { type = "array", items = { type = "number" }, minItems = 3, maxItems = 3, default = { 0, 1, 2 } },
      lit = { type = "boolean", default = true }, look = { type = "string", format = "path", default = "a.png" },
      word = { type = "string", default = "x" },
    }, schema.properties)
    assert.equal("object", schema.type)
    assert.is_false(schema.additionalProperties)
  end)

  it("tells who wins", function()
    local path = support.small()
    local r = rtray { "params", path, "--set", "large", "-D", "radius=0.5" }
    assert.truthy(r.out:find("command line, over set large's 2", 1, true), r.out)
    r = rtray { "render", path, "--set", "large", "-D", "radius=0.5", "--settings", "-o", support.folder() .. "/x.png" }
    assert.truthy(r.out:find "%-D radius +0.5 +command line, over set large's 2", r.out)
  end)

  it("are told from settings", function()
    local r = rtray { "render", support.small(), "-D", "max_depth=3", "-o", support.folder() .. "/x.png" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("-D max_depth: that is a setting, no parameter; --max-depth sets it", 1, true), r.err)
  end)
end)

describe("info", function()
  it("tells the build", function()
    local r = rtray { "info" }
    assert.equal(0, r.status)
    for _, word in ipairs { "librt", "cpus", "memory", "whitted", "kdtree", "stb=", "png=" } do
      assert.truthy(r.out:find(word, 1, true), word)
    end
    assert.truthy(require("cjson").decode(rtray({ "info", "--json" }).out).cpus >= 1)
  end)

  it("tells a scene's counts, memory and trees", function()
    local r = rtray { "info", support.small() }
    assert.equal(0, r.status, r.err)
    for _, pattern in ipairs { "shapes +1", "planes +1", "lights +1", "render +%S+ %S+ for 40x30", "\nkdtree ", "\noctree ", "references", "growth",
      "build", "depth", "nodes", "leaves", "empty%%", "largest", "SAH", "bytes" } do
      assert.truthy(r.out:find(pattern), pattern .. "\n" .. r.out)
    end
    local object = require("cjson").decode(rtray({ "info", support.small(), "--json", "--tracers", "octree" }).out)
    assert.equal(1, #object.trees)
    assert.equal("octree", object.trees[1].name)
    assert.equal(32, #object.hash)
    assert.is_true(object.render_bytes > 40 * 30 * 16)
  end)

  it("knows an empty scene, which renders its background", function()
    local folder = support.folder()
    local path = support.write(folder .. "/s.lua", "return require 'rt'.scene { background = {0, 1, 0}, settings = { width = 3, height = 2 } }")
    assert.equal(0, rtray({ "info", path }).status)
    local r = rtray { "render", path, "-o", folder .. "/x.bmp" }
    assert.equal(0, r.status, r.err)
    assert.equal("\0\255\0\0\255\0\0\255\0", support.read(folder .. "/x.bmp"):sub(-12, -4))
  end)
end)

describe("a mesh file", function()
  local CUBE = [[
ply
format ascii 1.0
element vertex 8
property float x
property float y
property float z
element face 6
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
4 3 2 1 0
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
]]

  it("just renders", function()
    local folder = support.folder()
    local path = support.write(folder .. "/cube.ply", CUBE)
    local r = rtray { "render", path, "--size", "40x30", "-n", "1", "-o", folder .. "/x.png" }
    assert.equal(0, r.status, r.err)
    assert.truthy(rtray({ "info", path }).out:find "triangles +12")
    assert.equal(2, rtray({ "render", path, "-D", "x=1" }).status)
  end)

  it("tells what it passes over", function()
    local folder = support.folder()
    support.write(folder .. "/t.mtl", "newmtl m\nmap_Kd gone.png\n")
    local path = support.write(folder .. "/t.obj", "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n")
    local r = rtray { "render", path, "-q", "--size", "8x8", "-n", "1", "-o", folder .. "/x.png" }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.err:find "^rtray: warning: [^\n]*gone%.png", r.err)
  end)

  it("that is cut is refused", function()
    local folder = support.folder()
    local path = support.write(folder .. "/cube.ply", CUBE:sub(1, -20))
    local r = rtray { "render", path, "-o", folder .. "/x.png" }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("cube.ply", 1, true), r.err)
  end)

  it("of a benchmark mesh is one of the scenes of scenes/, in the sandbox", function()
    local folder = support.folder()
    local mesh = support.write(folder .. "/bunny.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n" ..
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n-1 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    local r = rtray { "render", support.source .. "/scenes/real.lua", "-D", "mesh=" .. mesh, "--size", "8x6", "-o", folder .. "/x.png" }
    assert.equal(0, r.status, r.err)
    r = rtray { "render", support.source .. "/scenes/real.lua", "-D", "mesh=" .. support.write(folder .. "/cow.ply", ""), "-o", folder .. "/x.png" }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("known are sponza.ply, sibenik.ply and bunny.ply", 1, true), r.err)
  end)

  it("of the real ones verifies", function()
    local scenes = os.getenv "LIBRT_SCENES"
    if not scenes or not support.exists(scenes .. "/teapot.ply") then
      return
    end
    local r = rtray { "verify", scenes .. "/teapot.ply", "--size", "60x40", "-n", "1", "--workers", "1,3", "--tiles", "16,64" }
    assert.equal(0, r.status, r.out .. r.err)
  end)
end)
