-- No command writes over what it reads: named by whatever name, or read by the scene.

local support = require "support"
local rtray = support.rtray

-- Refused with these words, before anything else is said, and the file is as it was.
local function refused(file, words, args)
  local before = support.read(file)
  local r = rtray(args)
  assert.equal(2, r.status, r.err)
  assert.truthy(r.err:find(words, 1, true), r.err)
  assert.equal("", r.out)
  assert.is_true(before == support.read(file), file)
end

local ITSELF, READ = "is the input itself", "is a file that the scene reads"

local function textured(folder, ending)
  support.write(folder .. "/t." .. (ending or "jpg"), support.read(support.source .. "/scenes/flower.jpg"))
  return support.write(folder .. "/s.lua", (support.SMALL:gsub("normal = {0, 1, 0} }",
    "normal = {0, 1, 0}, material = rt.classic { texture = 't." .. (ending or "jpg") .. "' } }")))
end

describe("an output that is an input", function()
  it("is refused by render, through links and other names, too", function()
    local folder = support.folder()
    local scene = support.small(folder)
    assert(os.execute(("cd %s && ln -s small.lua soft.png && ln small.lua hard.png"):format(support.quote(folder))))
    for _, name in ipairs { "small.lua", "./small.lua", scene, "soft.png", "hard.png" } do
      refused(scene, ITSELF, { "render", "small.lua", "-o", name, "--format", "png", cwd = folder })
    end
    refused(scene, ITSELF, { "render", "small.lua", "--checkpoint", "small.lua", cwd = folder })
    refused(scene, ITSELF, { "render", "small.lua", "--preview", "soft.png", cwd = folder })
    assert.is_false(support.exists(folder .. "/small.png"))
    local mesh = support.write(folder .. "/m.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      .. "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    refused(mesh, ITSELF, { "render", mesh, "-o", mesh, "--format", "png" })
  end)

  it("is refused by the other commands", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local a, b = folder .. "/a.png", folder .. "/b.png"
    assert.equal(0, rtray({ "render", scene, "-q", "-o", a }).status)
    assert.equal(0, rtray({ "render", scene, "-q", "-o", b }).status)
    refused(a, ITSELF, { "compare", a, b, "--map", a })
    refused(b, ITSELF, { "compare", a, b, "--map", folder .. "/./b.png" })
    refused(scene, ITSELF, { "pixel", scene, "3,3", "--svg", scene })
    refused(scene, ITSELF, { "bench", scene, "-o", scene })
    refused(scene, ITSELF, { "bench", "rays", scene, "-o", scene })
    refused(a, ITSELF, { "replay", a, "-o", a })
    local film = support.write(folder .. "/f0.png",
      "local rt = require 'rt' return rt.animation { frames = 1, scene = function() "
      .. "return rt.scene { rt.sphere { center = {0, 0, 0}, radius = 1 } } end }")
    assert(os.rename(film, folder .. "/f.lua"))
    assert(os.execute(("cd %s && ln f.lua f.mp4 && ln f.lua f0.png"):format(support.quote(folder))))
    refused(folder .. "/f.lua", ITSELF, { "animate", "f.lua", "-o", "f.mp4", cwd = folder })
    refused(folder .. "/f.lua", ITSELF, { "animate", "f.lua", "-o", "f%d.png", cwd = folder })
  end)

  it("is refused when the scene reads it: textures, meshes, modules", function()
    local folder = support.folder()
    local scene = textured(folder)
    local texture = folder .. "/t.jpg"
    refused(texture, READ, { "render", "s.lua", "-o", "t.jpg", cwd = folder })
    refused(texture, READ, { "render", scene, "-o", texture, "--bands", "--format", "png", "--trust" })
    refused(texture, READ, { "render", scene, "-o", folder .. "/x.png", "--preview", texture })
    refused(texture, READ, { "pixel", scene, "3,3", "--svg", texture })
    refused(texture, READ, { "bench", scene, "-o", texture, "-q" })
    support.write(folder .. "/part.lua", "return 0.5")
    support.write(folder .. "/m.lua", (support.SMALL:gsub("radius = p.radius", "radius = require 'part'")))
    for _, more in ipairs { "-q", "--trust" } do
      refused(folder .. "/part.lua", READ, { "render", "m.lua", "-o", "part.lua", "--format", "png", more, cwd = folder })
    end
    local png = support.folder()
    textured(png, "png") -- the name that the image has without -o
    assert(os.rename(png .. "/s.lua", png .. "/t.lua"))
    refused(png .. "/t.png", READ, { "render", "t.lua", cwd = png })
    support.write(folder .. "/flower.jpg", support.read(support.source .. "/scenes/flower.jpg"))
    support.write(folder .. "/paper.sdf", support.read(support.source .. "/scenes/paper.sdf"))
    refused(folder .. "/flower.jpg", READ, { "render", "paper.sdf", "--size", "20x10", "-o", "flower.jpg", cwd = folder })
  end)

  it("is refused when it is a frame of an animation", function()
    local folder = support.folder()
    for i = 0, 1 do
      support.write(folder .. ("/in%d.jpg"):format(i), support.read(support.source .. "/scenes/flower.jpg"))
    end
    support.write(folder .. "/s.lua", [[
local rt = require "rt"
return rt.animation { frames = 2, scene = function(_, frame)
  return rt.scene { settings = { width = 8, height = 6, samples = 1 }, rt.point_light { at = {5, 5, 5} },
    rt.sphere { center = {0, 0, 0}, radius = 1, material = rt.classic { texture = ("in%d.jpg"):format(frame) } } }
end }]])
    refused(folder .. "/in0.jpg", READ, { "animate", "s.lua", "-o", "in%d.jpg", "-q", cwd = folder })
    local r = rtray { "animate", "s.lua", "-o", "out%d.jpg", "-q", cwd = folder }
    assert.equal(0, r.status, r.err)
    r = rtray { "animate", "s.lua", "-o", "out%d.jpg", "-q", cwd = folder } -- its own frames are no inputs
    assert.equal(0, r.status, r.err)
  end)
end)
