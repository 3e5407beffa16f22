local support = require "support"
local rtray = support.rtray

local CORPUS = support.source .. "/tests/fuzz/corpus/sdf/"

local function corpus(prefix)
  local list = {}
  for name in support.shell("ls " .. support.quote(CORPUS)).out:gmatch "[^\n]+" do
    if name:find("^" .. prefix) then
      list[#list + 1] = name
    end
  end
  return list
end

describe("the old scene definition files", function()
  it("that are good render, and convert to scripts that render the same bits", function()
    local files = corpus "good_"
    assert.is_true(#files >= 10)
    local folder = support.folder()
    for _, texture in ipairs { "it's here.jpg", 'a "b", c#d.png', "O'Brien#1.gif", "12" } do
      support.write(folder .. "/" .. texture, support.read(support.source .. "/scenes/flower.jpg"))
    end
    for _, name in ipairs(files) do
      local path = support.write(folder .. "/" .. name, support.read(CORPUS .. name))
      local a, b = path .. ".a.png", path .. ".b.png"
      local r = rtray { "render", path, "--size", "24x18", "-o", a, "-q" }
      assert.equal(0, r.status, name .. ": " .. r.err)
      r = rtray { "convert", path, "-o", path .. ".lua" }
      assert.equal(0, r.status, name .. ": " .. r.err)
      r = rtray { "render", path .. ".lua", "--size", "24x18", "-o", b, "-q" }
      assert.equal(0, r.status, name .. ": " .. r.err)
      assert.equal(0, rtray({ "compare", a, b }).status, name)
    end
  end)

  it("that are bad are refused with file, line and the sentence that their first line promises", function()
    local files = corpus "bad_"
    assert.is_true(#files >= 40)
    for _, name in ipairs(files) do
      local text = support.read(CORPUS .. name)
      local promised = text:match "^# (%d+: [^\n]*)" or "1: a scene definition begins with BEGIN_SCENE, but the end of the file stands here"
      local r = rtray { "render", CORPUS .. name, "-o", "never.png" }
      assert.equal(1, r.status, name)
      assert.equal(("rtray render: %s%s:%s\n"):format(CORPUS, name, promised), r.err)
      r = rtray { "convert", CORPUS .. name, "-o", "-" }
      assert.equal(1, r.status, name)
      assert.is_true(r.out == "" or r.out:find "^%-%- Made from" ~= nil)
      assert.equal(("rtray convert: %s%s:%s\n"):format(CORPUS, name, promised), r.err)
    end
  end)

  it("give the paper's scene in three spellings the same pixels, at any size", function()
    local folder = support.folder()
    local scenes = support.source .. "/scenes/"
    assert.equal(0, rtray({ "convert", scenes .. "paper.sdf", "-o", folder .. "/paper2.lua" }).status)
    for _, size in ipairs { "50x35", "33x47", "100x70" } do
      local files = { scenes .. "paper.lua", scenes .. "paper.sdf", folder .. "/paper2.lua" }
      for i, path in ipairs(files) do
        local r = rtray { "render", path, "--allow-read", scenes, "--size", size, "-q", "-o", ("%s/%s_%d.hdr"):format(folder, size, i) }
        assert.equal(0, r.status, r.err)
      end
      for i = 2, 3 do
        local r = rtray { "compare", ("%s/%s_1.hdr"):format(folder, size), ("%s/%s_%d.hdr"):format(folder, size, i) }
        assert.equal(0, r.status, r.out)
      end
    end
  end)

  it("have a 1000x700 default, as paper.lua does", function()
    local r = rtray { "render", support.source .. "/scenes/paper.sdf", "--settings", "--crop", "0,0,1,1", "-q", "-o", support.folder() .. "/x.png" }
    assert.truthy(r.out:find "width +1000 +script")
    assert.truthy(r.out:find "height +700 +script")
    assert.truthy(r.out:find "samples +4 +script")
  end)

  it("name a texture that is missing", function()
    local folder = support.folder()
    local path = support.write(folder .. "/x.sdf", "BEGIN_SCENE VIEWPOINT 0,0,5 END_SCENE\nPLANE CENTER 0,0,0 NORMAL 0,0,1 TEXTURE gone.jpg\n")
    local r = rtray { "render", path, "-o", folder .. "/x.png" }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("gone.jpg", 1, true), r.err)
    assert.falsy(support.exists(folder .. "/x.png"))
  end)

  it("keep numbers bit for bit in a German locale", function()
    local out = rtray { "convert", support.source .. "/scenes/paper.sdf", "-o", "-" }.out
    assert.truthy(out:find("ambient = {0.2, 0.2, 0.2}", 1, true))
    assert.equal(out, rtray { "convert", support.source .. "/scenes/paper.sdf", "-o", "-", env = "LC_ALL=de_DE.UTF-8 LANG=de_DE.UTF-8 " }.out)
  end)

  it("are read in one pass: ten times the objects take about ten times as long", function()
    local folder = support.folder()
    local function seconds(count)
      local parts = { "BEGIN_SCENE VIEWPOINT 0,0,5 LIGHTPOINT 5,5,5 END_SCENE\n" }
      for i = 1, count do
        parts[#parts + 1] = ("SPHERE\n CENTER %d,0,0\n RADIUS 1\n COLOR 1,0.5,0\n"):format(i)
      end
      local path = support.write(folder .. "/" .. count .. ".sdf", table.concat(parts))
      local r = support.shell("bash -c " .. support.quote("time -p " .. support.command { "convert", path, "-o", "/dev/null" }))
      assert.equal(0, r.status, r.err)
      return tonumber(r.err:match "user (%S+)")
    end
    local few, many = seconds(5000), seconds(50000)
    assert.is_true(many < 30 * math.max(few, 0.05), ("%g s for 5000, %g s for 50000"):format(few, many))
  end)
end)

describe("convert", function()
  it("keeps an existing script unless told otherwise", function()
    local folder = support.folder()
    local path = support.write(folder .. "/a.sdf", "BEGIN_SCENE VIEWPOINT 0,0,5 END_SCENE")
    for _, more in ipairs { {}, { "-o", folder .. "/a.lua" } } do
      support.write(folder .. "/a.lua", "mine")
      local r = rtray { "convert", path, table.unpack(more) }
      assert.equal(1, r.status)
      assert.truthy(r.err:find("--force", 1, true))
      assert.equal("mine", support.read(folder .. "/a.lua"))
      assert.equal(0, rtray({ "convert", path, "--force", table.unpack(more) }).status)
      assert.truthy(support.read(folder .. "/a.lua"):find("return rt.scene", 1, true))
    end
  end)

  it("never overwrites its input", function()
    local folder = support.folder()
    local text = "BEGIN_SCENE VIEWPOINT 0,0,5 END_SCENE"
    local path = support.write(folder .. "/a.sdf", text)
    local r = rtray { "convert", path, "-o", folder .. "/./a.sdf", "--force" }
    assert.equal(2, r.status)
    assert.equal(text, support.read(path))
  end)

  it("names textures as seen from the script's folder", function()
    local folder = support.folder()
    os.execute("mkdir " .. support.quote(folder .. "/in") .. " " .. support.quote(folder .. "/out"))
    local path = support.write(folder .. "/in/a.sdf", "BEGIN_SCENE VIEWPOINT 0,0,5 END_SCENE PLANE CENTER 0,0,0 NORMAL 0,0,1 TEXTURE t.jpg "
      .. "PLANE CENTER 0,0,1 NORMAL 0,0,1 TEXTURE /abs/t.jpg")
    assert.equal(0, rtray({ "convert", path, "-o", folder .. "/out/a.lua" }).status)
    local text = support.read(folder .. "/out/a.lua")
    assert.truthy(text:find('texture = "../in/t.jpg"', 1, true), text)
    assert.truthy(text:find('texture = "/abs/t.jpg"', 1, true), text)
    assert.truthy(rtray({ "convert", path, "-o", "-" }).out:find('texture = "t.jpg"', 1, true))
  end)

  it("leaves the old file, and nothing else, at a fault late in the input", function()
    local folder = support.folder()
    local path = support.write(support.folder() .. "/a.sdf", "BEGIN_SCENE VIEWPOINT 0,0,5 END_SCENE "
      .. ("SPHERE CENTER 0,0,0 RADIUS 1 "):rep(20000) .. "SPHERE")
    support.write(folder .. "/a.lua", "old")
    assert.equal(1, rtray({ "convert", path, "-o", folder .. "/a.lua", "--force" }).status)
    assert.equal(1, rtray({ "convert", path, "-o", folder .. "/b.lua" }).status)
    assert.equal("old", support.read(folder .. "/a.lua"))
    assert.equal("a.lua\n", support.shell("ls " .. support.quote(folder)).out)
  end)

  it("says when the disk is full", function()
    local path = support.source .. "/scenes/paper.sdf"
    assert.equal(3, rtray({ "convert", path, "-o", "/dev/full" }).status)
    assert.equal(3, rtray({ "convert", path, "-o", "-", tail = ">/dev/full" }).status)
  end)
end)
