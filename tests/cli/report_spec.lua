-- rtray report: the folder, what is said without gnuplot, the page in a real browser where there is one.

local support = require "support"
local rtray, quote = support.rtray, support.quote

local POINT = '{"key":"%d","values":{"n":"%d"},"status":"done","image":null,"hash":"h","runs":[{"seconds":%g}],"median":{"seconds":%g},'
  .. '"q1":{},"q3":{},"derived":{},"per_worker":[]}'

local function results(folder)
  local points = {}
  for i, seconds in ipairs { 10, 9, 0.5, 100 } do
    points[i] = POINT:format(i, i, seconds, seconds)
  end
  support.write(folder .. "/results.json",
    ('{"format":1,"title":"<b>t</b>","command":["rtray"],"scene":"s.lua","axes":[{"name":"n","values":["1","2","3","4"]}],'
    .. '"columns":[{"name":"seconds","unit":"s","per":"run","type":"number"}],"points":[%s]}'):format(table.concat(points, ",")))
  return folder
end

describe("rtray report", function()
  it("writes the page and prints its path", function()
    local folder = results(support.folder() .. "")
    local r = rtray { "report", folder .. "//", "--no-plots" }
    assert.same({ 0, folder .. "/index.html\n", "" }, { r.status, r.out, r.err })
    assert.truthy(support.read(folder .. "/index.html"):find("&lt;b&gt;t&lt;/b&gt;", 1, true))
    r = rtray { "report", folder, "--no-plots", "--json" }
    assert.truthy(r.out:find('"files":["index.html","results.json"]', 1, true), r.out)
    assert.equal("", rtray({ "report", folder, "--no-plots", "-q" }).out)
  end)

  it("works in folders of any name", function()
    local folder = support.folder() .. "/a'b\"c$(x)%d\n<script>\255"
    assert(os.execute("mkdir -p " .. quote(folder)))
    results(folder)
    local r = rtray { "report", folder }
    assert.equal(0, r.status, r.err)
    assert.is_true(support.exists(folder .. "/index.html"))
  end)

  it("says that gnuplot is missing, and makes the page without it", function()
    local folder = results(support.folder())
    local r = rtray { "report", folder, env = "PATH=/nowhere " }
    assert.equal(0, r.status, r.err)
    assert.truthy(r.err:find("gnuplot is not installed", 1, true), r.err)
    local page = support.read(folder .. "/index.html")
    assert.truthy(page:find("gnuplot is not installed", 1, true))
    assert.truthy(page:find('<svg class="chart"', 1, true))
    assert.is_false(support.exists(folder .. "/plots/seconds.svg"))
  end)

  it("says what is wrong", function()
    local function refused(status, words, ...)
      local r = rtray { "report", ... }
      assert.equal(status, r.status, r.err)
      assert.truthy(r.err:find(words, 1, true), r.err)
      assert.equal("", r.out)
    end
    local folder = support.folder()
    refused(1, "/nowhere' cannot be used", "/nowhere")
    refused(1, "results.json' cannot be read", folder)
    refused(1, "is no folder", support.write(folder .. "/file", ""))
    refused(2, "DIR", nil)
    support.write(folder .. "/results.json", "{}")
    refused(1, "has the format 'none'", folder)
    if support.shell("test $(id -u) -ne 0").status == 0 then
      results(folder)
      support.shell("chmod a-w " .. quote(folder))
      refused(1, "cannot be written", folder)
      support.shell("chmod u+w " .. quote(folder))
    end
  end)

  -- The page in a browser: the policy lets its script run, and the script sorts by numbers. A probe is put into a copy, allowed by its hash.
  it("is sorted by a browser", function()
    if support.shell("command -v chromium").status ~= 0 then
      pending "chromium is not installed"
      return
    end
    local folder = results(support.folder())
    assert.equal(0, rtray({ "report", folder, "--no-plots" }).status)
    local probe = 'document.querySelector("#points thead th:nth-child(3) button").click();document.title="sorted "+'
      .. 'Array.from(document.querySelectorAll("#points tbody th")).map(t=>t.textContent).join(" ")+" "+(document.querySelector("#points '
      .. 'thead th:nth-child(3)").getAttribute("aria-sort"))'
    local hash = support.shell("printf %s " .. quote(probe) .. " | openssl dgst -sha256 -binary | openssl base64").out:gsub("%s", "")
    if hash == "" then
      pending "openssl is not installed"
      return
    end
    local page = support.read(folder .. "/index.html")
    page = page:gsub("script%-src ", function(s)
      return s .. "'sha256-" .. hash .. "' "
    end, 1):gsub("</body>", function(s)
      return "<script>" .. probe .. "</script>" .. s
    end)
    support.write(folder .. "/probe.html", page)
    local r = support.shell(("timeout 60 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
      .. "--disable-component-update --disable-sync --user-data-dir=%s --dump-dom %s"):format(quote(folder .. "/profile"),
        quote("file://" .. folder .. "/probe.html")))
    assert.equal(0, r.status)
    assert.truthy(r.out:find("<title>sorted 3 2 1 4 ascending</title>", 1, true), r.out:match "<title>.-</title>")
  end)
end)
