-- rtray animate: films of the frames, through ffmpeg.

local support = require "support"
local animation = require "animation"
local rtray, quote = support.rtray, support.quote
local animate, script, list, has = animation.animate, animation.script, animation.list, animation.has

local has_ffmpeg = support.shell("ffmpeg -version").status == 0
local with_ffmpeg = has_ffmpeg and it or pending

describe("a film", function()
  local function probe(path, what)
    return (support.shell(("ffprobe -v error -count_frames -select_streams v -show_entries %s -of csv=p=0 file:%s"):format(what, quote(path))).out
      :gsub("%s+$", ""))
  end

  with_ffmpeg("is made in any folder, far from a scene in the sandbox", function()
    local folder = support.folder()
    support.shell("mkdir scenes films", folder)
    local r = animate(script(folder .. "/scenes", { size = "33, 25", frames = 2 }), "-o", folder .. "/films/film.mp4")
    assert.equal(0, r.status, r.err)
    assert.equal("film.frames film.mp4 ", list(folder .. "/films"))
  end)

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
    for _, name in ipairs { "it's $(touch x)", "-dash", 'two\nlines, "b"', "a:b %04d", "<script> \255\254 ü" } do
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
