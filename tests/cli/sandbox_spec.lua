-- A script from a stranger: what it cannot do, and the sentence that says so.

local support = require "support"
local rtray = support.rtray

local SCENE = [[
local rt = require "rt"
local scene = rt.scene { settings = { width = 8, height = 6, samples = 1 }, rt.sphere { center = {0, 0, 0}, radius = 1 } }
]]

-- Runs Lua lines in a scene script; gives what it printed and the rest.
local function script(lines, more)
  local folder = support.folder()
  support.write(folder .. "/evil.lua", SCENE .. lines .. "\nreturn scene\n")
  local args = { "render", "evil.lua", "-q", "-o", "evil.png", cwd = folder }
  for _, arg in ipairs(more or {}) do
    args[#args + 1] = arg
  end
  return rtray(args), folder
end

local READS = "a script in the sandbox reads below its own folder only"
local WRITES = "a script in the sandbox writes"
local NOT_THERE = "is not there for a script in the sandbox"

-- { what is tried, the words of the sentence }
local ATTACKS = {
  { [[os.execute "touch pwned"]], "os.execute " .. NOT_THERE }, { [[io.popen("id"):read "a"]], "io.popen " .. NOT_THERE },
  { [[os.remove "evil.lua"]], "os.remove " .. NOT_THERE }, { [[os.rename("evil.lua", "x.lua")]], "os.rename " .. NOT_THERE },
  { [[os.exit(0)]], "os.exit " .. NOT_THERE }, { [[os.getenv "HOME"]], "os.getenv " .. NOT_THERE }, { [[io.read "a"]], "io.read " .. NOT_THERE },
  { [[os.setlocale "de_DE"]], "os.setlocale " .. NOT_THERE }, { [[io.output "x.txt"]], "io.output " .. NOT_THERE },
  { [[debug.getregistry()]], "debug.getregistry " .. NOT_THERE }, { [[debug.sethook()]], "debug.sethook " .. NOT_THERE },
  { [[package.loadlib("libc.so.6", "*")]], "package.loadlib " .. NOT_THERE }, { [[package.cpath = "x"; local _ = package.cpath .. ""]], nil },
  { [[package.loaded.io.popen "id"]], "package.loaded " .. NOT_THERE }, { [[return package.searchers]], "package.searchers " .. NOT_THERE },
  { [[string.dump(print)]], "string.dump " .. NOT_THERE }, { [[(""):dump()]], "a nil value (method 'dump')" },
  { [[require "rtray.sys"]], "module 'rtray.sys' not found" }, { [[require "rt.core"]], "module 'rt.core' not found" },
  { [[require "../../../../../../etc/passwd"]], "not found" }, { [[require "cjson"]], "module 'cjson' not found" },
  { [[load("\27Lua")()]], "a nil value" }, { [[assert(load("\27Lua", "x", "b"))]], "attempt to load a binary chunk" },
  { [[assert(loadfile("chunk.txt", "b"))]], "attempt to load a binary chunk" }, { [[dofile "chunk.txt"]], "attempt to load a binary chunk" },
  { [[assert(io.open "/etc/passwd")]], READS }, { [[for _ in io.lines "/etc/passwd" do end]], READS }, { [[dofile "/etc/passwd"]], READS },
  { [[assert(loadfile "/etc/passwd")]], READS }, { [[assert(io.open "../../../../../../../../../../etc/passwd")]], READS },
  { [[assert(io.open "link.txt")]], READS }, { [[assert(io.open "linked/passwd")]], READS }, { [[assert(io.open ".hidden")]], READS },
  { [[assert(io.open "/etc/passwd_that_is_not_there")]], READS }, { [[assert(io.open "/dev/zero")]], READS },
  { [[assert(io.open "/proc/self/environ")]], READS }, { [[assert(io.open "pipe")]], "it is a device or a pipe" },
  { [[assert(io.open ".")]], "" }, { [[rt.image "/etc/passwd"]], READS }, { [[rt.image "pipe"]], "it is a device or a pipe" },
  { [[rt.scene { rt.mesh { file = "/etc/passwd.ply" } }]], READS }, { [[rt.load "/etc/passwd.lua"]], READS },
  { [[rt.load "/etc/passwd.sdf"]], READS }, { [[rt.load_snapshot "/etc/passwd"]], READS },
  { [[rt.scene { background = "/etc/passwd" }]], READS }, { [[rt.load("child.lua", { f = "/etc/passwd" })]], READS },
  { [[coroutine.wrap(rt.image)("/etc/passwd")]], READS }, { [[coroutine.wrap(function() rt.image "/etc/passwd" end)()]], READS },
  { [[scene.run.path = "/etc/passwd"; scene.run.folder = "/etc/"; assert(io.open "passwd")]], READS },
  { [[setmetatable(scene, {})]], "the metatable of rt.scene cannot be changed" },
  { [[getmetatable(scene).__index.render = print; assert(rt.scene {}.render == print)]], "attempt to index a nil value (field '__index')" },
  { [[getmetatable("").__index.format = print]], "attempt to index a boolean value" },
  { [[setmetatable({}, { __gc = print })]], "__gc is not there" }, { [[collectgarbage "stop"]], "collectgarbage 'stop' is not there" },
  { [[assert(io.open("x.lua", "w"))]], WRITES }, { [[assert(io.open(".bashrc", "w"))]], WRITES }, { [[assert(io.open("../x.txt", "w"))]], WRITES },
  { [[assert(io.open("/tmp/x.txt", "w"))]], WRITES }, { [[assert(io.open("there.txt", "w"))]], "it is there already" },
  { [[assert(io.open("there.txt", "a"))]], "it is there already" }, { [[assert(io.open("there.txt", "r+"))]], "it is there already" },
  { [[assert(io.open("linked/x.txt", "w"))]], WRITES }, { [[assert(io.open("link.txt", "w"))]], "it is there already" },
  { [[assert(io.open("pipe", "w"))]], WRITES }, { [[assert(io.open("nowhere/x.txt", "w"))]], "into folders that are there" },
  { [[rt.report "."]], "rt.report " .. NOT_THERE },
  { [[rt.image { width = 2, height = 2 }:save "/tmp/x.png"]], WRITES }, { [[rt.image { width = 2, height = 2 }:save "there.txt"]], "image format" },
  { [[scene:save "/tmp/x.rts"]], WRITES }, { [[scene:render_to_file "../x.png"]], WRITES },
  { [[rt.compare(rt.image { width = 2, height = 2 }, rt.image "/etc/passwd")]], READS },
  { [[error { status = 0, message = "all is well" }]], nil },
  { [[local t <close> = setmetatable({}, { __close = function() os.execute "id" end })]], "os.execute " .. NOT_THERE },
  { [[load(("("):rep(100000) .. "1")() ]], "attempt to call a nil value" },
  { [[assert(load(("("):rep(100000) .. "1" .. (")"):rep(100000)))]], "overflow" },
  { [[(("a"):rep(300000)):find(("(a"):rep(40))]], "too many captures" }, { [[(("a"):rep(300000)):match((".-"):rep(300000) .. "b")]], "too complex" },
  { [[local function f() return 1 + f() end f()]], "stack overflow" }, { [[string.format("%99999d", 1)]], "invalid" },
  { [[rt.main(1)]], nil }, { [[print(rt.process.run)]], "a nil value (field 'process')" },
  { [[rt.report "."]], "rt.report " .. NOT_THERE }, { [[rt.sweep {}]], "rt.sweep " .. NOT_THERE },
}

describe("a script in the sandbox", function()
  it("fails at each of these, with a sentence, and does no harm", function()
    local folder = support.folder()
    local function prepare(path)
      assert(os.execute(("cd %s && mkfifo pipe && ln -s /etc/passwd link.txt && ln -s /etc linked && echo secret > .hidden && echo there > there.txt")
        :format(support.quote(path))))
      support.write(path .. "/chunk.txt", string.dump(function() end))
      support.write(path .. "/child.lua", [[
        local rt = require "rt"
        local p = rt.params { f = { "x", type = "file" } }
        return rt.scene { background = p.f }]])
    end
    prepare(folder)
    -- All at once, each in a call of its own: a process for each would take a minute.
    local lines = { SCENE, "local try = function(i, f) local r = table.pack(pcall(f)) print('#' .. i, r[1], tostring(r[2])) end" }
    for i, attack in ipairs(ATTACKS) do
      lines[#lines + 1] = ("try(%d, function() %s end)"):format(i, attack[1]:gsub("^return ", "local _ = "))
    end
    support.write(folder .. "/evil.lua", table.concat(lines, "\n") .. "\nreturn scene\n")
    local r = rtray { "render", "evil.lua", "-q", "-o", "evil.png", cwd = folder }
    assert.equal(0, r.status, r.err)
    local out = "\n" .. r.out .. "\n#"
    for i, attack in ipairs(ATTACKS) do
      local ok, message = out:match("\n#" .. i .. "\t(%l+)\t(.-)\n#%d*")
      if attack[2] then
        assert.equal("false", ok, attack[1])
        assert.truthy(message:find(attack[2], 1, true), attack[1] .. ": " .. tostring(message))
      end
    end
    assert.is_false(support.exists(folder .. "/pwned"))
    assert.equal("there\n", support.read(folder .. "/there.txt"))
    assert.is_false(support.exists(folder .. "/x.txt") or support.exists(folder .. "/../x.txt") or support.exists("/tmp/x.rts"))
  end)

  it("stays guarded in what the program calls later: methods put in the place of its own, by tail calls, coroutines and metamethods", function()
    local folder, other = support.folder(), support.folder()
    assert.equal(0, rtray({ "render", support.small(other), "-q", "--size", "4x4", "-o", other .. "/secret.png" }).status)
    local head = SCENE .. ([[
      local image = rt.image { width = 2, height = 2 }
      local function write() return image:save "%s/pwned.png" end
      local function read() return rt.image "%s/secret.png" end
      local function later(f) return coroutine.wrap(function() while true do coroutine.yield(f()) end end) end
      local function seen(f) return function() local ok, what = pcall(f) print(ok, what) return scene end end
      local film = rt.animation { frames = 1, scene = function() return scene end }
    ]]):format(other, other)
    for i, lines in ipairs {
      "scene.hash = write return scene", "scene.start = write return scene", "scene.hash = later(write) return scene",
      "scene.effective = later(read) return scene", "scene.settings = setmetatable({}, { __index = write }) return scene",
      "scene.settings = setmetatable({}, { __index = later(write) }) return scene", "film.scene_at = write return film",
      "film.scene_at = later(seen(write)) return film", "film.scene_at = later(seen(read)) return film",
      "rt.on_log(write) return rt.scene { rt.mesh { file = 'm.obj' } }", "rt.on_log(later(write)) return rt.scene { rt.mesh { file = 'm.obj' } }",
    } do
      support.write(folder .. "/m.obj", "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n")
      support.write(folder .. "/s.lua", head .. lines .. "\n")
      local r = rtray { "render", "s.lua", "-q", "-o", ("out%d.png"):format(i), cwd = folder }
      assert.is_false(support.exists(other .. "/pwned.png"), lines)
      assert.is_nil(r.out:find("true", 1, true), lines)
      r = rtray { "animate", "s.lua", "-q", "-o", ("frame%d_%%d.png"):format(i), cwd = folder }
      assert.is_false(support.exists(other .. "/pwned.png"), lines)
      assert.is_nil(r.out:find("true", 1, true), lines)
    end
  end)

  it("does not learn from require what lies elsewhere", function()
    local folder, other = support.folder(), support.folder()
    support.write(other .. "/there.lua", "return 1")
    for _, name in ipairs { other .. "/there", ((other .. "/there"):gsub("/", ".")) } do
      support.write(folder .. "/s.lua", SCENE .. ("require %q return scene"):format(name))
      local r = rtray { "info", "s.lua", cwd = folder }
      assert.equal(1, r.status)
      assert.truthy(r.err:find("not found:", 1, true) and r.err:find("requires rt and .lua files below its folder", 1, true), r.err)
    end
  end)

  it("cannot end the program with a status or a message of its own", function()
    local r = script [[error { status = 0, message = "all is well" }]]
    assert.equal(1, r.status)
    assert.truthy(r.err:find("the script raised a table instead of a message", 1, true), r.err)
    r = script [[error(setmetatable({}, { __tostring = function() while true do end end, __index = function() return 4 end }))]]
    assert.equal(1, r.status)
    assert.truthy(r.err:find("the script raised a table instead of a message", 1, true), r.err)
    r = script [[error("\27]0;owned\7 \194\155 \155")]]
    assert.equal(1, r.status)
    assert.truthy(r.err:find([[\x1B]0;owned\x07]], 1, true), r.err)
    assert.is_nil(r.err:find "[\27\7\155]")
  end)

  it("does not steer a terminal", function()
    local folder = support.folder()
    support.write(folder .. "/s.lua", SCENE .. [[
      rt.params { x = { 1, help = "\27]0;owned\7" } }
      print "\27[31mred"
      io.write "\27[32mgreen\n"
      io.stderr:write "\27[33myellow\n"
      warn "\27[34mblue"
      return scene]])
    local r = support.shell("script -qec " .. support.quote(support.command { "params", "s.lua" }) .. " /dev/null", folder)
    for _, words in ipairs { [[\x1B[31mred]], [[\x1B[32mgreen]], [[\x1B[33myellow]], [[\x1B[34mblue]], [[\x1B]0;owned\x07]] } do
      assert.truthy(r.out:find(words, 1, true), words .. " in " .. r.out)
    end
    assert.is_nil(r.out:find("\27", 1, true))
  end)

  it("stays guarded beside the lines of a repl, which are not", function()
    local folder, other = support.folder(), support.folder()
    support.write(folder .. "/s.lua", SCENE .. [[
      function evil() rt.image { width = 2, height = 2 }:save 'x.png' end
      rawset(scene, 'evil', evil)
      return scene]])
    support.write(folder .. "/lines", ("rt.image { width = 2, height = 2 }:save '%s/own.png'\nprint(pcall(scene.evil))\n"):format(other))
    local r = support.shell(support.command { "repl", "s.lua" } .. " <lines", folder)
    assert.equal(0, r.status, r.err)
    assert.truthy(r.out:find(WRITES, 1, true), r.out)
    assert.is_true(support.exists(other .. "/own.png"))
    assert.is_false(support.exists(folder .. "/x.png"))
  end)

  it("has globals and libraries of its own", function()
    local r = script [[
      string.format, string.rep, table.concat, math.floor, tostring, ipairs, error, type, pcall = nil
      local g = _G
      for name in pairs(g) do g[name] = nil end
      rt.scene, rt.version = nil]]
    assert.equal(0, r.status, r.err)
    r = script [[setmetatable(_G, { __index = function(_, k) error("no " .. k) end }) ; string.format = error; scene.settings.samples = 1]]
    assert.equal(0, r.status, r.err)
  end)

  it("keeps what every frame's run sees apart", function()
    local folder = support.folder()
    support.write(folder .. "/child.lua", "seen = (seen or 0) + 1; local rt = require 'rt'; return rt.scene { name = tostring(seen) }")
    local r = rtray { "repl", cwd = folder, tail = "" }
    assert.equal(0, r.status)
    support.write(folder .. "/a.lua", [[
      local rt = require "rt"
      seen = 10
      assert(tostring(rt.load "child.lua"):find "'1'" and tostring(rt.load "child.lua"):find "'1'")
      return rt.load "child.lua"]])
    r = rtray { "info", "a.lua", cwd = folder }
    assert.equal(0, r.status, r.err)
  end)

  it("reads what lies below its folder, what -D names and what --allow-read allows", function()
    local folder, other = support.folder(), support.folder()
    assert(os.execute("mkdir " .. support.quote(folder .. "/lib")))
    support.write(folder .. "/lib/part.lua", "return { text = ..., radius = 1 }")
    support.write(folder .. "/data.txt", "one\ntwo\n")
    support.write(other .. "/far.txt", "far\n")
    support.write(other .. "/.far.txt", "hidden\n")
    support.write(folder .. "/s.lua", SCENE .. [[
      local part = require "lib.part"
      assert(part == require "lib.part" and part.text == "lib.part")
      local n = 0
      for _ in io.lines "data.txt" do n = n + 1 end
      assert(n == 2 and io.open "data.txt":read "a" == "one\ntwo\n")
      local p = rt.params { f = { "data.txt", type = "file" } }
      local file = assert(io.open(p.f))
      print(file:read "a")
      return scene]])
    for _, case in ipairs {
      { 0, "one" }, { 1, READS, "-D", "f=/etc/hostname_not" }, { 0, "far", "-D", "f=" .. other .. "/far.txt" },
    } do
      local r = rtray { "info", folder .. "/s.lua", table.unpack(case, 3) }
      assert.equal(case[1], r.status, r.err)
      assert.truthy((r.out .. r.err):find(case[2], 1, true), r.out .. r.err)
    end
    support.write(folder .. "/t.lua", SCENE .. ("assert(io.open '%s/.far.txt') return scene"):format(other))
    assert.equal(1, rtray({ "info", folder .. "/t.lua" }).status)
    assert.equal(0, rtray({ "info", folder .. "/t.lua", "--allow-read", other }).status)
    assert.equal(0, rtray({ "info", folder .. "/t.lua", "--trust" }).status)
    local r = rtray { "info", folder .. "/t.lua", "--allow-read", folder .. "/none" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("none': No such file", 1, true), r.err)
  end)

  it("guards the files that files name", function()
    local folder, other = support.folder(), support.folder()
    local red = rtray { "render", support.small(other), "-q", "--size", "4x4", "-o", other .. "/red.png" }
    assert.equal(0, red.status)
    support.write(folder .. "/m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n")
    support.write(folder .. "/m.mtl", ("newmtl a\nmap_Kd %s/red.png\n"):format(other))
    local r = rtray { "info", folder .. "/m.obj" }
    assert.equal(0, r.status)
    assert.truthy(r.err:find(READS, 1, true), r.err)
    assert.equal("", rtray({ "info", folder .. "/m.obj", "--allow-read", other }).err)
    local paper = support.read(support.source .. "/scenes/paper.sdf"):gsub('TEXTURE%s+"?[%w_.]+"?', 'TEXTURE "/etc/passwd"')
    support.write(folder .. "/p.sdf", paper)
    r = rtray { "info", folder .. "/p.sdf" }
    assert.truthy(r.err:find(READS, 1, true), r.err)
  end)

  it("writes new data files beside the output", function()
    local r, folder = script [[
      rt.image { width = 2, height = 2 }:save "depth.png"
      rt.image { width = 2, height = 2 }:save "depth.png"
      local file = assert(io.open("table.csv", "w"))
      assert(file:write("a,b\n"))
      file:close()
      assert(io.open("table.csv", "a")):write("c\n"):close()
      scene:save "x.rts"]]
    assert.equal(0, r.status, r.err)
    assert.equal("a,b\nc\n", support.read(folder .. "/table.csv"))
    assert.is_true(support.exists(folder .. "/depth.png") and support.exists(folder .. "/x.rts"))
    support.write(folder .. "/none.lua", SCENE .. "assert(io.open('new.txt', 'w')) return scene")
    r = rtray { "render", "none.lua", "-q", cwd = folder } -- no -o, no folder
    assert.equal(1, r.status)
    assert.truthy(r.err:find("-o names none", 1, true), r.err)
    assert.equal(0, rtray({ "render", "none.lua", "-q", "--trust", cwd = folder }).status)
  end)

  it("is not for --trust", function()
    local r, folder = script([[
      assert(os.execute "exit 0" and debug.getinfo(1) and package.path and require "string")
      string.format = nil
      getmetatable("").__index.x = 1]], { "--trust" })
    assert.equal(0, r.status, r.err)
    assert.is_true(support.exists(folder .. "/evil.png"))
  end)

  it("has every function of the module but those that start programs or write folders", function()
    local folder = support.folder()
    support.write(folder .. "/s.lua", SCENE .. [[
      for name, f in pairs(rt) do
        local ok, message = pcall(type(f) == "function" and f or error)
        print(name, not ok and tostring(message):find("is not there for a script", 1, true) and "withheld" or "there")
      end
      return scene]])
    local r = rtray { "info", folder .. "/s.lua" }
    assert.equal(0, r.status, r.err)
    local withheld, count = {}, 0
    for name, what in r.out:gmatch "([%w_]+)\t(%l+)\n" do
      count = count + 1
      withheld[#withheld + 1] = what == "withheld" and name or nil
    end
    table.sort(withheld)
    assert.is_true(count > 50)
    -- A new name here: is it safe for a stranger's script? Then lua/rtray/sandbox.lua names it; else this list does.
    assert.same({ "report", "sweep" }, withheld)
  end)
end)
