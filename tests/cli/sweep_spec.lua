local support = require "support"
local rtray = support.rtray

-- A scene of milliseconds with parameters of every kind.
local SCENE = [[
local rt = require "rt"
local p = rt.params {
  radius = { 1, min = 0.1, max = 2, step = 0.5 },
  count = { 1, type = "integer", min = 1, max = 9 },
  mood = { "day", choices = { "day", "night" } },
  word = "plain",
  tint = { {1, 0, 0}, type = "color" },
  seen = true,
  sets = { large = { radius = 2 } },
}
if p.word == "bad" then
  error("the word is bad", 0)
end
return rt.scene {
  settings = { width = 12, height = 8, samples = 1 },
  camera = rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0}, fov = 45 },
  ambient = {0.2, 0.2, 0.2},
  background = p.mood == "day" and {0.5, 0.5, 0.9} or {0, 0, 0.1},
  rt.point_light { at = {5, 5, 5} },
  rt.sphere { center = {0, 0, 0}, radius = p.radius, material = rt.classic { color = p.tint } },
}
]]

local function scene(folder, text)
  return support.write(folder .. "/x.lua", text or SCENE)
end

-- Records of a CSV file as RFC 4180 has it, each a table by the names of the head.
local function read_csv(path)
  local text = support.read(path)
  local rows, row, at = {}, {}, 1
  while at <= #text do
    local field, stop
    if text:sub(at, at) == '"' then
      local parts, from = {}, at + 1
      repeat
        stop = assert(text:find('"', from, true), "a quote has no end")
        parts[#parts + 1] = text:sub(from, stop - 1)
        from = stop + 2
      until text:sub(stop + 1, stop + 1) ~= '"'
      field, stop = table.concat(parts, '"'), stop + 1
    else
      stop = assert(text:find("[,\r]", at))
      field = text:sub(at, stop - 1)
    end
    row[#row + 1] = field
    if text:sub(stop, stop) == "," then
      at = stop + 1
    else
      assert(text:sub(stop, stop + 1) == "\r\n", "a row ends with CR LF")
      rows[#rows + 1], row, at = row, {}, stop + 2
    end
  end
  local list = {}
  for i = 2, #rows do
    assert(#rows[i] == #rows[1], "a row of another length")
    list[i - 1] = {}
    for j, name in ipairs(rows[1]) do
      list[i - 1][name] = rows[i][j]
    end
  end
  return list, rows[1]
end

-- rtray sweep x.lua ... -o out -q in a folder.
local function sweep(folder, ...)
  return rtray { "sweep", "x.lua", "-o", "out", "-q", "--no-report", cwd = folder, ... }
end

local function lines_of(path, pattern)
  local count = 0
  for _ in support.read(path):gmatch(pattern) do
    count = count + 1
  end
  return count
end

describe("rtray sweep", function()
  it("takes whole numbers of any size as they are", function()
    local folder = support.folder()
    scene(folder)
    local r = rtray { "sweep", "x.lua", "--over", "seed=9007199254740992:9007199254740996:2,9223372036854775805:9223372036854775807", "--dry-run",
      "-o", "o", cwd = folder }
    assert.equal(0, r.status, r.err)
    assert.equal("seed=9007199254740992\nseed=9007199254740994\nseed=9007199254740996\nseed=9223372036854775805\nseed=9223372036854775806\n"
      .. "seed=9223372036854775807\n", r.out)
    r = rtray { "sweep", "x.lua", "--over", "seed=0:9223372036854775807:3", "--dry-run", "-o", "o", cwd = folder }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("at most 100000 are taken", 1, true), r.err)
  end)

  it("does not believe a journal's machine with facts of other kinds", function()
    local folder = support.folder()
    scene(folder)
    local command = { "sweep", "x.lua", "--over", "count=1,2", "-q", "--no-report", "-o", "o", cwd = folder }
    assert.equal(0, rtray(command).status)
    local journal = support.read(folder .. "/o/journal.jsonl")
    support.write(folder .. "/o/journal.jsonl", (journal:gsub('"cpus":%d+', '"cpus":"<script>"')))
    os.remove(folder .. "/o/results.json")
    local r = rtray { "report", "o", cwd = folder }
    assert.is_nil(r.err:find("attempt to", 1, true), r.err)
    r = rtray(command)
    assert.equal(0, r.status, r.err)
    assert.equal(0, rtray({ "report", "o", cwd = folder }).status)
  end)

  it("removes nothing but its own images with --restart, whatever a journal says", function()
    local folder = support.folder()
    scene(folder)
    assert.equal(0, sweep(folder, "--over", "radius=1").status)
    local made = read_csv(folder .. "/out/results.csv")[1].image
    local journal = support.read(folder .. "/out/journal.jsonl")
    support.shell("mkdir out/sub && touch out/sub/x out/thesis.tex", folder)
    for i, name in ipairs { "thesis.tex", "sub/x", "images/../thesis.tex", "../x.lua" } do
      journal = journal .. ('{"t":"image","key":"%032x","file":"%s","bytes":1,"hash":"%016x"}\n'):format(i, name, i)
    end
    support.write(folder .. "/out/journal.jsonl", journal)
    assert.equal(0, sweep(folder, "--over", "radius=2", "--restart").status)
    for _, name in ipairs { "out/thesis.tex", "out/sub/x", "x.lua" } do
      assert.is_true(support.exists(folder .. "/" .. name), name)
    end
    assert.is_false(support.exists(folder .. "/out/" .. made))
  end)

  it("does not wait for a pipe in the place of its journal", function()
    local folder = support.folder()
    scene(folder)
    assert(os.execute(("mkdir %s && mkfifo %s"):format(support.quote(folder .. "/o"), support.quote(folder .. "/o/journal.jsonl"))))
    local r = support.shell("timeout -s KILL 60 " .. support.command { "sweep", "x.lua", "--over", "count=1", "-o", "o" }, folder)
    assert.equal(1, r.status, r.err)
    assert.truthy(r.err:find("'o/journal.jsonl' is no regular file; remove it", 1, true), r.err)
  end)

  it("measures a grid and writes tables, images and facts", function()
    local folder = support.folder()
    scene(folder)
    local r = sweep(folder, "--over", "radius=0.5:1.5:0.5", "--over", "workers=1,2", "--runs", "2", "--warmup", "1")
    assert.equal(0, r.status, r.err)
    local rows, head = read_csv(folder .. "/out/results.csv")
    assert.equal(6, #rows)
    assert.same({ "radius", "workers", "status" }, { head[1], head[2], head[3] })
    local labels = {}
    for i, row in ipairs(rows) do
      labels[i] = row.radius .. "/" .. row.workers
      assert.equal("done", row.status)
      assert.equal("2", row.runs)
      assert.equal("\137PNG", support.read(folder .. "/out/" .. row.image):sub(1, 4))
      assert.is_true(tonumber(row.seconds_median) > 0 and tonumber(row.peak_memory_bytes) > 1e6)
      assert.is_true(tonumber(row.seconds_q1) <= tonumber(row.seconds_median) and tonumber(row.seconds_median) <= tonumber(row.seconds_q3))
      assert.is_true(tonumber(row.rays) > 0)
    end
    assert.same({ "0.5/1", "0.5/2", "1/1", "1/2", "1.5/1", "1.5/2" }, labels)
    assert.equal(rows[1].hash, rows[2].hash)
    assert.not_equal(rows[1].hash, rows[3].hash)
    assert.equal(12, #read_csv(folder .. "/out/runs.csv"))
    local machine = support.read(folder .. "/out/machine.json")
    for _, key in ipairs { "fingerprint", "cpus", "caches", "memory_bytes", "compiler", "flags", "version", "kernel" } do
      assert.truthy(machine:find('"' .. key .. '":', 1, true), key)
    end
  end)

  it("goes on with what is missing, and keeps the rest", function()
    local folder = support.folder()
    scene(folder)
    local journal = folder .. "/out/journal.jsonl"
    assert.equal(0, sweep(folder, "--over", "radius=0.5,1").status)
    assert.equal(2, lines_of(journal, '"t":"run"'))
    local before = read_csv(folder .. "/out/results.csv")
    assert.equal(0, sweep(folder, "--over", "radius=0.5:1.5:0.5").status)
    assert.equal(3, lines_of(journal, '"t":"run"'))
    local after = read_csv(folder .. "/out/results.csv")
    for i, row in ipairs(before) do
      assert.same(row, after[i])
    end
    assert.equal(0, sweep(folder, "--over", "radius=0.5:1.5:0.5", "--runs", "2").status) -- more runs are added to the ones there are
    assert.equal(6, lines_of(journal, '"t":"run"'))
    local kept = support.read(journal)
    support.write(journal, kept .. '{"t":"run","key":"') -- what a kill leaves
    os.remove(folder .. "/out/" .. after[1].image)
    assert.equal(0, sweep(folder, "--over", "radius=0.5:1.5:0.5", "--runs", "2").status)
    assert.equal(6, lines_of(journal, '"t":"run"'))
    assert.is_true(support.exists(folder .. "/out/" .. after[1].image))
    scene(folder, (SCENE:gsub("fov = 45", "fov = 50"))) -- an edited scene is measured again
    assert.equal(0, sweep(folder, "--over", "radius=0.5:1.5:0.5").status)
    assert.equal(9, lines_of(journal, '"t":"run"'))
    scene(folder, SCENE .. "-- a comment changes nothing that is described\n")
    assert.equal(0, sweep(folder, "--over", "radius=0.5:1.5:0.5").status)
    assert.equal(9, lines_of(journal, '"t":"run"'))
    assert.equal(after[1].hash, read_csv(folder .. "/out/results.csv")[1].hash)
  end)

  it("loses and doubles no row when it is killed at any moment", function()
    local folder = support.folder()
    scene(folder)
    local args = { "sweep", "x.lua", "-o", "out", "-q", "--over", "radius=0.5:1.5:0.25", "--runs", "4" }
    assert.equal(0, sweep(folder, "--over", "radius=0.5").status) -- the folder is there however slow the machine is
    for i = 1, 10 do
      support.shell(("timeout -s KILL %.3f %s"):format(0.05 + (i * 0.618 % 1) * 0.4, support.command(args)), folder)
    end
    -- what a kill in the middle of a table or an image leaves, and what only looks like it
    for _, name in ipairs { "results.csv.1.part", "images/.rtray-1-0.part", "mine.1.part", "images/mine.part" } do
      support.write(folder .. "/out/" .. name, "half of it")
    end
    args.cwd = folder
    local r = rtray(args)
    assert.equal(0, r.status, r.err)
    local seen = {}
    for line in support.read(folder .. "/out/journal.jsonl"):gmatch "([^\n]*)\n" do
      local key, run = line:match '^{"t":"run","key":"(%x+)","run":(%d+),.*}$'
      if key then
        assert.is_nil(seen[key .. run], "a run stands twice")
        seen[key .. run] = true
      end
    end
    local rows = read_csv(folder .. "/out/runs.csv")
    assert.equal(20, #rows)
    for _, row in ipairs(rows) do
      assert.is_true(seen[row.key .. row.run])
      seen[row.key .. row.run] = nil
    end
    assert.is_nil(next(seen))
    assert.equal("mine.1.part\nmine.part\n", support.shell("ls -A out/images out | grep part", folder).out)
  end)

  it("notes a point that fails, does the others and ends with 1", function()
    local folder = support.folder()
    scene(folder)
    local r = sweep(folder, "--over", "word=good,bad,fine")
    assert.equal(1, r.status)
    assert.truthy(r.err:find("1 of 3 points failed, the first is word=bad: the word is bad", 1, true), r.err)
    local rows = read_csv(folder .. "/out/results.csv")
    assert.same({ "done", "failed", "done" }, { rows[1].status, rows[2].status, rows[3].status })
    assert.equal("the word is bad", rows[2].message)
    scene(folder, (SCENE:gsub('error%(.-%)', "rt.params {}")))
    assert.equal(0, sweep(folder, "--over", "word=good,bad,fine").status) -- a mended one is run
  end)

  it("ends a run that takes too long, and one that dies", function()
    local folder = support.folder()
    scene(folder, SCENE .. '\n')
    scene(folder, (SCENE:gsub('error%(.-%)', "while true do end")))
    local r = sweep(folder, "--over", "word=bad,good", "--timeout", "2")
    assert.equal(1, r.status)
    assert.truthy(r.err:find("word=bad: the run took longer than --timeout 2 s", 1, true), r.err)
    scene(folder, (SCENE:gsub('error%(.-%)', "os.exit(9)")))
    r = sweep(folder, "--over", "word=bad,good", "--restart", "--trust")
    assert.equal(1, r.status)
    assert.truthy(r.err:find("word=bad: the run's process ended with status 9 and no answer", 1, true), r.err)
    assert.equal("done", read_csv(folder .. "/out/results.csv")[2].status)
  end)

  it("takes hostile values as they are", function()
    local folder = support.folder()
    scene(folder)
    local values = { "a 'b' \"c\"", "$(touch x)", "two\nlines", "n=v", "\255\254", "<script>", "../../up", "%d", ("long"):rep(60) }
    local axis = {}
    for i, value in ipairs(values) do
      axis[i] = '"' .. value:gsub('"', '""') .. '"'
    end
    local r = sweep(folder, "--over", "word=" .. table.concat(axis, ","))
    assert.equal(0, r.status, r.err)
    local rows = read_csv(folder .. "/out/results.csv")
    local images = {}
    for i, value in ipairs(values) do
      assert.equal(value, rows[i].word)
      assert.is_nil(images[rows[i].image:lower()])
      images[rows[i].image:lower()] = true
      assert.truthy(rows[i].image:find "^images/[%w_.-]+%.png$", rows[i].image)
      assert.is_true(#rows[i].image < 130 and support.exists(folder .. "/out/" .. rows[i].image))
    end
    assert.is_false(support.exists(folder .. "/x"))
    assert.is_truthy(utf8.len(support.read(folder .. "/out/results.json")))
    local lines = lines_of(folder .. "/out/journal.jsonl", '"t":"run"')
    assert.equal(0, sweep(folder, "--over", "word=" .. table.concat(axis, ",")).status)
    assert.equal(lines, lines_of(folder .. "/out/journal.jsonl", '"t":"run"'))
  end)

  it("has axes of every kind, zipped too", function()
    local folder = support.folder()
    scene(folder)
    local function points(...)
      local r = rtray { "sweep", "x.lua", "--dry-run", cwd = folder, ... }
      assert.equal(0, r.status, r.err)
      return r.out
    end
    assert.equal("radius=0.5\nradius=1\nradius=1.5\nradius=2\n", points("--over", "radius=0.5:2")) -- by the declared step
    assert.equal("radius=0.1\nradius=0.2\nradius=0.3\n", points("--over", "radius=0.1:0.3:0.1"))
    assert.equal("count=9\ncount=6\ncount=3\n", points("--over", "count=9:1:-3"))
    assert.equal("workers=1\nworkers=2\nworkers=4\nworkers=8\nworkers=16\n", points("--over", "workers=1:16:*2"))
    assert.equal("size=500x500\nsize=1000x700\n", points("--over", "size=500x500,1000X700"))
    assert.equal("tint={1,0,0}\ntint={0,1,0.5}\ntint=#00ff00\n", points("--over", "tint={1,0,0},{0,1,0.5},#00ff00"))
    assert.equal("mood=day\nmood=night\n", points("--over", "mood=*"))
    assert.equal("seen=true\nseen=false\n", points("--over", "seen=*"))
    assert.equal("set=large\n", points("--over", "set=large"))
    assert.equal("max_depth=1\nmax_depth=2\n", points("--over", "max-depth=1:2"))
    assert.equal("count=1, word=a\ncount=2, word=b\n", points("--over", "count=1,2", "--over", "word=a,b", "--zip"))
    assert.equal("size=500x500, workers=1\n", points("--preset", "jpvm"):match "^[^\n]*\n")
    assert.equal(10, select(2, points("--preset", "jpvm"):gsub("\n", "")))
    assert.truthy(points("--preset", "structures"):find("tracer=bvh, builder=spatial\ntracer=kdtree, builder=exact\n", 1, true))
  end)

  it("refuses a wrong command line with status 2", function()
    local folder = support.folder()
    scene(folder)
    local function refused(message, ...)
      local r = sweep(folder, ...)
      assert.equal(2, r.status, r.err)
      assert.truthy(r.err:find(message, 1, true), r.err)
      assert.is_false(support.exists(folder .. "/out"))
    end
    refused("there is no axis")
    refused("--over radiu: the sweep has no parameter or setting 'radiu'; did you mean radius?", "--over", "radiu=1,2")
    refused("--over radius: there are no values", "--over", "radius=")
    refused("--over radius: a value between the commas is empty", "--over", "radius=1,,2")
    refused("from 1 by steps of -1 one never comes to 2; the step needs the other sign", "--over", "radius=1:2:-1")
    refused("the step of '1:2:0' is zero", "--over", "radius=1:2:0")
    refused("from 1 by factors of 0.5 one never comes to 8", "--over", "workers=1:8:*0.5")
    refused("--over radius: radius must be a number from 0.1 to 2; got 'nan'", "--over", "radius=nan")
    refused("the step of a range must be a number; got 'nan'", "--over", "radius=1:2:nan")
    refused("--over radius: radius must be from 0.1 to 2; got 3", "--over", "radius=1,3")
    refused("--over count: count must be a whole number from 1 to 9; got '1.5'", "--over", "count=1.5")
    refused("--over workers: workers must be a whole number; got 'many'", "--over", "workers=many")
    refused("'0:1:1e-9' is 1000000001 values; at most 100000 are taken", "--over", "radius=0:1:1e-9")
    refused("the axes make 1000000000 points; at most 100000 are taken", "--over", "seed=1:1000", "--over", "shadow_samples=1:1000", "--over",
      "ao_samples=1:1000")
    refused("the axis is given twice", "--over", "radius=1", "--over", "radius=2")
    refused("the point radius=1 is there twice", "--over", "radius=1,1.0")
    refused("--zip pairs the values, and here are 2 of them, but radius has 1", "--zip", "--over", "radius=1", "--over", "count=1,2")
    refused("a whole number from 1 to 1000 is expected", "--over", "radius=1", "--runs", "0")
    refused("NAME=VALUES is expected", "--over", "radius")
    refused("transport: threads (this build has no other) is expected", "--over", "transport=mpi")
    refused("--reference: radius has no value '7'", "--over", "radius=1", "--reference", "radius=7")
    refused("known are jpvm", "--preset", "jvm")
  end)

  it("refuses folders that it cannot or should not use with status 1", function()
    local folder = support.folder()
    scene(folder)
    local function refused(message, out, ...)
      local r = rtray { "sweep", "x.lua", "-q", "--over", "radius=1", "-o", out, cwd = folder, ... }
      assert.equal(1, r.status, r.err)
      assert.truthy(r.err:find(message, 1, true), r.err)
    end
    refused("cannot be made: File exists", "x.lua")
    refused("the folder '/proc/none' cannot be made", "/proc/none")
    for _, name in ipairs { "results.csv", "contact.png", "contact-2.png" } do -- a picture of somebody's, too, perhaps one that the scene reads
      support.shell("rm -rf mine && mkdir mine && touch mine/" .. name, folder)
      refused("'mine' holds " .. name .. ", but no journal of a sweep", "mine")
    end
    assert.equal(0, sweep(folder, "--over", "radius=1").status)
    support.write(folder .. "/y.lua", SCENE)
    local r = rtray { "sweep", "y.lua", "-q", "--over", "radius=1", "-o", "out", cwd = folder }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("'out' holds a sweep of 'x.lua'; choose another folder", 1, true), r.err)
    assert.equal(0, rtray({ "sweep", "y.lua", "-q", "--over", "radius=1", "-o", "out", "--restart", cwd = folder }).status)
    r = rtray { "sweep", "none.lua", "-q", "--over", "radius=1", cwd = folder }
    assert.equal(1, r.status)
    assert.truthy(r.err:find("'none.lua' cannot be read", 1, true), r.err)
    scene(folder, "return 5")
    assert.equal(1, sweep(folder, "--over", "radius=1", "--restart").status)
  end)

  it("mixes no rows of another machine unless told to, and then marks them", function()
    local folder = support.folder()
    scene(folder)
    assert.equal(0, sweep(folder, "--over", "radius=1").status)
    local journal = folder .. "/out/journal.jsonl"
    local mine = support.read(journal):match '"fingerprint":"(%x+)"'
    support.write(journal, (support.read(journal):gsub(mine, ("0"):rep(32)):gsub('"cpu":"[^"]*"', '"cpu":"Other CPU"')))
    local r = sweep(folder, "--over", "radius=1,2")
    assert.equal(1, r.status)
    assert.truthy(r.err:find("holds 1 run of another machine or version (Other CPU", 1, true), r.err)
    r = sweep(folder, "--over", "radius=1,2", "--force")
    assert.equal(0, r.status, r.err)
    local rows = read_csv(folder .. "/out/results.csv")
    assert.same({ ("0"):rep(32), mine }, { rows[1].machine, rows[2].machine })
    assert.equal(0, sweep(folder, "--over", "radius=1,2", "--restart").status)
    assert.equal(mine, read_csv(folder .. "/out/results.csv")[1].machine)
  end)

  it("lets one process at a time into a folder", function()
    local folder = support.folder()
    scene(folder, (SCENE:gsub('error%(.-%)', "while true do end")))
    local slow = support.command { "sweep", "x.lua", "-o", "out", "-q", "--over", "word=bad", "--timeout", "3" }
    local second = support.command { "sweep", "x.lua", "-o", "out", "-q", "--over", "word=good" }
    local r = support.shell(slow .. " & until [ -s out/journal.jsonl ]; do sleep 0.01; done; " .. second .. "; echo $?; " .. second
      .. " --wait; echo $?; wait", folder)
    assert.equal("1\n0\n", r.out, r.err)
    assert.truthy(r.err:find("another process works on 'out'; --wait waits until it has ended", 1, true), r.err)
    assert.truthy(r.err:find("another process works on 'out'; waiting for it", 1, true), r.err)
  end)

  it("that was killed is shown by rtray report: its tables are made from the journal", function()
    local folder = support.folder()
    scene(folder)
    local args = { "sweep", "x.lua", "-o", "out", "-q", "-n", "512", "--over", "word=a,\255", "--over", "size=12x8,4000x3000",
      "--zip", "--runs", "1" }
    local r = support.ended(args, "KILL", "grep -q '\"t\":\"run\"' out/journal.jsonl", folder)
    assert.same({ true, 137 }, { r.met, r.status })
    assert.is_false(support.exists(folder .. "/out/results.json"))
    r = rtray { "report", "out", "--no-plots", cwd = folder }
    assert.equal(0, r.status, r.err)
    local rows = read_csv(folder .. "/out/results.csv")
    assert.same({ "done", "missing", "\255" }, { rows[1].status, rows[2].status, rows[2].word })
    assert.is_true(tonumber(rows[1].seconds_median) > 0 and support.exists(folder .. "/out/" .. rows[1].image))
    local page = support.read(folder .. "/out/index.html")
    assert.truthy(page:find("1 point not measured yet", 1, true) and page:find(rows[1].image, 1, true))
    local before = support.read(folder .. "/out/results.json")
    assert.equal(0, rtray({ "report", "out", "--no-plots", cwd = folder }).status) -- made once: newer than the journal
    assert.equal(before, support.read(folder .. "/out/results.json"))
  end)

  it("has the same tables from its journal as at its end", function()
    local folder = support.folder()
    scene(folder)
    assert.equal(1, sweep(folder, "--over", "word=good,bad", "--over", "samples=1,4", "--reference", "samples=4", "--no-report").status)
    local names = { "results.json", "results.csv", "runs.csv" }
    local before = {}
    for i, name in ipairs(names) do
      before[i] = support.read(folder .. "/out/" .. name)
      os.remove(folder .. "/out/" .. name)
    end
    assert.equal(0, rtray({ "report", "out", "--no-plots", cwd = folder }).status)
    for i, name in ipairs(names) do
      assert.equal(before[i], support.read(folder .. "/out/" .. name))
    end
    assert.truthy(before[1]:find('"map":"maps/', 1, true))
    assert.truthy(support.read(folder .. "/out/index.html"):find('data%-map="maps/[^"]+%.png" data%-mean="0%.%d+"'))
    assert.truthy(support.read(folder .. "/out/index.html"):find('value="flip"', 1, true))
  end)

  it("is ended by a signal at any stage, and its processes with it", function()
    local folder = support.folder()
    scene(folder)
    local args = { "sweep", "x.lua", "-o", "out", "--over", "radius=0.5,1", "--size", "2000x1500", "-n", "65536" }
    local runs = "grep -q 'runs here' \"$LOG\" && test -s out/journal.jsonl"
    scene(folder, "io.stderr:write 'runs here\\n'\n" .. SCENE)
    local r = support.ended(args, "INT", "test $(grep -c 'runs here' \"$LOG\") -ge 4", folder) -- described three times, then rendered
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("interrupted; what is finished is in 'out', and the same command goes on", 1, true), r.err)
    assert.truthy(r.err:find("; 'out/index.html' shows it", 1, true), r.err)
    assert.truthy(support.read(folder .. "/out/index.html"):find("2 points not measured yet", 1, true))
    local left = support.shell("for p in /proc/[0-9]*; do readlink $p/cwd; done | grep -Fxc " .. support.quote(folder)).out
    assert.equal("0\n", left) -- processes that still work in the folder
    assert.is_true(support.exists(folder .. "/out/results.csv"))
    scene(folder, "io.stderr:write 'runs here\\n' while true do end")
    args[#args + 1] = "--restart"
    r = support.ended(args, "TERM", runs, folder)
    assert.same({ true, 143 }, { r.met, r.status }, r.err)
    scene(folder, "io.stderr:write 'runs here\\n'\n" .. SCENE)
    args[#args + 1] = "--in-process"
    r = support.ended(args, "INT", runs, folder)
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
  end)

  it("compares images with a reference's", function()
    local folder = support.folder()
    scene(folder)
    assert.equal(0, sweep(folder, "--over", "samples=1:16:*4", "--over", "radius=1,2", "--reference", "samples=16").status)
    local rows = read_csv(folder .. "/out/results.csv")
    assert.is_true(tonumber(rows[1].psnr) > 10 and tonumber(rows[3].psnr) > tonumber(rows[1].psnr))
    assert.equal("0", rows[5].differing)
    assert.is_true(tonumber(rows[2].flip) > tonumber(rows[4].flip) and tonumber(rows[4].flip) > 0 and tonumber(rows[1].ssim) < 1)
    assert.equal("0", rows[5].flip)
    assert.equal("", rows[5].psnr) -- of equal images it is infinite
  end)

  it("takes columns of one's own from a file", function()
    local folder = support.folder()
    scene(folder)
    support.write(folder .. "/m.lua", [[return function(image, stats, point)
      return { mean_red = image:stats().mean[1], twice = 2 * point.values.radius, rate = stats.rays, note = point.label .. ", quoted" } end]])
    assert.equal(0, sweep(folder, "--over", "radius=0.5,1", "--measure", "m.lua").status)
    local rows = read_csv(folder .. "/out/results.csv")
    assert.same({ "1", "2" }, { rows[1].twice_median, rows[2].twice_median })
    assert.equal("radius=1, quoted", rows[2].note)
    assert.is_true(tonumber(rows[1].mean_red_median) > 0)
    for text, message in pairs {
      ["return function() return 5 end"] = "measure must return a table",
      ["return function() return { seconds = 1 } end"] = "measure: seconds is the name of a column of the sweep's own",
      ["return function() return { ['a b'] = 1 } end"] = "measure: 'a b' is no name of a column",
      ["return 7"] = "a measure file must return a function",
      ["return function() error('oh', 0) end"] = "oh",
      ["return ("] = "unexpected symbol",
    } do
      support.write(folder .. "/m.lua", text)
      local r = sweep(folder, "--over", "radius=0.5,1", "--measure", "m.lua")
      assert.equal(1, r.status)
      assert.truthy(r.err:find(message, 1, true), r.err)
    end
    assert.equal(1, sweep(folder, "--over", "radius=1", "--measure", "none.lua").status)
  end)

  it("says loudly when images differ that must not", function()
    local folder = support.folder()
    scene(folder)
    assert.equal(0, sweep(folder, "--over", "workers=1,2", "--runs", "1").status)
    local journal = folder .. "/out/journal.jsonl"
    local text = support.read(journal)
    local hash = text:match '"t":"run".-"hash":"(%x+)"'
    support.write(journal, (text:gsub('("t":"run".-"hash":")' .. hash, "%1" .. ("f"):rep(32), 1)))
    local r = sweep(folder, "--over", "workers=1,2", "--runs", "1", "--no-images")
    assert.equal(4, r.status, r.err)
    assert.truthy(r.err:find("THE IMAGES DIFFER: settings that must not change the image did: workers=1 and workers=2", 1, true), r.err)
    assert.truthy(support.read(folder .. "/out/results.json"):find('"conflicts":[{"message"', 1, true))
  end)

  it("shows its table, its study, and the results as JSON", function()
    local folder = support.folder()
    scene(folder)
    local r = rtray { "sweep", "x.lua", "--preset", "weak", "-o", "out", cwd = folder }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find("efficiency", 1, true))
    r = rtray { "sweep", "x.lua", "--over", "workers=1,500", "--runs", "1", "-o", "two", "--no-report", cwd = folder }
    assert.truthy(r.out:find("more workers than the %d+ CPUs"), r.out)
    r = rtray { "sweep", "x.lua", "--over", "workers=1,500", "--runs", "1", "-o", "two", "--no-report", "--json", cwd = folder }
    assert.equal(support.read(folder .. "/two/results.json"), r.out)
    assert.truthy(r.out:find('"oversubscribed":true', 1, true))
  end)
end)
