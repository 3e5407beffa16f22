local support = require "support"
local rtray = support.rtray

local COMMANDS = {
  "render", "animate", "info", "tree", "pixel", "params", "convert", "compare", "verify", "bench", "bench-rays", "sweep", "report", "repl", "help",
}

describe("help", function()
  it("lists every command", function()
    local r = rtray { "help" }
    assert.equal(0, r.status)
    for _, name in ipairs(COMMANDS) do
      assert.truthy(r.out:find("\n  " .. (name == "bench-rays" and "bench rays" or name) .. " ", 1, true), name)
    end
    assert.equal(rtray({ "help", "bench-rays" }).out, rtray({ "help", "bench", "rays" }).out)
    assert.truthy(rtray({ "bench", "rays", "--nosuch" }).err:find("Try `rtray help bench rays`", 1, true))
    assert.equal(r.out, rtray({ "--help" }).out)
    assert.equal("", r.err)
  end)

  it("answers for each command, by help COMMAND and by --help", function()
    for _, name in ipairs(COMMANDS) do
      local r = rtray { "help", name }
      assert.equal(0, r.status)
      assert.equal(1, (r.out:find("usage: rtray " .. (name == "bench-rays" and "bench rays" or name), 1, true)), name)
      assert.truthy(r.out:find("Example", 1, true), name)
      assert.equal(r.out, rtray({ name, "--help" }).out)
      for line in r.out:gmatch "[^\n]+" do
        assert.is_true(#line <= 100 or line:find "^  rtray" ~= nil, line)
      end
    end
  end)

  it("names options that the parser accepts: every one of them has its help", function()
    local text = rtray({ "help", "render" }).out
    for _, option in ipairs { "--output", "--size", "--samples", "--workers", "-D", "--set", "--integrator", "--tracer", "--tile", "--schedule",
      "--seed",
      "--exposure", "--tone", "--bits", "--watch", "--preview", "--json", "--quiet", "--progress", "--stats" } do
      assert.truthy(text:find(option, 1, true), option)
    end
  end)

  it("says of -o what each command does with it", function()
    for name, words in pairs { animate = "a film, or a pattern", sweep = "the sweep's folder", tree = "write pictures into",
      render = "is standard output", bench = "is standard output" } do
      assert.truthy(rtray({ "help", name }).out:match("%-o, %-%-output [^\n]*"):find(words, 1, true), name)
    end
  end)

  it("prints the version", function()
    local r = rtray { "--version" }
    assert.equal(0, r.status)
    assert.truthy(r.out:find "^rtray %d+%.%d+%.%d+ %([%w_]+%)\n$")
  end)

  it("is manual pages too, one for the program and one for each command", function()
    local folder = support.folder()
    assert.equal(0, rtray({ "manual", "-o", folder .. "/" }).status)
    local groff = support.shell("command -v groff").status == 0
    local function check(file, head)
      local text = support.read(folder .. "/" .. file)
      assert.equal(head, text:match "^(%.TH %S+ 1) ")
      if groff then
        local r = support.shell("groff -man -ww -Tascii " .. support.quote(folder .. "/" .. file))
        assert.equal("", r.err)
        assert.equal(0, r.status)
      end
      return text
    end
    local text = check("rtray.1", ".TH RTRAY 1")
    for _, name in ipairs(COMMANDS) do
      assert.truthy(text:find(".BR rtray\\-" .. name:gsub("%-", "\\-") .. " (1)", 1, true), name)
      local page = check("rtray-" .. name .. ".1", ".TH RTRAY-" .. name:upper() .. " 1")
      assert.equal(page, rtray({ "manual", name }).out)
      assert.truthy(page:find("\n.SH OPTIONS\n", 1, true))
    end
  end)

  it("says when standard output is full", function()
    local r = rtray { "help", tail = "> /dev/full" }
    assert.equal(3, r.status)
    assert.truthy(r.err:find("standard output cannot be written", 1, true))
  end)
end)

describe("a wrong command line", function()
  local function refused(args, message)
    local r = rtray(args)
    assert.equal(2, r.status, r.err)
    assert.truthy(r.err:find(message, 1, true), r.err)
    assert.equal("", r.out)
    assert.truthy(r.err:find("Try `rtray help", 1, true) or #args == 0)
  end

  it("is refused with status 2 and a hint", function()
    refused({}, "usage: rtray COMMAND")
    refused({ "rendr", "x" }, "there is no command 'rendr'; did you mean render?")
    refused({ "frobnicate" }, "there is no command 'frobnicate'")
    refused({ "--quiet" }, "a command stands first")
    refused({ "help", "rendr" }, "did you mean render?")
    refused({ "render" }, "SCENE is missing")
    refused({ "render", "" }, "SCENE is empty")
    refused({ "render", "a", "b" }, "'b' is one argument too many")
    refused({ "render", "x", "--sampels", "3" }, "unknown option '--sampels'; did you mean --samples?")
    refused({ "render", "x", "--bits", "12" }, "--bits '12': known are 8, 16")
    refused({ "render", "x", "-1" }, "unknown option '-1'\n")
    refused({ "render", "x", "-z" }, "unknown option '-z'")
    refused({ "render", "x", "--samples" }, "--samples needs a value: N")
    refused({ "render", "x", "--samples", "0" }, "--samples '0': a whole number from 1 to 65536 is expected")
    refused({ "render", "x", "--samples=1e3" }, "a whole number from 1 to 65536 is expected")
    refused({ "render", "x", "-n-3" }, "-n '-3': a whole number")
    refused({ "render", "x", "--size", "100" }, "WIDTHxHEIGHT is expected")
    refused({ "render", "x", "--size", "0x100" }, "WIDTHxHEIGHT is expected")
    refused({ "render", "x", "--size", "100000000000x1" }, "WIDTHxHEIGHT is expected")
    refused({ "render", "x", "--tracer", "kdtre" }, "did you mean kdtree? known are auto, kdtree, octree, bvh, brute")
    refused({ "render", "x", "--quiet=yes" }, "--quiet takes no value, but 'yes' stands behind it")
    refused({ "render", "x", "-D", "radius" }, "NAME=VALUE is expected")
    refused({ "render", "x", "--crop", "1,2,3" }, "X,Y,WIDTH,HEIGHT in pixels is expected")
    refused({ "render", "x", "--exposure", "nan" }, "a number from -32 to 32 is expected")
    refused({ "render", "x", "-o", "" }, "-o '': it is empty")
    refused({ "compare", "a" }, "B is missing")
    refused({ "completion", "csh" }, "known are bash, zsh, fish")
    refused({ "render", "x", "-o", "-", "--json" }, "both want standard output")
    refused({ "render", "x", "-o", "x.exr" }, "names no image format; known are .png, .jpg, .bmp, .tga, .hdr")
  end)

  it("shows foreign bytes escaped", function()
    local r = rtray { "render", "x", "--\27[31m\255" }
    assert.equal(2, r.status)
    assert.truthy(r.err:find("\\x1B[31m\\xFF", 1, true), r.err)
  end)
end)

describe("completions", function()
  it("are written for three shells", function()
    for shell, sign in pairs { bash = "complete -F _rtray rtray", zsh = "#compdef rtray", fish = "complete -c rtray" } do
      local r = rtray { "completion", shell }
      assert.equal(0, r.status)
      assert.truthy(r.out:find(sign, 1, true), shell)
      assert.falsy(r.out:find "%f[%w]answer[:)']") -- hidden commands stay hidden
    end
  end)

  it("complete in bash", function()
    local folder = support.folder()
    support.write(folder .. "/rtray.bash", rtray({ "completion", "bash" }).out)
    local function complete(line)
      local words = {}
      for word in line:gmatch "%S+" do
        words[#words + 1] = support.quote(word)
      end
      support.write(folder .. "/try.sh", table.concat({
        "compopt() { :; }", ". ./rtray.bash", "COMP_WORDS=(" .. table.concat(words, " ") .. ")", "COMP_CWORD=$((${#COMP_WORDS[@]} - 1))",
        "_rtray", "printf '%s\\n' \"${COMPREPLY[@]}\"" }, "\n"))
      return support.shell("bash try.sh", folder).out
    end
    assert.equal("render\nreplay\nreport\nrepl\n", complete "rtray re")
    assert.equal("--samples\n--stats\n--settings\n", (complete "rtray render --s":gsub("%-%-[^\n]*\n", function(name)
      return name:find "^%-%-s[ate]" and not name:find "^%-%-seed" and not name:find "%-%-set\n" and name or ""
    end)))
    assert.equal("kdtree\n", complete "rtray render x.lua --tracer kd")
    assert.equal("verify\n", complete "rtray help ver")
  end)

  it("are read by the shells that are here", function()
    for _, shell in ipairs { "bash", "zsh", "fish" } do
      if support.shell("command -v " .. shell).status == 0 then
        local folder = support.folder()
        local file = support.write(folder .. "/completion", rtray({ "completion", shell }).out)
        local r = support.shell(shell .. " -n " .. support.quote(file))
        assert.equal(0, r.status, r.err)
      end
    end
  end)
end)
