local support = require "support"
local rt = support.rt
local axis = require "rt.axis"
local core = require "rt.core"
local csv = require "rt.csv"
local json = require "rt.json"
local study = require "rt.study"

local function near(a, b, e)
  assert(math.abs(a - b) <= (e or 1e-9) * math.max(1, math.abs(b)), ("%g, not %g"):format(a, b))
end

local SCRIPT = [[
local rt = require "rt"
local p = rt.params { radius = { 1, min = 0.1, max = 2000 }, mood = { "day", choices = { "day", "night" } } }
if p.mood == "night" then
  error("it is too dark", 0)
end
return rt.scene {
  settings = { width = 8, height = 6, samples = 1, workers = 1 }, camera = rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0}, fov = 45 },
  rt.point_light { at = {5, 5, 5} }, rt.sphere { center = {0, 0, 0}, radius = p.radius },
}
]]

describe("quartiles", function()
  it("are those of R and NumPy", function()
    assert.equal(3, study.median { 5, 1, 3 })
    assert.equal(2.5, study.median { 4, 1, 2, 3 })
    near(study.quantile({ 1, 2, 3, 4 }, 0.25), 1.75)
    near(study.quantile({ 1, 2, 3, 4 }, 0.75), 3.25)
    assert.equal(7, study.quantile({ 7 }, 0.25))
    assert.is_nil(study.median {})
  end)
end)

-- Points of a sweep over workers with the given times.
local function points(times, more)
  local list = {}
  for i, t in ipairs(times) do
    list[i] = {
      index = i, values = { workers = tostring(t[1]) }, workers = t[1], status = "done", median = { seconds = t[2] }, derived = {}, key = tostring(i),
    }
    for key, value in pairs(more and more[i] or {}) do
      list[i][key] = value
    end
  end
  return list
end

describe("a study of workers", function()
  it("finds the law that made the times", function()
    local times = {} -- Amdahl with 10% serial, 8 s of work
    for i, w in ipairs { 1, 2, 4, 8, 16 } do
      times[i] = { w, 0.8 + 7.2 / w }
    end
    times[5][2] = 9 -- more workers than CPUs: not fitted
    local list = points(times)
    local groups = study.groups(list, { { name = "workers" } }, 8)
    assert.equal(1, #groups)
    local fit = groups[1].fit
    near(fit.serial_seconds, 0.8)
    near(fit.parallel_seconds, 7.2)
    near(fit.serial_fraction, 0.1)
    near(fit.r2, 1)
    assert.equal(4, fit.points)
    near(list[3].derived.speedup, 8 / 2.6)
    near(list[3].derived.efficiency, 8 / 2.6 / 4)
    for i = 2, 4 do
      near(list[i].derived.serial_fraction, 0.1) -- Karp and Flatt's is constant where Amdahl's law holds
    end
    assert.is_nil(list[1].derived.serial_fraction)
  end)

  it("takes the fewest workers for ideal where one worker is missing", function()
    local list = points { { 4, 10 }, { 8, 5 } }
    study.groups(list, { { name = "workers" } }, 8)
    near(list[1].derived.speedup, 4)
    near(list[2].derived.speedup, 8)
    near(list[2].derived.efficiency, 1)
  end)

  it("judges weak scaling by the pixels", function()
    local list = points({ { 1, 2 }, { 4, 2.5 } }, { { width = 100, height = 100 }, { width = 200, height = 200 } })
    local groups = study.groups(list, { { name = "workers" }, { name = "size" } }, 8, true)
    assert.equal("weak", groups[1].kind)
    near(list[2].derived.efficiency, 0.8)
    near(list[2].derived.speedup, 3.2)
    assert.is_nil(groups[1].fit)
  end)

  it("makes a group of each other axis, and no fit of one count", function()
    local list = points { { 1, 2 }, { 2, 1 }, { 1, 4 } }
    list[1].values.tile, list[2].values.tile, list[3].values.tile = "8", "8", "16"
    local groups = study.groups(list, { { name = "tile" }, { name = "workers" } }, 8)
    assert.equal(2, #groups)
    assert.equal("16", groups[2].values.tile)
    assert.is_nil(groups[2].fit)
    assert.is_nil(groups[1].fit.r2) -- any line meets two points
    assert.same({}, study.groups(list, { { name = "tile" } }, 8))
  end)
end)

describe("JSON", function()
  it("comes back as it went", function()
    local text = "a\"\\\n\t\1é\u{1F600}"
    local o = json.object():set("list", { 1, 0.1, -2e300, true, text }):set("nothing", json.null):set("empty", {})
    local t = json.decode(json.encode(o))
    assert.same({ list = { 1, 0.1, -2e300, true, text }, empty = {} }, t)
    assert.equal("integer", math.type(t.list[1]))
    assert.equal("😀", json.decode [["\ud83d\ude00"]])
  end)

  it("reads numbers strictly", function()
    assert.same({ 0, -0.0, 10, 0.5, -1.25e-3, 2e3 }, json.decode "[0,-0,10,0.5,-1.25E-3,2e+3]")
    for text, words in pairs { ["01"] = "begins with 0", ["-00.5"] = "begins with 0", ["1."] = "no digit behind the point",
      ["[1.]"] = "no digit behind",
      ["1.e5"] = "no digit behind", ["1e"] = "no digit in the exponent", ["1e+"] = "no digit in the exponent", ["+1"] = "no value",
      [".5"] = "no value",
      ["-"] = "no value", ["0x10"] = "behind", ["1.5.2"] = "behind", ["NaN"] = "no value", ["Infinity"] = "no value" } do
      local value, why = json.decode(text)
      assert.is_nil(value, text)
      assert.truthy(why:find(words, 1, true), why)
    end
  end)

  it("refuses what is none, however it is nested", function()
    for _, text in ipairs { "", "{", "[1,]", "{\"a\":}", "\"a", "tru", "[1] 2", "{1:2}", "\"\\q\"", "\"\\u12\"", ("["):rep(100000) } do
      local value, why = json.decode(text)
      assert.is_nil(value)
      assert.truthy(why:find "^byte %d+: ", text)
    end
  end)
end)

describe("CSV", function()
  it("quotes what RFC 4180 asks for", function()
    assert.equal("'=1+1,'@SUM(A1),'-x,\"'+a,b\",'\tx,-1,+2.5e3,-0.5,a=b\r\n",
      csv.row { "=1+1", "@SUM(A1)", "-x", "+a,b", "\tx", "-1", "+2.5e3", -0.5, "a=b" })
    assert.equal('a,,"b,c","d""e","f\ng",0.1,2,true\r\n', csv.row { "a", nil, "b,c", 'd"e', "f\ng", 0.1, 2, true, n = 8 })
  end)
end)

describe("an axis", function()
  it("prints its numbers as short as they can be", function()
    local a = axis.new("x", "0:1:0.1", { { name = "x", type = "number" } })
    assert.same({ "0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1" }, a.values)
    assert.same({ "1e-06", "1e-05", "0.0001", "0.001" }, axis.new("x", "1e-6:1e-3:*10", { { name = "x", type = "number" } }).values)
    assert.same({ "1", "1.5", "2" }, axis.new("x", "1:2.4:0.5", { { name = "x", type = "number" } }).values)
  end)
end)

describe("rt.sweep", function()
  it("runs a script in processes of this interpreter, and gives the results", function()
    support.in_folder(function(folder)
      support.write(folder .. "/x.lua", SCRIPT)
      local results = rt.sweep {
        scene = folder .. "/x.lua", over = { workers = { 1, 2 }, radius = "0.5:1.5:0.5" }, runs = 2, output = folder .. "/out",
        measure = function(image, stats, point)
          local w, h = image:size()
          return { pixels = w * h, half = point.values.radius / 2, same = stats.rays > 0 }
        end,
      }
      assert.equal("radius=0.5, workers=1", results.points[1].label) -- keys come by name
      assert.equal(6, #results.points)
      for _, p in ipairs(results.points) do
        assert.equal("done", p.status)
        assert.same({ 2, 48 }, { #p.runs, p.median.pixels })
        near(p.median.half, tonumber(p.values.radius) / 2)
        assert.equal("true", p.runs[1].same)
        assert.is_true(p.median.process_seconds > p.median.seconds)
      end
      assert.equal(0, #results.conflicts)
      local read = json.decode(io.open(folder .. "/out/results.json"):read "a")
      assert.equal(results.points[6].key, read.points[6].key)
      assert.equal(results.points[6].median.seconds, read.points[6].median.seconds)
    end)
  end)

  it("ends when `measure` is interrupted: its point has not failed", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/x.lua", SCRIPT)
      for _, in_process in ipairs { false, true } do
        local message = support.message(rt.sweep, {
          scene = path, over = { radius = { 1, 2 } }, in_process = in_process, output = folder .. "/out",
          measure = function() error "interrupted!" end, -- as lua5.4 at Ctrl-C
        })
        assert.is_truthy(message:find "interrupted!$", message)
        assert.is_falsy(io.open(folder .. "/out/journal.jsonl"):read("a"):find('"failed"', 1, true))
      end
    end)
  end)

  it("leaves no pixels behind, which go to `measure` by files", function()
    support.in_folder(function(folder)
      local path, names, tmpname = support.write(folder .. "/x.lua", SCRIPT), {}, os.tmpname
      rawset(os, "tmpname", function()
        names[#names + 1] = ("%s/pixels-%d"):format(folder, #names)
        return names[#names]
      end)
      local ok, raised = pcall(function()
        rt.sweep { scene = path, over = { radius = { 1 } }, measure = function() error "it has no size" end }
        rt.sweep {
          scene = path, over = { radius = { 1, 2 } }, runs = 2, reference = "radius=2", output = folder .. "/out", measure = function() return {} end,
        }
      end)
      rawset(os, "tmpname", tmpname)
      assert(ok, raised)
      assert.is_true(#names >= 3)
      for _, name in ipairs(names) do
        assert(not core.file_stat(name), name .. " is still there")
      end
    end)
  end)

  it("is described by code that runs", function()
    local file <close> = assert(io.open "docs/sweep.md")
    local count = 0
    for code in file:read("a"):gmatch "```lua\n(.-)```" do
      count = count + 1
      assert(load(code, "=docs/sweep.md block " .. count))()
    end
    assert.equal(1, count)
  end)

  it("takes a function of the values, without a folder too", function()
    local seen = {}
    local results = rt.sweep {
      scene = function(values)
        seen[#seen + 1] = values.radius
        return rt.scene { rt.sphere { center = { 0, 0, 0 }, radius = values.radius }, rt.point_light { at = { 3, 3, 3 } } }
      end,
      over = { { "radius", { 1, 2 } }, { "samples", "1,4" } }, settings = { size = { 8, 6 } },
    }
    assert.equal("in-process", results.mode)
    assert.equal("radius=1, samples=4", results.points[2].label)
    assert.is_true(math.type(seen[1]) ~= nil)
    assert.equal(4 * results.points[1].median.rays_camera, results.points[2].median.rays_camera)
  end)

  it("parses a mesh and builds its tree once for all points of a process", function()
    support.in_folder(function(folder)
      local lines = {}
      for y = 0, 20 do
        for x = 0, 20 do
          lines[#lines + 1] = ("v %d %d %d"):format(x, y, (x * y) % 5)
        end
      end
      for y = 0, 19 do
        for x = 0, 19 do
          local a = y * 21 + x + 1
          lines[#lines + 1] = ("f %d %d %d\nf %d %d %d"):format(a, a + 1, a + 21, a + 1, a + 22, a + 21)
        end
      end
      support.write(folder .. "/hills.obj", table.concat(lines, "\n") .. "\n")
      support.write(folder .. "/x.lua", [[
        local rt = require "rt"
        local p = rt.params { ior = { 1.5, min = 1, max = 2.5 } }
        return rt.scene {
          settings = { width = 8, height = 6, samples = 1 }, rt.point_light { at = {10, 10, 30} },
          rt.mesh { file = "hills.obj", material = rt.classic { refractiveness = p.ior, transparency = 0.9 } },
        }]])
      local before = rt.counts()
      local results = rt.sweep { scene = folder .. "/x.lua", over = { ior = "1:2:0.25" }, in_process = true }
      local after = rt.counts()
      assert.equal(5, #results.points)
      assert.equal("done", results.points[5].status)
      assert.equal(1, after.files_read - before.files_read)
      assert.equal(1, after.trees_built - before.trees_built)
    end)
  end)

  it("keeps a failing point's message, and raises for a wrong sweep", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/x.lua", SCRIPT)
      local results = rt.sweep { scene = path, over = { mood = "*" }, in_process = true }
      assert.same({ "done", "failed" }, { results.points[1].status, results.points[2].status })
      assert.equal("it is too dark", results.points[2].message)
      local function raises(sentence, t)
        support.raises(sentence, function() rt.sweep(t) return nil end)
      end
      raises("rt.sweep: scene is missing", { over = {} })
      raises("rt.sweep has no key 'ovr'; did you mean over?", { scene = path, ovr = {} })
      raises("rt.sweep: over radius: there are no values; give some, as in { 1, 2, 4 }", { scene = path, over = { radius = {} } })
      raises("rt.sweep: over rdius: the sweep has no parameter or setting 'rdius'; did you mean radius?", { scene = path, over = { rdius = { 1 } } })
      raises("rt.sweep: runs must be a whole number from 1 to 100000; got 0", { scene = path, runs = 0 })
      raises("rt.sweep: a reference is kept in the output folder; output is missing", { scene = path, reference = "radius=1" })
      raises("rt.sweep: a timeout ends processes of runs, and with in_process there are none", { scene = path, in_process = true, timeout = 1 })
    end)
  end)

  it("adds no memory to many points, and tells the time it adds", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/x.lua", SCRIPT) -- of one worker: with two the peak tells when both are first at work together
      local full = os.getenv "LIBRT_FULL" == "1"
      local count, peaks = full and 1000 or 300, {}
      local begun, work = os.clock(), 0
      local results = rt.sweep {
        scene = path, over = { radius = ("1:%d"):format(count) }, in_process = true, output = folder .. "/out",
        measure = function()
          if #peaks % 10 == 0 then -- the peak is to show what is kept, not how much garbage a cycle of Lua's collector happens to meet
            local at = os.clock()
            collectgarbage()
            begun = begun + (os.clock() - at)
          end
          peaks[#peaks + 1] = core.usage().max_rss
          return {}
        end,
      }
      local took = os.clock() - begun -- CPU time: others may be at work on this machine
      for _, p in ipairs(results.points) do
        work = work + p.median.seconds + p.median.build_seconds + p.median.load_seconds
      end
      assert.equal(count, #peaks)
      print(("# %.2f ms of CPU a point beside its work (5 ms is the goal)"):format((took - work) / count * 1000))
      if not os.getenv "RT_TEST_SLOW" then
        assert(peaks[count] <= 1.01 * peaks[100], ("peak memory grows from %d to %d"):format(peaks[100], peaks[count]))
      end
    end)
  end)
end)
