-- rtray bench SCENE: times of tree builders and of renders. Each run is a process of its own, runs of all arrangements interleaved;
-- medians are shown.

local child = require "rtray.child"
local cli = require "rtray.cli"
local csv = require "rt.csv"
local study = require "rt.study"
local sweep_folder = require "rt.sweep_folder"
local files = require "rtray.files"
local json = require "rtray.json"
local output = require "rtray.output"
local source = require "rtray.source"

local bench = {}

local BUILDERS = { -- as `builder` and `accel`
  { name = "kdtree exact", tracer = "kdtree", builder = "exact" }, { name = "kdtree binned", tracer = "kdtree", builder = "binned" },
  { name = "kdtree paper", tracer = "kdtree", builder = "paper" }, { name = "octree", tracer = "octree", builder = "auto" },
  { name = "bvh", tracer = "bvh", builder = "auto" }, { name = "bvh compact", tracer = "bvh", builder = "compact" },
  { name = "bvh spatial", tracer = "bvh", builder = "spatial" },
}

-- All trees of the scene together: seconds and bytes add up, depth is the deepest; cost is the first one's.
local function read_build(text)
  local sum = { seconds = 0, nodes = 0, depth = 0, bytes = 0 }
  for name, seconds, nodes, depth, cost, bytes in text:gmatch "(%S+) %S+ (%S+) (%S+) (%S+) (%S+) (%S+)\n" do
    sum.name, sum.cost = sum.name or name, sum.cost or tonumber(cost)
    sum.seconds, sum.nodes, sum.bytes = sum.seconds + tonumber(seconds), sum.nodes + tonumber(nodes), sum.bytes + tonumber(bytes)
    sum.depth = math.max(sum.depth, tonumber(depth))
  end
  return sum.name and sum or nil
end

local function read_render(text)
  local seconds, build, rays, workers, hash = text:match "^(%S+) (%S+) (%S+) (%S+) (%S+)"
  return { seconds = tonumber(seconds), build_seconds = tonumber(build), rays = math.tointeger(tonumber(rays)), workers = tonumber(workers),
    hash = hash }
end

local function note(values, ...)
  if not values.quiet then
    output.note(...)
  end
end

-- Each once, in the order given: by themselves one worker and one a CPU, which may be the same.
local function worker_counts(values)
  local list, seen = {}, {}
  for _, count in ipairs(values.workers_list or { 1, require("rt").machine().cpus }) do
    list[#list + 1] = not seen[count] and count or nil
    seen[count] = true
  end
  return list
end

-- The arrangements to time: each has row(run) -> measured, and what the table and the CSV say of it.
local function arrangements(path, values, settings)
  local list = {}
  for _, b in ipairs(BUILDERS) do
    list[#list + 1] = {
      kind = "build", name = b.name, tracer = b.tracer, builder = b.builder,
      measure = function()
        return read_build(child.run("build", path, values, { "--tracers=" .. b.tracer, "--builder=" .. b.builder }))
      end,
    }
  end
  local size = { ("--size=%dx%d"):format(settings.width, settings.height), ("--samples=%d"):format(settings.samples) }
  if values.integrator then
    size[3] = "--integrator=" .. values.integrator
  end
  for _, tracer in ipairs(values.tracers_list or { "kdtree", "octree", "bvh" }) do
    for _, workers in ipairs(worker_counts(values)) do
      local more = table.move(size, 1, #size, 1, { })
      more[#more + 1] = "--tracer=" .. tracer
      more[#more + 1] = ("--workers=%d"):format(workers)
      list[#list + 1] = {
        kind = "render", name = tracer, tracer = tracer, builder = "auto", workers = workers,
        measure = function()
          return read_render(child.run("measure", path, values, more))
        end,
      }
    end
  end
  return list
end

local function measure_all(list, runs, values)
  for run = 1, runs do
    note(values, "run %d of %d", run, runs)
    for _, a in ipairs(list) do
      a.runs = a.runs or {}
      local lock = sweep_folder.machine_lock(function(text) note(values, "rtray bench: %s", text) end)
      a.runs[run] = a.measure() or { seconds = 0, missing = true }
      if lock then
        lock:release()
      end
    end
  end
  for _, a in ipairs(list) do
    local seconds = {}
    for i, r in ipairs(a.runs) do
      seconds[i] = r.seconds
    end
    a.median, a.last = study.median(seconds), a.runs[#a.runs]
  end
end

local function print_tables(list, path, settings, runs)
  output.print("%s, medians of %d run%s", path, runs, runs == 1 and "" or "s")
  local rows = { { "builder", "build", "nodes", "depth", "SAH", "bytes" } }
  for _, a in ipairs(list) do
    if a.kind == "build" and not a.last.missing then
      rows[#rows + 1] = { a.name, output.seconds(a.median), output.count(a.last.nodes), tostring(a.last.depth), ("%.2f"):format(a.last.cost),
        output.bytes(a.last.bytes) }
    end
  end
  output.table(rows, { true })
  output.print("\n%dx%d, %d sample%s", settings.width, settings.height, settings.samples, settings.samples == 1 and "" or "s")
  rows = { { "structure", "workers", "render", "rays/s", "speedup" } }
  local base = {}
  for _, a in ipairs(list) do
    if a.kind == "render" then
      base[a.tracer] = base[a.tracer] or a.median
      rows[#rows + 1] = { a.name, tostring(a.workers), output.seconds(a.median), output.rate(a.last.rays / a.median),
        ("%.2f"):format(base[a.tracer] / a.median) }
    end
  end
  output.table(rows, { true })
end

local COLUMNS = {
  "scene", "kind", "structure", "builder", "workers", "width", "height", "samples", "run", "seconds", "rays", "rays_per_second", "nodes", "depth",
  "sah_cost", "tree_bytes", "hash",
}

local function as_csv(list, path, settings)
  local lines = { csv.row(COLUMNS) }
  for _, a in ipairs(list) do
    for run, r in ipairs(a.runs) do
      local render = a.kind == "render"
      local row = {
        path, a.kind, a.tracer, a.builder, a.workers or "", render and settings.width or "", render and settings.height or "",
        render and settings.samples or "", run, ("%.9g"):format(r.seconds), r.rays or "", r.rays and ("%.0f"):format(r.rays / r.seconds) or "",
        r.nodes or "", r.depth or "", r.cost or "", r.bytes or "", r.hash or "",
      }
      if not r.missing then
        lines[#lines + 1] = csv.row(row)
      end
    end
  end
  return table.concat(lines)
end

local function as_json(list, path, settings, runs)
  local rows = {}
  for _, a in ipairs(list) do
    if not a.last.missing then
      rows[#rows + 1] = json.object():set("kind", a.kind):set("structure", a.tracer):set("builder", a.builder):set("workers", a.workers)
        :set("median_seconds", a.median):set("rays", a.last.rays):set("nodes", a.last.nodes):set("hash", a.last.hash)
    end
  end
  return json.object():set("scene", path):set("width", settings.width):set("height", settings.height):set("samples", settings.samples)
    :set("runs", runs):set("results", rows)
end

function bench.run(command, values, arguments)
  local path = arguments[1]
  if values.output == "-" and values.json then
    cli.fault(command, "-o - and --json both want standard output")
  elseif values.output then
    files.check_output(values.output)
  end
  local runs = values.runs or 3
  local settings = source.open(path, values, command).scene:effective() -- faults show before the first run
  if values.output then
    files.check_output(values.output) -- again: now it is known what the scene reads
  end
  local list = arrangements(path, values, settings)
  measure_all(list, runs, values)
  if values.json then
    output.print("%s", json.encode(as_json(list, path, settings, runs)))
  elseif values.output == "-" then
    output.write(as_csv(list, path, settings))
    return 0
  else
    print_tables(list, path, settings, runs)
  end
  if values.output then
    files.replace(values.output, as_csv(list, path, settings))
  end
  return 0
end

return bench
