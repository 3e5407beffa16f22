-- The plots of a report for papers: a script for gnuplot, which anybody may change and run again, and the SVG and PNG files it makes. The script
-- holds nothing of the user's but numbers and texts in single quotes, in which gnuplot replaces nothing (in double quotes it would run `commands`).

local chart = require "rt.report_chart"
local core = require "rt.core"
local plots = require "rt.report_plots"
local process = require "rt.process"
local text = require "rt.report_text"

local gnuplot = {}

local SECONDS = 120 -- a longer run is ended

local COLORS = { "#0072b2", "#d55e00", "#007f5f", "#b0528b", "#b07c00", "#3b8fc4", "#5b6470" } -- those of the page (report_style.lua)
local FILLED, HOLLOW = { 7, 5, 9, 13, 11 }, { 6, 4, 8, 12, 10 } -- circle, square, triangle, diamond, triangle down

local function quote(s, most)
  return "'" .. text.short(s, most or 80):gsub("[%z\1-\31\127]", " "):gsub("'", "''") .. "'"
end

local function num(x)
  return (("%.9g"):format(x):gsub(",", "."))
end

-- Whatever a block holds, its own end does not stand in it: only numbers do.
local function block(o, name, rows)
  o[#o + 1] = "$" .. name .. " << EOD"
  for _, row in ipairs(rows) do
    o[#o + 1] = table.concat(row, " ")
  end
  o[#o + 1] = "EOD"
end

local function ticks(o, letter, list, most)
  local parts = {}
  for i, t in ipairs(list) do
    parts[i] = quote(t[2], most or 16) .. " " .. num(t[1])
  end
  o[#o + 1] = ("set %stics (%s)"):format(letter, table.concat(parts, ", "))
end

local function x_axis(o, plot)
  local list = {}
  for i, v in ipairs(plot.x.values) do
    list[i] = { plot.x.scale == "category" and i or tonumber(v), v }
  end
  if plot.x.scale == "category" then
    o[#o + 1] = ("set xrange [0.5:%d.5]"):format(#list)
  elseif plot.x.scale == "log" then
    o[#o + 1] = "set logscale x 2"
  end
  if #list <= 16 then
    ticks(o, "x", list)
  end
end

local function lines(o, plot, id)
  o[#o + 1] = "set xlabel " .. quote(plot.x.name)
  o[#o + 1] = "set ylabel " .. quote(plot.name .. (plot.unit ~= "" and " [" .. plot.unit .. "]" or ""))
  o[#o + 1] = "set grid ytics lc rgb '#d9dbde' lt 1"
  o[#o + 1] = "set offsets graph 0.04, graph 0.04, graph 0.05, 0"
  x_axis(o, plot)
  if plot.log then
    o[#o + 1] = "set logscale y"
  elseif plot.ideal or plot.low > 0 and plot.low < 0.6 * plot.high then
    o[#o + 1] = "set yrange [0:*]"
  end
  local parts, low, high = {}, math.huge, -math.huge
  for i, curve in ipairs(plot.series) do
    local rows, over = {}, {}
    for k, p in ipairs(curve.points) do
      rows[k] = { num(p.x), num(p.y), num(p.low or p.y), num(p.high or p.y) }
      over[#over + 1] = p.over and rows[k] or nil
      low, high = math.min(low, p.x), math.max(high, p.x)
    end
    local name = ("%s%d"):format(id, i)
    block(o, name, rows)
    local color = COLORS[(i - 1) % #COLORS + 1]
    local dash = i > #COLORS and " dt 2" or ""
    local shape = (i - 1) % #FILLED + 1
    if curve.points[1] and curve.points[1].low then
      parts[#parts + 1] = ("$%s using 1:2:3:4 with yerrorbars lw 1.2 pt 0 lc rgb '%s' notitle"):format(name, color)
    end
    parts[#parts + 1] = ("$%s using 1:2 with linespoints lw 2 pt %d ps 0.9 lc rgb '%s'%s title %s"):format(name, FILLED[shape], color, dash,
      quote(curve.name ~= "" and curve.name or plot.name))
    if #over > 0 then
      block(o, name .. "over", over)
      parts[#parts + 1] = ("$%sover using 1:2 with points pt %d ps 0.6 lc rgb '#ffffff' notitle"):format(name, FILLED[shape])
      parts[#parts + 1] = ("$%sover using 1:2 with points pt %d ps 0.9 lw 1.5 lc rgb '%s' notitle"):format(name, HOLLOW[shape], color)
    end
  end
  if plot.ideal then
    local formula = plot.ideal == "speedup" and "x" or "1"
    local log, pad = plot.x.scale == "log", 0.04 * (high - low)
    o[#o + 1] = ("set xrange [%s:%s]"):format(num(log and low / 1.1 or low - pad), num(log and high * 1.1 or high + pad))
    local top = plot.ideal == "speedup" and 1.05 * math.max(1.2, math.min(high, 1.3 * plot.high + 1)) or math.max(1.16, 1.1 * plot.high)
    o[#o + 1] = ("set yrange [0:%s]"):format(num(top))
    table.insert(parts, 1, ("%s with lines lw 1.5 dt 3 lc rgb '#59616b' title 'ideal'"):format(formula))
  end
  if plot.over and plot.cpus and plot.x.scale ~= "category" then
    o[#o + 1] = ("set object 1 rect from %s, graph 0 to graph 1, graph 1 behind fc rgb '#f2f3f4' fs solid noborder"):format(num(plot.cpus))
    o[#o + 1] = ("set label 1 %s at graph 0.98, graph 0.95 right tc rgb '#59616b'"):format(quote(("more than %d CPUs"):format(plot.cpus)))
  end
  o[#o + 1] = "set key above horizontal samplen 2"
  return "plot " .. table.concat(parts, ", \\\n     ")
end

local function heat(o, map, id)
  local rows, across, down = {}, map.across.values, map.down.values
  for j, d in ipairs(down) do
    for i, a in ipairs(across) do
      local cell = map.cells[d] and map.cells[d][a]
      rows[#rows + 1] = { tostring(i), tostring(j), cell and num(cell.value) or "NaN" }
    end
  end
  block(o, id, rows)
  local colors = {}
  for i = 0, 10 do
    colors[i + 1] = ("%s '%s'"):format(num(i / 10), (chart.ramp(i / 10)))
  end
  o[#o + 1] = "set palette defined (" .. table.concat(colors, ", ") .. ")"
  o[#o + 1] = "set xlabel " .. quote(map.across.name)
  o[#o + 1] = "set ylabel " .. quote(map.down.name)
  o[#o + 1] = "set cblabel " .. quote(map.name .. (map.unit ~= "" and " [" .. map.unit .. "]" or ""))
  local function side(letter, values)
    local list, every = {}, math.max(1, math.ceil(#values / 24))
    for i = 1, #values, every do
      list[#list + 1] = { i, values[i] }
    end
    ticks(o, letter, list)
    o[#o + 1] = ("set %srange [0.5:%d.5]"):format(letter, #values)
  end
  side("x", across)
  side("y", down)
  if map.low > 0 and map.high > 20 * map.low then
    o[#o + 1] = "set logscale cb"
  end
  o[#o + 1] = "unset key"
  return ("plot $%s using 1:2:3 with image"):format(id)
end

local function busy(o, plot, id)
  local rows, list, at = {}, {}, 0
  for _, row in ipairs(plot.rows) do
    list[#list + 1] = { at + (#row.values - 1) / 2, row.label }
    for _, seconds in ipairs(row.values) do
      rows[#rows + 1] = { num(at), num(seconds / plot.by), num(row.seconds and row.seconds / plot.by or 0) }
      at = at + 1
    end
    at = at + 1
  end
  block(o, id, rows)
  ticks(o, "x", list, 36)
  o[#o + 1] = "set xtics rotate by -8"
  o[#o + 1] = "set ylabel " .. quote("busy [" .. plot.unit .. "]")
  o[#o + 1] = "set yrange [0:*]"
  o[#o + 1] = "set boxwidth 0.85"
  o[#o + 1] = "set style fill solid"
  o[#o + 1] = "set grid ytics lc rgb '#d9dbde' lt 1"
  o[#o + 1] = "set key above horizontal"
  return ("plot $%s using 1:2 with boxes lc rgb '%s' title 'each worker', \\\n"
    .. "     $%s using ($1-0.5):3:(1):(0) with vectors nohead lw 2 lc rgb '%s' title 'time of the render'"):format(id, COLORS[1], id, COLORS[2])
end

local draw = { lines = lines, heat = heat, busy = busy }

-- The script, and the names of the files that it makes beside itself.
function gnuplot.script(study, list)
  local o = {
    "# Made by rtray from results.json. Change it as you like and run: gnuplot plots.gp",
    "# (`rtray report` writes it anew.)",
    "png = strstrt(GPVAL_TERMINALS, 'pngcairo') > 0 ? 'pngcairo' : 'png'",
  }
  local names = {}
  for i, plot in ipairs(list) do
    local name = plot.id:gsub("[^%w%-]", "_"):sub(1, 60)
    if plot.figure then
      name = ("figure-%d-%s"):format(plot.figure, name)
    end
    local id = "p" .. i
    o[#o + 1] = ""
    o[#o + 1] = "# " .. name
    o[#o + 1] = "reset"
    o[#o + 1] = "set title " .. quote(plot.title .. (plot.facet and ": " .. plot.facet or "") .. " - " .. study.title, 100) .. " noenhanced"
    o[#o + 1] = "set border 3 lc rgb '#59616b'"
    o[#o + 1] = "set tics nomirror noenhanced"
    local command = draw[plot.kind](o, plot, id)
    o[#o + 1] = ("set terminal svg size 640,460 font 'sans,13' noenhanced background '#ffffff'\nset output '%s.svg'"):format(name)
    o[#o + 1] = command
    o[#o + 1] = ("set terminal @png size 1280,920 font 'sans,20' linewidth 2 pointscale 1.6 noenhanced\nset output '%s.png'"):format(name)
    o[#o + 1] = "replot"
    o[#o + 1] = "unset output"
    names[#names + 1] = name .. ".svg"
    names[#names + 1] = name .. ".png"
  end
  return table.concat(o, "\n") .. "\n", names
end

-- Writes FOLDER/plots/plots.gp by write(name, text) and runs gnuplot there. Gives the files it made, and a sentence when it made none.
function gnuplot.run(study, folder, write)
  local list = plots.of(study)
  if #list == 0 then
    return {}, nil
  end
  local script, names = gnuplot.script(study, list)
  local made, why = core.make_folder(folder .. "/plots")
  if made == nil then
    return {}, "the folder plots cannot be made: " .. why
  end
  write("plots/plots.gp", script)
  for _, name in ipairs(names) do
    os.remove(folder .. "/plots/" .. name) -- nothing stale stays when gnuplot fails
  end
  local child <close>, reason, number = process.spawn {
    "gnuplot", "-d", "plots.gp", cwd = folder .. "/plots", stdin = "null", stdout = "pipe", stderr = "stdout", env = { LC_ALL = "C" },
  }
  if not child then
    return { "plots/plots.gp" }, number == 2
      and "gnuplot is not installed, so plots/ holds its script alone and no SVG and PNG files; the plots of this page need it not"
      or "gnuplot cannot be started: " .. tostring(reason)
  end
  local result = child:communicate(nil, SECONDS)
  local files = { "plots/plots.gp" }
  for _, name in ipairs(names) do
    if core.file_stat(folder .. "/plots/" .. name) == "file" then
      files[#files + 1] = "plots/" .. name
    end
  end
  if result.timed_out then
    return files, ("gnuplot took longer than %d s and was ended"):format(SECONDS)
  elseif result.status ~= 0 then
    local line = (result.out:match "line %d+:[^\n]*" or result.out:match "%S[^\n]*" or "no message")
    return files, ("gnuplot ended with status %d: %s"):format(result.status, text.short(line, 200))
  end
  return files, nil
end

return gnuplot
