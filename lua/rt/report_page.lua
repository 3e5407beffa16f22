-- The page of a study: one HTML file that needs no network and no other program. Every text is escaped; the policy lets nothing run or load but
-- its own style, its own script (both by hash) and images beside it.

local chart = require "rt.report_chart"
local data = require "rt.report_data"
local machine = require "rt.report_machine"
local plots = require "rt.report_plots"
local report_table = require "rt.report_table"
local script = require "rt.report_script"
local sha256 = require "rt.sha256"
local style = require "rt.report_style"
local text = require "rt.report_text"

local page = {}

local escape, address = text.escape, text.address

local out = {}
out.__index = out

-- out:add(format, ...): arguments must be escaped.
function out:add(...)
  self[#self + 1] = string.format(...)
end

local function count(points, test)
  local n = 0
  for _, p in ipairs(points) do
    n = n + (test(p) and 1 or 0)
  end
  return n
end

local function shell_word(word)
  return word ~= "" and not word:find "[^%w%-%._/=:,+@%%]" and word or "'" .. word:gsub("'", "'\\''") .. "'"
end

local function command_line(words)
  local parts = {}
  for i, word in ipairs(words) do
    parts[i] = shell_word(word)
  end
  return table.concat(parts, " ")
end

-- ---- head ----

local hashes -- of the style and the script, which never change

local function head(o, study)
  hashes = hashes or { sha256.base64(style), sha256.base64(script) }
  local policy = ("default-src 'none'; img-src 'self' file:; base-uri 'none'; form-action 'none'; style-src 'sha256-%s'; script-src 'sha256-%s'")
    :format(hashes[1], hashes[2])
  o:add '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">'
  o:add('<meta http-equiv="Content-Security-Policy" content="%s">', policy)
  o:add '<meta name="viewport" content="width=device-width, initial-scale=1">\n<meta name="color-scheme" content="light dark">'
  o:add '<meta name="referrer" content="no-referrer">\n<meta name="generator" content="rtray">'
  o:add("<title>%s</title>", escape(text.short(study.title, 120)))
  o[#o + 1] = "<style>" .. style .. "</style>\n</head>\n<body>"
end

local function about(study)
  local parts = { text.count(#study.points, "point") }
  if study.runs then
    parts[#parts + 1] = text.count(study.runs, "run") .. " each" .. (study.warmup and study.warmup > 0 and (" after %s"):format(
      text.count(study.warmup, "warm-up")) or "")
  end
  if study.mode then
    parts[#parts + 1] = study.mode == "in-process" and "all in one process" or "each run a process of its own"
  end
  local version = study.version and "librt " .. study.version
  parts[#parts + 1] = version
  local time = type(study.machine.time) == "string" and study.machine.time:gsub("T", " "):gsub("Z$", " UTC")
  parts[#parts + 1] = time or nil
  return table.concat(parts, " \u{B7} ")
end

local function top(o, study, sections)
  o:add '<a class="skip" href="#content">To the content</a>\n<header class="top">'
  o:add("<h1>%s</h1>", escape(text.short(study.title, 200)))
  o:add('<p class="sub">%s</p>', escape(about(study)))
  if #study.command > 0 then
    o:add('<pre class="command" aria-label="The command that made this">%s</pre>', escape(command_line(study.command)))
  end
  o:add '<nav aria-label="Sections"><ul>'
  for _, s in ipairs(sections) do
    o:add('<li><a href="#%s">%s</a></li>', s[1], escape(s[2]))
  end
  o:add '</ul></nav>\n</header>\n<main id="content">'
end

-- ---- what stands out ----

local function best(study, column, most)
  local found, value
  for _, p in ipairs(study.points) do
    local v = p.status == "done" and data.value(p, column)
    if v and (not value or (most and v > value or not most and v < value)) then
      found, value = p, v
    end
  end
  return found, value
end

local function fact(o, name, value, small)
  o:add("<div><dt>%s</dt><dd>%s%s</dd></div>", escape(name), escape(value), small and "<small>" .. escape(text.short(small, 90)) .. "</small>" or "")
end

local function facts(o, study)
  o:add '<dl class="facts">'
  local done = count(study.points, function(p) return p.status == "done" end)
  fact(o, "Points", done == #study.points and tostring(done) or ("%d of %d"):format(done, #study.points),
    done == #study.points and "all done" or ("%d without a result"):format(#study.points - done))
  local fastest, seconds = best(study, "seconds")
  if fastest then
    fact(o, "Fastest", text.duration(seconds), fastest.label)
    local slowest, longest = best(study, "seconds", true)
    if slowest ~= fastest then
      fact(o, "Slowest", text.duration(longest), slowest.label)
    end
  end
  local quickest, speedup = best(study, "speedup", true)
  if quickest and speedup > 1 then
    fact(o, "Highest speed-up", text.number(speedup), quickest.label)
  end
  local name = study.machine.cpus
  if math.type(name) then
    fact(o, "CPUs", text.number(name), type(study.machine.cpu) == "string" and study.machine.cpu or nil)
  end
  o:add "</dl>"
end

-- Sentences of what a reader must know before the numbers are believed: those that make them wrong, and those that colour them.
local function remarks(study, notes)
  local bad, soft = {}, {}
  for _, message in ipairs(study.conflicts) do
    bad[#bad + 1] = message
  end
  local failed = count(study.points, function(p) return p.status == "failed" end)
  if failed > 0 then
    bad[#bad + 1] = text.count(failed, "point") .. " failed; the messages stand under Failures"
  end
  local missing = count(study.points, function(p) return p.status == "missing" end)
  if missing > 0 then
    soft[#soft + 1] = text.count(missing, "point") .. " not measured yet: the same command goes on where it ended"
  end
  local mixed = count(study.points, function(p) return p.mixed end)
  if mixed > 0 then
    bad[#bad + 1] = text.count(mixed, "point") .. " with runs of several machines or versions: their times cannot be compared"
  end
  local over = count(study.points, function(p) return p.oversubscribed end)
  if over > 0 then
    local cpus = math.type(study.machine.cpus) and (" (%s)"):format(text.number(study.machine.cpus)) or ""
    soft[#soft + 1] = ("%s with more workers than CPUs%s: marked by hollow marks, and by * in tables"):format(text.count(over, "point"), cpus)
  end
  local load = machine.load(study.machine)
  if load and load > 0.3 then
    soft[#soft + 1] = ("other programs ran beside the sweep: the load was %s when it began"):format(text.number(load))
  end
  local governor = study.machine.governor
  if type(governor) == "string" and governor ~= "performance" and governor ~= "" then
    soft[#soft + 1] = ("the CPU's frequency was governed by '%s', so its speed may have changed from run to run"):format(governor)
  end
  if study.mode == "in-process" then
    soft[#soft + 1] = "the runs shared a process: trees and textures that points have in common were made once, in the first point that needed them"
  end
  if study.runs == 1 and study.by_column.seconds then
    soft[#soft + 1] = "each point was run once, so nothing tells how much its time varies; --runs 5 would"
  end
  for _, note in ipairs(notes) do
    soft[#soft + 1] = note
  end
  return bad, soft
end

local function remark_list(o, list, class, title)
  if #list == 0 then
    return
  end
  o:add('<div class="warnings%s" role="note"><strong>%s</strong><ul>', class, escape(title))
  for i = 1, math.min(#list, 20) do
    o:add("<li>%s</li>", escape(text.short(list[i], 600)))
  end
  if #list > 20 then
    o:add("<li>and %d more, in results.json</li>", #list - 20)
  end
  o:add "</ul></div>"
end

-- ---- plots ----

local function legend(o, plot)
  if #plot.series < 2 and not plot.ideal and not plot.over then
    return
  end
  o:add '<ul class="legend">'
  for _, curve in ipairs(plot.series) do
    if #plot.series > 1 then
      o:add("<li>%s%s</li>", chart.sample(curve.number), escape(text.short(curve.name, 60)))
    end
  end
  if plot.ideal then
    o:add("<li>%sideal</li>", chart.ideal_sample())
  end
  o:add "</ul>"
end

local PAPER = {
  [5] = "After figure 5 of Hwang, Kim, Ahn, Hwang, Implementation of a Ray-Tracer on a Java Parallel Environment: time over workers.",
  [6] = "After figure 6 of the paper. There: JPVM on a Sun Enterprise 3000 with 6 UltraSPARC CPUs and 512 MB. Its text gives no numbers of the two "
    .. "figures; it says that 2 workers took about as long as the ray tracer without workers, for the messages, and that doubling up to 16 made "
    .. "it faster.",
}

local function caption(plot)
  local parts = {}
  if plot.figure then
    parts[#parts + 1] = PAPER[plot.figure]
  end
  if plot.spread and (plot.id == "time" or plot.id == "seconds") then
    parts[#parts + 1] = "Medians; bars span the quartiles."
  end
  if plot.ideal == "speedup" then
    parts[#parts + 1] = "Against the point with the fewest workers."
  end
  if plot.log then
    parts[#parts + 1] = "Logarithmic scale."
  end
  if plot.help and not plot.ideal and plot.id ~= "time" then
    parts[#parts + 1] = (text.short(plot.help, 200):gsub("^%l", string.upper)) .. (plot.help:find "%.$" and "" or ".")
  end
  if plot.hidden and plot.hidden > 0 then
    parts[#parts + 1] = ("%d more curves are in the table."):format(plot.hidden)
  end
  if plot.kind == "busy" then
    parts[#parts + 1] = "Of each curve the point with the most workers that the machine has CPUs for; the line is the time of the render. "
      .. "Even: mean by longest."
  end
  return table.concat(parts, " ")
end

local function figures(o, list)
  if #list == 0 then
    return
  end
  o:add '<section aria-labelledby="plots"><h2 id="plots">Plots</h2><div class="plots">'
  for _, plot in ipairs(list) do
    local facet = plot.facet and (": " .. plot.facet) or ""
    o:add("<figure><h3>%s</h3>", escape(text.short(plot.title .. facet, 80)))
    o[#o + 1] = chart.svg(plot)
    if plot.kind == "lines" then
      legend(o, plot)
    end
    o:add("<figcaption>%s</figcaption></figure>", escape(caption(plot)))
  end
  o:add "</div></section>"
end

-- ---- images ----

local FLIP_MODE = [[
<label><input type="radio" name="mode" value="flip">FLIP of A against its reference</label>]]

local function compare(o, second, maps)
  o:add([[<div class="compare" id="compare" data-second="%d" hidden><div class="tools">
<label>A, left <select id="a"></select></label><label>B, right <select id="b"></select></label>
<button type="button" class="plain" id="swap">Swap</button>
<fieldset><legend>Show as</legend><label><input type="radio" name="mode" value="slide" checked>slider</label>
<label><input type="radio" name="mode" value="side">side by side</label>
<label><input type="radio" name="mode" value="difference">difference</label>%s</fieldset>
<label id="slidelabel">Divider <input type="range" id="slide" min="0" max="100" step="0.5" value="50"></label>
<label id="gainlabel" hidden><span>Brightness of the difference <span id="gainvalue"></span></span>
<input type="range" id="gain" min="1" max="64" step="1" value="4"></label>
</div><div id="stage" class="stage"></div></div>]], second, maps and FLIP_MODE or "")
end

local function links(names, word)
  local parts = {}
  for i, name in ipairs(names) do
    parts[i] = ('<a href="%s">%s</a>'):format(address(name), word(name, i))
  end
  return table.concat(parts, ", ")
end

-- Beside the first image the first of its size that differs from it is shown, or else the next one: its number from 0.
local function other_image(shown)
  local first = shown[1]
  for i = 2, #shown do
    local p = shown[i]
    if p.width == first.width and p.height == first.height and p.hash and p.hash ~= first.hash then
      return i - 1
    end
  end
  return 1
end

local function images(o, study, sheets)
  local shown, maps = {}, false
  for _, p in ipairs(study.points) do
    if p.image then
      shown[#shown + 1] = p
      maps = maps or p.map ~= nil
    end
  end
  if #shown == 0 then
    return
  end
  o:add '<section aria-labelledby="images"><h2 id="images">Images</h2>'
  if #shown > 1 then
    compare(o, other_image(shown), maps)
  end
  o:add '<ul class="gallery">'
  for _, p in ipairs(shown) do
    local src, name = address(p.image), escape(text.short(p.label, 200))
    local size = p.width and p.height and (' width="%d" height="%d"'):format(p.width, p.height) or ""
    local small = p.width and p.width <= 160 and ' class="small"' or ""
    local map = p.map and (' data-map="%s" data-mean="%s"'):format(address(p.map), p.derived.flip and text.number(p.derived.flip) or "") or ""
    o:add('<li data-src="%s" data-name="%s" data-w="%d"%s><a href="%s"><img loading="lazy" decoding="async" src="%s" alt="%s"%s%s></a>', src, name,
      p.width or 0, map, src, src, name, size, small)
    local flip = p.map and (' \u{B7} <a href="%s">FLIP%s</a>'):format(address(p.map),
      p.derived.flip and " " .. text.number(p.derived.flip) or "") or ""
    o:add('<div class="cap">%s%s</div><div class="pick" hidden>', name, flip)
    o:add('<button type="button" class="plain" data-to="a" aria-label="Show %s as A">A</button>', name)
    o:add('<button type="button" class="plain" data-to="b" aria-label="Show %s as B">B</button></div></li>', name)
  end
  o:add '</ul>'
  if #shown > 60 then
    o:add '<p><button type="button" class="plain" id="more" hidden>Show 60 more</button></p>'
  end
  if #sheets > 0 then
    o:add("<p>All on %s.</p>", links(sheets, function(_, i)
      return #sheets == 1 and "a contact sheet" or "contact sheet " .. i
    end))
  end
  o:add "</section>"
end

-- ---- the rest ----

local function failures(o, study)
  local any = false
  for _, p in ipairs(study.points) do
    if p.status == "failed" then
      if not any then
        o:add '<section aria-labelledby="failures"><h2 id="failures">Failures</h2>'
        any = true
      end
      o:add("<h3>%s</h3><pre>%s</pre>", escape(text.short(p.label, 200)), escape(p.message or "it ended without a message"))
    end
  end
  if any then
    o:add "</section>"
  end
end

local function machines(o, study)
  local list = #study.machines > 1 and study.machines or { study.machine }
  if #list == 1 and #machine.rows(list[1]) == 0 then
    return
  end
  o:add('<section aria-labelledby="machine"><h2 id="machine">Machine%s</h2>', #list > 1 and "s" or "")
  for i, m in ipairs(list) do
    if #list > 1 then
      o:add("<h3>Machine %d</h3>", i)
    end
    o:add '<dl class="machine">'
    for _, row in ipairs(machine.rows(m)) do
      o:add("<dt>%s</dt><dd>%s</dd>", escape(row[1]), escape(text.short(row[2], 1000)))
    end
    o:add "</dl>"
  end
  o:add "</section>"
end

local function files(o, list)
  o:add('<section aria-labelledby="files"><h2 id="files">Files</h2><p class="files">%s</p></section>', links(list, escape))
end

-- The page's text. extra: { notes = {sentence}, sheets = {file}, files = {file} }
function page.html(study, extra)
  local o = setmetatable({}, out)
  local list = plots.of(study)
  local bad, soft = remarks(study, extra.notes)
  local sections = {}
  local function section(id, name, there)
    if there then
      sections[#sections + 1] = { id, name }
    end
  end
  local failed = count(study.points, function(p) return p.status == "failed" end) > 0
  section("plots", "Plots", #list > 0)
  section("images", "Images", count(study.points, function(p) return p.image end) > 0)
  section("table", "Table", #study.points > 0)
  section("scaling", "Scaling", #study.groups > 0)
  section("failures", "Failures", failed)
  section("machine", "Machine", #machine.rows(study.machine) > 0)
  section("files", "Files", true)
  head(o, study)
  top(o, study, sections)
  facts(o, study)
  remark_list(o, bad, " bad", "Look at this first")
  remark_list(o, soft, "", "To be known")
  figures(o, list)
  images(o, study, extra.sheets)
  report_table.points(o, study)
  report_table.groups(o, study)
  failures(o, study)
  machines(o, study)
  files(o, extra.files)
  o:add "</main>\n<footer>Made by rtray from results.json; <code>rtray report</code> with this folder makes it again."
  o:add "It loads nothing from a network.</footer>"
  o[#o + 1] = "<script>" .. script .. "</script>\n</body>\n</html>\n"
  return table.concat(o, "\n")
end

return page
