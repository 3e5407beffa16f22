local support = require "support"
local process = require "rt.process"
local core = require "rt.core"

local quoted = "a 'b' \"c\" $(touch x) %s\n<script> \255"

local function alive(id)
  local file = io.open(("/proc/%d/stat"):format(id), "rb")
  local state = file and file:read "a":match "%) (%a)"
  if file then
    file:close()
  end
  return state ~= nil and state ~= "Z"
end

-- Whether a process is gone within some seconds.
local function ends(id)
  local till = core.clock() + 5
  while alive(id) and core.clock() < till do
    process.spawn({ "true" }):wait()
  end
  return not alive(id)
end

describe("a process", function()
  it("gets its arguments, environment and folder as they are", function()
    local child <close> = process.spawn {
      "sh", "-c", 'printf "%s|%s|" "$1" "$RT_X"; pwd; exit 3', "sh", quoted, stdout = "pipe", env = { RT_X = quoted }, cwd = "/",
    }
    local result = child:communicate()
    assert.equal(quoted .. "|" .. quoted .. "|/\n", result.out)
    assert.equal(3, result.status)
    assert.is_nil(result.signal)
    assert.is_true(result.seconds > 0 and result.max_rss > 0)
  end)

  it("is fed and read at once, more than pipes hold", function()
    local text = ("0123456789"):rep(50000) .. "\nlast"
    local child <close> = process.spawn { "cat", stdin = "pipe", stdout = "pipe" }
    assert.is_true(child:communicate(text).out == text)
  end)

  it("gives lines as they come, the last one without its end too", function()
    local child <close> = process.spawn { "sh", "-c", "echo a; echo; printf c", stdout = "pipe" }
    assert.same({ "a", "", "c" }, { child:line(), child:line(), child:line() })
    assert.same({ nil, "end" }, { child:line() })
    local slow <close> = process.spawn { "sleep", "20", stdout = "pipe" }
    assert.same({ nil, "timeout" }, { slow:line(0.02) })
  end)

  it("keeps its standard error apart, or in its output", function()
    local child <close> = process.spawn { "sh", "-c", "echo o; echo e >&2", stdout = "pipe", stderr = "pipe" }
    local result = child:communicate()
    assert.same({ "o\n", "e\n" }, { result.out, result.err })
    local both <close> = process.spawn { "sh", "-c", "echo o; echo e >&2", stdout = "pipe", stderr = "stdout" }
    assert.equal("o\ne\n", both:communicate().out)
  end)

  it("that does not exist is said with the system's number", function()
    local child, why, number = process.spawn { "no-such-program-of-rt" }
    assert.is_nil(child)
    assert.equal("No such file or directory", why)
    assert.equal(2, number)
  end)

  it("that stops reading ends a write with a reason, not the writer", function()
    local child <close> = process.spawn { "true", stdin = "pipe" }
    child:wait()
    assert.same({ nil, "Broken pipe" }, { child:write(("x"):rep(1000000)) })
    local closes <close> = process.spawn { "sh", "-c", "exec 0<&-; sleep 0.2", stdin = "pipe" }
    assert.same({ nil, "Broken pipe" }, { closes:write(("x"):rep(1000000)) })
  end)

  it("ends when it is told, released, or its time is over", function()
    local child <close> = process.spawn { "sleep", "50" }
    assert.is_nil(child:wait(0.02))
    assert.equal(15, child:stop().signal)
    local late <close> = process.spawn { "sleep", "50", stdout = "pipe" }
    local result = late:communicate(nil, 0.05)
    assert.is_true(result.timed_out)
    assert.equal(137, result.status)
    local dropped = process.spawn { "sleep", "50" }
    local id = dropped:id()
    assert.is_true(alive(id))
    dropped:release()
    assert.is_false(alive(id))
    dropped:release()
  end)

  it("ends with its starter, killed even by SIGKILL", function()
    if not io.open "/proc/self/stat" then
      return
    end
    local script = [[local p = require "rt" and require "rt.process"
      local c = p.spawn { "sleep", "50" } print(c:id()) io.stdout:flush() c:wait()]]
    local starter <close> = process.spawn { arg and arg[-1] or "lua5.4", "-e", script, stdout = "pipe" }
    local id = tonumber(starter:line())
    assert.is_true(alive(id))
    starter:kill "KILL"
    starter:wait()
    assert.is_true(ends(id))
  end)

  it("has limits, and kill reaches its group", function()
    local child <close> = process.spawn { "sh", "-c", "ulimit -t; ulimit -n", stdout = "pipe", limits = { cpu = 7, files = 20 } }
    assert.equal("7\n20\n", child:communicate().out)
    local group <close> = process.spawn { "sh", "-c", "sleep 50 & echo $!; wait", stdout = "pipe", group = true }
    local id = tonumber(group:line())
    group:kill "KILL"
    assert.equal(9, group:wait().signal)
    assert.is_true(ends(id))
  end)

  it("is started by a checked table", function()
    support.raises("process.spawn: stdin must be one of inherit, null, pipe; got 'stdout'", function() process.spawn { "true", stdin = "stdout" } end)
    support.raises("process.spawn has no key 'stdio'; did you mean stdin?", function() process.spawn { "true", stdio = "pipe" } end)
  end)
end)

describe("a folder's file", function()
  it("is locked by one process at a time", function()
    support.in_folder(function(folder)
      local path = folder .. "/lock"
      local lock = core.lock_file(path)
      assert.is_false(core.lock_file(path))
      lock:release()
      local again <close> = core.lock_file(path)
      assert.is_truthy(again)
      local nothing, why = core.lock_file(folder .. "/none/lock")
      assert.is_nil(nothing)
      assert.equal("No such file or directory", why)
    end)
  end)

  it("is a journal that loses a cut line only", function()
    support.in_folder(function(folder)
      local path = support.write(folder .. "/j", "one\ntw")
      local journal <close> = core.journal_open(path, 4)
      assert.is_true(journal:add "three\n")
      local file <close> = io.open(path)
      assert.equal("one\nthree\n", file:read "a")
      assert.same({ "j" }, core.list_folder(folder))
      assert.is_true(core.make_folder(folder .. "/f"))
      assert.is_false(core.make_folder(folder .. "/f"))
      local made, why = core.make_folder(path)
      assert.is_nil(made)
      assert.equal("File exists", why)
    end)
  end)
end)
