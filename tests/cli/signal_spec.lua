local support = require "support"

local ENDLESS = "local n = 0\nwhile true do n = n + 1 end\n"

-- Runs the program, sends it a signal after some seconds, returns what support.shell does. A process that a shell starts in the background
-- ignores SIGINT; one started by timeout does not.
local function interrupted(args, signal, seconds)
  return support.shell(("timeout --preserve-status -s %s -k 20 %s %s"):format(signal, seconds, support.command(args)))
end

local function long_render(folder)
  return { "render", support.small(folder), "--size", "800x600", "-n", "4096", "-o", folder .. "/x.png" }
end

describe("a signal", function()
  it("ends a render, saves what is finished and says how to go on", function()
    for signal, status in pairs { INT = 130, TERM = 143 } do
      local folder = support.folder()
      local r = interrupted(long_render(folder), signal, 2)
      assert.equal(status, r.status, r.err)
      assert.truthy(r.err:find "interrupted at %d+%%; ", r.err)
      if r.err:find("nothing was finished", 1, true) then
        assert.is_false(support.exists(folder .. "/x.png"))
      else
        assert.truthy(r.err:find("The same command renders it whole", 1, true), r.err)
        assert.equal("\137PNG", support.read(folder .. "/x.png"):sub(1, 4))
        assert.truthy(r.err:find("x.png", 1, true))
      end
    end
  end)

  it("ends a render within a second", function()
    local folder = support.folder()
    local line = support.command(long_render(folder))
    local r = support.shell("bash -c " .. support.quote("exec 2>/dev/null; time -p timeout -s TERM 1 " .. line .. " 2>err") .. " 2>time; cat err")
    assert.truthy(r.out:find("interrupted at", 1, true), r.out)
  end)

  it("keeps the old file when an image is made in bands", function()
    local folder = support.folder()
    support.write(folder .. "/x.png", "old")
    local args = long_render(folder)
    args[#args + 1] = "--bands"
    local r = interrupted(args, "INT", 2)
    assert.equal(130, r.status, r.err)
    assert.truthy(r.err:find("is as it was", 1, true), r.err)
    assert.equal("old", support.read(folder .. "/x.png"))
    assert.equal("x.png\n", support.shell("ls " .. support.quote(folder) .. " | grep -v small.lua").out)
  end)

  it("ends a script that runs for ever", function()
    local folder = support.folder()
    local r = interrupted({ "render", support.write(folder .. "/x.lua", ENDLESS) }, "INT", 0.5)
    assert.equal(130, r.status, r.err)
    assert.truthy(r.err:find("interrupted", 1, true), r.err)
  end)

  it("that comes twice ends at once, also a script that catches the first", function()
    local folder = support.folder()
    local script = support.write(folder .. "/x.lua", "while true do pcall(function() while true do end end) end")
    local line = ("%s & pid=$!; sleep 0.5; kill -TERM $pid; sleep 0.3; kill -TERM $pid; wait $pid"):format(support.command { "render", script })
    local r = support.shell("bash -c " .. support.quote(line .. "; exit $?"))
    assert.equal(143, r.status, r.err)
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
