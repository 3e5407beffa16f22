-- What measured runs say: medians and quartiles, speed-up, Karp and Flatt's serial fraction, Amdahl's law fitted. docs/sweep.md gives the formulas.

local study = {}

-- The q-quantile (0 ... 1) of numbers, between neighbours by their distance (type 7, as R and NumPy have it); nil of none.
function study.quantile(list, q)
  local n = #list
  if n == 0 then
    return nil
  end
  local sorted = table.move(list, 1, n, 1, {})
  table.sort(sorted)
  local at = 1 + (n - 1) * q
  local low = math.floor(at)
  local a, b = sorted[low], sorted[math.min(low + 1, n)]
  return at == low and a or a + (b - a) * (at - low)
end

function study.median(list)
  return study.quantile(list, 0.5)
end

-- Of runs, the numbers in a column.
local function numbers(runs, name)
  local list = {}
  for _, r in ipairs(runs) do
    if math.type(r[name]) then
      list[#list + 1] = r[name]
    end
  end
  return list
end

-- median, q1, q3 by column of runs.
function study.quartiles(runs, columns)
  local median, q1, q3 = {}, {}, {}
  for _, column in ipairs(columns) do
    if column.per == "run" and column.type == "number" then
      local list = numbers(runs, column.name)
      median[column.name], q1[column.name], q3[column.name] = study.median(list), study.quantile(list, 0.25), study.quantile(list, 0.75)
    end
  end
  return median, q1, q3
end

-- The run whose seconds are nearest to the median (the first of equals).
function study.middle_run(runs, median)
  local best
  for _, r in ipairs(runs) do
    if r.seconds and (not best or math.abs(r.seconds - median) < math.abs(best.seconds - median)) then
      best = r
    end
  end
  return best
end

-- Least squares of T = a + b / workers over { workers, seconds } pairs: serial and parallel seconds, serial fraction, r2 (nil
-- of two, which any line meets); nil below two different counts.
function study.amdahl(pairs_of)
  local n, sx, sy, sxx, sxy, syy = 0, 0, 0, 0, 0, 0
  for _, p in ipairs(pairs_of) do
    local x, y = 1 / p[1], p[2]
    n, sx, sy, sxx, sxy, syy = n + 1, sx + x, sy + y, sxx + x * x, sxy + x * y, syy + y * y
  end
  local spread = n * sxx - sx * sx
  if n < 2 or spread <= 1e-12 * n * sxx then
    return nil
  end
  local b = (n * sxy - sx * sy) / spread
  local a = (sy - b * sx) / n
  local total = syy - sy * sy / n
  local rest = 0
  for _, p in ipairs(pairs_of) do
    rest = rest + (p[2] - a - b / p[1]) ^ 2
  end
  return { serial_seconds = a, parallel_seconds = b, serial_fraction = a / (a + b), r2 = n > 2 and total > 0 and 1 - rest / total or nil, points = n }
end

-- Text that is the same for points which differ in `workers` alone (strong), or in workers and size (weak).
local function group_key(point, axes, without)
  local parts = {}
  for _, a in ipairs(axes) do
    if not without[a.name] then
      parts[#parts + 1] = a.name .. "=" .. point.values[a.name]
    end
  end
  return table.concat(parts, "\0")
end

local function rest_of(point, axes, without)
  local rest = {}
  for _, a in ipairs(axes) do
    if not without[a.name] then
      rest[a.name] = point.values[a.name]
    end
  end
  return rest
end

local function measured(point)
  return point.status == "done" and point.median.seconds and point.median.seconds > 0
end

-- Speed-up and so on of a group's points, which stand in the order of their workers.
local function judge(group, cpus)
  local base = group.members[1]
  local w0, t0 = base.workers, base.median.seconds
  local pixels0 = (base.width or 1) * (base.height or 1)
  local fit = {}
  for _, p in ipairs(group.members) do
    local w, t = p.workers, p.median.seconds
    local d = p.derived
    if group.kind == "weak" then
      d.efficiency = ((p.width or 1) * (p.height or 1) / w) / (pixels0 / w0) * t0 / t
      d.speedup = d.efficiency * w
    else
      d.speedup = w0 * t0 / t
      d.efficiency = d.speedup / w
      if w > 1 then
        d.serial_fraction = (1 / d.speedup - 1 / w) / (1 - 1 / w)
      end
      if w <= cpus then
        fit[#fit + 1] = { w, t }
      end
    end
  end
  group.fit = #fit >= 2 and study.amdahl(fit) or nil
end

-- Groups of points over the axis `workers`, and their derived values; none without such an axis. weak: the axis `size` goes along with it.
function study.groups(points, axes, cpus, weak)
  local has = {}
  for _, a in ipairs(axes) do
    has[a.name] = true
  end
  if not has.workers then
    return {}
  end
  local without = { workers = true, size = weak or nil, width = weak or nil, height = weak or nil }
  local groups, by_key = {}, {}
  for _, p in ipairs(points) do
    if measured(p) and p.workers then
      local key = group_key(p, axes, without)
      if not by_key[key] then
        by_key[key] = { kind = weak and "weak" or "strong", values = rest_of(p, axes, without), members = {} }
        groups[#groups + 1] = by_key[key]
      end
      table.insert(by_key[key].members, p)
    end
  end
  for _, group in ipairs(groups) do
    table.sort(group.members, function(a, b)
      return a.workers < b.workers or a.workers == b.workers and a.index < b.index
    end)
    judge(group, cpus)
  end
  return groups
end

-- Points whose images must be equal, and are not: they agree in all that describes the picture. identity: of a done point, such a text.
function study.conflicts(points, identity)
  local list, first, by_identity = {}, {}, {}
  for _, p in ipairs(points) do
    if p.status == "done" then
      for _, r in ipairs(p.runs) do
        if r.hash ~= p.hash then
          list[#list + 1] = { message = ("two runs of %s gave different images"):format(p.label), keys = { p.key }, hashes = { p.hash, r.hash } }
          break
        end
      end
      local id = identity(p)
      if not first[id] then
        first[id] = p
      elseif first[id].hash ~= p.hash then
        local c = by_identity[id]
        if not c then
          c = { message = "settings that must not change the image did: " .. first[id].label, keys = { first[id].key }, hashes = { first[id].hash } }
          by_identity[id] = c
          list[#list + 1] = c
        end
        c.message = c.message .. " and " .. p.label
        c.keys[#c.keys + 1], c.hashes[#c.hashes + 1] = p.key, p.hash
      end
    end
  end
  return list
end

return study
