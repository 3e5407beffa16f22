-- --limit time=T,memory=M: what runs away is ended wherever it is, and the sentence says what ran out and where.

local support = require "support"
local rtray = support.rtray

local HEAD = [[
local rt = require "rt"
local function scene(more)
  local t = { settings = { width = 64, height = 48, samples = 1 }, rt.point_light { at = {5, 5, 5} }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
  for k, v in pairs(more or {}) do t[k] = v end
  return rt.scene(t)
end
]]

local function run(lines, limit, ...)
  local folder = support.folder()
  support.write(folder .. "/s.lua", HEAD .. lines)
  local r = rtray { "render", "s.lua", "-q", "-o", "s.png", "--limit", limit, cwd = folder, tail = "; echo $? >status", ... }
  r.status = tonumber(support.read(folder .. "/status"))
  return r, folder
end

local IN_SCRIPT = "the time limit of 200ms ran out in the script"
local RAN_OUT = {
  { "an endless loop", [[while true do end]], "time=200ms", IN_SCRIPT },
  { "an endless loop that catches errors", [[while true do pcall(function() while true do end end) end]], "time=200ms",
    IN_SCRIPT },
  { "an endless coroutine", [[coroutine.wrap(function() while true do end end)()]], "time=200ms", IN_SCRIPT },
  { "a search that takes for ever", [[(("a"):rep(3000)):find((".-"):rep(30) .. "b")]], "time=200ms", IN_SCRIPT },
  { "a move of the whole integer range", [[table.move({}, 1, math.maxinteger - 1, 2)]], "time=200ms", IN_SCRIPT },
  { "an endless __index", [[local t = setmetatable({}, { __index = function(t, k) return t[k + 1] end })
    pcall(function() return t[1] end) while true do end]], "time=200ms", IN_SCRIPT },
  { "a string that fills the memory", [[local s = ("x"):rep(1 << 30)]], "memory=64M", "the memory limit of 64M ran out in the script" },
  { "strings that fill the memory", [[local t = {} while true do pcall(function() t[#t + 1] = ("x"):rep(1000000) .. #t end) end]],
    "memory=64M,time=1s", "ran out in the script" },
  { "tables that fill the memory", [[local t = {} for i = 1, 1e9 do t[i] = {} end]], "memory=64M", "the memory limit of 64M ran out in the script" },
  { "an image that fills the memory", [[rt.image { width = 4000, height = 4000 }]], "memory=64M", "the memory limit of 64M ran out in the script" },
  { "a buffer that fills the memory", [[rt.buffer("f32", 1 << 28)]], "memory=64M", "the memory limit of 64M ran out in the script" },
}

describe("--limit", function()
  for _, case in ipairs(RAN_OUT) do
    it("ends " .. case[1], function()
      local r, folder = run(case[2] .. "\nreturn scene()", case[3])
      assert.equal(1, r.status, r.err)
      assert.truthy(r.err:find(case[4], 1, true), r.err)
      assert.equal(1, select(2, r.err:gsub("\n", "")), r.err)
      assert.is_false(support.exists(folder .. "/s.png"))
    end)
  end

  it("ends a long build", function()
    local lines = [[
      local x = rt.buffer("f32", 2400000)
      for i = 1, #x do x[i] = i * 7919.37 % 1000 end
      return scene { settings = { accel = "kdtree", builder = "exact", width = 8, height = 6 }, rt.spheres { centers = x, radius = 6 } }]]
    local r
    local low, time, high = 100, 2000, 16000 -- milliseconds: the script before and the render behind the build take their time, too
    for _ = 1, 20 do
      r = run(lines, ("time=%dms"):format(time))
      if r.err:find("ran out in the build of the trees", 1, true) then
        assert.equal(1, r.status, r.err)
        return
      end
      if r.err:find("ran out in the script", 1, true) then
        low = time
      else
        high = time
      end
      if high - low < 100 then -- the machine's pace has changed meanwhile
        low, high = 100, 16000
      end
      time = (low + high) // 2
    end
    error(r.err)
  end)

  it("keeps what is finished of a render whose time runs out", function()
    local r, folder
    for _, seconds in ipairs { 1, 4, 16, 64 } do -- the script takes its time, too, and the first tile
      r, folder = run("return scene { settings = { width = 1000, height = 1000, samples = 65536, workers = 1, tile = 1 } }",
        ("time=%ds"):format(seconds))
      if r.err:find("what is finished is in", 1, true) then
        break
      end
    end
    assert.equal(1, r.status, r.err)
    assert.truthy(r.err:find "the time limit of %d+s ran out in the render at ", r.err)
    assert.truthy(r.err:find("what is finished is in 's.png'", 1, true), r.err)
    assert.is_true(support.exists(folder .. "/s.png"))
    assert.equal("", support.shell("ls | grep part; true", folder).out)
  end)

  it("counts a render's memory", function()
    local r = run("return scene { settings = { width = 4000, height = 4000, samples = 1 } }", "memory=64M", "--preview", "p.png")
    assert.equal(1, r.status, r.err)
    assert.truthy(r.err:find("the memory limit of 64M ran out in the render", 1, true), r.err)
  end)

  it("lets what stays below be", function()
    local r = run("return scene()", "time=1m,memory=1G")
    assert.equal(0, r.status, r.err)
    assert.equal("", r.err)
    local folder = support.folder()
    r = rtray { "verify", support.small(folder), "-q", "--size", "8x6", "--workers", "1", "--tiles", "8", "--limit", "time=1m", "--trust" }
    assert.equal(0, r.status, r.err)
  end)

  it("reads its values strictly", function()
    for text, words in pairs { ["time=0s"] = "a time is expected", ["time=1y"] = "a time is expected", ["memory=1"] = "at least 1M",
      ["memory=x"] = "a number of bytes", ["speed=1"] = "time=T, memory=M", [""] = "time=T, memory=M", ["time"] = "time=T, memory=M" } do
      local r = rtray { "info", support.small(), "--limit", text }
      assert.equal(2, r.status, text)
      assert.truthy(r.err:find(words, 1, true), r.err)
    end
  end)
end)
