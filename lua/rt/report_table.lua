-- The tables of a report: a row a point, and a row a curve of speed-ups.

local data = require "rt.report_data"
local text = require "rt.report_text"

local tables = {}

local escape, address = text.escape, text.address

-- Columns that some point has a value of, each with the way its numbers are written: the time, what was derived from it, the rest.
local FIRST_COLUMNS = 7 -- the others are shown when asked for, and not printed

local function used_columns(study)
  local used, axes = {}, {}
  for _, axis in ipairs(study.axes) do
    axes[axis.name] = true
  end
  for _, column in ipairs(study.columns) do
    local numbers, words, any = {}, false, false
    for _, p in ipairs(study.points) do
      local v = data.value(p, column.name)
      numbers[#numbers + 1] = v
      any = any or v and v ~= 0
      words = words or column.type == "text" and (p.median[column.name] or p.derived[column.name]) ~= nil
    end
    local said = axes[column.name] or column.name:find "^rays_" and not any -- by an axis; a kind of rays that there was none of
    if #numbers > 0 and not said then
      local write, unit = text.column(column.unit, numbers)
      used[#used + 1] = { column = column, write = write, unit = unit, number = true }
    elseif words then
      used[#used + 1] = { column = column }
    end
  end
  local order = {}
  for i, u in ipairs(used) do
    order[u] = (u.column.name == "seconds" and 0 or u.column.per == "point" and 1000 or 2000) + i
  end
  table.sort(used, function(a, b)
    return order[a] < order[b]
  end)
  for i, u in ipairs(used) do
    u.class = (u.number and "n" or "words") .. (i > FIRST_COLUMNS and " more" or "")
  end
  return used
end

local function head_cell(o, name, class, unit, help, plain)
  local label = escape(text.short(name, 60)) .. (unit and unit ~= "" and ' <span class="unit">[' .. escape(unit) .. "]</span>" or "")
  local title = help and (' title="%s"'):format(escape(text.short(help, 200))) or ""
  if plain then
    o:add('<th scope="col"%s%s>%s</th>', class, title, label)
  else
    o:add('<th scope="col"%s%s aria-sort="none" data-name="%s"><button type="button">%s</button></th>', class, title, escape(text.short(name, 60)),
      label)
  end
end

local function spread(o, p, u)
  local name = u.column.name
  local low, high = p.q1[name], p.q3[name]
  local v = data.value(p, name)
  if not v then
    o:add('<td class="%s" data-v="">\u{2013}</td>', u.class)
  elseif name == "seconds" and low and high and p.runs > 1 then
    o:add('<td class="%s" data-v="%.17g">%s<small>%s \u{2013} %s</small></td>', u.class, v, escape(u.write(v)), escape(u.write(low)),
      escape(u.write(high)))
  else
    o:add('<td class="%s" data-v="%.17g">%s</td>', u.class, v, escape(u.write(v)))
  end
end

local function status(p)
  if p.status == "done" then
    return p.mixed and '<span class="tag">machines mixed</span>' or "done"
  elseif p.status == "failed" then
    return '<span class="tag">failed</span>'
  end
  return escape(text.short(p.status, 20))
end

local function numeric_axis(axis)
  for _, v in ipairs(axis.values) do
    if not tonumber(v) then
      return false
    end
  end
  return #axis.values > 0
end

local function row(o, study, p, used, numeric, images)
  o:add('<tr%s>', p.status == "failed" and ' class="failed"' or "")
  o:add('<th scope="row" class="n" data-v="%d">%d</th>', p.index, p.index)
  for i, axis in ipairs(study.axes) do
    local value = p.values[axis.name]
    local mark = p.oversubscribed and axis.name == "workers" and '<span class="star" title="more workers than CPUs">*</span>' or ""
    if numeric[i] then
      o:add('<td class="n" data-v="%s">%s%s</td>', tonumber(value) and ("%.17g"):format(tonumber(value)) or "", escape(text.short(value, 40)), mark)
    else
      o:add('<td class="words">%s%s</td>', escape(text.short(value, 120)), mark)
    end
  end
  for _, u in ipairs(used) do
    if u.number then
      spread(o, p, u)
    else
      o:add('<td class="%s">%s</td>', u.class, escape(text.short(p.median[u.column.name] or p.derived[u.column.name] or "", 120)))
    end
  end
  o:add("<td>%s</td>", status(p))
  if images then
    o:add("<td>%s</td>", p.image and ('<a href="%s">%s</a>'):format(address(p.image), escape(text.short(p.hash or "image", 8))) or "")
  end
  o:add "</tr>"
end

function tables.points(o, study)
  if #study.points == 0 then
    o:add '<section aria-labelledby="table"><h2 id="table">Table</h2><p>The sweep has no points.</p></section>'
    return
  end
  local used, numeric, images = used_columns(study), {}, false
  for i, axis in ipairs(study.axes) do
    numeric[i] = numeric_axis(axis)
  end
  for _, p in ipairs(study.points) do
    images = images or p.image ~= nil
  end
  o:add '<section aria-labelledby="table"><h2 id="table">Table</h2>'
  o:add '<div class="tools"><label>Only rows with these words <input type="search" id="filter" autocomplete="off" spellcheck="false"></label>'
  if #used > FIRST_COLUMNS then
    o:add('<label class="row" id="alllabel" hidden><input type="checkbox" id="all"> all %d columns</label>', #used)
  end
  o:add '<output id="shown" for="filter"></output></div><p class="skip" id="said" role="status"></p>'
  o:add '<div class="scroll" role="region" aria-label="Table of points" tabindex="0"><table id="points"><thead><tr>'
  head_cell(o, "#", ' class="n"', nil, "the order of the sweep")
  for i, axis in ipairs(study.axes) do
    head_cell(o, axis.name, numeric[i] and ' class="n"' or "", nil, axis.help or axis.kind)
  end
  for _, u in ipairs(used) do
    head_cell(o, u.column.name, (' class="%s"'):format(u.class), u.unit, u.column.help)
  end
  head_cell(o, "status", "")
  if images then
    head_cell(o, "image", "", nil, "the start of its hash: equal images have equal ones")
  end
  o:add "</tr></thead><tbody>"
  for _, p in ipairs(study.points) do
    row(o, study, p, used, numeric, images)
  end
  o:add "</tbody></table></div></section>"
end

-- ---- speed-ups ----

local function cell(o, value, write)
  o:add('<td class="n">%s</td>', value and escape(write(value)) or "\u{2013}")
end

local function percent(x)
  return text.fixed(x * 100, 2) .. " %"
end

-- What a group's curve is called: the axes other than workers.
local function group_name(study, group)
  local p = group.baseline or group.points[1]
  local parts = {}
  for _, axis in ipairs(study.axes) do
    if axis.name ~= "workers" and #axis.values > 1 and p and not study.zip then
      parts[#parts + 1] = axis.name .. " " .. p.values[axis.name]
    end
  end
  return #parts > 0 and table.concat(parts, ", ") or "all"
end

function tables.groups(o, study)
  if #study.groups == 0 then
    return
  end
  local weak = study.groups[1].kind == "weak"
  o:add('<section aria-labelledby="scaling"><h2 id="scaling">Scaling</h2>')
  o:add('<p class="soft">%s</p>', weak
    and "The work grows with the workers: efficiency is the work done for each worker and second against the first point."
    or "Against the point with the fewest workers. Karp and Flatt's serial fraction is taken from one point's speed-up; Amdahl's law "
    .. "T = a + b / workers is fitted to the medians of the points that the machine has CPUs for, and its serial fraction is a / (a + b).")
  o:add '<div class="scroll" role="region" aria-label="Table of speed-ups" tabindex="0"><table class="wrap"><thead><tr>'
  for _, name in ipairs { "curve", "from", "to", "highest speed-up", "its efficiency", "serial fraction (Karp, Flatt)", "serial fraction (fit)",
    "fit's R\u{B2}" } do
    head_cell(o, name, name == "curve" and "" or ' class="n"', nil, nil, true)
  end
  o:add "</tr></thead><tbody>"
  for _, g in ipairs(study.groups) do
    local top
    for _, p in ipairs(g.points) do
      if p.derived.speedup and (not top or p.derived.speedup > top.derived.speedup) then
        top = p
      end
    end
    local last = g.points[#g.points]
    o:add('<tr><th scope="row">%s</th>', escape(text.short(group_name(study, g), 80)))
    cell(o, g.baseline and (g.baseline.values.workers or "1"), tostring)
    cell(o, last and last.values.workers, tostring)
    cell(o, top and top.derived.speedup, function(x)
      return ("%s with %s worker%s"):format(text.number(x), top.values.workers or "?", top.values.workers == "1" and "" or "s")
    end)
    cell(o, top and top.derived.efficiency, percent)
    cell(o, top and top.derived.serial_fraction, percent)
    cell(o, g.fit and g.fit.fraction, percent)
    cell(o, g.fit and g.fit.r2, function(x)
      return text.fixed(x, 4)
    end)
    o:add "</tr>"
  end
  o:add "</tbody></table></div></section>"
end

return tables
