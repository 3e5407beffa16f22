-- Running scripts: folders, places of errors, what they return; scripts as programs.

local support = require "support"
local rt = support.rt

local function script(folder, text, name)
  return support.write(folder .. "/" .. (name or "s.lua"), 'local rt = require "rt"\n' .. text)
end

local function message_of(text)
  local message
  support.in_folder(function(folder)
    message = support.message(rt.load, script(folder, text)):gsub(folder:gsub("%p", "%%%0") .. "/", "")
  end)
  return message
end

describe("rt.load", function()
  it("returns what a script returns, and its run", function()
    support.in_folder(function(folder)
      local path = script(folder, "return rt.scene { rt.sphere { center = {0, 0, 0}, radius = 1 } }")
      local scene, run = rt.load(path)
      assert.equal(1, scene:info().shapes)
      assert.equal(path, run.path)
      assert.equal(1, rt.load(script(folder, "return { rt.sphere { center = {0, 0, 0}, radius = 1 } }")):info().shapes)
      assert.equal(5, rt.load(script(folder, "return function() return 5 end"))())
    end)
  end)

  it("finds the script's files and modules beside it, and leaves no trace", function()
    support.in_folder(function(folder)
      os.execute("mkdir " .. folder .. "/deep")
      rt.image({ width = 1, height = 1 }):save(folder .. "/deep/white.png")
      script(folder, "return { radius = 3 }", "deep/helper_of_a_spec.lua")
      local path = script(folder, [[
        local helper = require "helper_of_a_spec"
        return rt.scene { rt.sphere { center = {0, 0, 0}, radius = helper.radius, material = rt.classic { texture = "white.png" } } }
      ]], "deep/s.lua")
      local before = package.path
      local _, high = rt.load(path):bounds()
      assert.is_true(math.abs(high[1] - 3) < 1e-4)
      assert.equal(before, package.path)
      assert.is_nil(package.loaded.helper_of_a_spec)
      script(folder, "return { radius = 4 }", "deep/helper_of_a_spec.lua")
      _, high = rt.load(path):bounds()
      assert.is_true(math.abs(high[1] - 4) < 1e-4)
    end)
  end)

  it("finds textures that a description was given since beside the script, too", function()
    support.in_folder(function(folder)
      os.execute("mkdir " .. folder .. "/deep")
      rt.image({ width = 1, height = 1 }):save(folder .. "/deep/white.png")
      local function loaded(change)
        return rt.load(script(folder, ([[
          local texture = rt.texture { file = "first.png" }
          local ball = rt.classic { texture = texture }
          local other = rt.classic { texture = "first.png" }
          texture.file, other.texture = "white.png", "white.png"
          %s
          return rt.scene {
            rt.sphere { center = {0, 0, 0}, radius = 1, material = ball }, rt.sphere { center = {2, 0, 0}, radius = 1, material = other },
          }
        ]]):format(change), "deep/s.lua"))
      end
      assert.equal(1, loaded "":info().textures)
      assert.equal(2, loaded [[other.texture = rt.image "white.png"]]:info().textures)
      for change, expected in pairs {
        ["other.texture = 5"] = "s.lua:4: rt.classic: texture must be a file's name, a texture as rt.texture",
        ["texture.file = 'no.png'"] = "s.lua:3: item 1 (rt.sphere): " .. folder .. "/deep/no.png: cannot open it for reading",
        ["texture.file = 7"] = "s.lua:2: rt.texture: file must be a string; got 7",
        ["texture.file = nil"] = "s.lua:2: rt.texture: give either file or image",
      } do
        local message = support.message(loaded, change)
        assert.is_truthy(message:find(expected, 1, true), message)
      end
    end)
  end)

  it("restores everything after an error", function()
    support.in_folder(function(folder)
      local before = package.path
      support.message(rt.load, script(folder, "error 'x'"))
      assert.equal(before, package.path)
    end)
  end)

  it("seeds math.random when asked to", function()
    support.in_folder(function(folder)
      local path = script(folder, "local x = math.random(); return function() return x end")
      assert.equal(rt.load(path, {}, { seed = 7 })(), rt.load(path, {}, { seed = 7 })())
      assert.not_equal(rt.load(path, {}, { seed = 7 })(), rt.load(path, {}, { seed = 8 })())
    end)
  end)

  it("names the file of bytecode, which it does not run", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/s.lua", string.dump(function() return 1 end))
      assert.truthy(support.message(rt.load, path):find(path .. ": ", 1, true))
    end)
  end)

  it("names file and line", function()
    assert.equal("s.lua:2: rt.sphere: radius is missing", message_of "local s = rt.sphere { center = {0, 0, 0} }\nreturn rt.scene { s }")
    assert.equal("s.lua:3: rt.sphere: radius is missing", message_of [[
local function ball(c) return rt.sphere { center = c } end
local s = ball { 0, 0, 0 }
return rt.scene { s }]])
    assert.equal("s.lua:4: rt.scene has no key 'amient'; did you mean ambient?", message_of "\n\nreturn rt.scene { amient = {0, 0, 0} }")
    assert.equal("s.lua:2: attempt to index a nil value (global 'nothing')", message_of "return nothing.there")
    assert.is_truthy(message_of("return {"):find "^s.lua:2: .*expected")
  end)

  it("says when nothing useful comes back", function()
    assert.equal("s.lua: the script returns nothing; its last line must return a scene, as in `return rt.scene { ... }`", message_of "")
    assert.equal("s.lua: the script returns 5; it must return a scene, as in `return rt.scene { ... }`", message_of "return 5")
    assert.equal("s.lua:2: rt.scene: item 1 is 5; an item is an object, a list of items or false", message_of "return rt.scene { 5 }")
  end)

  it("makes messages strings", function()
    assert.equal("s.lua: the script raised a table instead of a message", message_of "error {}")
  end)

  it("says which file is missing or of no known kind", function()
    assert.is_truthy(support.message(rt.load, "/nowhere/s.lua"):find("/nowhere/s.lua", 1, true))
    for _, ending in ipairs { "lua", "ply", "rts", "sdf" } do -- a script that loads one is told its own line
      local path = "/nowhere/s." .. ending
      support.raises(("rt.load: %s: No such file or directory"):format(path), function() return rt.load(path), nil end)
    end
    assert.is_truthy(support.message(rt.load, "/nowhere/s.txt"):find("the file's kind is not known by its ending", 1, true))
    assert.is_truthy(support.message(rt.load, "/nowhere/s.ply"):find("/nowhere/s.ply", 1, true))
    local message
    support.in_folder(function(folder)
      local path = script(folder, 'return rt.scene { rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, '
        .. 'material = rt.classic { texture = "missing.png" } } }')
      message = support.message(rt.load, path)
      assert.is_truthy(message:find("missing.png", 1, true), message)
    end)
  end)

  it("shows a mesh file under a lamp", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/t.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        .. "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
      local scene = rt.load(path)
      local info = scene:info()
      assert.equal(1, info.triangles)
      assert.equal(1, info.planes)
      assert.is_true(info.lights >= 1)
      local image = scene:render { width = 40, height = 30, samples = 1 }
      assert.equal(0, image:stats().not_finite)
      assert.is_truthy(support.message(rt.load, path, { ior = 1 }):find("declares no parameters", 1, true))
    end)
  end)

  it("shows a real mesh", function()
    local path = support.scenes .. "/bunny.ply"
    local file = io.open(path)
    if not file then
      pending("no bunny.ply in " .. support.scenes)
      return
    end
    file:close()
    local scene = rt.load(path, {}, { settings = { width = 48, height = 36, samples = 1 } })
    assert.is_true(scene:info().triangles > 60000)
    local stats = scene:render():stats()
    assert.equal(0, stats.not_finite)
    assert.is_true(stats.mean[1] > 0.1 and stats.max[1] > stats.min[1])
  end)

  it("reads old scene definitions", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/p.sdf", "BEGIN_SCENE\nVIEWPOINT 0,0,10\nLIGHTPOINT 5,5,5\nEND_SCENE\n"
        .. "SPHERE\nCENTER 0,0,0\nRADIUS 2\nCOLOR 1,0,0\n")
      local ok, scene = pcall(rt.load, path)
      assert(ok, scene)
      assert.equal(1, scene:info().shapes)
    end)
  end)

  it("can be called within a script", function()
    support.in_folder(function(folder)
      os.execute("mkdir " .. folder .. "/inner")
      script(folder, 'return rt.scene { rt.mesh { file = "../t.stl" } }', "inner/i.lua")
      support.write(folder .. "/t.stl",
        "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n")
      local scene = rt.load(script(folder, 'local inner = rt.load "inner/i.lua"\nreturn rt.scene { rt.instance { inner } }'))
      assert.equal(1, scene:info().instances)
    end)
  end)
end)

describe("scripts that load each other in a circle", function()
  it("are refused", function()
    support.in_folder(function(folder)
      script(folder, 'local x = rt.load "b.lua"\nreturn x', "a.lua")
      script(folder, '\nlocal x = rt.load "a.lua"\nreturn x', "b.lua")
      local message = support.message(rt.load, folder .. "/a.lua")
      assert.is_truthy(message:find("b.lua:3: " .. folder .. "/a.lua loads itself", 1, true), message)
    end)
  end)
end)

describe("settings of the command line", function()
  it("reach a script that a script loads", function()
    support.in_folder(function(folder)
      script(folder, "return rt.scene { settings = { samples = 4, tile = 8 } }", "inner.lua")
      local path = script(folder, 'return rt.load("inner.lua", {}, { settings = { tile = 9 } })')
      local scene = rt.load(path, {}, { settings = { samples = 1, tile = 7 } })
      local values = scene:effective()
      assert.same({ 1, 9 }, { values.samples, values.tile })
    end)
  end)
end)

describe("a script that writes over itself", function()
  it("is stopped", function()
    support.in_folder(function(folder)
      for _, line in ipairs { "rt.image({ width = 1, height = 1 }):save(me)", "rt.scene({}):save(me)", "rt.scene({}):render_to_file(me)" } do
        local path = script(folder, "local me = " .. ("%q"):format(folder .. "/./s.lua") .. "\n" .. line)
        local ok, raised = pcall(rt.load, path)
        assert.is_false(ok)
        assert.is_truthy(raised:find("s.lua:%d: [%w:_]+: '[^']*s.lua' is the script itself; name another file"), raised)
        assert.equal('local rt = require "rt"', io.lines(path)())
      end
    end)
  end)
end)

describe("a script as a program", function()
  local function run(folder, arguments)
    local pipe = io.popen(("cd / && lua5.4 %s/s.lua %s 2>&1; echo status $?"):format(folder, arguments))
    local text = pipe:read "a"
    pipe:close()
    return text
  end

  local TEXT = [[
local p = rt.params { radius = { 1, min = 0.1 }, sets = { tiny = { radius = 0.5, samples = 1 } } }
local scene = rt.scene { settings = { width = 8, height = 6, samples = 1 },
  rt.sphere { center = {0, 0, 0}, radius = p.radius, material = rt.classic { texture = "white.png" } } }
rt.main(scene)
]]

  it("renders a frame of an animation", function()
    support.in_folder(function(folder)
      script(folder, [[
local rt = require "rt"
return rt.main(rt.animation { frames = 3, scene = function(t)
  return rt.scene { settings = { size = {4, 4}, samples = 1 }, ambient = {t, t, t}, rt.plane { point = {0, -1, 0}, normal = {0, 1, 0} } }
end })
]])
      assert.equal("status 0\n", run(folder, "--quiet -o " .. folder .. "/0.hdr"))
      assert.equal("status 0\n", run(folder, "--quiet --frame 2 -o " .. folder .. "/2.hdr"))
      assert.is_true(rt.compare(rt.image(folder .. "/0.hdr"), rt.image(folder .. "/2.hdr")).differing > 0)
      assert.is_truthy(run(folder, "--frame 3"):find("there is no frame 3; the animation has 3, 0 to 2", 1, true))
      assert.is_truthy(run(folder, "--frame x"):find("--frame needs a whole number; got 'x'", 1, true))
    end)
  end)

  it("renders", function()
    support.in_folder(function(folder)
      rt.image({ width = 1, height = 1 }):save(folder .. "/white.png")
      script(folder, TEXT)
      local text = run(folder, "--size 10x5 -D radius=2 --set tiny -o " .. folder .. "/o.png")
      assert.is_truthy(text:find "^[^\r\n]*o%.png: 10 x 5, %d+ rays, [%d.]+ s\nstatus 0\n$", text)
      assert.same({ 10, 5 }, { rt.image(folder .. "/o.png"):size() })
      text = run(folder, "--quiet -o " .. folder .. "/p.png")
      assert.equal("status 0\n", text)
      assert.same({ 8, 6 }, { rt.image(folder .. "/p.png"):size() })
    end)
  end)

  it("says what is wrong", function()
    support.in_folder(function(folder)
      rt.image({ width = 1, height = 1 }):save(folder .. "/white.png")
      script(folder, TEXT)
      assert.is_truthy(run(folder, "--sampels 4"):find "command line: '%-%-sampels' is no option.*status 2")
      assert.is_truthy(run(folder, "--size 4"):find "size must be WIDTHxHEIGHT.*status 2")
      assert.is_truthy(run(folder, "-D radus=1"):find "no parameter 'radus'; did you mean radius%?.*status 1")
      script(folder, "return rt.scene { amient = 1 }")
      assert.is_truthy(run(folder, ""):find "s.lua:2: rt.scene has no key 'amient'; did you mean ambient%?.*status 1")
      script(folder, TEXT)
      assert.is_truthy(run(folder, "--help"):find "%-D radius=1.*status 0")
    end)
  end)

  it("writes over nothing that it reads", function()
    support.in_folder(function(folder)
      rt.image({ width = 1, height = 1 }):save(folder .. "/white.png")
      script(folder, TEXT)
      local function refused(words, arguments)
        local text = run(folder, arguments)
        assert.is_truthy(text:find(words .. ".*status 1"), text)
        assert.same({ 1, 1 }, { rt.image(folder .. "/white.png"):size() })
      end
      refused("^%-%-output: '[^']*white.png' is a file that the scene reads %([^)]*white.png%)", "-o " .. folder .. "/./white.png")
      refused("^%-%-output: '[^']*s.lua' is the script itself; name another file", "-o " .. folder .. "/s.lua --quiet")
    end)
  end)

  it("is only a value under rt.load", function()
    support.in_folder(function(folder)
      rt.image({ width = 1, height = 1 }):save(folder .. "/white.png")
      local path = script(folder, TEXT)
      assert.equal(1, rt.load(path):info().shapes)
    end)
  end)
end)
