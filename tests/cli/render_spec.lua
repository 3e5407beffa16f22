local support = require "support"
local rtray = support.rtray

-- The text of an entry in a PNG file.
local function png_text(path, key)
  local data, at = support.read(path), 9
  while at < #data do
    local size, kind = (">I4c4"):unpack(data, at)
    local name, text = data:sub(at + 8, at + 7 + size):match "^([^%z]*)%z(.*)$"
    if kind == "tEXt" and name == key then
      return text
    end
    at = at + 12 + size
  end
end

describe("render", function()
  it("writes NAME.png into the current folder", function()
    local folder, cwd = support.folder(), support.folder()
    local r = rtray { "render", support.small(folder, "ball.lua"), cwd = cwd }
    assert.equal(0, r.status, r.err)
    assert.equal("\137PNG", support.read(cwd .. "/ball.png"):sub(1, 4))
    assert.truthy(r.err:find "^ball%.png: 40x30, 2 samples, ", r.err)
    assert.equal("", r.out)
  end)

  it("takes every image format, by ending and by --format", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local signs = { png = "^\137PNG\r\n", jpg = "^\255\216\255", bmp = "^BM", tga = "^%z", hdr = "^#%?RADIANCE" }
    for format, sign in pairs(signs) do
      assert.equal(0, rtray({ "render", scene, "-q", "-o", folder .. "/a." .. format }).status)
      assert.truthy(support.read(folder .. "/a." .. format):find(sign), format)
      assert.equal(0, rtray({ "render", scene, "-q", "-o", folder .. "/b", "--format", format }).status)
      assert.equal(support.read(folder .. "/a." .. format), support.read(folder .. "/b"), format)
      assert.equal(support.read(folder .. "/a." .. format), rtray({ "render", scene, "-q", "-o", "-", "--format", format }).out, format)
    end
  end)

  it("writes equal files for any arrangement", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local function file(...)
      assert.equal(0, rtray({ "render", scene, "-q", "-o", folder .. "/x.png", ... }).status)
      return support.read(folder .. "/x.png")
    end
    local first = file()
    for _, more in ipairs { { "--workers", "1" }, { "--workers=3", "--tile=8" }, { "--tracer", "brute" }, { "--tracer=octree", "--schedule=static" },
      { "--builder", "exact" } } do
      assert.equal(first, file(table.unpack(more)))
    end
    assert.not_equal(first, file("--samples", "3"))
    assert.not_equal(first, file("--seed", "3"))
  end)

  it("keeps the scene, settings, parameters and hash inside the file", function()
    local folder = support.folder()
    assert.equal(0, rtray({ "render", support.small(folder), "-q", "-D", "radius=0.5", "-o", folder .. "/x.png" }).status)
    assert.equal('{"radius":0.5}', png_text(folder .. "/x.png", "Parameters"))
    assert.truthy(png_text(folder .. "/x.png", "Settings"):find('"width":40,"height":30,"samples":2', 1, true))
  end)

  it("goes band by band to the same pixels", function()
    local folder = support.folder()
    local scene = support.small(folder)
    for _, format in ipairs { "png", "bmp", "tga", "hdr" } do
      local whole, bands = folder .. "/whole." .. format, folder .. "/bands." .. format
      assert.equal(0, rtray({ "render", scene, "-q", "-o", whole }).status)
      local r = rtray { "render", scene, "-o", bands, "--bands", "--band-memory", "5K" }
      assert.equal(0, r.status, r.err)
      assert.truthy(r.err:find("in bands", 1, true))
      assert.equal(0, rtray({ "compare", whole, bands }).status, format)
    end
  end)

  it("takes settings: command line over set over script over built-in", function()
    local folder = support.folder()
    local scene = support.write(folder .. "/s.lua", [[
local rt = require "rt"
rt.params { a = 1, sets = { fast = { samples = 3, width = 12 } } }
return rt.scene { settings = { width = 10, height = 11, samples = 4 }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
]])
    local function setting(name, ...)
      local r = rtray { "render", scene, "-q", "--settings", "-o", folder .. "/x.png", ... }
      assert.equal(0, r.status, r.err)
      return r.out:match("\n?" .. name .. " +(%S+ +[^\n]+)"):gsub(" +", " ")
    end
    assert.equal("4 script", (setting("samples")))
    assert.equal("3 set fast", (setting("samples", "--set", "fast")))
    assert.equal("5 command line", (setting("samples", "--set", "fast", "-n5")))
    assert.equal("12 set fast", (setting("width", "--set", "fast")))
    assert.equal("7 command line", (setting("height", "--size=9x7")))
    assert.equal("32 built in", (setting "tile"))
  end)

  it("takes -D in every form", function()
    local folder = support.folder()
    local scene = support.write(folder .. "/s.lua", [[
local rt = require "rt"
local p = rt.params { n = 1.5, name = "ball", on = true, c = { {1, 0, 0}, type = "color" }, v = {1, 2, 3}, k = { "a", choices = {"a", "b"} } }
io.write(tostring(p.n), " ", p.name, " ", tostring(p.on), " ", p.c[1], " ", p.v[3], " ", p.k, "\n")
return rt.scene { settings = { width = 4, height = 4 }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
]])
    local r = rtray { "params", scene, "-D", "n=2.25", "-Dname=a=b c", "--define=on=false", "-D", "c=0.5,1,0", "--define", "v={4,5,6}", "-Dk=b" }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find "^2%.25 a=b c false 0%.5 6[.0]* b\n", r.out)
    for text, message in pairs {
      ["n=x"] = "must be a number", ["onn=1"] = "did you mean on?", ["on=maybe"] = "true or false", ["v=1,2"] = "three numbers", ["k=c"] = "a, b",
    } do
      r = rtray { "params", scene, "-D", text }
      assert.equal(2, r.status, r.err)
      assert.truthy(r.err:find(message, 1, true), r.err)
    end
  end)

  it("prints one JSON object with --json", function()
    local folder = support.folder()
    local r = rtray { "render", support.small(folder), "--json", "-o", folder .. '/a "b".png' }
    assert.equal(0, r.status, r.err)
    local cjson = require "cjson"
    local object = cjson.decode(r.out)
    assert.equal(folder .. '/a "b".png', object.output)
    assert.equal(40, object.width)
    assert.equal(32, #object.hash)
    assert.equal(40 * 30 * 2, object.rays.camera)
    assert.equal(2, object.settings.samples)
    assert.is_true(object.seconds > 0)
  end)

  it("prints statistics with --stats", function()
    local folder = support.folder()
    local r = rtray { "render", support.small(folder), "--stats", "-q", "-o", folder .. "/x.png" }
    assert.equal(0, r.status)
    assert.truthy(r.out:find "camera +2,400 rays")
    assert.truthy(r.out:find "worker 0 busy")
    assert.falsy(r.out:find "\nnodes" or r.out:find "\ntests") -- not counted
    assert.equal("", r.err)
    r = rtray { "render", support.small(folder), "--stats", "-q", "--integrator", "cost", "-o", folder .. "/x.png" }
    assert.truthy(r.out:find "\nnodes +[%d,]+ visited.-\ntests +[%d,]+ primitives", r.out)
  end)

  it("writes progress as JSON lines, or none", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local r = rtray { "render", scene, "--progress", "json", "-q", "-o", folder .. "/x.png", "--size", "100x75", "-n", "8" }
    assert.equal(0, r.status)
    assert.equal("", r.err) -- quiet is stronger
    r = rtray { "render", scene, "--progress", "json", "-o", folder .. "/x.png", "--size", "400x300", "-n", "64", "-j", "1", "--limit", "time=5s" }
    local cjson, lines = require "cjson", 0
    for line in r.err:gmatch "[^\n]+" do
      if line:sub(1, 1) == "{" then
        local event = cjson.decode(line)
        assert.equal("progress", event.event)
        assert.is_true(event.done >= 0 and event.done <= 1)
        lines = lines + 1
      end
    end
    assert.is_true(lines >= 1, r.err)
  end)

  it("shows one line fitted to the terminal, plain without one", function()
    if support.shell("command -v script").status ~= 0 then
      return
    end
    local folder = support.folder()
    local scene = support.small(folder)
    local function line(samples)
      return support.quote("stty cols 50; " .. support.command { "render", scene, "--size", "400x300", "-n", samples, "-o", folder .. "/x.png",
        "--limit", "time=5s" }) -- so long do sanitizers and slow machines need for a line or two
    end
    local r = support.shell("TERM=xterm script -qec " .. line "384" .. " /dev/null")
    local longest = 0
    for part in r.out:gmatch "\r([^\r\27]+)\27%[K" do
      longest = math.max(longest, #part)
    end
    assert.is_true(longest > 20 and longest < 50, r.out)
    r = support.shell("TERM=dumb script -qec " .. line "16" .. " /dev/null")
    assert.falsy(r.out:find "\27")
  end)

  it("refuses a bad output before it renders", function()
    local folder = support.folder()
    local scene = support.write(folder .. "/x.lua", "error 'the script ran'")
    for path, message in pairs {
      [folder .. "/no/x.png"] = "cannot be used: No such file or directory", [folder] = "names no image format",
      [scene .. "/x.png"] = "is a file", ["/proc/x.png"] = "/proc",
    } do
      local r = rtray { "render", scene, "-o", path }
      assert.is_true(r.status == 1 or r.status == 2)
      if path ~= "/proc/x.png" or r.err:find("cannot be written", 1, true) then
        assert.truthy(r.err:find(message, 1, true), r.err)
        assert.falsy(r.err:find("the script ran", 1, true))
      end
    end
    os.execute("mkdir " .. support.quote(folder .. "/d.png"))
    local r = rtray { "render", scene, "-o", folder .. "/d.png" }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("is a folder", 1, true))
  end)

  it("keeps what a script prints out of an image or JSON on standard output", function()
    local folder = support.folder()
    local scene = support.write(folder .. "/talk.lua", [[
      local rt = require "rt"
      print("said", 1, nil)
      io.write "written\n"
      return rt.scene { ambient = {1, 1, 1}, rt.sphere { center = {0, 0, 0}, radius = 1 } }
    ]])
    local r = rtray { "render", scene, "-q", "--size", "8x8", "-o", "-" }
    assert.equal(0, r.status, r.err)
    assert.equal("\137PNG", r.out:sub(1, 4))
    assert.equal("said\t1\tnil\nwritten\n", r.err)
    r = rtray { "info", scene, "--json" }
    assert.equal("{", r.out:sub(1, 1))
    assert.truthy(r.err:find("said\t1\tnil\nwritten\n", 1, true))
    r = rtray { "render", scene, "-q", "--size", "8x8", "-o", folder .. "/x.png" }
    assert.equal("said\t1\tnil\nwritten\n", r.out)
  end)

  it("says when the disk is full, and leaves the old file", function()
    local scene = support.small()
    local r = rtray { "render", scene, "-o", "/dev/full", "--format", "png" }
    assert.equal(3, r.status, r.err)
    assert.truthy(r.err:find("the disk is full", 1, true))
    assert.equal(3, rtray({ "render", scene, "-o", "-", "-q", tail = ">/dev/full" }).status)
    assert.equal(3, rtray({ "render", scene, "-o", "/dev/null", "--format", "png", "--json", tail = ">/dev/full" }).status)
    if support.shell("command -v bash").status == 0 then -- a limit of file size stands for a full disk that keeps an old file
      local folder = support.folder()
      support.write(folder .. "/x.bmp", "old")
      local line = "ulimit -f 1; trap '' XFSZ; " .. support.command { "render", scene, "-o", folder .. "/x.bmp" }
      r = support.shell("bash -c " .. support.quote(line))
      assert.equal(3, r.status, r.err)
      assert.equal("old", support.read(folder .. "/x.bmp"))
      assert.equal("x.bmp\n", support.shell("ls " .. support.quote(folder)).out)
    end
  end)

  it("says when the memory limit is too small", function()
    local folder = support.folder()
    local r = rtray { "render", support.small(folder), "--size", "2000x2000", "--memory-limit", "1M", "-o", folder .. "/x.jpg" }
    assert.equal(3, r.status)
    assert.truthy(r.err:find("1048576", 1, true), r.err)
    assert.truthy(r.err:find(".png, .bmp, .tga and .hdr take one band after the other", 1, true), r.err)
    r = rtray { "render", support.small(folder), "--memory-limit", "1K", "-j", "2", "-o", folder .. "/x.png" } -- in bands of a row already
    assert.equal(3, r.status)
    assert.truthy(r.err:find "40 x 1 pixels with 2 workers need %d+ bytes; memory_limit is 1024; fewer workers take less\n$", r.err)
  end)

  it("warns of a picture that will be black, and of views that a format cuts off", function()
    local folder = support.folder()
    local function err(lines, ...)
      local path = support.write(folder .. "/s.lua", "local rt = require 'rt'\nlocal ball = { center = {0, 0, 0}, radius = 1 }\nreturn rt.scene { "
        .. "settings = { width = 8, height = 6, samples = 1 }, " .. lines .. " }")
      local r = rtray { "render", path, "-o", folder .. "/x.png", ... }
      assert.equal(0, r.status, r.err)
      return r.err
    end
    local ball, none = "rt.sphere(ball)", "the picture will be black"
    assert.truthy(err("", "-q"):find "^rtray render: the picture will be black: the scene is empty\n$")
    assert.truthy(err(ball, "-q"):find "^rtray render: the picture will be black: the scene has no light; [^\n]*\n$")
    assert.truthy(err("rt.instance { " .. ball .. " }"):find(none, 1, true))
    assert.truthy(err("ambient = {0, 0, 0}, background = rt.vec(0, 0, 0), " .. ball, "--integrator", "path"):find(none, 1, true))
    for _, lit in ipairs { "ambient = {0.1, 0.1, 0.1}, " .. ball, "background = {0, 0, 1}", "background_top = {0, 0, 1}, " .. ball,
      "rt.point_light { at = {0, 5, 0} }, " .. ball, "rt.sphere { center = {0, 0, 0}, radius = 1, material = rt.emissive { emission = {1, 1, 1} } }",
      "background = rt.image { width = 2, height = 2 }" } do
      assert.equal("", err(lit, "-q"), lit)
    end
    assert.equal("", err(ball, "-q", "--integrator", "ao"))
    for _, view in ipairs { "depth", "steps" } do
      assert.truthy(err(ball, "--integrator", view):find "above 1 are white in this format; %.hdr keeps them", view)
      assert.falsy(err(ball, "--integrator", view, "--format", "hdr"):find("above 1", 1, true))
    end
    assert.equal("", err(ball, "--integrator", "depth", "-q"))
  end)

  it("keeps a preview up to date", function()
    local folder = support.folder()
    local r = rtray { "render", support.small(folder), "-q", "-o", folder .. "/x.png", "--preview", folder .. "/p.png" }
    assert.equal(0, r.status, r.err)
    assert.equal(0, rtray({ "compare", folder .. "/x.png", folder .. "/p.png" }).status)
    assert.equal(2, rtray({ "render", support.small(folder), "--preview", folder .. "/p" }).status)
  end)

  it("renders a part of the image", function()
    local folder = support.folder()
    local r = rtray { "render", support.small(folder), "--crop", "5,6,7,8", "-o", folder .. "/x.png" }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.err:find(": 7x8, ", 1, true), r.err)
    assert.equal(1, rtray({ "render", support.small(folder), "--crop", "35,6,7,8", "-o", folder .. "/x.png" }).status)
  end)

  it("takes names with blanks, quotes, newlines and bytes that are no UTF-8", function()
    for _, name in ipairs { "a b", "it's", 'say "x"', "new\nline", "\255\254", "ü", "-o", "$(false)", "a%d", "?x" } do
      local folder = support.folder() .. "/in " .. name
      assert(os.execute("mkdir -p " .. support.quote(folder)))
      support.small(folder, name .. ".lua")
      local r = rtray { "render", "--", name .. ".lua", cwd = folder }
      if name:sub(1, 1) == "-" then -- `--` ends the options
        assert.equal(0, r.status, r.err)
      else
        assert.equal(0, r.status, r.err)
        r = rtray { "render", name .. ".lua", "-o", folder .. "/" .. name .. ".png", "-q", cwd = "/" , }
        assert.equal(1, r.status) -- names are relative to where the program runs
        r = rtray { "render", folder .. "/" .. name .. ".lua", "-o", folder .. "/" .. name .. ".bmp", cwd = "/" }
        assert.equal(0, r.status, r.err)
        assert.is_true(support.exists(folder .. "/" .. name .. ".bmp"))
      end
      assert.is_true(support.exists(folder .. "/" .. name .. ".png"))
    end
  end)

  it("gives the same picture in a German locale", function()
    local folder = support.folder()
    local scene = support.small(folder)
    assert.equal(0, rtray({ "render", scene, "-q", "-D", "radius=1.5", "-o", folder .. "/a.png" }).status)
    local r = rtray { "render", scene, "-q", "-D", "radius=1.5", "-o", folder .. "/b.png", env = "LC_ALL=de_DE.UTF-8 LC_NUMERIC=de_DE.UTF-8 " }
    assert.equal(0, r.status, r.err)
    assert.equal(support.read(folder .. "/a.png"), support.read(folder .. "/b.png"))
  end)

  it("runs scripts with the same random numbers each time, other ones with another seed", function()
    local folder = support.folder()
    local scene = support.write(folder .. "/r.lua", [[
local rt = require "rt"
io.write(math.random(1000000), "\n")
return rt.scene { settings = { width = 4, height = 4 }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
]])
    local function number(...)
      return rtray({ "render", scene, "-q", "-o", folder .. "/x.png", ... }).out
    end
    local first = number()
    assert.truthy(first:find "^%d+\n$")
    assert.equal(first, number())
    assert.not_equal(first, number("--seed", "1"))
    assert.equal(number("--seed=0x1"), number("--seed", "1"))
  end)

  it("renders a frame of an animation", function()
    local folder = support.folder()
    local script = support.write(folder .. "/a.lua", [[
local rt = require "rt"
return rt.animation { frames = 8, scene = function(t, frame)
  local radius = frame == 7 and 0 or 1
  return rt.scene { settings = { size = {16, 12}, samples = 1 }, rt.point_light { at = {4, 4, 4} },
    rt.sphere { center = {t, 0, 0}, radius = radius } }
end }]])
    local function render(...)
      return rtray { "render", script, "-o", folder .. "/x.png", ... }
    end
    assert.equal(0, render("--frame", "6").status)
    local sixth = support.read(folder .. "/x.png")
    assert.equal(0, render().status)
    local first = support.read(folder .. "/x.png")
    assert.not_equal(first, sixth)
    assert.equal(0, render("--frame", "0").status)
    assert.equal(first, support.read(folder .. "/x.png"))
    local r = render("--frame=7")
    assert.equal(1, r.status)
    assert.truthy(r.err:find("a.lua:5: rt.sphere: radius must be greater than 0; got 0 (frame 7, t = 1)", 1, true), r.err)
    r = render("--frame=8")
    assert.equal(2, r.status)
    assert.truthy(r.err:find("--frame 8: the animation has 8 frames, 0 to 7", 1, true), r.err)
    r = rtray { "render", support.small(folder), "--frame=0" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("is a single picture", 1, true), r.err)
  end)
end)
