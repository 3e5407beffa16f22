-- Renders that are killed, interrupted, refused, and go on.

local support = require "support"
local rtray = support.rtray

-- Runs the render until it ends by itself, killing it at other moments each time; returns how often it was killed.
local function to_the_end(args, signal)
  local at = { 0.15, 0.3, 0.2, 0.4, 0.25 }
  for kills = 0, 200 do
    local seconds = at[kills % #at + 1] * (1 + kills // 10) -- it ends on a busy machine too
    local r = support.shell(("timeout --preserve-status -s %s %g %s"):format(signal, seconds, support.command(args)))
    if r.status == 0 then
      return kills
    end
    assert.truthy(r.status == 137 or r.status == 130, r.err)
  end
  error "it never ended"
end

local function args_of(folder, scene, ...)
  return { "render", scene, "-q", "--size", "200x140", "-n", "24", "-o", folder .. "/x.png", ... }
end

local function files_of(folder)
  return support.shell("ls -A " .. support.quote(folder) .. " | grep -v '[.]part$'").out
end

describe("--checkpoint", function()
  it("goes on after kill -9 and Ctrl-C to the same file", function()
    for _, signal in ipairs { "KILL", "INT" } do
      local folder = support.folder()
      local scene = support.small(folder)
      assert.equal(0, rtray(args_of(folder, scene)).status)
      local want = support.read(folder .. "/x.png")
      os.remove(folder .. "/x.png")
      local state = folder .. "/the $(state) 'of' it"
      local kills = to_the_end(args_of(folder, scene, "--checkpoint", state, "--every", "0.01"), signal)
      assert.is_true(kills >= 1)
      assert.equal(want, support.read(folder .. "/x.png"))
      assert.equal("small.lua\nx.png\n", files_of(folder)) -- the checkpoint is gone
    end
  end)

  it("does so in bands, and makes no finished band again", function()
    local folder = support.folder()
    local scene = support.small(folder)
    assert.equal(0, rtray(args_of(folder, scene, "--bands", "--band-memory", "64K")).status)
    local want = support.read(folder .. "/x.png")
    os.remove(folder .. "/x.png")
    local args = args_of(folder, scene, "--bands", "--band-memory", "64K", "--checkpoint", folder .. "/state", "--every", "0.01")
    assert.is_true(to_the_end(args, "KILL") >= 1)
    assert.equal(want, support.read(folder .. "/x.png"))
    assert.equal("small.lua\nx.png\n", files_of(folder))
  end)

  it("refuses what is of another render, and says what differs", function()
    local folder = support.folder()
    local scene = support.small(folder)
    local args = args_of(folder, scene, "--checkpoint", folder .. "/state", "-n", "4096")
    local r = support.shell("timeout --preserve-status -s INT 0.5 " .. support.command(args))
    assert.equal(130, r.status, r.err)
    assert.truthy(r.err:find("state' keeps what is done", 1, true), r.err)
    assert.truthy(r.err:find("The same command goes on from it.", 1, true), r.err)
    args[#args] = "4095"
    r = rtray(args)
    assert.equal(1, r.status)
    assert.truthy(r.err:find("samples is 4096 there and 4095 here; remove it or name another file", 1, true), r.err)
    args[#args] = "4096"
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
