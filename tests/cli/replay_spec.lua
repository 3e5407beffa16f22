-- rtray replay: an image makes itself again, or says what differs; images from strangers do no harm.

local support = require "support"
local cjson = require "cjson"
local rtray = support.rtray

local SCENE = [[
local rt = require "rt"
local part = require "lib.part"
local p = rt.params { radius = { 1, min = 0.1, max = 2 }, picture = { "tex.png", type = "file" }, sets = { large = { radius = 1.5 } } }
local data = io.open("data.txt"):read "n"
return rt.scene {
  settings = { width = 20, height = 14, samples = 1 },
  camera = rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0}, fov = 45 },
  ambient = {0.2, 0.2, math.random()},
  rt.point_light { at = {5, 5, 5} },
  rt.sphere { center = {0, 0, 0}, radius = p.radius * data, material = rt.classic { texture = p.picture } },
  part.floor(rt),
}
]]
local PART = "-- a comment\tin \255\254 bytes\r\nreturn { floor = function(rt) return rt.plane { point = {0, -1, 0}, normal = {0, 1, 0} } end }\n"

local function texture(path, color)
  local folder = support.folder()
  support.write(folder .. "/t.lua", ([[
    local rt = require "rt"
    return rt.scene { settings = { width = 2, height = 2, samples = 1 }, camera = rt.camera { eye = {0, 0, 1}, look_at = {0, 0, 0} },
      background = %s }]]):format(color))
  local r = rtray { "render", folder .. "/t.lua", "-q", "--no-metadata", "-o", path }
  assert.equal(0, r.status, r.err)
end

local function scene(folder)
  assert(os.execute("mkdir -p " .. support.quote(folder .. "/lib")))
  support.write(folder .. "/lib/part.lua", PART)
  support.write(folder .. "/data.txt", "0.75\n")
  texture(folder .. "/tex.png", "{1, 0.5, 0}")
  return support.write(folder .. "/s.lua", SCENE)
end

local function render(folder, ...)
  local r = rtray { "render", "s.lua", "-q", cwd = folder, ... }
  assert.equal(0, r.status, r.err)
end

local function replay(folder, ...)
  return rtray { "replay", cwd = folder, ... }
end

local function says(r, status, ...)
  assert.equal(status, r.status, r.out .. r.err)
  for _, words in ipairs { ... } do
    assert.truthy((r.out .. r.err):find(words, 1, true), ("%s: %s"):format(words, r.out .. r.err))
  end
end

local MESH = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
  .. "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"

-- Changes the recipe that lies beside x.bmp.
local function forge(folder, change)
  local path = folder .. "/x.bmp.json"
  local texts = cjson.decode(support.read(path))
  local recipe = cjson.decode(texts.Recipe)
  texts.Recipe = change(recipe, texts) or cjson.encode(recipe)
  support.write(path, cjson.encode(texts))
end

describe("replay", function()
  it("gives the same bits from every format", function()
    local folder = support.folder()
    scene(folder)
    for _, name in ipairs { "a.png", "a.hdr", "a.jpg", "a.bmp", "a.tga" } do
      render(folder, "-o", name, "--set", "large", "-D", "picture=tex.png", "--seed", "7", "--samples", "2", "--exposure", "0.5")
      local again = name:gsub("a", "again", 1)
      says(replay(folder, name, "-o", again, "--workers", "1"), 0, "'" .. name .. "': the same bits, ")
      assert.equal(support.read(folder .. "/" .. name), support.read(folder .. "/" .. again), name)
      local beside = support.exists(folder .. "/" .. name .. ".json")
      assert.equal(name:find "jpg" ~= nil or name:find "bmp" ~= nil or name:find "tga" ~= nil, beside)
      if beside then
        assert.equal(support.read(folder .. "/" .. name .. ".json"), support.read(folder .. "/" .. again .. ".json"))
      end
    end
    local object = cjson.decode(replay(folder, "a.png", "--json").out)
    assert.is_true(object.equal and #object.hash == 32 and #object.differences == 0)
  end)

  it("needs nothing but the image and the files, and runs them in the sandbox", function()
    local folder, other = support.folder(), support.folder()
    scene(folder)
    render(folder, "-o", other .. "/a.png")
    says(replay(other, "a.png"), 4, "the file 'data.txt' is not here", "the file 'tex.png' is not here", "it cannot be made here")
    says(replay(other, "a.png", "--files", folder), 0)
    assert(os.execute(("cp %s/*.txt %s/*.png %s"):format(support.quote(folder), support.quote(folder), support.quote(other))))
    says(replay(other, "a.png"), 0) -- the scripts are in it
    texture(other .. "/tex.png", "{0, 1, 0}")
    local r = replay(other, "a.png")
    says(r, 4, "the file 'tex.png' is another: sha256 ", "the script describes another scene here", "the image is another")
    assert.equal(3, select(2, r.out:gsub("differs: ", "")))
    assert.is_nil(r.out:find("data.txt", 1, true))
  end)

  it("works for frames of animations, old scene definitions, meshes and images in bands", function()
    local folder = support.folder()
    support.write(folder .. "/s.lua", [[
      local rt = require "rt"
      return rt.animation { frames = 4, scene = function(t)
        return rt.scene { settings = { width = 16, height = 12, samples = 1 }, rt.sphere { center = {t, 0, 0}, radius = 1 } }
      end }]])
    render(folder, "--frame", "2", "-o", "f.png")
    says(replay(folder, "f.png", "-o", "g.png"), 0)
    assert.equal(support.read(folder .. "/f.png"), support.read(folder .. "/g.png"))
    local r = rtray { "animate", "s.lua", "-q", "-o", "m%d.png", cwd = folder }
    assert.equal(0, r.status, r.err)
    says(replay(folder, "m3.png"), 0)
    local scenes = support.source .. "/scenes"
    r = rtray { "render", scenes .. "/paper.sdf", "-q", "--size", "20x14", "-n", "1", "-o", folder .. "/sdf.png" }
    assert.equal(0, r.status, r.err)
    says(replay(folder, "sdf.png", "--files", scenes), 0)
    support.write(folder .. "/m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    r = rtray { "render", folder .. "/m.obj", "-q", "--size", "20x14", "-n", "1", "-o", folder .. "/obj.png" }
    assert.equal(0, r.status, r.err)
    says(replay(folder, "obj.png"), 0)
    support.write(folder .. "/m.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    says(replay(folder, "obj.png"), 4, "the file 'm.obj' is another", "describes another scene")
    render(folder, "--frame", "1", "--bands", "-o", "b.png")
    says(replay(folder, "b.png"), 0)
  end)

  it("keeps the view that --eye, --at and --fov give of a mesh file", function()
    local folder = support.folder()
    support.write(folder .. "/m.ply", MESH)
    local quick = { "--size", "16x12", "-n", "1", "-q" }
    assert.equal(0, rtray({ "render", "m.ply", "-o", "framed.png", cwd = folder, table.unpack(quick) }).status)
    for option, value in pairs { ["--eye"] = "0.5,0.5,3", ["--at"] = "1,0,0", ["--fov"] = "20" } do
      local r = rtray { "render", "m.ply", "-o", "x.png", option, value, cwd = folder, table.unpack(quick) }
      assert.equal(0, r.status, r.err)
      assert.equal(4, rtray({ "compare", "framed.png", "x.png", "-q", cwd = folder }).status, option)
      says(replay(folder, "x.png"), 0, "the same bits")
    end
    local r = rtray { "pixel", "m.ply", "8,6", "--eye", "0,0,5", "--json", "--size", "16x12", cwd = folder }
    assert.same({ 0, 0, 5 }, cjson.decode(r.out).rays[1].origin)
    scene(folder)
    says(rtray { "render", "s.lua", "--fov", "30", cwd = folder }, 2, "--fov is for mesh files (.ply, .obj, .stl); 's.lua' has a camera of its own")
    says(rtray { "render", "m.ply", "--eye", "1,2", cwd = folder }, 2, "X,Y,Z is expected")
    says(rtray { "render", "m.ply", "--eye", "1,2,3", "--at", "1,2,3", cwd = folder }, 1, "eye and look_at are the same point")
  end)

  it("works for the images of a sweep", function()
    local folder = support.folder()
    scene(folder)
    local r = rtray { "sweep", "s.lua", "-q", "-o", "out", "--over", "radius=0.5,1", "--set", "large", "-D", "picture=tex.png", cwd = folder }
    assert.equal(0, r.status, r.err)
    for _, name in ipairs { "radius-0.5.png", "radius-1.png" } do
      says(replay(folder, "out/images/" .. name, "--files", "."), 0, "the same bits")
    end
  end)

  it("says when the version, the picture or the recipe is another", function()
    local folder = support.folder()
    scene(folder)
    render(folder, "-o", "x.bmp")
    forge(folder, function(recipe) recipe.librt = "9.9.9" end)
    says(replay(folder, "x.bmp"), 4, "librt '9.9.9' made it; this is ")
    render(folder, "-o", "x.bmp")
    local bytes = support.read(folder .. "/x.bmp")
    support.write(folder .. "/x.bmp", bytes:sub(1, -9) .. ("\7"):rep(8))
    says(replay(folder, "x.bmp"), 4, "the picture in 'x.bmp' is not the one that its recipe gives")
    render(folder, "-o", "y.bmp", "--no-metadata")
    assert.is_false(support.exists(folder .. "/y.bmp.json"))
    says(replay(folder, "y.bmp"), 1, "holds no recipe")
    says(replay(folder, "gone.png"), 1, "cannot be read")
    says(replay(folder, "x.bmp", "--files", "nowhere"), 2, "there is no such folder")
    says(replay(folder, "x.bmp", "--trust"), 2, "unknown option '--trust'")
  end)

  it("keeps the user's folders, and with --no-metadata everything, out of the image", function()
    local folder, far = support.folder(), support.folder()
    scene(folder)
    texture(far .. "/far.png", "{0, 0, 1}")
    local r = rtray { "render", folder .. "/s.lua", "-q", "-D", "picture=" .. far .. "/far.png", "-o", folder .. "/a.png" }
    assert.equal(0, r.status, r.err)
    local bytes = support.read(folder .. "/a.png")
    assert.truthy(bytes:find("far.png", 1, true))
    assert.is_nil(bytes:find(far, 1, true))
    assert.is_nil(bytes:find(folder, 1, true))
    says(replay(folder, "a.png"), 4, "the file 'far.png' is not here")
    says(replay(folder, "a.png", "--allow-read", far), 0)
    render(folder, "-o", "b.png", "--no-metadata")
    bytes = support.read(folder .. "/b.png")
    for _, words in ipairs { "Recipe", "librt", "radius", "tEXt", "iTXt" } do
      assert.is_nil(bytes:find(words, 1, true), words)
    end
  end)

  it("takes scripts of any size, and small ones along", function()
    local folder = support.folder()
    support.write(folder .. "/s.lua", "--" .. ("x"):rep(3000000)
      .. "\nreturn require 'rt'.scene { settings = { width = 4, height = 4, samples = 1 } }")
    render(folder, "-o", "a.png")
    assert.is_true(#support.read(folder .. "/a.png") < 100000)
    says(replay(folder, "a.png"), 0)
    os.remove(folder .. "/s.lua")
    says(replay(folder, "a.png"), 4, "the file 's.lua' is not here")
  end)
end)

describe("an image from a stranger", function()
  local image, beside -- rendered once

  local function evil(script, name)
    local folder = support.folder()
    support.write(folder .. "/s.lua", "return require 'rt'.scene { settings = { width = 4, height = 4, samples = 1 } }")
    if not image then
      render(folder, "-o", "x.bmp")
      image, beside = support.read(folder .. "/x.bmp"), support.read(folder .. "/x.bmp.json")
    end
    support.write(folder .. "/x.bmp", image)
    support.write(folder .. "/x.bmp.json", beside)
    forge(folder, function(recipe)
      local path = support.write(folder .. "/evil", script)
      local sum = support.shell("sha256sum evil", folder).out:match "^%x+"
      os.remove(path)
      recipe.files = { { name = name or "s.lua", text = script, bytes = #script, sha256 = sum } }
    end)
    return folder
  end

  it("writes nothing and reads nothing elsewhere", function()
    for _, case in ipairs {
      { "assert(io.open('x.txt', 'w'))", "writes below the output folder only" }, { "os.execute 'touch x.txt'", "is not there for a script" },
      { "require 'rt'.image { width = 2, height = 2 }:save 'x.png'", "writes below the output folder only" },
      { "assert(io.open '/etc/passwd')", "reads below its own folder only" }, { "require '../../etc/passwd'", "not found" },
      { "\27Lua", "attempt to load a binary chunk" }, { "while true do end", "the time limit of 300ms ran out in the script" },
    } do
      local folder = evil(case[1])
      says(replay(folder, "x.bmp", "-o", "y.png", "--limit", "time=300ms"), 1, case[2])
      assert.equal("s.lua\nx.bmp\nx.bmp.json\n", support.shell("ls", folder).out)
    end
  end)

  it("gets no file by a parameter", function()
    for _, file in ipairs { "/etc/passwd", ".secret" } do
      local folder = evil [[
        local rt = require "rt"
        local p = rt.params { f = { "x", type = "file" } }
        assert(io.open(p.f))]]
      support.write(folder .. "/.secret", "x")
      forge(folder, function(recipe)
        recipe.parameters = { { name = "f", text = file } }
      end)
      says(replay(folder, "x.bmp"), 1, "reads below its own folder only")
      forge(folder, function(recipe)
        recipe.parameters = { { name = "f", file = ".secret", sha256 = "x" } }
      end)
      says(replay(folder, "x.bmp"), 4, "reads below its own folder only")
    end
  end)

  it("names no file elsewhere", function()
    for _, name in ipairs { "../evil.lua", "/etc/passwd", "a/../../b", "..", "a\nb" } do
      says(replay(evil("return 1", name), "x.bmp"), 1, "the recipe is broken: the name of a file")
    end
  end)

  it("cannot be nonsense", function()
    for _, case in ipairs {
      { function() return "{" end, "the recipe is broken" }, { function() return ("["):rep(100000) end, "the recipe is broken" },
      { function() return "[]" end, "the recipe is of form" }, { function(r) r.recipe = 2 end, "the recipe is of form '2'" },
      { function(r) r.files[1].sha256 = ("0"):rep(64) end, "another hash than it says" }, { function(r) r.files = 7 end, "files is missing" },
      { function(r) r.scene = "../s.lua" end, "the scene" },
      { function(r) r.scene = ".s.lua" end, "the scene" }, { function(r) r.frame = -1 end, "frame" }, { function(r) r.seed = "x" end, "seed" },
      { function(r) r.parameters = { { name = "x" } } end, "a parameter" }, { function(r) r.settings.samples = "many" end, "samples" },
      { function(r) r.settings.width = 1e9 end, "width" }, { function(r) r.settings.nonsense = 1 end, "nonsense" },
      { function(r) r.parameters = { { name = "x", text = "1" } } end, "declares no parameters" }, { function(r) r.save.tone = "x" end, "tone" },
      { function(_, t) t.Recipe = nil return ("x"):rep(20000000) end, "holds no recipe" },
    } do
      local folder = evil "return require 'rt'.scene { settings = { width = 4, height = 4, samples = 1 } }"
      forge(folder, case[1])
      local r = replay(folder, "x.bmp")
      says(r, 1, case[2])
    end
  end)

  it("is shown without harm to the terminal, and without being run", function()
    local folder = evil "io.stderr:write 'it runs' -- \27]0;owned\7 \194\155\nreturn 1"
    local r = replay(folder, "x.bmp", "--print")
    says(r, 0, [[-- \x1B]0;owned\x07 \xC2\x9B]], "made by librt", "---- 's.lua' ----")
    assert.is_nil((r.out .. r.err):find "[\27\7]")
    assert.is_nil(r.err:find "it runs")
  end)
end)
