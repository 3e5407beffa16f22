-- rtray animate: frames, films, going on after any end, sharing the work, and every bad input with its sentence and status.

local support = require "support"
local rtray, quote = support.rtray, support.quote

local has_ffmpeg = support.shell("ffmpeg -version").status == 0
local with_ffmpeg = has_ffmpeg and it or pending

-- An animation of tiny frames; `body` may use t and frame.
local function script(folder, options)
  options = options or {}
  return support.write(folder .. "/" .. (options.name or "a.lua"), ([[
local rt = require "rt"
%s
return rt.animation { frames = %d, fps = 12%s, scene = function(t, frame, seconds)
  %s
  return rt.scene {
    settings = { size = {%s}, samples = %d }, camera = rt.camera { eye = {0, 0, 6}, look_at = {0, 0, 0} }, ambient = {0.3, 0.3, 0.3},
    rt.point_light { at = {4, 4, 4} }, rt.sphere { center = {2 * t - 1, 0, 0}, radius = 1, material = %s },
  }
end }]]):format(options.head or "", options.frames or 5, options.more or "", options.body or "", options.size or "16, 12", options.samples or 1,
    options.material or "nil"))
end

local function animate(path, ...)
  return rtray { "animate", path, ... }
end

local function list(folder)
  return (support.shell("ls " .. quote(folder)).out:gsub("\n", " "))
end

-- The hash of an image's pixels, as the file says.
local function hash_of(path)
  return support.read(path):match("Hash%z(" .. ("%x"):rep(32) .. ")")
end

-- The number of frames rendered and taken over, as the closing line says.
local function counts(r)
  return tonumber(r.err:match "(%d+) rendered"), tonumber(r.err:match "(%d+) taken over" or 0)
end

local function has(r, text)
  assert.truthy(r.err:find(text, 1, true), ("not in: %s"):format(r.err))
end

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

describe("a film", function()
  local function probe(path, what)
    return (support.shell(("ffprobe -v error -count_frames -select_streams v -show_entries %s -of csv=p=0 file:%s"):format(what, quote(path))).out
      :gsub("%s+$", ""))
  end

  with_ffmpeg("is made of the frames in OUT.frames/, padded to even sizes, and kept while it is up to date", function()
    local folder = support.folder()
    local out = folder .. "/film.mp4"
    local path = script(folder, { size = "33, 25", frames = 6 })
    local r = animate(path, "-o", out)
    assert.equal(0, r.status, r.err)
    has(r, "; the film is made")
    local facts = probe(out, "stream=width,height,pix_fmt,r_frame_rate,nb_read_frames")
    assert.truthy(facts:find "^34,26,yuv420p,12/1,6", facts)
    assert.is_true((support.read(out):find("moov", 1, true)) < support.read(out):find("mdat", 1, true)) -- faststart
    assert.equal("000000.png 000001.png 000002.png 000003.png 000004.png 000005.png state ", list(folder .. "/film.frames"))
    assert.equal("a.lua film.frames film.mp4 ", list(folder))
    assert.truthy(support.read(out):find('"scene":"a.lua","frames":6,"fps":12}', 1, true))
    local before = support.read(out)
    r = animate(path, "-o", out)
    has(r, "0 rendered, 6 taken over")
    has(r, "; the film is up to date")
    os.remove(out)
    has(animate(path, "-o", out), "; the film is made")
    assert.equal(before, support.read(out))
    support.write(out, before:sub(1, 1000)) -- damaged
    has(animate(path, "-o", out), "; the film is made")
    assert.equal(before, support.read(out))
    r = animate(script(folder, { size = "33, 25", frames = 6, body = "if frame == 3 then t = 0 end" }), "-o", out)
    has(r, "1 rendered, 5 taken over")
    has(r, "; the film is made")
    assert.not_equal(before, support.read(out))
  end)

  with_ffmpeg("comes in every kind, of the same frames", function()
    local folder = support.folder()
    local path = script(folder, { frames = 4, more = ", loop = true" })
    for _, kind in ipairs { "mp4", "webm", "gif", "mkv", "mov", "apng", "webp" } do
      local r = animate(path, "-o", folder .. "/film." .. kind)
      assert.equal(0, r.status, kind .. ": " .. r.err)
      has(r, kind == "mp4" and "4 rendered" or "0 rendered, 4 taken over")
      if kind ~= "webp" then -- which ffprobe of some versions does not read
        assert.truthy(probe(folder .. "/film." .. kind, "stream=width,height,nb_read_frames"):find "16,12,4", kind)
      end
    end
    assert.equal("RIFF", support.read(folder .. "/film.webp"):sub(1, 4))
    assert.truthy(support.read(folder .. "/film.gif"):find("NETSCAPE2.0", 1, true))
  end)

  it("that cannot be made for lack of ffmpeg leaves the frames, and says so", function()
    local folder = support.folder()
    local path = script(folder)
    local r = rtray { "animate", path, "-o", folder .. "/film.mp4", env = "PATH=/nonexistent " }
    assert.equal(3, r.status, r.err)
    has(r, "ffmpeg was not found (No such file or directory); install it")
    has(r, "the film is not made, its 5 frames are finished in '" .. folder .. "/film.frames' and the same command goes on from there")
    assert.is_false(support.exists(folder .. "/film.mp4"))
    assert.equal("000000.png 000001.png 000002.png 000003.png 000004.png state ", list(folder .. "/film.frames"))
  end)

  -- A folder with a program ffmpeg that is this shell script.
  local function fake(folder, text)
    local path = support.write(folder .. "/bin/ffmpeg", "#!/bin/sh\n" .. text)
    assert(os.execute("chmod +x " .. quote(path)))
    return ("PATH=%s:$PATH "):format(quote(folder .. "/bin"))
  end

  with_ffmpeg("falls back to VP9 where libx264 is missing; other coders have no other", function()
    local folder = support.folder()
    os.execute("mkdir " .. quote(folder .. "/bin"))
    local real = support.shell("command -v ffmpeg").out:gsub("\n", "")
    local env = fake(folder, ("case \"$*\" in *-encoders*) %s -v error -encoders | grep -v 264;; *) exec %s \"$@\";; esac\n"):format(real, real))
    local path = script(folder)
    local r = rtray { "animate", path, "-o", folder .. "/film.mp4", env = env }
    assert.equal(0, r.status, r.err)
    assert.equal("vp9", (probe(folder .. "/film.mp4", "stream=codec_name"):gsub(",", "")))
    r = rtray { "animate", path, "-o", folder .. "/film.mov", env = env }
    assert.equal(3, r.status)
    has(r, "this ffmpeg lacks libx264, which a .mov film needs; the film is not made, its 5 frames are finished in")
  end)

  it("that ffmpeg cannot make is said with ffmpeg's words; the old film stays", function()
    local folder = support.folder()
    os.execute("mkdir " .. quote(folder .. "/bin"))
    local list_it = "case \"$*\" in *-encoders*) printf '\\n V..... libx264 x\\n'; exit 0;; esac\n"
    support.write(folder .. "/film.mp4", "old")
    local r = rtray { "animate", script(folder), "-o", folder .. "/film.mp4", env = fake(folder, list_it .. "echo 'no room' >&2; exit 7\n") }
    assert.equal(3, r.status, r.err)
    has(r, "ffmpeg ended with status 7: no room; the film '" .. folder .. "/film.mp4' is not made, its frames are in")
    assert.equal("old", support.read(folder .. "/film.mp4"))
    assert.equal("a.lua bin film.frames film.mp4 ", list(folder))
    -- It reads nothing, and dies.
    r = rtray { "animate", script(folder, { frames = 40 }), "-o", folder .. "/film.mp4", env = fake(folder, list_it .. "kill -9 $$\n") }
    assert.equal(3, r.status, r.err)
    has(r, "ffmpeg was ended by signal")
  end)

  with_ffmpeg("and its frames may have any name", function()
    for _, name in ipairs { "it's", 'a "b"', "$(touch x)", "100%d", "two\nlines", "-dash", "a:b", "<script>", "\255\254", "ü %04d" } do
      local folder = support.folder()
      local cwd = folder .. "/" .. name
      assert(os.execute("mkdir " .. quote(cwd)))
      local r = rtray { "animate", script(folder, { frames = 2 }), "-q", cwd = cwd, "-o", "./" .. name .. ".mp4" }
      assert.equal(0, r.status, r.err)
      assert.equal("2", (probe(cwd .. "/" .. name .. ".mp4", "stream=nb_read_frames"):gsub(",", "")))
      if not name:find "%%" then
        assert.equal(0, rtray({ "animate", script(folder, { frames = 2 }), "-q", "-o", cwd .. "/" .. name .. "%d.png" }).status)
        assert.is_true(support.exists(cwd .. "/" .. name .. "1.png"))
      end
      assert.is_false(support.exists(cwd .. "/x"))
    end
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

describe("a disk that fills up", function()
  local mounts = support.shell("unshare -m sh -c 'mount -t tmpfs tmpfs /mnt'").status == 0

  ;(mounts and it or pending)("keeps what is finished, and the film before it", function()
    local to = support.folder()
    local path = script(to, { frames = 40, size = "120, 80", material = "rt.classic { color = {rt.random(t), 1, 1} }" })
    assert(os.execute("mkdir " .. quote(to .. "/disk")))
    local command = support.command { "animate", path, "-o", to .. "/disk/%d.png" }
    local line = "mount -t tmpfs -o size=160k tmpfs %s && { %s; status=$?; cp -r %s %s; exit $status; }"
    local r = support.shell("unshare -m sh -c " .. quote(line:format(
      quote(to .. "/disk"), command, quote(to .. "/disk/."), quote(to .. "/kept"))))
    assert.equal(3, r.status, r.err)
    assert.truthy(r.err:find "[Nn]o space" or r.err:find "full", r.err)
    local finished = tonumber(r.err:match "(%d+) of 40 frames %l+ finished in")
    assert.is_true(finished > 0 and finished < 40, r.err)
    local again = animate(path, "-o", to .. "/kept/%d.png")
    assert.same({ 40 - finished, finished }, { counts(again) })
  end)
end)

describe("animate that is ended", function()
  local function hashes(folder, count)
    local all = {}
    for frame = 0, count - 1 do
      all[frame + 1] = hash_of(("%s/%d.png"):format(folder, frame))
    end
    return table.concat(all, " ")
  end

  it("by Ctrl-C in a script that runs for ever says what is finished", function()
    local folder = support.folder()
    local path = script(folder, { body = "while frame == 2 do end" })
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--at-once", "1" }
    local r = support.shell("timeout --preserve-status -s INT -k 20 1.5 " .. command)
    assert.equal(130, r.status, r.err)
    has(r, "rtray animate: interrupted: 2 of 5 frames are finished in '" .. folder .. "'; the same command goes on from there")
    assert.equal("000000 000001 ", list(folder .. "/%d.png.state"))
  end)

  it("by a limit of time names the frame, or says how far it is", function()
    local folder = support.folder()
    local path = script(folder, { body = "while frame == 2 do end" })
    local r = animate(path, "-o", folder .. "/%d.png", "--at-once", "1", "--limit", "time=0.5s")
    assert.equal(1, r.status, r.err)
    has(r, "frame 2: the time limit of 0.5s ran out")
    has(r, "2 of 5 frames are finished in")
    path = script(folder, { frames = 2, size = "400, 300", samples = 60000 })
    r = animate(path, "-o", folder .. "/%d.png", "--at-once", "1", "--limit", "time=0.5s")
    assert.equal(1, r.status, r.err)
    has(r, "the time limit of 0.5s ran out")
    has(r, "0 of 2 frames are finished in")
  end)

  it("by Ctrl-C in a render keeps the frames before", function()
    local folder = support.folder()
    local path = script(folder, { samples = 1, body = "local n = frame == 2 and 60000 or 1\n  local size = frame == 2 and {400, 300} or {16, 12}\n"
      .. "  if frame == 2 then return rt.scene { settings = { size = size, samples = n }, rt.sphere { center = {0, 0, 0}, radius = 1 } } end" })
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--at-once", "1" }
    local r = support.shell("timeout --preserve-status -s TERM -k 20 1.5 " .. command)
    assert.equal(143, r.status, r.err)
    has(r, "interrupted: 2 of 5 frames are finished")
    assert.equal("%d.png.state 0.png 1.png a.lua ", list(folder))
  end)

  it("within a long frame goes on from its checkpoint, to the same bits", function()
    local folder, calm = support.folder(), support.folder()
    local function long(samples)
      return script(folder, { frames = 2, size = "160, 120", body = "local samples = frame == 1 and " .. samples .. " or 1", samples = 0 })
    end
    local path = long(700)
    support.write(path, (support.read(path):gsub("samples = 0", "samples = samples")))
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--every", "0.1", "--at-once", "1" }
    local state = folder .. "/%d.png.state"
    local r = support.shell("timeout -s INT -k 20 1 " .. command)
    has(r, "1 of 2 frames is finished in")
    assert.truthy(r.err:find "frame 1 is done to %d+%%; the same command goes on", r.err)
    assert.truthy(list(state):find "^000000 000001%.%x+%.checkpoint $", list(state))
    support.shell("timeout -s KILL 1 " .. command)
    assert.truthy(list(state):find "000001%.%x+%.checkpoint", list(state))
    r = rtray { "animate", path, "-o", folder .. "/%d.png", "--json" }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find '"frame":1,"state":"rendered".-"tiles_resumed":%d+', r.out)
    assert.equal(0, animate(path, "-q", "-o", calm .. "/%d.png").status)
    assert.equal(support.read(calm .. "/1.png"), support.read(folder .. "/1.png"))
    assert.equal("000000 000001 ", list(state))
  end)

  it("and whose checkpoint is damaged begins that frame anew", function()
    local folder = support.folder()
    local path = script(folder, { frames = 1, size = "160, 120", samples = 700 })
    local command = support.command { "animate", path, "-q", "-o", folder .. "/%d.png", "--every", "0.1" }
    support.shell("timeout -s KILL 1 " .. command)
    local file = folder .. "/%d.png.state/" .. list(folder .. "/%d.png.state"):match "000000%.%x+%.checkpoint"
    support.write(file, support.read(file):sub(1, 500))
    local r = support.shell("timeout -s INT -k 20 0.5 " .. command)
    assert.truthy(r.err:find "frame 0 begins anew: .* damaged", r.err)
    support.shell("timeout -s KILL 0.7 " .. command)
    script(folder, { frames = 1, size = "160, 120", samples = 3 }) -- another description: the checkpoint is of no use
    assert.same({ 1, 0 }, { counts(animate(path, "-o", folder .. "/%d.png")) })
    assert.equal("000000 ", list(folder .. "/%d.png.state"))
  end)

  it("by kill -9 at any moment goes on to the same bits", function()
    local folder, calm = support.folder(), support.folder()
    local path = script(folder, { frames = 16, size = "120, 90", samples = 16 })
    local command = support.command { "animate", path, "-q", "-o", folder .. "/%d.png" }
    for i = 1, 5 do
      local r = support.shell(("timeout -s KILL %.2f %s"):format(0.06 + 0.05 * i, command))
      assert.is_true(r.status == 137 or r.status == 0, r.status)
    end
    assert.equal(0, support.shell(command).status)
    assert.equal(0, animate(path, "-q", "-o", calm .. "/%d.png").status)
    assert.equal(hashes(calm, 16), hashes(folder, 16))
    assert.truthy(#hashes(calm, 16) == 16 * 33 - 1)
    assert.equal("", support.shell("ls " .. quote(folder .. "/%d.png.state") .. " | grep -v '^[0-9]*$'").out) -- no claim, nothing unfinished
  end)
end)

describe("several processes on one folder", function()
  it("share the work", function()
    local folder = support.folder()
    local path = script(folder, { frames = 24, size = "100, 80", samples = 16 })
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--at-once", "1", "--json" }
    local r = support.shell(("%s >a 2>a.err & %s >b 2>b.err & wait; cat a b a.err b.err"):format(command, command), folder)
    local sum = 0
    for n in r.out:gmatch '"rendered":(%d+)' do
      sum = sum + n
      assert.is_true(tonumber(n) > 0, r.out)
    end
    assert.equal(24, sum, r.out)
    assert.same({ 0, 24 }, { counts(animate(path, "-o", folder .. "/%d.png")) })
  end)

  it("void the claims of the dead at once, of other machines after a while", function()
    local folder = support.folder()
    local path = script(folder, { frames = 3 })
    local to = folder .. "/%d.png"
    assert.equal(0, animate(path, "-q", "-o", to).status)
    local state = folder .. "/%d.png.state/"
    -- A claim as this machine writes it, taken from a process that is killed.
    local slow = script(folder, { name = "slow.lua", frames = 3, body = "while true do end" })
    support.shell("timeout -s KILL 0.5 " .. support.command { "animate", slow, "-q", "-o", folder .. "/s%d.png" })
    for frame = 0, 2 do
      os.remove(("%s/%d.png"):format(folder, frame))
    end
    support.write(state .. "000001.claim", "elsewhere - - 1 -\n")
    local begun = os.time()
    local r = rtray { "animate", path, "-o", to, env = "RTRAY_CLAIM_SECONDS=0.5 " }
    assert.equal(0, r.status, r.err)
    assert.is_true(os.time() - begun < 10)
    has(r, "waiting for 1 frame that process 1 on elsewhere renders")
    assert.same({ 3, 0 }, { counts(r) })
    assert.equal("000000 000001 000002 ", list(state))
  end)

  it("take no claim of a process that was killed for the work of a living one", function()
    local folder = support.folder()
    local path = script(folder, { frames = 2, size = "400, 300", samples = 4000 })
    support.shell("timeout -s KILL 1 " .. support.command { "animate", path, "-q", "-o", folder .. "/%d.png", "--at-once", "1" })
    assert.truthy(list(folder .. "/%d.png.state"):find("000000.claim ", 1, true))
    local begun = os.time()
    local r = rtray { "animate", script(folder, { frames = 2 }), "-o", folder .. "/%d.png" }
    assert.same({ 2, 0 }, { counts(r) })
    assert.is_true(os.time() - begun < 10)
    assert.is_nil(r.err:find("waiting", 1, true))
  end)
end)
