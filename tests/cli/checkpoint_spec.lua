-- Renders that are killed, interrupted, refused, and go on.

local support = require "support"
local rtray = support.rtray

local function mark(folder, name)
  return (support.shell("ls -i " .. support.quote(name), folder).out:gsub("%s+$", ""))
end

-- Runs the render, ends it at each of its first three checkpoints of some of the picture (one without is a kilobyte or two), each time at one that it
-- has written itself, and lets it be the fourth time; returns how often it was ended so.
local function to_the_end(folder, args, name, signal)
  local kills = 0
  for _ = 1, 3 do
    local event = ('set -- "$(find %s -size +8k -exec ls -i {} +)"; test "$1" && test "$1" != %s'):format(support.quote(name),
      support.quote(mark(folder, name)))
    local r = support.ended(args, signal, event, folder)
    if r.status == 0 then
      return kills
    end
    assert.truthy(r.status == 137 or r.status == 130, r.err)
    kills = kills + (mark(folder, name) ~= "" and 1 or 0)
  end
  args.cwd = folder
  assert.equal(0, rtray(args).status)
  return kills
end

local function args_of(folder, scene, ...)
  return { "render", scene, "-q", "--size", "100x70", "-o", folder .. "/x.png", ... }
end

local function files_of(folder)
  return support.shell("ls -A " .. support.quote(folder) .. " | grep -v '[.]part$'").out
end

-- A render of so many samples that the signal meets it goes on to the file of an undisturbed one.
local function goes_on(signal, ...)
  local more = { ... }
  support.long_enough(function(samples)
    local folder = support.folder()
    local scene = support.small(folder)
    local function args(...)
      local list = args_of(folder, scene, "-n", tostring(samples), table.unpack(more))
      return table.move({ ... }, 1, select("#", ...), #list + 1, list)
    end
    local state = "the $(state) 'of' it"
    local kills = to_the_end(folder, args("--checkpoint", folder .. "/" .. state, "--every", "0.01", "--workers", "1"), state, signal)
    local got = support.read(folder .. "/x.png")
    assert.equal("small.lua\nx.png\n", files_of(folder)) -- the checkpoint is gone
    if kills == 0 then
      return nil
    end
    assert.equal(0, rtray(args()).status)
    assert.equal(support.read(folder .. "/x.png"), got)
    return kills
  end)
end

describe("--checkpoint", function()
  it("goes on after kill -9 and Ctrl-C to the same file", function()
    goes_on "KILL"
    goes_on "INT"
  end)

  it("does so in bands", function()
    goes_on("KILL", "--bands", "--band-memory", "64K")
  end)

  it("refuses what is of another render, and says what differs", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local args = args_of(folder, scene, "--size", "1000x700", "--checkpoint", folder .. "/state", "--every", "0.01", "-n", "65536")
    local r = support.ended(args, "INT", 'test "$(find state -size +8k)"', folder) -- the first one, of nothing, comes before anybody waits
    assert.same({ true, 130 }, { r.met, r.status }, r.err)
    assert.truthy(r.err:find("state' keeps what is done", 1, true), r.err)
    assert.truthy(r.err:find("The same command goes on from it.", 1, true), r.err)
    args[#args] = "65535"
    r = rtray(args)
    assert.equal(1, r.status)
    assert.truthy(r.err:find("samples is 65536 there and 65535 here; remove it or name another file", 1, true), r.err)
    args[#args] = "65536"
    args[#args + 1] = "-Dradius=0.7"
    r = rtray(args)
    assert.equal(1, r.status)
    assert.truthy(r.err:find("another scene", 1, true), r.err)
    support.write(folder .. "/state", "precious")
    r = rtray(args)
    assert.equal(1, r.status)
    assert.truthy(r.err:find("no checkpoint of a render", 1, true), r.err)
    assert.equal("precious", support.read(folder .. "/state"))
  end)

  it("is checked on the command line", function()
    local folder = support.folder()
    local scene = support.small(folder)
    for _, case in ipairs {
      { { "--every", "3" }, "name one" }, { { "--checkpoint", folder .. "/s", "--watch" }, "--watch renders many" },
      { { "--checkpoint", "-" }, "standard output is none" }, { { "--checkpoint", folder .. "/s", "--every", "0" }, "every" },
    } do
      local args = args_of(folder, scene, table.unpack(case[1]))
      local r = rtray(args)
      assert.equal(2, r.status, r.err)
      assert.truthy(r.err:find(case[2], 1, true), r.err)
    end
    local r = rtray(args_of(folder, scene, "--checkpoint", folder .. "/no/such/state"))
    assert.truthy(r.status == 1 or r.status == 3, r.err)
    assert.truthy(r.err:find("no/such", 1, true), r.err)
  end)
end)
