-- Which plots a study asks for, as plain tables that the page (report_chart.lua) and gnuplot (report_gnuplot.lua) draw alike.

local data = require "rt.report_data"
local text = require "rt.report_text"

local plots = {}

plots.MOST_CURVES = 12
local MOST_MEASURES, MOST_FACETS, MOST_BUSY, MOST_BUSY_WORKERS = 8, 6, 6, 64

-- ---- axes ----

local function number_of(value)
  local n = tonumber(value)
  return n and n == n and math.abs(n) ~= math.huge and n or nil
end

local function all_numbers(values)
  for _, v in ipairs(values) do
    if not number_of(v) then
      return false
    end
  end
  return true
end

-- 1, 2, 4, 8 ... are read best at equal distances.
local function is_geometric(values)
  if #values < 3 then
    return false
  end
  local sorted = {}
  for i, v in ipairs(values) do
    sorted[i] = number_of(v)
  end
  table.sort(sorted)
  if sorted[1] <= 0 or sorted[#sorted] < 4 * sorted[1] then
    return false
  end
  local first, last = sorted[2] / sorted[1], sorted[#sorted] / sorted[#sorted - 1]
  return first > 1.2 and math.abs(first - last) < 0.02 * first
end

local function x_of(axis)
  local numeric = all_numbers(axis.values)
  local scale = not numeric and "category" or (axis.name == "workers" and #axis.values > 2 or is_geometric(axis.values)) and "log" or "linear"
  for _, v in ipairs(axis.values) do
    if scale == "log" and number_of(v) <= 0 then
      scale = "linear"
    end
  end
  return { axis = axis, name = axis.name, scale = scale, values = axis.values }
end

local function place(x, value)
  if x.scale ~= "category" then
    return number_of(value)
  end
  for i, v in ipairs(x.values) do
    if v == value then
      return i
    end
  end
end

-- Axes along which something changes.
local function varying(study)
  local found = {}
  for _, axis in ipairs(study.axes) do
    if #axis.values > 1 then
      found[#found + 1] = axis
    end
  end
  return found
end

local function without(axes, ...)
  local rest = {}
  for _, axis in ipairs(axes) do
    local out = false
    for _, other in ipairs { ... } do
      out = out or axis == other
    end
    if not out then
      rest[#rest + 1] = axis
    end
  end
  return rest
end

-- What tells the curves apart: "size 500x500, tile 16".
local function name_of(point, axes)
  local parts = {}
  for i, axis in ipairs(axes) do
    parts[i] = axis.name .. " " .. point.values[axis.name]
  end
  return #parts > 0 and table.concat(parts, ", ") or nil
end

-- Points in curves, one for each combination of the other axes, in the order of the points.
local function curves(study, x, others, column, quartiles)
  local list, by_name = {}, {}
  for _, p in ipairs(study.points) do
    local y = p.status == "done" and data.value(p, column)
    local at = y and place(x, p.values[x.name])
    if at then
      local name = name_of(p, others) or ""
      local curve = by_name[name]
      if not curve then
        curve = { name = name, points = {}, number = #list + 1 }
        list[#list + 1], by_name[name] = curve, curve
      end
      curve.points[#curve.points + 1] = {
        x = at, y = y, low = quartiles and p.q1[column], high = quartiles and p.q3[column], over = p.oversubscribed, label = p.label,
        value = p.values[x.name],
      }
    end
  end
  local hidden = math.max(0, #list - plots.MOST_CURVES)
  for i = #list, plots.MOST_CURVES + 1, -1 do
    list[i] = nil
  end
  for _, curve in ipairs(list) do
    table.sort(curve.points, function(a, b)
      return a.x < b.x
    end)
  end
  return list, hidden
end

local function range(series)
  local low, high = math.huge, -math.huge
  for _, curve in ipairs(series) do
    for _, p in ipairs(curve.points) do
      low, high = math.min(low, p.low or p.y, p.y), math.max(high, p.high or p.y, p.y)
    end
  end
  return low, high
end

-- Scales a plot's values into the unit in which they are read best.
local function into_unit(plot)
  local low, high = range(plot.series)
  local by, unit = text.scale(plot.unit, math.max(math.abs(low), math.abs(high)))
  for _, curve in ipairs(plot.series) do
    for _, p in ipairs(curve.points) do
      p.y, p.low, p.high = p.y / by, p.low and p.low / by, p.high and p.high / by
    end
  end
  plot.unit, plot.low, plot.high = unit, low / by, high / by
  plot.log = not plot.ideal and low > 0 and high > 60 * low
end

local PLAIN = {
  seconds = "time", build_seconds = "time of the trees", speedup = "speed-up", psnr = "PSNR", mse = "mean squared error", ssim = "SSIM",
  flip = "FLIP",
  differing = "differing pixels", peak_memory_bytes = "peak memory",
}

local function words_of(column)
  return PLAIN[column] or (column:gsub("_", " "))
end

local function line_plot(study, x, others, column, more)
  local known = study.by_column[column]
  local plot = {
    kind = "lines", id = column, x = x, name = words_of(column), title = text.title(words_of(column)),
    unit = known and known.unit or "", help = known and known.help,
    spread = (study.runs or 1) > 1, cpus = x.name == "workers" and math.tointeger(study.machine.cpus) or nil,
  }
  for key, value in next, more or {} do
    plot[key] = value
  end
  plot.series, plot.hidden = curves(study, x, others, column, column == "seconds")
  local points = 0
  for _, curve in ipairs(plot.series) do
    points = math.max(points, #curve.points)
    for _, p in ipairs(curve.points) do
      plot.over = plot.over or p.over
    end
  end
  if points < 2 then
    return nil
  end
  into_unit(plot)
  return plot
end

-- ---- which columns ----

local SCALING = { speedup = true, efficiency = true, serial_fraction = true }
local AFTER = { rays_per_second = 1001, peak_memory_bytes = 1002, build_seconds = 1003 } -- behind what the user measured
-- Columns of a sweep's runs that are plotted as AFTER says or not at all; any other is the user's own.
local OWN = {
  seconds = true, build_seconds = true, load_seconds = true, user_seconds = true, system_seconds = true, process_seconds = true, rays = true,
  rays_camera = true, rays_shadow = true, rays_reflect = true, rays_refract = true, rays_diffuse = true, rays_ao = true, rays_per_second = true,
  nodes = true, tests = true, workers = true, memory_bytes = true, peak_memory_bytes = true, bytes_moved = true,
}

local function rank(column, i)
  if column.type ~= "number" or SCALING[column.name] then
    return nil
  elseif column.name == "seconds" then
    return 0
  elseif column.per == "point" or not OWN[column.name] then
    return i
  end
  return AFTER[column.name]
end

local function distinct(study, column)
  local first
  for _, p in ipairs(study.points) do
    local v = p.status == "done" and data.value(p, column)
    if v and first and v ~= first then
      return true
    end
    first = first or v
  end
  return false
end

-- Columns worth a plot: the time, what was derived or measured by the user, what is usually asked.
local function measures(study)
  local found = {}
  for i, column in ipairs(study.columns) do
    local order = rank(column, i)
    if order and distinct(study, column.name) then
      found[#found + 1] = { column = column, order = order }
    end
  end
  table.sort(found, function(a, b)
    return a.order < b.order
  end)
  local names = {}
  for i = 1, math.min(#found, MOST_MEASURES) do
    names[i] = found[i].column.name
  end
  return names
end

-- ---- the kinds ----

local function add(list, plot)
  list[#list + 1] = plot
end

local function scaling(study, axes, workers, list)
  local x, others = x_of(workers), study.zip and {} or without(axes, workers)
  local jpvm = study.preset == "jpvm"
  local weak = study.groups[1] and study.groups[1].kind == "weak"
  add(list, line_plot(study, x, others, "seconds", { id = "time", title = jpvm and "Figure 5: execution time" or "Time", name = "time",
    figure = jpvm and 5 or nil }))
  -- On a linear axis ideal speed-up is a straight line.
  local straight = { axis = x.axis, name = x.name, scale = x.scale == "log" and "linear" or x.scale, values = x.values }
  add(list, line_plot(study, straight, others, "speedup", { id = "speedup",
    title = jpvm and "Figure 6: speed-up" or weak and "Scaled speed-up" or "Speed-up", name = "speed-up", ideal = "speedup",
    figure = jpvm and 6 or nil }))
  add(list, line_plot(study, x, others, "efficiency", { id = "efficiency", title = "Efficiency", name = "speed-up / workers", ideal = "efficiency" }))
end

-- One map a combination of the axes that are neither across nor down.
local function heat_maps(study, axes, column, list)
  local across, down = axes[#axes], axes[#axes - 1]
  local others = without(axes, across, down)
  local maps, by_name = {}, {}
  for _, p in ipairs(study.points) do
    local value = p.status == "done" and data.value(p, column)
    if value then
      local name = name_of(p, others) or ""
      local map = by_name[name]
      if not map and #maps < MOST_FACETS then
        map = { kind = "heat", id = ("map-%s%s"):format(column, #maps > 0 and "-" .. #maps + 1 or ""), facet = name ~= "" and name or nil,
          title = text.title(words_of(column)), name = words_of(column), across = across, down = down, cells = {},
          unit = study.by_column[column] and study.by_column[column].unit or "", low = math.huge, high = -math.huge }
        maps[#maps + 1], by_name[name] = map, map
      end
      if map then
        local a, d = p.values[across.name], p.values[down.name]
        map.cells[d] = map.cells[d] or {}
        map.cells[d][a] = { value = value, over = p.oversubscribed, label = p.label }
        map.low, map.high = math.min(map.low, value), math.max(map.high, value)
      end
    end
  end
  for _, map in ipairs(maps) do
    local by, unit = text.scale(map.unit, map.high)
    for _, d in ipairs(down.values) do
      for _, a in ipairs(across.values) do
        local cell = map.cells[d] and map.cells[d][a]
        if cell then
          cell.value = cell.value / by
        end
      end
    end
    map.unit, map.low, map.high = unit, map.low / by, map.high / by
    add(list, map)
  end
end

-- How evenly the work lay: for each curve the point with the most workers that fits the machine.
local function busy(study, axes)
  local workers = nil
  for _, axis in ipairs(axes) do
    workers = workers or axis.name == "workers" and axis
  end
  local others, list, by_name, rows_at_most = workers and without(axes, workers) or axes, {}, {}, workers and MOST_BUSY or 3
  for _, p in ipairs(study.points) do
    if #p.per_worker > 1 and #p.per_worker <= MOST_BUSY_WORKERS and p.status == "done" then
      local name = name_of(p, study.zip and {} or others) or ""
      local row = by_name[name]
      if not row and #list < rows_at_most then
        row = {}
        list[#list + 1], by_name[name] = row, row
      end
      if row and (not row.point or row.point.oversubscribed and not p.oversubscribed
        or row.point.oversubscribed == p.oversubscribed and #p.per_worker > #row.point.per_worker) then
        row.point = p
      end
    end
  end
  if #list == 0 then
    return nil
  end
  local plot = { kind = "busy", id = "busy", title = "Busy time of each worker", name = "busy", unit = "s", rows = {}, high = 0 }
  for i, row in ipairs(list) do
    local p = row.point
    local most, sum = 0, 0
    for _, s in ipairs(p.per_worker) do
      most, sum = math.max(most, s), sum + s
    end
    plot.rows[i] = { label = p.label, values = p.per_worker, seconds = p.median.seconds, balance = most > 0 and sum / #p.per_worker / most or nil,
      over = p.oversubscribed }
    plot.high = math.max(plot.high, most, p.median.seconds or 0)
  end
  local by
  by, plot.unit = text.scale("s", plot.high)
  plot.by, plot.high = by, plot.high / by
  return plot
end

-- The plots of a study, in the order of the page.
function plots.of(study)
  local axes, list = varying(study), {}
  local workers, x
  for _, axis in ipairs(axes) do
    if axis.name == "workers" then
      workers = axis
    elseif all_numbers(axis.values) or not x or not all_numbers(x.values) then
      x = axis
    end
  end
  if workers then
    scaling(study, axes, workers, list)
  end
  local columns = measures(study)
  for _, column in ipairs(columns) do
    local along = workers or x
    if along and not (workers and column == "seconds") then
      add(list, line_plot(study, x_of(along), study.zip and {} or without(axes, along), column))
    end
  end
  if #axes > 1 and not study.zip then
    for i = 1, math.min(#columns, 2) do
      heat_maps(study, axes, columns[i], list)
    end
    for _, column in ipairs { "efficiency", "flip" } do
      if (workers or column == "flip") and column ~= columns[1] and column ~= columns[2] and distinct(study, column) then
        heat_maps(study, axes, column, list)
      end
    end
  end
  add(list, busy(study, axes))
  return list
end

return plots
