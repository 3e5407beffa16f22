-- What a sweep has found, as tables: a Lua table of the shape that docs/sweep.md describes, results.json, results.csv and runs.csv.

local csv = require "rt.csv"
local json = require "rt.json"
local study = require "rt.study"
local sweep_folder = require "rt.sweep_folder"

local sweep_tables = {}

local function column(name, unit, help, more)
  local c = { name = name, unit = unit, help = help, per = "run", type = "number" }
  for key, value in next, more or {} do
    c[key] = value
  end
  return c
end

local TIMED, TEXT, POINT = { spread = true }, { type = "text" }, { per = "point" }

-- Of each run, then of each point. spread: the quartiles are in results.csv, too.
sweep_tables.columns = {
  column("seconds", "s", "wall time of the render", TIMED),
  column("build_seconds", "s", "wall time of making the trees", TIMED),
  column("load_seconds", "s", "wall time of the script and the files it reads", TIMED),
  column("user_seconds", "s", "CPU time of the process outside the system", TIMED),
  column("system_seconds", "s", "CPU time of the process inside the system"),
  column("process_seconds", "s", "wall time of the process from its start to its end", TIMED),
  column("rays", "", "rays of all kinds"), column("rays_camera", "", "rays from the camera"), column("rays_shadow", "", "rays to lights"),
  column("rays_reflect", "", "mirrored rays"), column("rays_refract", "", "refracted rays"), column("rays_diffuse", "", "scattered rays"),
  column("rays_ao", "", "rays of ambient occlusion"), column("rays_per_second", "1/s", "rays by the wall time of the render", TIMED),
  column("nodes", "", "nodes of trees visited (counted by the integrators cost and steps alone)"),
  column("tests", "", "primitives tested (likewise)"), column("workers", "", "threads that computed"),
  column("memory_bytes", "bytes", "memory of the renderer"),
  column("peak_memory_bytes", "bytes", "largest resident memory of the process so far"),
  column("bytes_moved", "bytes", "bytes sent between processes"), column("hash", "", "hash of the image", TEXT),
  column("speedup", "", "wall time of the fewest workers by this one", POINT), column("efficiency", "", "speed-up by workers", POINT),
  column("serial_fraction", "", "Karp and Flatt's: what of the work is serial", POINT),
  column("psnr", "dB", "peak signal to noise against the reference; absent when equal", POINT),
  column("mse", "", "mean squared error against the reference", POINT),
  column("ssim", "", "structural similarity with the reference", POINT), column("flip", "", "perceived difference from the reference", POINT),
  column("differing", "", "pixels that differ from the reference", POINT),
}

local own = {}
for _, c in ipairs(sweep_tables.columns) do
  own[c.name] = c
end
local FIELDS = { "key", "status", "message", "image", "map", "width", "height", "run", "machine", "label", "description", "per_worker", "measured" }
for _, name in ipairs(FIELDS) do
  own[name] = {}
end

-- Whether a measure function may give a column of that name.
function sweep_tables.is_own(name)
  return own[name] ~= nil
end

-- The columns that occur: the sweep's own, then the measured ones by name.
function sweep_tables.columns_of(points)
  local present, kinds, list, more = {}, {}, {}, {}
  for _, p in ipairs(points) do
    for _, r in ipairs(p.runs) do
      for name, value in next, r do
        present[name] = true
        if not own[name] and not kinds[name] then
          kinds[name] = math.type(value) and "number" or "text"
          more[#more + 1] = name
        elseif not own[name] and not math.type(value) then
          kinds[name] = "text"
        end
      end
    end
    for name in next, p.derived do
      present[name] = true
    end
  end
  for _, c in ipairs(sweep_tables.columns) do
    list[#list + 1] = present[c.name] and c or nil
  end
  table.sort(more)
  for _, name in ipairs(more) do
    list[#list + 1] = column(name, "", "by the measure function", { type = kinds[name], spread = kinds[name] == "number" })
  end
  return list
end

-- ---- JSON ----

local function object_of(values, names)
  local o = json.object()
  for _, name in ipairs(names) do
    o:set(name, values[name])
  end
  return o
end

-- { key, value } with null where there is none.
local function put(o, key, value)
  if value == nil then
    value = json.null
  end
  return o:set(key, value)
end

local function names_of(list)
  local names = {}
  for i, item in ipairs(list) do
    names[i] = item.name
  end
  return names
end

local function axis_json(a)
  return json.object():set("name", a.name):set("kind", a.kind):set("type", a.type):set("values", a.values):set("help", a.help)
end

local function column_json(c)
  return json.object():set("name", c.name):set("unit", c.unit):set("help", c.help):set("per", c.per):set("type", c.type)
end

local function point_json(p, axes, per_run, per_point)
  local runs = {}
  for i, r in ipairs(p.runs) do
    local o = json.object():set("run", r.run):set("machine", r.machine)
    for _, name in ipairs(per_run) do
      o:set(name, r[name])
    end
    runs[i] = o
  end
  local o = json.object():set("key", p.key):set("values", object_of(p.values, axes)):set("label", p.label):set("status", p.status)
  for _, key in ipairs { "message", "image", "map", "width", "height", "hash", "description" } do
    put(o, key, p[key])
  end
  o:set("oversubscribed", p.oversubscribed)
  put(o, "machine", p.machine)
  put(o:set("mixed", p.mixed), "reference", p.reference)
  return o:set("runs", runs):set("median", object_of(p.median, per_run)):set("q1", object_of(p.q1, per_run)):set("q3", object_of(p.q3, per_run))
    :set("derived", object_of(p.derived, per_point)):set("per_worker", p.per_worker)
end

local function group_json(g, axes)
  local o = json.object():set("kind", g.kind):set("values", object_of(g.values, axes)):set("baseline", g.baseline):set("points", g.points)
  return put(o, "fit", g.fit and object_of(g.fit, { "serial_seconds", "parallel_seconds", "serial_fraction", "r2", "points" }))
end

local function mapped(list, f, ...)
  local t = {}
  for i, item in ipairs(list) do
    t[i] = f(item, ...)
  end
  return t
end

function sweep_tables.json(results)
  local axes, per_run, per_point = names_of(results.axes), {}, {}
  for _, c in ipairs(results.columns) do
    local list = c.per == "run" and per_run or per_point
    list[#list + 1] = c.name
  end
  local o = json.object():set("format", 1):set("title", results.title):set("command", results.command):set("scene", results.scene)
    :set("version", results.machine.version):set("build", results.machine.build):set("mode", results.mode)
  put(o, "preset", results.preset):set("zip", results.zip):set("runs", results.runs):set("warmup", results.warmup)
  o:set("axes", mapped(results.axes, axis_json)):set("columns", mapped(results.columns, column_json))
    :set("points", mapped(results.points, point_json, axes, per_run, per_point)):set("groups", mapped(results.groups, group_json, axes))
    :set("conflicts", mapped(results.conflicts, function(c)
      return json.object():set("message", c.message):set("keys", c.keys):set("hashes", c.hashes)
    end)):set("machine", sweep_folder.machine_json(results.machine)):set("machines", mapped(results.machines, sweep_folder.machine_json))
  return json.encode(put(o, "reference", results.reference)) .. "\n"
end

-- ---- CSV ----

-- Axes and columns may share a name (workers): then the axis stands for both.
local function without_axes(results, per)
  local taken, list = {}, {}
  for _, a in ipairs(results.axes) do
    taken[a.name] = true
  end
  for _, c in ipairs(results.columns) do
    if not taken[c.name] and (not per or c.per == per) then
      list[#list + 1] = c
    end
  end
  return list
end

-- A row a point.
function sweep_tables.points_csv(results)
  local head, columns = names_of(results.axes), without_axes(results)
  for _, name in ipairs { "status", "message", "runs", "image", "width", "height", "oversubscribed", "machine", "key" } do
    head[#head + 1] = name
  end
  for _, c in ipairs(columns) do
    head[#head + 1] = c.spread and c.name .. "_median" or c.name
    if c.spread then
      head[#head + 1], head[#head + 2] = c.name .. "_q1", c.name .. "_q3"
    end
  end
  local lines = { csv.row(head) }
  for _, p in ipairs(results.points) do
    local row, n = {}, 0
    local function add(value)
      n = n + 1
      row[n] = value
    end
    for _, a in ipairs(results.axes) do
      add(p.values[a.name])
    end
    add(p.status) add(p.message) add(#p.runs) add(p.image) add(p.width) add(p.height) add(p.oversubscribed)
    add(p.machine and results.machines[p.machine + 1].fingerprint) add(p.key)
    for _, c in ipairs(columns) do
      if c.per == "point" then
        add(p.derived[c.name])
      elseif c.type == "text" then
        add(p.runs[1] and p.runs[1][c.name])
      else
        add(p.median[c.name])
      end
      if c.spread then
        add(p.q1[c.name]) add(p.q3[c.name])
      end
    end
    row.n = n
    lines[#lines + 1] = csv.row(row)
  end
  return table.concat(lines)
end

-- A row a run.
function sweep_tables.runs_csv(results)
  local head, columns = names_of(results.axes), without_axes(results, "run")
  for _, name in ipairs { "run", "machine", "key" } do
    head[#head + 1] = name
  end
  for _, c in ipairs(columns) do
    head[#head + 1] = c.name
  end
  local lines = { csv.row(head) }
  for _, p in ipairs(results.points) do
    for _, r in ipairs(p.runs) do
      local row, n = {}, 0
      for _, a in ipairs(results.axes) do
        n = n + 1
        row[n] = p.values[a.name]
      end
      row[n + 1], row[n + 2], row[n + 3] = r.run, results.machines[r.machine + 1].fingerprint, p.key
      n = n + 3
      for _, c in ipairs(columns) do
        n = n + 1
        row[n] = r[c.name]
      end
      row.n = n
      lines[#lines + 1] = csv.row(row)
    end
  end
  return table.concat(lines)
end

-- ---- a point's numbers ----

-- Sets what the runs of each point say together: medians, quartiles, busy times; then what the points say of each other.
function sweep_tables.judge(results, identity)
  for _, p in ipairs(results.points) do
    p.derived = p.metrics or {}
  end
  results.columns = sweep_tables.columns_of(results.points)
  for _, p in ipairs(results.points) do
    p.median, p.q1, p.q3 = study.quartiles(p.runs, results.columns)
    local middle = p.median.seconds and study.middle_run(p.runs, p.median.seconds)
    p.per_worker = middle and middle.per_worker or {}
    local asked = tonumber(p.values.workers)
    p.workers = asked and asked > 0 and asked or p.median.workers
    p.oversubscribed = p.workers ~= nil and p.workers > results.machine.cpus
  end
  results.groups = study.groups(results.points, results.axes, results.machine.cpus, results.weak)
  for _, g in ipairs(results.groups) do
    g.baseline, g.points = g.members[1].key, {}
    for i, p in ipairs(g.members) do
      g.points[i] = p.key
    end
    g.members = nil
  end
  results.columns = sweep_tables.columns_of(results.points)
  results.conflicts = study.conflicts(results.points, identity)
end

return sweep_tables
