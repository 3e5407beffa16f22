-- Where the program's own threads meet the library's: the watch of --limit, the hook that opens a scene's files, calls that run away from the Lua
-- state, frames rendered at once. In the thread sanitizer's build a race ends the program with a report; in others these are what they say.

local support = require "support"
local animation = require "animation"
local rtray = support.rtray

local HEAD = "local rt = require 'rt'\nio.stderr:write 'it runs\\n'\n"

local function scene(folder, settings, more)
  return support.write(folder .. "/s.lua", HEAD .. ([[
local list = {}
for i = 1, 40 do
  list[i] = rt.sphere { center = {rt.random("x", i), rt.random("y", i), rt.random("z", i)}, radius = 0.1 }
end
return rt.scene { settings = { %s }, camera = rt.camera { eye = {0.5, 0.5, 4}, look_at = {0.5, 0.5, 0.5} }, rt.point_light { at = {5, 5, 5} }, list,
  %s }]]):format(settings, more or ""))
end

-- The status, and that no sanitizer has said a word.
local function ends(status, r, words)
  assert.is_nil(r.err:find("Sanitizer", 1, true), r.err)
  assert.equal(status, r.status, r.err)
  assert.truthy(not words or r.err:find(words, 1, true), r.err)
end

local function run(folder, ...)
  return rtray { cwd = folder, ... }
end

describe("threads", function()
  it("of a limit that runs out: in the script, the build, the render", function()
    local folder = support.folder()
    support.write(folder .. "/loop.lua", "while true do end")
    ends(1, run(folder, "render", "loop.lua", "--limit", "time=200ms"), "the time limit of 200ms ran out in the script")
    support.write(folder .. "/search.lua", [[local s = (("a"):rep(3000)):find((".-"):rep(30) .. "b")]])
    ends(1, run(folder, "render", "search.lua", "--limit", "time=200ms"), "ran out in the script")
    scene(folder, "width = 1000, height = 800, samples = 65536, workers = 3, tile = 4")
    ends(1, run(folder, "render", "s.lua", "-q", "--limit", "time=2s"), "the time limit of 2s ran out in the ")
    ends(1, run(folder, "render", "s.lua", "-q", "--limit", "memory=12M", "--size", "2000x2000", "--preview", "p.png"),
      "the memory limit of 12M ran out")
  end)

  it("of a limit that holds, with files that workers' textures come from", function()
    local folder = support.folder()
    support.write(folder .. "/t.jpg", support.read(support.source .. "/scenes/flower.jpg"))
    scene(folder, "width = 40, height = 30, samples = 2, workers = 3, tile = 4",
      "rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = rt.classic { texture = 't.jpg' } }")
    ends(0, run(folder, "render", "s.lua", "-q", "--limit", "time=100s,memory=2G", "--checkpoint", "c", "--every", "0.001", "-o", "a.png"))
    ends(0, run(folder, "render", "s.lua", "-q", "--workers", "1", "-o", "b.png"))
    assert.equal(0, run(folder, "compare", "a.png", "b.png").status)
  end)

  it("of a signal: in a render with a checkpoint, in an explained pixel, in trees", function()
    local folder = support.folder()
    scene(folder, "width = 1000, height = 800, samples = 65536, workers = 3, tile = 4")
    for _, args in ipairs {
      { "render", "s.lua", "--checkpoint", "c", "--every", "0.01" }, { "pixel", "s.lua", "500,400" }, { "tree", "s.lua", "--size", "8000x6000" },
    } do
      ends(130, support.ended(args, "INT", args[1] == "render" and "test -s c" or 'grep -q "it runs" "$LOG"', folder), "interrupted")
    end
  end)

  it("of frames at once, beside another process", function()
    local folder = support.folder()
    local path = animation.script(folder, { frames = 6, samples = 2 })
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--at-once", "3", "--workers", "4", "--limit", "time=200s" }
    ends(0, support.shell(("%s 2>b.err & %s; status=$?; wait $! || exit; cat b.err >&2; (exit $status)"):format(command, command), folder))
    assert.same({ 0, 6 }, { animation.counts(animation.animate(path, "-o", folder .. "/%d.png")) })
  end)
end)
