-- Folders as a sweep leaves them, made by hand: for the tests of reports.

local fixture = {}

local json = require "rt.json"

local function object(...)
  local o = json.object()
  local list = { ... }
  for i = 1, #list, 2 do
    o:set(list[i], list[i + 1])
  end
  return o
end
fixture.object = object

fixture.COLUMNS = {
  object("name", "seconds", "unit", "s", "help", "time of the render", "per", "run", "type", "number"),
  object("name", "build_seconds", "unit", "s", "help", "time of the trees", "per", "run", "type", "number"),
  object("name", "rays_per_second", "unit", "1/s", "help", "rays of all kinds", "per", "run", "type", "number"),
  object("name", "peak_memory", "unit", "bytes", "help", "most memory of the process", "per", "run", "type", "number"),
  object("name", "speedup", "unit", "", "help", "against the fewest workers", "per", "point", "type", "number"),
  object("name", "efficiency", "unit", "", "help", "speed-up / workers", "per", "point", "type", "number"),
  object("name", "serial_fraction", "unit", "", "help", "Karp and Flatt", "per", "point", "type", "number"),
}

-- One point. p: { values (object), status, message, image, seconds, workers, cpus, base (seconds of one worker), hash }
function fixture.point(i, p)
  local median, q1, q3 = json.object(), json.object(), json.object()
  local derived, busy = json.object(), {}
  if p.seconds then
    median:set("seconds", p.seconds):set("build_seconds", 0.0123):set("rays_per_second", 4.2e6 / p.seconds):set("peak_memory", 52428800 + 1e6 * i)
    q1:set("seconds", p.seconds * 0.97)
    q3:set("seconds", p.seconds * 1.05)
    if p.base then
      local s = p.base / p.seconds
      derived:set("speedup", s):set("efficiency", s / p.workers)
      derived:set("serial_fraction", p.workers > 1 and (1 / s - 1 / p.workers) / (1 - 1 / p.workers) or nil)
    end
    for w = 1, p.workers or 0 do
      busy[w] = p.seconds * (0.9 - 0.03 * (w % 4))
    end
  end
  local runs = {}
  for r = 1, p.seconds and 3 or 0 do
    runs[r] = object("run", r, "machine", 1, "seconds", p.seconds * (1 + 0.02 * (r - 2)))
  end
  return object("key", ("%032x"):format(i), "values", p.values, "label", p.label, "status", p.status or "done", "message", p.message, "image",
    p.image,
    "width", p.width, "height", p.height, "hash", p.hash, "oversubscribed", p.workers and p.workers > (p.cpus or 1024) or false, "mixed", false,
    "runs", runs, "median", median, "q1", q1, "q3", q3, "derived", derived, "per_worker", busy)
end

fixture.MACHINE = object("fingerprint", "f00", "cpu", "Test CPU @ 2 GHz", "logical_cpus", 4, "cores", 2, "cpus", 4, "memory_bytes", 8 * 2 ^ 30,
  "system", "Linux",
  "kernel", "6.1", "governor", "powersave", "load", { 0.8, 0.5, 0.3 }, "version", "0.1.0", "build", "stb=ON", "compiler", "gcc 12", "flags", "-O2",
  "caches", { object("level", 1, "type", "Data", "bytes", 32768), object("level", 2, "type", "Unified", "bytes", 1048576) },
  "time", "2026-01-02T03:04:05Z")

-- t: { axes = {{name, kind, {values}}}, points, conflicts, groups, preset, command, title, columns, machine }
function fixture.results(t)
  local axes = {}
  for i, a in ipairs(t.axes or {}) do
    axes[i] = object("name", a[1], "kind", a[2], "type", "number", "values", a[3])
  end
  return json.encode(object("format", 1, "title", t.title or "scene.lua", "command", t.command or { "rtray", "sweep", "scene.lua", "-o", "report" },
    "scene",
    t.scene or "scene.lua", "version", "0.1.0", "build", "stb=ON", "mode", t.mode or "process", "preset", t.preset, "zip", t.zip or false, "runs",
      3, "warmup", 1,
    "axes", axes, "columns", t.columns or fixture.COLUMNS, "points", t.points or {}, "groups", t.groups or {}, "conflicts", t.conflicts or {},
    "machine", t.machine or fixture.MACHINE, "machines", { t.machine or fixture.MACHINE }))
end

-- Times over workers for some sizes, as Amdahl's law has them.
function fixture.scaling(t)
  local points, groups = {}, {}
  local workers = t.workers or { 1, 2, 4, 8, 16 }
  for s, size in ipairs(t.sizes) do
    local keys, base = {}, 0.8 * s
    for _, w in ipairs(workers) do
      local i = #points + 1
      local seconds = base * (0.06 + 0.94 / math.min(w, t.cpus or 4)) * (w > (t.cpus or 4) and 1.04 or 1)
      local image = t.image and t.image(i, w, size)
      points[i] = fixture.point(i, { values = object("workers", tostring(w), "size", size), seconds = seconds, base = base, workers = w,
        cpus = t.cpus or 4,
        image = image, width = image and 64, height = image and 48, hash = image and ("%032x"):format(s) })
      keys[#keys + 1] = ("%032x"):format(i)
    end
    groups[s] = object("kind", "strong", "values", object("size", size), "baseline", keys[1], "points", keys, "fit",
      object("serial_seconds", base * 0.06, "parallel_seconds", base * 0.94, "serial_fraction", 0.06, "r2", 0.9991, "points", 3))
  end
  local texts = {}
  for i, w in ipairs(workers) do
    texts[i] = tostring(w)
  end
  t.points, t.groups = points, groups
  t.axes = { { "workers", "setting", texts }, { "size", "setting", t.sizes } }
  return fixture.results(t)
end

function fixture.write(folder, text)
  local file = assert(io.open(folder .. "/results.json", "wb"))
  assert(file:write(text))
  assert(file:close())
end

return fixture
