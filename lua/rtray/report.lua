-- What a render tells about itself: the closing line, statistics, settings, as text and as JSON.

local files = require "rtray.files"
local axis = require "rt.axis"
local json = require "rtray.json"
local output = require "rtray.output"
local recipe = require "rtray.recipe"
local types = require "rtray.types"

local report = {}

local arrangement = require("rt.settings").arrangement
local KINDS = { "camera", "shadow", "reflect", "refract", "diffuse", "ao" }

local function setting_list()
  return require("rt").settings()
end

local function plain(value)
  if type(value) == "table" and value.width then
    return json.object():set("x", value.x):set("y", value.y):set("width", value.width):set("height", value.height)
  end
  return value
end

function report.picture_settings(settings)
  local object = json.object()
  for _, row in ipairs(setting_list()) do
    if not arrangement[row.name] then
      object:set(row.name, plain(settings[row.name]))
    end
  end
  return object
end

local function parameter(value)
  if type(value) == "table" or type(value) == "userdata" then
    return { value[1] or value.x, value[2] or value.y, value[3] or value.z }
  end
  return value
end
report.parameter = parameter

function report.parameter_values(run)
  local object = json.object()
  for _, p in ipairs(run.params) do
    object:set(p.name, p.type == "file" and files.name_of(p.value) or parameter(p.value)) -- where the user keeps files is nobody's business
  end
  return object
end

-- What an image file says about itself: { [key] = text }. Only what decides the picture: equal pictures make equal files, however they were computed.
-- values: the options; save: how the image is saved. With --no-metadata there are none.
function report.texts(opened, settings, values, save)
  local run = opened.run
  if values.no_metadata then
    return {}
  end
  local picture = report.picture_settings(settings)
  return {
    Software = "librt " .. require("rt").version,
    Scene = types.quote(files.name_of(run.path)):sub(2, -2),
    Settings = json.encode(picture),
    Parameters = #run.params > 0 and json.encode(report.parameter_values(run)) or nil,
    Recipe = recipe.of(opened, picture, save),
  }
end

-- The same for a point of a sweep (rt/sweep_run.lua).
function report.texts_of_sweep(opened, settings, request)
  local define = {}
  for i, pair in ipairs(request.parameters or {}) do
    define[i] = { name = pair[1], text = pair[2] }
  end
  recipe.remember(opened.run, request.scene, { define = define, set = request.set, seed = request.seed })
  return report.texts(opened, settings, {}, {})
end

function report.render_json(path, image, settings, stats)
  local width, height = image:size()
  local rays = json.object()
  for _, kind in ipairs(KINDS) do
    rays:set(kind, stats["rays_" .. kind])
  end
  local workers = {}
  for i, w in ipairs(stats.per_worker) do
    workers[i] = json.object():set("busy_seconds", w.busy_seconds):set("cpu_seconds", w.cpu_seconds):set("rays", w.rays):set("tiles", w.tiles)
  end
  local counted = stats.nodes + stats.tests > 0 -- by the views of costs alone
  return json.object():set("output", path):set("width", width):set("height", height):set("hash", image:hash())
    :set("settings", report.picture_settings(settings)):set("tracer", settings.tracer):set("tile", settings.tile)
    :set("seconds", stats.seconds):set("build_seconds", stats.build_seconds):set("rays", rays)
    :set("nodes", counted and stats.nodes or nil):set("tests", counted and stats.tests or nil)
    :set("clamped", stats.clamped):set("dropped", stats.dropped):set("memory", stats.memory)
    :set("work", report.work_json(report.work())):set("workers", workers)
end

function report.render_line(path, image, settings, stats)
  local width, height = image:size()
  local rate = stats.rays / math.max(stats.seconds, 1e-9)
  local warning = stats.dropped > 0 and (", %s contributions were no numbers and left out"):format(output.count(stats.dropped)) or ""
  local name = path == "-" and "standard output" or path
  return ("%s: %dx%d, %d sample%s, %s, %s rays (%s/s), %d worker%s%s"):format(name, width, height, settings.samples,
    settings.samples == 1 and "" or "s", output.seconds(stats.seconds), output.rate(stats.rays), output.rate(rate), stats.workers,
    stats.workers == 1 and "" or "s", warning)
end

local COUNTS = {
  "files_read", "files_kept", "trees_built", "top_trees_built", "trees_kept", "trees_refitted", "read_seconds", "build_seconds", "saved_seconds",
}
local before = {}

-- What reading and building cost since this was asked last, by the names of rt.counts.
function report.work()
  local now, since = require("rt").counts(), {}
  for _, key in ipairs(COUNTS) do
    since[key] = now[key] - (before[key] or 0)
  end
  before = now
  return since
end

function report.work_json(work)
  local object = json.object()
  for _, key in ipairs(COUNTS) do
    object:set(key, work[key])
  end
  return object
end

function report.print_work(note, work)
  note("files    %d read and parsed in %s, %d taken over", work.files_read, output.seconds(work.read_seconds), work.files_kept)
  note("built    %d tree%s of geometry, %d of the top level in %s; %d taken over, %d refitted", work.trees_built, work.trees_built == 1 and "" or "s",
    work.top_trees_built, output.seconds(work.build_seconds), work.trees_kept, work.trees_refitted)
  note("saved    %s by what was taken over", output.seconds(work.saved_seconds))
end

function report.print_stats(note, stats)
  report.print_work(note, report.work())
  note("render   %s", output.seconds(stats.seconds))
  note("trees    %s", output.seconds(stats.build_seconds))
  for _, kind in ipairs(KINDS) do
    local count = stats["rays_" .. kind]
    if count > 0 then
      note("%-8s %s rays", kind, output.count(count))
    end
  end
  local rays = math.max(stats.rays, 1)
  if stats.nodes + stats.tests > 0 then
    note("nodes    %s visited, %.1f a ray", output.count(stats.nodes), stats.nodes / rays)
    note("tests    %s primitives, %.1f a ray", output.count(stats.tests), stats.tests / rays)
  end
  note("memory   %s", output.bytes(stats.memory))
  note("clamped  %s, dropped %s", output.count(stats.clamped), output.count(stats.dropped))
  for i, w in ipairs(stats.per_worker) do
    note("worker %d busy %s of %s, cpu %s, %s rays, %s tiles", i - 1, output.seconds(w.busy_seconds), output.seconds(stats.seconds),
      output.seconds(w.cpu_seconds), output.count(w.rays), output.count(w.tiles))
  end
end

-- run: of the script, whose parameters are printed too.
function report.print_settings(note, values, sources, run)
  for _, p in ipairs(run and run.params or {}) do
    local over = p.overruled ~= nil and (", over set %s's %s"):format(run.set, axis.text(p.overruled)) or ""
    note("-D %-12s %-12s %s", p.name, axis.text(p.value), p.source .. over)
  end
  for _, row in ipairs(setting_list()) do
    local value = values[row.name]
    if type(value) == "table" then
      value = ("%d,%d,%d,%d"):format(value.x, value.y, value.width, value.height)
    end
    if value ~= nil then
      note("%-15s %-12s %s", row.name, tostring(value), sources[row.name] or "built in")
    end
  end
end

return report
