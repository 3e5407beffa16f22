local support = require "support"

local ENDLESS = "local n = 0\nwhile true do n = n + 1 end\n"

-- Longer than anybody waits, of tiles that are soon finished.
local function long_render(folder, ...)
  support.small(folder)
  return { "render", "small.lua", "--size", "1000x750", "-n", "65536", "--tile", "4", "--progress", "json", "-o", "x.png", ... }
end

local FINISHED = [[grep -q '"done":[0-9.e-]*[1-9]' "$LOG"]] -- some of the picture

-- A script that says when it is there.
local function at(folder, lines)
  support.write(folder .. "/x.lua", "io.stderr:write 'it runs'\n" .. lines)
  return { "render", "x.lua" }, 'grep -q "it runs" "$LOG"'
end

describe("a signal", function()
  it("ends a render, saves what is finished and says how to go on", function()
    for _, case in ipairs { { "INT", 130, "black" }, { "TERM", 143, "transparent", "--alpha" } } do
      local folder = support.folder()
      local r = support.ended(long_render(folder, case[4]), case[1], FINISHED, folder)
      assert.same({ true, case[2] }, { r.met, r.status }, r.err)
      assert.truthy(r.err:find("interrupted at %d+%%; what is finished is in 'x.png', the rest is " .. case[3] .. "%."), r.err)
      assert.truthy(r.err:find("The same command renders it whole", 1, true), r.err)
      assert.equal("\137PNG", support.read(folder .. "/x.png"):sub(1, 4))
    end
  end)

  it("that comes before anything is finished leaves no file", function()
    local folder = support.folder()
    local r = support.ended(long_render(folder, "--tile", "1024"), "INT", 'grep -q progress "$LOG"', folder)
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("interrupted at 0%; nothing was finished, so nothing was written", 1, true), r.err)
    assert.is_false(support.exists(folder .. "/x.png"))
  end)

  it("keeps the old file when an image is made in bands", function()
    local folder = support.folder()
    support.write(folder .. "/x.png", "old")
    local r = support.ended(long_render(folder, "--bands"), "INT", FINISHED, folder)
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("is as it was", 1, true), r.err)
    assert.equal("old", support.read(folder .. "/x.png"))
    assert.equal("x.png\n", support.shell("ls " .. support.quote(folder) .. " | grep -v small.lua").out)
    r = support.ended(long_render(folder, "--bands", "--tile", "1024"), "INT", 'grep -q progress "$LOG"', folder) -- within its first tile
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("interrupted at 0%; an image in bands is written whole or not at all", 1, true), r.err)
  end)

  it("ends a script that runs for ever", function()
    local folder = support.folder()
    local args, event = at(folder, ENDLESS)
    local r = support.ended(args, "INT", event, folder)
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("interrupted", 1, true), r.err)
  end)

  it("that comes again ends at once, also a script that catches the first", function()
    local folder = support.folder()
    local args, event = at(folder, "while true do pcall(function() while true do end end) end")
    local r = support.ended(args, "TERM", event, folder, "kill -TERM $(cat pid)")
    assert.same({ true, 143 }, { r.met, r.status }, r.err)
  end)

  it("that the starter ignores stays ignored", function()
    local folder = support.folder()
    local command = support.command { "render", support.small(folder), "-n", "16", "--size", "300x200", "-q", "-o", folder .. "/x.png" }
    local line = "trap '' INT; " .. command .. " & pid=$!; sleep 0.1; kill -INT $pid; wait $pid"
    local r = support.shell("bash -c " .. support.quote(line))
    assert.equal(0, r.status, r.err)
  end)
end)

describe("--watch", function()
  -- Starts a watching render in the background, runs the shell lines, ends it; its standard error comes back.
  local function watching(folder, lines)
    local log = folder .. "/log"
    local command = support.command { "render", folder .. "/s.lua", "--watch", "-o", folder .. "/x.png" }
    local script = { command .. " 2>" .. support.quote(log) .. " & pid=$!", [[
until_log() { i=0; until [ "$(grep -c "$1" log)" -ge "$2" ]; do i=$((i+1)); [ $i -gt 200 ] && break; sleep 0.05; done; }]],
      "until_log 'waiting for a change' 1" }
    for _, line in ipairs(lines) do
      script[#script + 1] = line
    end
    script[#script + 1] = "kill -TERM $pid; wait $pid; echo $?"
    support.write(folder .. "/try.sh", table.concat(script, "\n"))
    local r = support.shell("bash try.sh", folder)
    return support.read(log), r
  end

  it("renders again when the script changes, and goes on after a fault", function()
    local folder = support.folder()
    support.small(folder, "s.lua")
    support.write(folder .. "/bad", "return rt.scene {")
    support.write(folder .. "/good", (support.SMALL:gsub("width = 40", "width = 41")))
    local log, r = watching(folder, {
      "cp bad s.lua", "until_log 'near <eof>' 1", "cp good s.lua", "until_log '41x30' 1",
    })
    assert.truthy(log:find("40x30", 1, true), log)
    assert.truthy(log:find("near <eof>", 1, true), log)
    assert.truthy(log:find("s.lua has changed", 1, true), log)
    assert.truthy(log:find("41x30", 1, true), log)
    assert.equal("143\n", r.out)
  end)

  it("looks at the files that the script uses", function()
    local folder = support.folder()
    support.write(folder .. "/part.lua", "return 0.5")
    support.write(folder .. "/t.jpg", support.read(support.source .. "/scenes/flower.jpg"))
    support.write(folder .. "/s.lua", (support.SMALL:gsub("radius = p.radius", "radius = require 'part'")
      :gsub("normal = {0, 1, 0} }", "normal = {0, 1, 0}, material = rt.classic { texture = 't.jpg' } }")))
    local log = watching(folder, {
      "echo 'return 0.75' > part.lua", "until_log 'x.png: 40x30' 2", "until_log 'waiting for a change' 2", "touch t.jpg",
      "until_log 'x.png: 40x30' 3",
    })
    assert.truthy(log:find("part.lua has changed", 1, true), log)
    assert.truthy(log:find("t.jpg has changed", 1, true), log)
    local _, renders = log:gsub("x%.png: 40x30", "")
    assert.equal(3, renders)
  end)
end)
