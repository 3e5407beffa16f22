-- tests/bench/frames: a program in C that times frames of a saved scene by workers, beside as many processes.
local support = require "support"
local program = support.program:gsub("[^/]*$", "../tests/bin/frames")

local function run(...)
  local words = { support.quote(program) }
  for _, word in ipairs { ... } do
    words[#words + 1] = support.quote(word)
  end
  return support.shell(table.concat(words, " "))
end

describe("frames", function()
  it("times a saved scene by workers", function()
    local folder = support.folder()
    local script = support.write(folder .. "/save.lua", [[
      local rt = require "rt"
      local scene = rt.scene { camera = rt.camera { eye = { 0, 0, 5 }, look_at = { 0, 0, 0 } }, rt.point_light { at = { 3, 3, 3 } },
        rt.sphere { center = { 0, 0, 0 }, radius = 1, material = rt.classic { color = { 1, 0, 0 } } } }
      scene:save "x.rts"
      return scene]])
    local saved = support.rtray { "render", script, "--trust", "-s", "8x8", "-o", folder .. "/x.png", "-q", cwd = folder }
    assert.equal(0, saved.status, saved.err)
    local r = run(folder .. "/x.rts", "40x30", "2", "2,5", "3")
    assert.equal(0, r.status, r.err)
    local lines = {}
    for line in r.out:gmatch "[^\n]+" do
      lines[#lines + 1] = line
    end
    assert.equal("scene,width,height,samples,workers,runs,seconds,low,high,speedup,ceiling,share", lines[1])
    assert.equal(4, #lines)
    for i, workers in ipairs { 1, 2, 5 } do
      local seconds, low, high, speedup, ceiling, share =
        lines[i + 1]:match(("^x%%.rts,40,30,2,%d,3,([%%d.e+-]+),([%%d.e+-]+),([%%d.e+-]+),([%%d.e+-]+),([%%d.e+-]+),([%%d.e+-]+)$"):format(workers))
      assert.is_true(seconds and tonumber(low) <= tonumber(seconds) and tonumber(seconds) <= tonumber(high), lines[i + 1])
      assert.near(tonumber(speedup), share * ceiling, 0.01 * speedup)
    end
  end)

  it("says what is wrong with its words", function()
    for _, words in ipairs { {}, { "x.rts", "0x3" }, { "x.rts", "8x8x8" }, { "x.rts", "8x8", "0" }, { "x.rts", "8x8", "1", "1" },
      { "x.rts", "8x8", "1", "2,", "3" }, { "x.rts", "8x8", "1", "2", "1000" }, { "x.rts", "8x8", "1", "2", "3", "4" } } do
      local r = run(table.unpack(words))
      assert.equal(2, r.status)
      assert.truthy(r.err:find("usage: frames SNAPSHOT", 1, true))
      assert.equal("", r.out)
    end
    local r = run "none.rts"
    assert.equal(1, r.status)
    assert.truthy(r.err:find("none.rts", 1, true))
  end)
end)
