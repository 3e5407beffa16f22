-- Reports: what a page says and never says, its policy, its plots, what happens without gnuplot, with hostile values, with nothing.

local support = require "support"
local rt = support.rt
local fixture = require "report_fixture"
local data = require "rt.report_data"
local gnuplot = require "rt.report_gnuplot"
local page = require "rt.report_page"
local plots = require "rt.report_plots"
local sha256 = require "rt.sha256"
local text = require "rt.report_text"
local json = require "rt.json"

local object = fixture.object

local function read(path)
  local file = assert(io.open(path, "rb"))
  local content = file:read "a"
  file:close()
  return content
end

local function exists(path)
  local file = io.open(path, "rb")
  if file then
    file:close()
  end
  return file ~= nil
end

local function count(s, pattern)
  return select(2, s:gsub(pattern, ""))
end

local function study_of(results)
  return data.from(assert(json.decode(results)), "'results.json'")
end

local function html_of(results, extra)
  return page.html(study_of(results), extra or { notes = {}, sheets = {}, files = {} })
end

local VOID = { meta = true, img = true, input = true, path = true, line = true, rect = true }

-- Every element is closed, in order, every attribute quoted; returns the names of elements met.
local function check_markup(html)
  local stack, seen = {}, {}
  html = html:gsub("<style>.-</style>", ""):gsub("<script>.-</script>", ""):gsub("^<!DOCTYPE html>", "")
  for close, name, attributes, slash in html:gmatch "<(/?)([%w]+)([^<>]-)(/?)>" do
    seen[name] = (seen[name] or 0) + 1
    if close == "/" then
      assert.equal(table.remove(stack), name)
    else
      assert.is_nil(attributes:gsub('%s+[%w%-:]+="[^"]*"', ""):gsub("%s+[%w%-]+", ""):match "%S", attributes)
      if slash ~= "/" and not (VOID[name] and name ~= "path" and name ~= "rect" and name ~= "line") then
        stack[#stack + 1] = name
      end
    end
  end
  assert.same({}, stack)
  assert.is_nil(html:gsub("</?[%w]+[^<>]*>", ""):find "[<>]")
  return seen
end

local EVIL = "<script>alert(1)</script>\"'&\n`touch /tmp/evil`$(x)%s%n\255\0\u{202e}"

describe("words and numbers", function()
  it("are escaped and whole", function()
    assert.equal("&lt;script&gt;&quot;&#39;&amp;", text.escape "<script>\"'&")
    assert.equal("a\u{FFFD}b\u{FFFD}\u{FFFD}", text.clean "a\255b\0\u{FFFF}")
    assert.equal("\u{FFFD}\u{FFFD}x", text.clean "\xc3\xed" .. "x")
    assert.equal("a%20b%22%3C/..%3Fc%23", text.address "a b\"</..?c#")
    assert.equal("abcd\u{2026}", text.short("abcd\nefgh", 5))
    assert.equal("\u{e4}\u{e4}\u{2026}", text.short(("\u{e4}"):rep(10), 3))
  end)

  it("have units and line up", function()
    local write, unit = text.column("s", { 0.0123, 0.5, 1.5 })
    assert.equal("s", unit)
    assert.same({ "0.012", "0.500", "1.500" }, { write(0.0123), write(0.5), write(1.5) })
    write, unit = text.column("bytes", { 52428800 })
    assert.same({ "50", "MiB" }, { write(52428800), unit })
    write, unit = text.column("1/s", { 4.25e6, 17e6 })
    assert.same({ "17.00", "M/s" }, { write(17e6), unit })
    assert.same({ "1.6", "0.0012", "236", "1200", "0" }, { text.number(1.6), text.number(0.0012), text.number(236.4), text.number(1200.4),
      text.number(0) })
    assert.same({ "236 ms", "1 min 5 s", "2 h 3 min" }, { text.duration(0.236), text.duration(65.2), text.duration(7380) })
    assert.equal("0", (text.column("", { 1, 100, 200 }))(-0.2))
  end)
end)

describe("sha256", function()
  it("gives the digests of the standard", function()
    assert.equal("e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855", sha256.hex "")
    assert.equal("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", sha256.hex "abc")
    assert.equal("248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1",
      sha256.hex "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")
    assert.equal("41edece42d63e8d9bf515a9ba6932e1c20cbc9f5a5d134645adb5db1b9737ea3", sha256.hex(("a"):rep(1000)))
    assert.equal("ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=", sha256.base64 "abc")
  end)
end)

describe("results.json", function()
  it("must be there and be what a sweep writes", function()
    support.in_folder(function(folder)
      assert.is_truthy(support.message(rt.report, folder):find("results.json' cannot be read: No such file or directory", 1, true))
      local function refused(content, words)
        fixture.write(folder, content)
        assert.is_truthy(support.message(rt.report, folder):find(words, 1, true), words)
        assert.is_false(exists(folder .. "/index.html"))
      end
      refused("", "is no JSON")
      refused("{", "is no JSON")
      refused("[1,2", "is no JSON")
      refused("3", "holds no object")
      refused("null", "is null")
      refused("{}", "has the format 'none'; this librt reads format 1")
      refused('{"format":2}', "has the format '2'")
      refused(("["):rep(100000), "is no JSON")
      assert.is_truthy(support.message(rt.report, 7):find("rt.report: the folder must be a string; got 7", 1, true))
    end)
  end)

  it("may have any values in it: what is wrong is left out", function()
    local bad = { "true", "7", '"x"', "[]", "{}", "[[]]", "[7]", '[{"name":7}]', '[{"name":"seconds"}]', '["\\u0000"]', '[null,{"key":[]}]', "null",
      "1e999",
      '{"seconds":{}}', '[{"values":7,"median":7,"q1":"x","runs":3,"per_worker":["a",{}],"machine":{},"image":7,"hash":[]}]' }
    local names = { "title", "command", "scene", "axes", "columns", "points", "groups", "conflicts", "machine", "machines", "runs", "warmup", "zip",
      "preset", "mode", "version", "reference" }
    for _, name in ipairs(names) do
      for _, value in ipairs(bad) do
        check_markup(html_of(('{"format":1,"%s":%s}'):format(name, value)))
      end
    end
    for _, key in ipairs { "values", "median", "derived", "q1", "image", "message", "label", "status", "per_worker", "runs", "oversubscribed",
      "width" } do
      local points = {}
      for i, value in ipairs(bad) do
        points[i] = ('{"key":"%d","status":"done","median":{"seconds":%d},"%s":%s},{"status":"failed","%s":%s}'):format(i, i, key, value, key, value)
      end
      check_markup(html_of(('{"format":1,"axes":[{"name":"a","values":["1","2"]}],"columns":[{"name":"seconds","unit":"s"}],"points":[%s]}'):format(
        table.concat(points, ","))))
    end
  end)

  it("names no image outside of the folder", function()
    for _, image in ipairs { "/etc/passwd", "../x.png", "images/../../x.png", "http://x/y.png", "a\0b.png", "..", "a\\b.png" } do
      local study = study_of(fixture.results { points = { fixture.point(1, { image = image }) } })
      local got = study.points[1].image
      assert.is_true(got == nil or image == "http://x/y.png", image)
    end
    local html = html_of(fixture.results { points = { fixture.point(1, { image = "http://x/y.png" }), fixture.point(2, {
      image = "javascript:alert(1)" }) } })
    assert.is_nil(html:find 'src="http:')
    assert.is_truthy(html:find('src="http%3A//x/y.png"', 1, true)) -- the name of a file in a folder
    assert.is_nil(html:find "javascript:")
  end)
end)

describe("a page", function()
  it("shows a study of workers and sizes", function()
    local html = html_of(fixture.scaling { sizes = { "500x500", "1000x700" }, preset = "jpvm", image = function(i) return "images/" .. i
      .. ".png" end },
      { notes = { "a note" }, sheets = { "contact.png" }, files = { "results.csv" } })
    local seen = check_markup(html)
    assert.equal(2 * 9, seen.figure)
    for _, words in ipairs { "Figure 5: execution time", "Figure 6: speed-up", "Efficiency", "Busy time of each worker", "ideal", "more than 4 CPUs",
      "UltraSPARC", "4 points with more workers than CPUs", "a note", "Test CPU @ 2 GHz", "rtray sweep scene.lua -o report", "6.00 %", "0.9991",
      "the load was 0.8", "powersave" } do
      assert.is_truthy(html:find(words, 1, true), words)
    end
    assert.equal(10, count(html, '<th scope="row" class="n" data%-v='))
    assert.equal(10, count(html, '<li data%-src="images/'))
  end)

  it("lets only its own script and style run, and asks nothing of a network", function()
    local html = html_of(fixture.scaling { sizes = { "500x500" } })
    local policy = html:match 'Content%-Security%-Policy" content="([^"]*)"'
    assert.is_truthy(policy:find("default-src 'none'", 1, true))
    assert.is_nil(policy:find "unsafe")
    assert.is_truthy(policy:find("script-src 'sha256-" .. sha256.base64(html:match "<script>(.-)</script>") .. "'", 1, true))
    assert.is_truthy(policy:find("style-src 'sha256-" .. sha256.base64(html:match "<style>(.-)</style>") .. "'", 1, true))
    local outside = html:gsub("<style>.-</style>", ""):gsub("<script>.-</script>", "")
    assert.is_nil(outside:find "https?:")
    assert.is_nil(outside:find "%sstyle=")
    assert.is_nil(outside:find "%son%l+=")
    assert.is_nil(html:find("url(", 1, true) and html:gsub("url%(#clip%-[%w%-]+%)", ""):find("url(", 1, true))
  end)

  it("holds hostile values as text", function()
    local evil_json = EVIL:gsub("\0", "")
    local axes = { { evil_json, "parameter", { evil_json, "b" } }, { "n", "parameter", { "1", "2", "3" } } }
    local points = {}
    for i = 1, 6 do
      points[i] = fixture.point(i, { values = object(evil_json, i % 2 == 0 and "b" or evil_json, "n", tostring((i + 1) // 2)), seconds = i,
        workers = 2,
        image = "images/<x>\"'.png", hash = evil_json, status = i == 6 and "failed" or "done", message = evil_json })
    end
    local html = html_of(fixture.results { axes = axes, points = points, title = evil_json, scene = evil_json, command = { "rtray", evil_json },
      conflicts = { object("message", evil_json) }, machine = object("cpu", evil_json, "cpus", 4), columns = {
        object("name", "seconds", "unit", evil_json, "help", evil_json, "per", "run", "type", "number"),
        object("name", evil_json, "unit", "s", "per", "point", "type", "text") } }, { notes = { evil_json }, sheets = {}, files = { evil_json } })
    check_markup(html)
    assert.is_nil(html:find "<script>alert")
    assert.equal(1, count(html, "<script>"))
    assert.is_truthy(html:find("&lt;script&gt;alert(1)&lt;/script&gt;", 1, true))
    assert.is_truthy(utf8.len(html))
    assert.is_nil(html:find "%z")
  end)

  it("copes with no axes, no points, one point, one axis, three axes", function()
    check_markup(html_of(fixture.results {}))
    assert.is_truthy(html_of(fixture.results {}):find("The sweep has no points", 1, true))
    local one = html_of(fixture.results { points = { fixture.point(1, { seconds = 0.5, image = "images/a.png" }) } })
    check_markup(one)
    assert.is_nil(one:find 'id="compare"')
    local points, axes = {}, { { "ior", "parameter", { "1", "1.5", "2" } }, { "mood", "parameter", { "day", "night" } },
      { "tile", "setting", { "8", "16", "32", "64" } } }
    for _, a in ipairs(axes[1][3]) do
      for _, b in ipairs(axes[2][3]) do
        for _, c in ipairs(axes[3][3]) do
          local i = #points + 1
          points[i] = fixture.point(i, { values = object("ior", a, "mood", b, "tile", c), seconds = 0.1 * i })
        end
      end
    end
    local results = fixture.results { axes = axes, points = points }
    check_markup(html_of(results))
    local list = plots.of(study_of(results))
    assert.same({ "lines", 6, "heat", "ior 1" }, { list[1].kind, #list[1].series, list[#list].kind, list[#list - 2].facet })
    local single = plots.of(study_of(fixture.results { axes = { { "mood", "parameter", { "day", "night" } } }, points = {
      fixture.point(1, { values = object("mood", "day"), seconds = 1 }), fixture.point(2, { values = object("mood", "night"), seconds = 2 }) } }))
    assert.equal("category", single[1].x.scale)
  end)

  it("tells failures, doubts and differences first", function()
    local html = html_of(fixture.results { axes = { { "a", "parameter", { "1", "2", "3" } } }, conflicts = { object("message",
      "workers 1 and 2 differ") }, points = {
      fixture.point(1, { values = object("a", "1"), status = "failed", message = "paper.lua:3: no such thing" }),
      fixture.point(2, { values = object("a", "2"), status = "missing" }), fixture.point(3, { values = object("a", "3"), seconds = 1 }) } })
    check_markup(html)
    for _, words in ipairs { "workers 1 and 2 differ", "1 point failed", "1 point not measured yet", "paper.lua:3: no such thing", "1 of 3" } do
      assert.is_truthy(html:find(words, 1, true), words)
    end
  end)

  it("stays small and quick with 1,000 points", function()
    local points, values = {}, {}
    for i = 1, 1000 do
      values[i] = tostring(i)
      points[i] = fixture.point(i, { values = object("n", values[i]), seconds = 0.001 * i, image = ("images/n%d.png"):format(i) })
    end
    local results = fixture.results { axes = { { "n", "parameter", values } }, points = points }
    local before = os.clock()
    local html = html_of(results)
    assert.is_true(os.clock() - before < 20)
    assert.is_true(#html < 3e6)
    assert.is_truthy(html:find('id="more"', 1, true))
  end)
end)

describe("a plot", function()
  it("takes the ideal line, quartiles and hollow marks where they belong", function()
    local list = plots.of(study_of(fixture.scaling { sizes = { "500x500", "1000x700" } }))
    local time, speedup = list[1], list[2]
    assert.same({ "time", 2, "log" }, { time.id, #time.series, time.x.scale })
    assert.is_true(math.abs(time.series[1].points[1].low / time.series[1].points[1].y - 0.97) < 1e-9)
    assert.same({ "speedup", "linear", "speedup" }, { speedup.id, speedup.x.scale, speedup.ideal })
    local last = speedup.series[1].points[5]
    assert.same({ 16, true }, { last.x, last.over })
  end)

  it("leaves curves out above twelve, and says so", function()
    local sizes = {}
    for i = 1, 15 do
      sizes[i] = ("%dx%d"):format(i * 10, i * 10)
    end
    local results = fixture.scaling { sizes = sizes, workers = { 1, 2 } }
    assert.equal(12, #plots.of(study_of(results))[1].series)
    assert.is_truthy(html_of(results):find("3 more curves are in the table", 1, true))
  end)
end)

describe("gnuplot's script", function()
  it("holds texts in single quotes alone", function()
    local evil = "a'b`touch /tmp/evil`$(x)\"@png\\n%d\n"
    local points = {}
    for i = 1, 4 do
      points[i] = fixture.point(i, { values = object("a", i < 3 and evil or "b", "w", tostring(i % 2)), seconds = i, workers = 2 })
    end
    local study = study_of(fixture.results { title = evil, axes = { { "a", "parameter", { evil, "b" } }, { "w", "parameter", { "0", "1" } } },
      points = points })
    local script = gnuplot.script(study, plots.of(study))
    for line in script:gmatch "[^\n]+" do
      local bare = line:gsub("''", ""):gsub("'[^']*'", "")
      assert.is_true(line:find "^#" ~= nil or not bare:find "[`\"']", line)
    end
    assert.is_truthy(script:find("''b`touch", 1, true))
  end)
end)

describe("rt.report", function()
  local function sweep_folder(folder, options)
    assert(os.execute("mkdir '" .. folder .. "/images'"))
    fixture.write(folder, fixture.scaling(options or { sizes = { "500x500", "1000x700" }, image = function(i)
      rt.image { width = 16, height = 12, pixel = function(x) return x / 16, i / 10, 0 end }:save(("%s/images/p%d.png"):format(folder, i))
      return ("images/p%d.png"):format(i)
    end }))
  end

  it("writes page, sheet and plots, and the same again", function()
    support.in_folder(function(folder)
      sweep_folder(folder)
      local made = rt.report(folder)
      assert.equal(folder .. "/index.html", made.page)
      check_markup(read(made.page))
      assert.is_true(exists(folder .. "/contact.png"))
      assert.is_true(exists(folder .. "/plots/plots.gp"))
      if os.execute "command -v gnuplot >/dev/null" then
        assert.same({}, made.notes)
        assert.is_truthy(read(folder .. "/plots/speedup.svg"):find("</svg>", 1, true))
        assert.equal("\137PNG", read(folder .. "/plots/time.png"):sub(1, 4))
      end
      local before, sheet = read(made.page), read(folder .. "/contact.png")
      rt.report(folder)
      assert.equal(before, read(made.page))
      assert.equal(sheet, read(folder .. "/contact.png"))
      assert.is_false(exists(folder .. "/index.html.part"))
    end)
  end)

  it("shows what it can of images that are broken or gone", function()
    support.in_folder(function(folder)
      sweep_folder(folder)
      os.remove(folder .. "/images/p3.png")
      support.write(folder .. "/images/p4.png", "\137PNG broken")
      local made = rt.report(folder, { plots = false })
      assert.is_truthy(made.notes[1]:find("^an image is left out: [^:]*p3.png"), made.notes[1])
      assert.is_true(exists(folder .. "/contact.png"))
    end)
  end)

  it("ends when it is interrupted while the images are read, and leaves the old sheet", function()
    support.in_folder(function(folder)
      sweep_folder(folder)
      support.write(folder .. "/contact.png", "old")
      local load_image, loads = require("rt.core").image_load, 0
      debug.sethook(function()
        loads = loads + (debug.getinfo(2, "f").func == load_image and 1 or 0)
        if loads == 2 then
          debug.sethook()
          error "interrupted!" -- as lua5.4 at Ctrl-C
        end
      end, "c")
      local message = support.message(rt.report, folder, { plots = false })
      debug.sethook()
      assert.is_truthy(message:find "interrupted!$", message)
      assert.equal("old", read(folder .. "/contact.png"))
      assert.is_false(exists(folder .. "/index.html"))
    end)
  end)

  it("says so when the folder takes no files", function()
    support.in_folder(function(folder)
      sweep_folder(folder)
      assert(os.execute("mkdir '" .. folder .. "/index.html'"))
      assert.is_truthy(support.message(rt.report, folder):find("/index.html' cannot be written: ", 1, true))
      assert.is_false(exists(folder .. "/index.html.part"))
    end)
  end)

  it("puts many images on several sheets and takes stale ones away", function()
    support.in_folder(function(folder)
      assert(os.execute("mkdir '" .. folder .. "/images'"))
      rt.image { width = 4, height = 3 }:save(folder .. "/images/a.png")
      local function write(n)
        local points, values = {}, {}
        for i = 1, n do
          values[i] = tostring(i)
          points[i] = fixture.point(i, { values = object("n", values[i]), seconds = i, image = "images/a.png", width = 4, height = 3 })
        end
        fixture.write(folder, fixture.results { axes = { { "n", "parameter", values } }, points = points })
      end
      write(100)
      rt.report(folder, { plots = false })
      assert.is_true(exists(folder .. "/contact-2.png"))
      write(5)
      rt.report(folder, { plots = false })
      assert.is_false(exists(folder .. "/contact-2.png"))
      assert.is_true(exists(folder .. "/contact.png"))
    end)
  end)
end)
