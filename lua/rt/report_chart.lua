-- Plots as SVG inside the page: they take its colours (light and dark) from its style sheet, and need no other program.

local text = require "rt.report_text"

local chart = {}

local escape, fixed = text.escape, text.fixed
local WIDTH, HEIGHT = 400, 300
local RIGHT, TOP, BOTTOM = 12, 14, 50

local svg = {}
svg.__index = svg

function svg:add(...)
  self[#self + 1] = string.format(...)
end

local function n(x)
  return (fixed(x, 2):gsub("%.?0+$", ""))
end

-- ---- ticks ----

local function nice_step(span, most)
  local raw = span / most
  local size = 10.0 ^ math.floor(math.log(raw, 10))
  for _, m in ipairs { 1, 2, 2.5, 5, 10 } do
    if m * size >= raw * 0.999 then
      return m * size
    end
  end
end

local function linear_ticks(low, high, most)
  local step = nice_step(math.max(high - low, 1e-300), most)
  local ticks = {}
  local first = math.ceil(low / step - 1e-9)
  for i = first, first + 50 do
    if i * step > high + step * 1e-6 then
      break
    end
    ticks[#ticks + 1] = i * step
  end
  return ticks
end

local function log_ticks(low, high)
  local ticks = {}
  local many = math.log(high / low, 10) > 3
  for e = math.floor(math.log(low, 10)) - 1, math.ceil(math.log(high, 10)) do
    for _, m in ipairs(many and { 1 } or { 1, 2, 5 }) do
      local v = m * 10.0 ^ e
      if v >= low * 0.999 and v <= high * 1.001 then
        ticks[#ticks + 1] = v
      end
    end
  end
  return ticks
end

-- ---- scales: a value's place between 0 and 1 ----

local function y_scale(plot)
  local low, high = plot.low, plot.high
  if plot.ideal == "speedup" then
    low = 0
    high = math.max(high, 1)
    for _, curve in ipairs(plot.series) do
      for _, p in ipairs(curve.points) do
        high = math.max(high, math.min(p.x, 1.3 * plot.high + 1))
      end
    end
  elseif plot.ideal == "efficiency" then
    low, high = math.min(0, low), math.max(1.16, high * 1.1)
  end
  if plot.log then
    local a, b = math.log(low * 0.85), math.log(high * 1.18)
    return function(v)
      return (math.log(math.max(v, 1e-300)) - a) / (b - a)
    end, log_ticks(low * 0.85, high * 1.18)
  end
  if low > 0 and low < 0.6 * high or low > 0 and plot.unit == "s" or low > 0 and plot.unit == "ms" then
    low = 0
  end
  if high <= low then
    low, high = low - math.max(0.5, math.abs(low) * 0.1), high + math.max(0.5, math.abs(high) * 0.1)
  end
  local ticks = linear_ticks(low, high, 6)
  local step = #ticks > 1 and ticks[2] - ticks[1] or high - low
  low = low == 0 and 0 or math.floor(low / step) * step
  high = plot.ideal and high or math.ceil(high / step - 0.2) * step
  high = math.max(high, plot.high * 1.02)
  return function(v)
    return (v - low) / (high - low)
  end, linear_ticks(low, high, 6)
end

local function x_scale(plot)
  local x = plot.x
  local low, high = math.huge, -math.huge
  for _, curve in ipairs(plot.series) do
    for _, p in ipairs(curve.points) do
      low, high = math.min(low, p.x), math.max(high, p.x)
    end
  end
  local ticks = {}
  if x.scale == "category" then
    for i, v in ipairs(x.values) do
      ticks[i] = { i, v }
    end
    return function(v)
      return (v - 0.5) / #x.values
    end, ticks
  end
  local log = x.scale == "log"
  local map = log and math.log or function(v)
    return v
  end
  local a, b = map(low), map(high)
  local pad = b > a and (b - a) * 0.04 or 1
  a, b = a - pad, b + pad
  if #x.values <= 12 then
    for i, v in ipairs(x.values) do
      ticks[i] = { tonumber(v), v }
    end
    table.sort(ticks, function(s, t)
      return s[1] < t[1]
    end)
  else
    for i, v in ipairs(log and log_ticks(low, high) or linear_ticks(low, high, 8)) do
      ticks[i] = { v, text.number(v) }
    end
  end
  return function(v)
    return (map(v) - a) / (b - a)
  end, ticks
end

local function begin(plot, width, height, description)
  local s = setmetatable({}, svg)
  s:add('<svg class="chart" viewBox="0 0 %d %d" role="img" aria-labelledby="t-%s d-%s">', width, height, escape(plot.id), escape(plot.id))
  s:add('<title id="t-%s">%s</title><desc id="d-%s">%s</desc>', escape(plot.id), escape(plot.title), escape(plot.id), escape(description))
  return s
end

-- Labels of ticks that would stand on each other are left out.
local function x_labels(s, ticks, px, y, room)
  local last = -math.huge
  local shown = {}
  for i, t in ipairs(ticks) do
    shown[i] = text.short(t[2], math.max(4, math.floor(room * 1.9 / (#ticks * 7.4))))
  end
  for i, t in ipairs(ticks) do
    local half = (utf8.len(shown[i]) or 4) * 3.7 + 3
    if px(t[1]) - half > last then
      s:add('<text class="tick" x="%s" y="%s" text-anchor="middle">%s</text>', n(px(t[1])), n(y), escape(shown[i]))
      last = px(t[1]) + half
    end
  end
end

local function tick_text(v, step)
  if v ~= 0 and (math.abs(v) >= 1e6 or math.abs(v) < 1e-3) then
    return text.number(v)
  end
  local decimals = math.max(0, math.min(6, math.ceil(-math.log(step, 10) - 1e-9)))
  if step * 10 ^ decimals % 1 > 1e-6 then
    decimals = decimals + 1
  end
  return fixed(v, decimals)
end

-- The words beside the ticks of y, and how much room they take.
local function y_labels(plot, ticks)
  local step = #ticks > 1 and ticks[2] - ticks[1] or 1
  local labels, longest = {}, 0
  for i, v in ipairs(ticks) do
    labels[i] = plot.log and text.number(v) or tick_text(v, step)
    longest = math.max(longest, utf8.len(labels[i]))
  end
  return labels, math.max(46, 31 + 7 * longest)
end

local function frame(s, plot, px, py, xticks, yticks, labels, left)
  local right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
  if plot.over and plot.cpus and plot.x.scale ~= "category" then
    local from = math.max(left, math.min(right, px(plot.cpus)))
    s:add('<rect class="over" x="%s" y="%d" width="%s" height="%d"/>', n(from), TOP, n(right - from), bottom - TOP)
    s:add('<text class="note" x="%s" y="%d" text-anchor="end">more than %d CPU%s</text>', n(right - 5), TOP + 14, plot.cpus,
      plot.cpus == 1 and "" or "s")
  end
  for i, v in ipairs(yticks) do
    local y = py(v)
    s:add('<line class="grid" x1="%s" y1="%s" x2="%d" y2="%s"/>', n(left), n(y), right, n(y))
    s:add('<text class="tick" x="%s" y="%s" text-anchor="end">%s</text>', n(left - 6), n(y + 4), escape(labels[i]))
  end
  s:add('<line class="axis" x1="%s" y1="%d" x2="%d" y2="%d"/>', n(left), bottom, right, bottom)
  for _, t in ipairs(xticks) do
    s:add('<line class="axis" x1="%s" y1="%d" x2="%s" y2="%d"/>', n(px(t[1])), bottom, n(px(t[1])), bottom + 4)
  end
  x_labels(s, xticks, px, bottom + 18, right - left)
  s:add('<text class="name" x="%s" y="%d" text-anchor="middle">%s</text>', n((left + right) / 2), HEIGHT - 12, escape(text.short(plot.x.name, 50)))
  local label = text.short(plot.name, 36) .. (plot.unit ~= "" and " [" .. plot.unit .. "]" or "")
  s:add('<text class="name" transform="translate(13 %s) rotate(-90)" text-anchor="middle">%s</text>', n((TOP + bottom) / 2), escape(label))
end

-- ---- marks: told apart by shape as well as by colour ----

local function marker(number, x, y, hollow, title, size)
  local class = ("mark c%d%s"):format((number - 1) % 7 + 1, hollow and " hollow" or "")
  local shape = (number - 1) % 5 + 1
  local paths = {
    'm-4.4 0a4.4 4.4 0 1 0 8.8 0a4.4 4.4 0 1 0 -8.8 0z', 'm-4 -4h8v8h-8z', 'm0 -5.2l5 8.7h-10z', 'm0 -5.6l5.6 5.6l-5.6 5.6l-5.6 -5.6z',
    'm0 5.2l5 -8.7h-10z',
  }
  local place = size and (' transform="translate(%s %s) scale(%s)"'):format(n(x), n(y), n(size)) or ""
  return ('<path class="%s"%s d="M%s %s%s">%s</path>'):format(class, place, size and "0" or n(x), size and "0" or n(y), paths[shape],
    title and "<title>" .. escape(title) .. "</title>" or "")
end

local function curve_path(curve, px, py)
  local parts = {}
  for i, p in ipairs(curve.points) do
    parts[i] = ("%s%s %s"):format(i == 1 and "M" or "L", n(px(p.x)), n(py(p.y)))
  end
  return table.concat(parts)
end

local function draw_curve(s, plot, curve, px, py)
  local class = ("c%d%s"):format((curve.number - 1) % 7 + 1, curve.number > 7 and " dashed" or "")
  s:add('<path class="curve %s" d="%s"/>', class, curve_path(curve, px, py))
  local size = #curve.points > 80 and 0.3 or #curve.points > 16 and 0.55 or nil -- many marks would hide the curve
  for _, p in ipairs(curve.points) do
    local x, spread = px(p.x), ""
    if p.low and p.high and py(p.low) - py(p.high) > 0.6 then
      s:add('<path class="bar %s" d="M%s %sV%sM%s %sh8M%s %sh8"/>', class, n(x), n(py(p.low)), n(py(p.high)), n(x - 4), n(py(p.low)), n(x - 4),
        n(py(p.high)))
    end
    if p.low and p.high then
      spread = (", quartiles %s and %s"):format(text.number(p.low), text.number(p.high))
    end
    s[#s + 1] = marker(curve.number, x, py(p.y), p.over, ("%s: %s %s%s%s"):format(p.label, text.number(p.y), plot.unit, spread,
      p.over and ", more workers than CPUs" or ""), size)
  end
end

local function ideal_path(s, plot, px, py)
  local low, high = math.huge, -math.huge
  for _, curve in ipairs(plot.series) do
    for _, p in ipairs(curve.points) do
      low, high = math.min(low, p.x), math.max(high, p.x)
    end
  end
  local parts = {}
  for i = 0, 48 do
    local x = low * (high / low) ^ (i / 48)
    parts[#parts + 1] = ("%s%s %s"):format(i == 0 and "M" or "L", n(px(x)), n(py(plot.ideal == "speedup" and x or 1)))
  end
  s:add('<path class="ideal" clip-path="url(#clip-%s)" d="%s"/>', escape(plot.id), table.concat(parts))
end

local function lines(plot)
  local u, xticks = x_scale(plot)
  local v, yticks = y_scale(plot)
  local labels, left = y_labels(plot, yticks)
  local px = function(x)
    return left + u(x) * (WIDTH - left - RIGHT)
  end
  local py = function(y)
    return HEIGHT - BOTTOM - v(y) * (HEIGHT - TOP - BOTTOM)
  end
  local s = begin(plot, WIDTH, HEIGHT, ("%s over %s, %s"):format(plot.name, plot.x.name, text.count(#plot.series, "curve")))
  s:add('<clipPath id="clip-%s"><rect x="%s" y="%d" width="%s" height="%d"/></clipPath>', escape(plot.id), n(left), TOP - 4, n(WIDTH - left - RIGHT),
    HEIGHT - TOP - BOTTOM + 4)
  frame(s, plot, px, py, xticks, yticks, labels, left)
  if plot.ideal then
    ideal_path(s, plot, px, py)
  end
  for _, curve in ipairs(plot.series) do
    draw_curve(s, plot, curve, px, py)
  end
  s:add "</svg>"
  return table.concat(s, "\n")
end

-- ---- heat maps ----

-- Cividis: dark blue to yellow, read alike with and without colour vision.
local RAMP = { { 0, 34, 78 }, { 49, 70, 107 }, { 102, 105, 112 }, { 150, 143, 119 }, { 202, 186, 106 }, { 254, 232, 56 } }

function chart.ramp(t)
  local at = math.max(0, math.min(1, t)) * (#RAMP - 1)
  local i = math.min(#RAMP - 2, math.floor(at))
  local a, b, f = RAMP[i + 1], RAMP[i + 2], at - i
  local rgb = {}
  for k = 1, 3 do
    rgb[k] = math.floor(a[k] + (b[k] - a[k]) * f + 0.5)
  end
  return ("#%02x%02x%02x"):format(rgb[1], rgb[2], rgb[3]), t > 0.52
end

-- Values far apart are told by their logarithms.
function chart.heat_place(map)
  if map.high <= map.low then
    return function()
      return 0.5
    end
  elseif map.low > 0 and map.high > 20 * map.low then
    local a, b = math.log(map.low), math.log(map.high)
    return function(v)
      return (math.log(v) - a) / (b - a)
    end
  end
  return function(v)
    return (v - map.low) / (map.high - map.low)
  end
end

local function heat(map)
  local across, down = map.across.values, map.down.values
  local left, top, bottom = 86, 8, 50
  local cw, ch = (WIDTH - left - 10) / #across, math.max(3, math.min(34, 300 / #down))
  local height = math.floor(top + ch * #down + bottom + 24)
  local gap = cw > 14 and ch > 12 and 1 or 0
  local t = chart.heat_place(map)
  local all = {}
  for _, d in ipairs(down) do
    for _, a in ipairs(across) do
      local cell = map.cells[d] and map.cells[d][a]
      all[#all + 1] = cell and cell.value
    end
  end
  local write = text.column("", all)
  local s = begin(map, WIDTH, height, ("%s for each %s and %s"):format(map.name, map.across.name, map.down.name))
  local wide = 0
  for _, v in ipairs(all) do
    wide = math.max(wide, #write(v))
  end
  local size = math.min(12.5, (cw - 3) / (wide * 0.6))
  for j, d in ipairs(down) do
    local y = top + (j - 1) * ch
    for i, a in ipairs(across) do
      local cell = map.cells[d] and map.cells[d][a]
      local x = left + (i - 1) * cw
      if cell then
        local color, light = chart.ramp(t(cell.value))
        s:add('<rect x="%s" y="%s" width="%s" height="%s" fill="%s"><title>%s: %s %s</title></rect>', n(x), n(y), n(cw - gap), n(ch - gap), color,
          escape(cell.label), escape(write(cell.value)), escape(map.unit))
        if size >= 7 and ch >= 12 then
          s:add('<text class="%s" x="%s" y="%s" text-anchor="middle" font-size="%s">%s%s</text>', light and "on-light" or "on-dark", n(x + cw / 2),
            n(y + ch / 2 + size * 0.35), n(size), escape(write(cell.value)), cell.over and "*" or "")
        end
      else
        s:add('<rect class="none" x="%s" y="%s" width="%s" height="%s"><title>%s=%s, %s=%s: no value</title></rect>', n(x), n(y), n(cw - gap),
          n(ch - gap), escape(map.across.name), escape(a), escape(map.down.name), escape(d))
      end
    end
  end
  local every = math.max(1, math.ceil(13 / ch))
  for j = 1, #down, every do
    s:add('<text class="tick" x="%d" y="%s" text-anchor="end">%s</text>', left - 6, n(top + (j - 0.5) * ch + 4), escape(text.short(down[j], 9)))
  end
  local ticks, longest = {}, 1
  for _, a in ipairs(across) do
    longest = math.max(longest, math.min(12, utf8.len(text.clean(a))))
  end
  for i = 1, #across, math.max(1, math.ceil((longest * 7.4 + 6) / cw)) do
    ticks[#ticks + 1] = { i, across[i] }
  end
  local base = top + ch * #down
  x_labels(s, ticks, function(i)
    return left + (i - 0.5) * cw
  end, base + 15, WIDTH - left)
  s:add('<text class="name" x="%s" y="%s" text-anchor="middle">%s</text>', n((left + WIDTH) / 2), n(base + 34),
    escape(text.short(map.across.name, 50)))
  s:add('<text class="name" transform="translate(14 %s) rotate(-90)" text-anchor="middle">%s</text>', n(top + ch * #down / 2),
    escape(text.short(map.down.name, math.max(6, math.floor(ch * #down / 7)))))
  for i = 0, 29 do -- the legend
    s:add('<rect x="%s" y="%s" width="6.4" height="9" fill="%s"/>', n((left + WIDTH) / 2 - 90 + i * 6), n(base + 46), (chart.ramp(i / 29)))
  end
  s:add('<text class="tick" x="%s" y="%s" text-anchor="end">%s</text>', n((left + WIDTH) / 2 - 96), n(base + 55), escape(write(map.low)))
  s:add('<text class="tick" x="%s" y="%s">%s %s</text>', n((left + WIDTH) / 2 + 96), n(base + 55), escape(write(map.high)), escape(map.unit))
  s:add "</svg>"
  return table.concat(s, "\n")
end

-- ---- busy time ----

local function busy(plot)
  local left, bar, gap = 8, 15, 26
  local rows = 0
  for _, row in ipairs(plot.rows) do
    rows = rows + gap + #row.values * (bar * (#row.values > 16 and 0.5 or 1)) + 8
  end
  local height = math.floor(rows + 48)
  local s = begin(plot, WIDTH, height, "A bar for each worker of some points; a line marks the time of the render")
  local ticks = linear_ticks(0, plot.high * 1.02, 6)
  local px = function(v)
    return left + 24 + v / (plot.high * 1.04) * (WIDTH - left - 44)
  end
  local step = #ticks > 1 and ticks[2] - ticks[1] or 1
  for _, v in ipairs(ticks) do
    s:add('<line class="grid" x1="%s" y1="6" x2="%s" y2="%d"/>', n(px(v)), n(px(v)), height - 42)
    s:add('<text class="tick" x="%s" y="%d" text-anchor="middle">%s</text>', n(px(v)), height - 26, escape(tick_text(v, step)))
  end
  s:add('<text class="name" x="%d" y="%d" text-anchor="middle">%s</text>', WIDTH // 2, height - 6, escape("busy [" .. plot.unit .. "]"))
  local y = 4
  for _, row in ipairs(plot.rows) do
    local h = bar * (#row.values > 16 and 0.5 or 1)
    local balance = row.balance and (", %d%% even"):format(math.floor(row.balance * 100 + 0.5)) or ""
    s:add('<text class="note strong" x="%d" y="%s">%s</text>', left, n(y + 15), escape(text.short(row.label, 40) .. balance))
    y = y + gap - 4
    for i, seconds in ipairs(row.values) do
      local value = seconds / plot.by
      s:add('<rect class="busy%s" x="%s" y="%s" width="%s" height="%s"><title>worker %d: %s %s</title></rect>', row.over and " hollow" or "",
        n(px(0)), n(y), n(math.max(0.5, px(value) - px(0))), n(h - 2), i - 1, escape(text.number(value)), escape(plot.unit))
      if h >= 12 then
        s:add('<text class="tick" x="%s" y="%s" text-anchor="end">%d</text>', n(px(0) - 5), n(y + h - 4), i - 1)
      end
      y = y + h
    end
    if row.seconds then
      s:add('<line class="wall" x1="%s" y1="%s" x2="%s" y2="%s"><title>time of the render: %s %s</title></line>', n(px(row.seconds / plot.by)),
        n(y - #row.values * h - 2), n(px(row.seconds / plot.by)), n(y), escape(text.number(row.seconds / plot.by)), escape(plot.unit))
    end
    y = y + 12
  end
  s:add "</svg>"
  return table.concat(s, "\n")
end

-- A sample of a curve for the legend.
function chart.sample(number)
  return ('<svg class="sample" viewBox="0 0 26 12" width="26" height="12" aria-hidden="true"><path class="curve c%d%s" d="M0 6H26"/>%s</svg>'):format(
    (number - 1) % 7 + 1, number > 7 and " dashed" or "", marker(number, 13, 6))
end

function chart.ideal_sample()
  return '<svg class="sample" viewBox="0 0 26 12" width="26" height="12" aria-hidden="true"><path class="ideal" d="M0 6H26"/></svg>'
end

local draw = { lines = lines, heat = heat, busy = busy }

function chart.svg(plot)
  return draw[plot.kind](plot)
end

return chart
