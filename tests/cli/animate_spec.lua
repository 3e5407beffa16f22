-- rtray animate: the frames, what is taken over of them, and every bad input with its sentence and status.

local support = require "support"
local animation = require "animation"
local rtray, quote = support.rtray, support.quote
local animate, script, list, hash_of, counts, has = animation.animate, animation.script, animation.list, animation.hash_of,
  animation.counts, animation.has

describe("animate", function()
  it("writes a file a frame, the same as render --frame does", function()
    local folder = support.folder()
    local path = script(folder)
    local r = animate(path, "-o", folder .. "/img/f%03d.png")
    assert.equal(0, r.status, r.err)
    assert.equal("f%03d.png.state f000.png f001.png f002.png f003.png f004.png ", list(folder .. "/img"))
    assert.truthy(r.err:find "f%%03d%.png: 5 frames %(0%.416667 s at 12 a second%), 5 rendered, ", r.err)
    for frame = 0, 4 do
      assert.equal(0, rtray({ "render", path, "--frame", tostring(frame), "-q", "-o", folder .. "/x.png" }).status)
      assert.equal(support.read(folder .. "/x.png"), support.read(folder .. ("/img/f%03d.png"):format(frame)))
    end
    assert.not_equal(hash_of(folder .. "/img/f000.png"), hash_of(folder .. "/img/f001.png"))
  end)

  it("blurs what moves while the shutter is open", function()
    local function hash(shutter)
      local folder = support.folder()
      local path = support.write(folder .. "/a.lua", ([[
local rt = require "rt"
return rt.animation { frames = 2%s, scene = function(t)
  return rt.scene { settings = { size = {16, 12}, samples = 8 }, camera = rt.camera { eye = {0, 0, 6}, look_at = {0, 0, 0} },
    rt.point_light { at = {4, 4, 4} },
    rt.instance { rt.sphere { center = {0, 0, 0}, radius = 1 }, transform = rt.translate(2 * t, 0, 0), name = "ball" } }
end }]]):format(shutter))
      local r = animate(path, "-q", "-o", folder .. "/%d.png")
      assert.equal(0, r.status, r.err)
      return hash_of(folder .. "/0.png")
    end
    assert.equal(hash "", hash "")
    assert.not_equal(hash "", hash ", shutter = 0.5")
    assert.not_equal(hash ", shutter = 1", hash ", shutter = 0.5")
  end)

  it("renders ranges of frames, each frame once", function()
    local folder = support.folder()
    local path = script(folder, { frames = 12 })
    for range, files in pairs { ["1:3"] = "1 2 3 ", ["0:11:5"] = "0 10 5 ", ["7,9"] = "7 9 ", ["2,1:3,2"] = "1 2 3 ", ["11"] = "11 " } do
      local to = support.folder()
      local r = animate(path, "-q", "--frames", range, "-o", to .. "/%d.png")
      assert.equal(0, r.status, r.err)
      assert.equal("%d.png.state " .. files, (list(to):gsub("(%d+)%.png ", "%1 ")), range)
    end
  end)

  it("makes the same bits one frame at a time and several at once", function()
    local folder = support.folder()
    local path = script(folder, { frames = 8, size = "40, 30" })
    for i, more in ipairs { { "--at-once", "1" }, { "--at-once", "3" }, { "--at-once=8", "--workers=1" }, { "--workers=3" } } do
      assert.equal(0, animate(path, "-q", "-o", ("%s/%d-%%d.png"):format(folder, i), table.unpack(more)).status)
      for frame = 0, 7 do
        assert.equal(support.read(("%s/1-%d.png"):format(folder, frame)), support.read(("%s/%d-%d.png"):format(folder, i, frame)))
      end
    end
  end)

  it("takes over what is finished by what it describes", function()
    local folder = support.folder()
    local to = folder .. "/%d.png"
    local function go(options, ...)
      local r = animate(script(folder, options), "-o", to, ...)
      assert.equal(0, r.status, r.err)
      return counts(r)
    end
    assert.same({ 5, 0 }, { go() })
    assert.same({ 0, 5 }, { go() })
    assert.same({ 0, 5 }, { go { head = "-- another text, the same description", body = "local unused = t" } })
    assert.same({ 2, 3 }, { go { material = "frame >= 3 and rt.classic { color = {1, 0, 0} } or nil" } })
    assert.same({ 2, 3 }, { go() })
    assert.same({ 5, 0 }, { go(nil, "--seed", "7") })
    assert.same({ 5, 0 }, { go() })
    assert.same({ 5, 0 }, { go(nil, "-s", "17x12") })
    assert.same({ 5, 0 }, { go(nil, "--tone", "filmic") })
    assert.same({ 5, 0 }, { go() })
    assert.same({ 0, 5 }, { go(nil, "--tracer", "brute", "--workers", "1", "--tile", "8") }) -- no bit of the picture depends on these
    assert.same({ 0, 6 }, { go { frames = 6, body = "t = frame / 4" } } and { 0, 6 })
  end)

  it("renders of an edited material only the frames whose rays met it, though all describe it", function()
    local folder = support.folder()
    local function go(color, to)
      local path = support.write(folder .. "/m.lua", ([[
local rt = require "rt"
return rt.animation { frames = 12, fps = 12, scene = function(t, frame)
  return rt.scene {
    settings = { size = {16, 12}, samples = 2 }, camera = rt.camera { eye = {0, 0, 6}, look_at = {0, 0, 0} }, ambient = {0.3, 0.3, 0.3},
    rt.point_light { at = {4, 4, 4} }, rt.sphere { center = {-1, 0, 0}, radius = 1 },
    rt.sphere { center = {1.2, 0, frame %% 4 == 1 and 0 or 40}, radius = 1, material = rt.classic { color = %s } }, -- else behind the camera
  }
end }]]):format(color))
      local r = animate(path, "-o", folder .. "/" .. to)
      assert.equal(0, r.status, r.err)
      return { counts(r) }
    end
    assert.same({ 12, 0 }, go("{1, 0, 0}", "a%02d.png"))
    assert.same({ 3, 9 }, go("{0, 1, 0}", "a%02d.png"))
    assert.same({ 0, 12 }, go("{0, 1, 0}", "a%02d.png"))
    assert.same({ 12, 0 }, go("{0, 1, 0}", "fresh%02d.png"))
    for i = 0, 11 do
      assert.equal(hash_of(("%s/fresh%02d.png"):format(folder, i)), hash_of(("%s/a%02d.png"):format(folder, i)))
    end
  end)

  it("renders again when a texture's bytes change under its name", function()
    local folder = support.folder()
    local function texture(byte)
      support.write(folder .. "/t.tga", "\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\24\0" .. string.char(byte, byte, byte))
    end
    local options = { material = 'rt.classic { texture = "t.tga" }' }
    texture(200)
    assert.same({ 5, 0 }, { counts(animate(script(folder, options), "-o", folder .. "/%d.png")) })
    assert.same({ 0, 5 }, { counts(animate(script(folder, options), "-o", folder .. "/%d.png")) })
    texture(90)
    assert.same({ 5, 0 }, { counts(animate(script(folder, options), "-o", folder .. "/%d.png")) })
  end)

  it("renders damaged frames again, and says so", function()
    local folder = support.folder()
    local path = script(folder)
    local to = folder .. "/%d.png"
    assert.equal(0, animate(path, "-o", to).status)
    local whole = {}
    for frame = 0, 4 do
      whole[frame] = support.read(("%s/%d.png"):format(folder, frame))
    end
    support.write(folder .. "/0.png", whole[0]:sub(1, -20))
    support.write(folder .. "/1.png", whole[1]:sub(1, -21) .. "x" .. whole[1]:sub(-19))
    os.remove(folder .. "/2.png")
    local state = folder .. "/%d.png.state/000003"
    support.write(state, support.read(state):sub(1, -30)) -- a record that was cut
    local r = animate(path, "-o", to)
    assert.equal(0, r.status, r.err)
    has(r, "frame 0: '" .. folder .. "/0.png' was cut off; it is rendered again")
    has(r, "/1.png' has changed or is damaged; it is rendered again")
    has(r, "/2.png' is gone; it is rendered again")
    assert.same({ 4, 1 }, { counts(r) })
    for frame = 0, 4 do
      assert.equal(whole[frame], support.read(("%s/%d.png"):format(folder, frame)))
    end
  end)

  it("tells programs what it did", function()
    local folder = support.folder()
    local path = script(folder)
    local r = animate(path, "--json", "--progress", "json", "--frames", "0:1", "-o", folder .. "/%d.png")
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find('"count":2,"rendered":2,"taken_over":0,"by_others":0,"failed":0', 1, true), r.out)
    assert.truthy(r.out:find('"frame":1,"state":"rendered","file":"' .. folder .. '/1.png","hash":"' .. hash_of(folder .. "/1.png"), 1, true), r.out)
    assert.equal(1, select(2, r.out:gsub("\n", "")))
    assert.equal(2, select(2, r.err:gsub('"event":"frame"', "")))
    r = animate(path, "--json", "--frames", "0:1", "-o", folder .. "/%d.png")
    assert.truthy(r.out:find('"frame":0,"state":"taken over"', 1, true), r.out)
    assert.truthy(animate(path, "--stats", "-q", "-o", folder .. "/%d.png").out:find "frames +3 rendered, 2 taken over")
  end)
end)

describe("trees of an animation", function()
  local function built(things)
    local folder = support.folder()
    local path = support.write(folder .. "/a.lua", ([[
local rt = require "rt"
local balls = {}
for i = 1, 300 do
  balls[i] = rt.sphere { center = {rt.random("x", i), rt.random("y", i), rt.random("z", i)}, radius = 0.02 }
end
return rt.animation { frames = 3, scene = function(t)
  return rt.scene {
    settings = { size = {16, 12}, samples = 1 }, camera = rt.orbit { radius = 3 }:camera(t), rt.directional_light { direction = {0, -1, 0} }, %%s
  }
end }]]):gsub("%%%%s", things))
    local r = animate(path, "--stats", "--at-once", "1", "-o", folder .. "/%d.png")
    assert.equal(0, r.status, r.err)
    local numbers = {}
    for trees, top in r.out:gmatch "frame %d +(%d+) trees built, (%d+) of the top level" do
      numbers[#numbers + 1] = trees .. "+" .. top
    end
    return numbers
  end

  it("are built once when only the camera moves", function()
    local n = built "balls"
    assert.equal("1+", n[1]:sub(1, 2))
    assert.same({ n[1], "0+0", "0+0" }, n)
  end)

  it("are built at the top alone when instances move", function()
    local group = "rt.instance { rt.group { balls }, transform = rt.translate(%d * t, 0, %d) }"
    local things = {}
    for i = 1, 6 do
      things[i] = group:format(i, 3 * i)
    end
    local n = built(table.concat(things, ", "))
    assert.same({ "1+1", "0+1", "0+1" }, n)
  end)
end)

describe("a bad input of animate", function()
  local folder = support.folder()
  local path = script(folder)

  local function refused(status, sentence, ...)
    local r = animate(path, ...)
    assert.equal(status, r.status, r.err)
    has(r, sentence)
  end

  it("has its sentence: the frames", function()
    local function range(sentence, text)
      refused(2, sentence, "-o", folder .. "/%d.png", "--frames", text)
    end
    range("--frames '5:3': '5:3' is empty: it begins at 5 and ends at 3", "5:3")
    range("A, A:B or A:B:STEP with whole numbers up to 999999 is expected, several with commas, as in 0:119 or 0:119:2 or 7,9; "
      .. "frames count from 0", "-1")
    range("; frames count from 0", "3:-1")
    range("--frames: there is no frame 5; the animation has 5 frames, 0 to 4", "5")
    range("--frames: there is no frame 9; the animation has 5 frames, 0 to 4", "2:9")
    range("the step of '0:4:0' is 0; it must be at least 1", "0:4:0")
    for _, text in ipairs { "", "a", "1,,2", "1:2:3:4", ":", "1:", "0:4:", "1.5", "99999999999999999999" } do
      range("--frames '" .. text .. "': ", text)
    end
  end)

  it("has its sentence: the output", function()
    refused(2, "it has no place for the frame's number; write %d or %04d where it goes, as in frame%04d.png", "-o", folder .. "/x.png")
    refused(2, "it has more than one place for the frame's number; one %d is expected", "-o", folder .. "/%d-%d.png")
    refused(2, "'%s' stands in it; %d or %0Nd (as %04d) takes the frame's number, %% is a percent sign", "-o", folder .. "/%s.png")
    refused(2, "'%4' stands in it", "-o", folder .. "/%4d.png")
    refused(2, "its ending names no film (.mp4, .webm, .gif, .webp, .apng, .mkv, .mov) and, as a pattern for images, it has no place", "-o",
      folder .. "/x.avi")
    refused(2, "the ending of '" .. folder .. "/%d.xyz' names no image format", "-o", folder .. "/%d.xyz")
    refused(2, "which standard output cannot be", "-o", "-")
    refused(2, "a film's frames are kept as PNG", "-o", folder .. "/x.mp4", "--format", "jpg")
    refused(2, "the frame's number stands in a folder's name", "-o", folder .. "/%d/x.png")
    refused(1, "cannot be used: No such file or directory", "-o", "/nonexistent/folder/%d.png")
    support.write(folder .. "/file", "x")
    refused(1, "is a file", "-o", folder .. "/file/%d.png")
    os.execute("mkdir -p " .. quote(folder .. "/dir.mp4"))
    refused(1, "is a folder; name a file in it", "-o", folder .. "/dir.mp4")
    refused(1, "cannot be", "-o", "/proc/%d.png")
    refused(1, ("the output '%s/%%d.png' cannot be written: the folder '%s' is a file"):format(path, path), "-o", path .. "/%d.png")
    assert.equal("a.lua dir.mp4 file ", list(folder))
  end)

  it("has its sentence: the scene", function()
    local r = rtray { "animate", support.small(folder), "-o", folder .. "/%d.png" }
    assert.equal(1, r.status)
    has(r, "small.lua: the script returns a scene, not an animation; `return rt.animation { frames = ..., scene = function(t) ... end }` makes one")
    assert.equal(1, rtray({ "animate", folder .. "/none.lua", "-o", folder .. "/%d.png" }).status)
    r = rtray { "animate", path, "-D", "x=1", "-o", folder .. "/%d.png" }
    assert.equal(2, r.status, r.err)
  end)

  local BAD = { frames = 10, body = "if frame == 7 then local x = nil + 1 end" }

  it("that is a mistake at frame 7 ends there; what is finished is kept", function()
    local to = support.folder()
    local bad = script(to, BAD)
    local r = animate(bad, "-o", to .. "/%d.png", "--at-once", "1")
    assert.equal(1, r.status, r.err)
    assert.truthy(r.err:find "a%.lua:4: attempt to perform arithmetic on a nil value %(frame 7, t = 0%.777778%)\n", r.err)
    has(r, "7 of 10 frames are finished in '" .. to .. "'; the same command goes on from there")
    assert.equal("%d.png.state 0.png 1.png 2.png 3.png 4.png 5.png 6.png a.lua ", list(to))
    r = animate(bad, "-o", to .. "/%d.png", "--keep-going")
    assert.equal(1, r.status, r.err)
    has(r, "2 rendered, 7 taken over, 1 failed")
    has(r, "1 frame failed, the first of them frame 7")
    assert.is_true(support.exists(to .. "/9.png"))
    assert.same({ 1, 9 }, { counts(animate(script(to, { frames = 10 }), "-o", to .. "/%d.png")) })
  end)

  it("makes no film with a frame missing", function()
    local to = support.folder()
    local r = animate(script(to, BAD), "-o", to .. "/x.mp4", "--keep-going")
    assert.equal(1, r.status, r.err)
    has(r, "the film is not made")
    assert.is_false(support.exists(to .. "/x.mp4"))
  end)

  it("that is a full disk keeps what is finished", function()
    local to = support.folder()
    local big = script(to, { frames = 3, size = "290, 270",
      body = "if frame == 0 then return { settings = { size = {2, 2}, samples = 1 } } end" })
    local line = ("trap '' XFSZ; ulimit -f 2; exec %s"):format(support.command { "animate", big, "-o", to .. "/%d.png", "--at-once", "1" })
    local r = support.shell("bash -c " .. quote(line))
    assert.equal(3, r.status, r.err)
    has(r, "frame 1: " .. to .. "/1.png: cannot write it: the file is too large (errno 27)")
    has(r, "1 of 3 frames is finished in")
    assert.equal("%d.png.state 0.png a.lua ", list(to))
    assert.equal("000000 ", (list(to .. "/%d.png.state"):gsub("%S+checkpoint ", ""))) -- a render that is done but could not be saved waits there
    assert.same({ 2, 1 }, { counts(animate(big, "-o", to .. "/%d.png")) })
  end)
end)
