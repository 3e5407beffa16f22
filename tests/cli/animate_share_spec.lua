-- rtray animate that is ended by signals, kills, limits and full disks and goes on, alone or with others on one folder.

local support = require "support"
local animation = require "animation"
local rtray, quote = support.rtray, support.quote
local animate, script, list, hash_of, counts, has = animation.animate, animation.script, animation.list, animation.hash_of,
  animation.counts, animation.has

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
    script(folder, { body = "if frame == 2 then io.stderr:write 'for ever' end while frame == 2 do end" })
    local r = support.ended({ "animate", "a.lua", "-o", "%d.png", "--at-once", "1" }, "INT", 'grep -q "for ever" "$LOG"', folder)
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    has(r, "rtray animate: interrupted: 2 of 5 frames are finished in '.'; the same command goes on from there")
    assert.equal("000000 000001 ", list(folder .. "/%d.png.state"))
  end)

  it("by a limit of time names the frame, or says how far it is", function()
    local folder = support.folder()
    local path = script(folder, { body = "while frame == 2 do end" })
    local r
    for _, limit in ipairs { "0.5s", "2s", "8s", "30s" } do -- what takes up the frames before takes its time, too
      r = animate(path, "-o", folder .. "/%d.png", "--at-once", "1", "--limit", "time=" .. limit)
      assert.equal(1, r.status, r.err)
      if r.err:find("frame 2: the time limit of " .. limit .. " ran out", 1, true) then
        break
      end
    end
    has(r, "frame 2: the time limit of ")
    has(r, "2 of 5 frames are finished in")
    path = script(folder, { frames = 2, size = "2000, 1500", samples = 65536 })
    r = animate(path, "-o", folder .. "/%d.png", "--at-once", "1", "--limit", "time=0.5s")
    assert.equal(1, r.status, r.err)
    has(r, "the time limit of 0.5s ran out")
    has(r, "0 of 2 frames are finished in")
  end)

  it("by a signal in a render keeps the frames before", function()
    local folder = support.folder()
    script(folder, { samples = 1, body = "if frame == 2 then return rt.scene { settings = { size = {2000, 1500}, samples = 65536 }, "
      .. "rt.sphere { center = {0, 0, 0}, radius = 1 } } end" })
    local r = support.ended({ "animate", "a.lua", "-o", "%d.png", "--at-once", "1" }, "TERM", "test -e %d.png.state/000002.claim", folder)
    assert.same({ true, 143 }, { r.met, r.status }, r.err)
    has(r, "interrupted: 2 of 5 frames are finished")
    assert.equal("%d.png.state 0.png 1.png a.lua ", list(folder))
  end)

  -- A checkpoint of frame 0 that holds some of the picture (one without is a kilobyte), other than `before`, a line of `ls -i`.
  local function checkpoint(before)
    return ('set -- "$(find %%d.png.state -name "000000.*.checkpoint" -size +8k -exec ls -i {} +)"; test "$1" && test "$1" != %s'):format(
      quote(before or ""))
  end

  local function marks(folder)
    return (support.shell("find %d.png.state -name '*.checkpoint' -exec ls -i {} +", folder).out:gsub("%s+$", ""))
  end

  it("within a long frame goes on from its checkpoint, to the same bits", function()
    local args = { "animate", "a.lua", "-o", "%d.png", "--every", "0.01", "--at-once", "1", "--workers", "1" }
    local folder = support.long_enough(function(samples)
      local place = support.folder()
      script(place, { frames = 1, size = "80, 60", samples = samples })
      local r = support.ended(args, "INT", checkpoint(), place)
      if not r.met or marks(place) == "" then -- the frame was finished first
        return nil
      end
      assert.equal(130, r.status, r.err)
      has(r, "0 of 1 frame are finished in")
      assert.truthy(r.err:find "frame 0 is done to %d+%%; the same command goes on", r.err)
      assert.truthy(list(place .. "/%d.png.state"):find "^000000%.%x+%.checkpoint $")
      r = support.ended(args, "KILL", checkpoint(marks(place)), place) -- the one that it has written itself
      return r.met and r.status == 137 and marks(place) ~= "" and place or nil
    end)
    local state, calm = folder .. "/%d.png.state", support.folder()
    assert.truthy(list(state):find "000000%.%x+%.checkpoint")
    local kept = marks(folder)
    local r = rtray { "animate", "a.lua", "-o", "%d.png", "--memory-limit", "1K", cwd = folder } -- no fault of the checkpoint
    assert.equal(3, r.status, r.err)
    assert.equal(kept, marks(folder))
    r = rtray { "animate", "a.lua", "-o", "%d.png", "--json", cwd = folder }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find '"frame":0,"state":"rendered".-"tiles_resumed":%d+', r.out)
    assert.equal(0, animate(folder .. "/a.lua", "-q", "-o", calm .. "/%d.png").status)
    assert.equal(support.read(calm .. "/0.png"), support.read(folder .. "/0.png"))
    assert.equal("000000 ", list(state))
  end)

  it("and whose checkpoint is damaged begins that frame anew", function()
    local args = { "animate", "a.lua", "-o", "%d.png", "--every", "0.01", "--workers", "1" }
    local folder = support.long_enough(function(samples)
      local place = support.folder()
      script(place, { frames = 1, size = "80, 60", samples = samples })
      local r = support.ended(args, "KILL", checkpoint(), place)
      return r.met and r.status == 137 and marks(place) ~= "" and place or nil
    end)
    local state = folder .. "/%d.png.state"
    local file = state .. "/" .. list(state):match "000000%.%x+%.checkpoint"
    support.write(file, support.read(file):sub(1, 500))
    local r = rtray { "animate", "a.lua", "-o", "%d.png", cwd = folder }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.err:find "frame 0 begins anew: .* damaged", r.err)
    assert.equal("000000 ", list(state))
    support.write(file, "of a description that is none any more")
    script(folder, { frames = 1, size = "80, 60", samples = 3 })
    assert.same({ 1, 0 }, { counts(animate(folder .. "/a.lua", "-o", folder .. "/%d.png")) })
    assert.equal("000000 ", list(state))
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

describe("several processes on one folder", function()
  -- Waits in the script, at one frame of one process, until a file is there: so that each has its share, whatever their pace.
  local function waits(frame, process, file)
    return ([[if frame == %d and os.getenv "WHO" == "%s" then while not io.open(%q) do end end ]]):format(frame, process, file)
  end

  it("share the work", function()
    local folder = support.folder()
    local state = folder .. "/%d.png.state/"
    local path = script(folder, { frames = 24, samples = 4, body = waits(0, "b", state .. "000000") .. waits(12, "a", state .. "000012") })
    local command = support.command { "animate", path, "-o", folder .. "/%d.png", "--at-once", "1", "--json", "--trust" }
    local r = support.shell(("WHO=a %s >a 2>a.err & WHO=b %s >b 2>b.err & wait; cat a b a.err b.err"):format(command, command), folder)
    local sum = 0
    for n in r.out:gmatch '"rendered":(%d+)' do
      sum = sum + n
      assert.is_true(tonumber(n) > 0, r.out)
    end
    assert.equal(24, sum, r.out)
    assert.same({ 0, 24 }, { counts(animate(path, "--trust", "-o", folder .. "/%d.png")) })
  end)

  it("void the claims of other machines after a while", function()
    local folder = support.folder()
    local path = script(folder, { frames = 3 })
    local to = folder .. "/%d.png"
    assert.equal(0, animate(path, "-q", "-o", to).status)
    local state = folder .. "/%d.png.state/"
    for frame = 0, 2 do
      os.remove(("%s/%d.png"):format(folder, frame))
    end
    support.write(state .. "000001.claim", "elsewhere - - 1 -\n")
    local r = rtray { "animate", path, "-o", to, env = "RTRAY_CLAIM_SECONDS=0.5 " }
    assert.equal(0, r.status, r.err)
    has(r, "waiting for 1 frame that process 1 on elsewhere renders")
    assert.same({ 3, 0 }, { counts(r) })
    assert.equal("000000 000001 000002 ", list(state))
  end)

  it("void a claim whose owner was ended before it wrote its name", function()
    local folder = support.folder()
    local path = script(folder, { frames = 2 })
    local to = folder .. "/%d.png"
    assert.equal(0, animate(path, "-q", "-o", to).status)
    os.remove(folder .. "/1.png")
    support.write(to .. ".state/000001.claim", "")
    local r = support.shell("RTRAY_CLAIM_SECONDS=0.5 timeout -s KILL 60 " .. support.command { "animate", path, "-o", to }, folder)
    assert.equal(0, r.status, r.err)
    assert.equal("000000 000001 ", list(to .. ".state/"))
  end)

  it("do not wait for pipes and devices in the place of records and claims", function()
    local folder = support.folder()
    script(folder, { frames = 4 })
    local command = "timeout -s KILL 60 " .. support.command { "animate", "a.lua", "-o", "%d.png" }
    assert.equal(0, support.shell(command, folder).status)
    local before = hash_of(folder .. "/1.png")
    assert(os.execute(("cd %s && rm 000000 000001 000002 ../2.png && mkfifo 000000 000002.claim && ln -s /dev/zero 000001"):format(
      quote(folder .. "/%d.png.state"))))
    local r = support.shell(command, folder)
    assert.equal(0, r.status, r.err)
    assert.same({ "000000 000001 000002 000003 ", before }, { list(folder .. "/%d.png.state"), hash_of(folder .. "/1.png") })
  end)

  it("clear the claim of a process that was killed when its frame was finished", function()
    local folder = support.folder()
    local state = folder .. "/%d.png.state"
    script(folder, { frames = 2, size = "2000, 1500", samples = 65536 })
    local r = support.ended({ "animate", "a.lua", "-q", "-o", "%d.png", "--at-once", "1" }, "KILL", "test -s %d.png.state/000000.claim", folder)
    assert.same({ true, 137 }, { r.met, r.status })
    local claim = support.read(state .. "/000000.claim")
    local path = script(folder, { frames = 2 })
    assert.same({ 2, 0 }, { counts(animate(path, "-o", folder .. "/%d.png")) })
    support.write(state .. "/000000.claim", claim)
    assert.same({ 0, 2 }, { counts(animate(path, "-o", folder .. "/%d.png")) })
    assert.equal("000000 000001 ", list(state))
  end)

  it("take no claim of a process that was killed for the work of a living one", function()
    local folder = support.folder()
    script(folder, { frames = 2, size = "2000, 1500", samples = 65536 })
    local r = support.ended({ "animate", "a.lua", "-q", "-o", "%d.png", "--at-once", "1" }, "KILL", "test -s %d.png.state/000000.claim", folder)
    assert.same({ true, 137 }, { r.met, r.status })
    assert.truthy(list(folder .. "/%d.png.state"):find("000000.claim ", 1, true))
    r = rtray { "animate", script(folder, { frames = 2 }), "-o", folder .. "/%d.png", env = "RTRAY_CLAIM_SECONDS=100000 " }
    assert.same({ 2, 0 }, { counts(r) })
    assert.is_nil(r.err:find("waiting", 1, true))
  end)
end)
