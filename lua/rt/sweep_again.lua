-- What a sweep that was killed had found: its plan (axes, points, their keys) stands in plan.json since it began, its runs in the journal; the
-- tables are made from the two as the sweep makes them at its end.

local core = require "rt.core"
local json = require "rt.json"
local presets = require "rt.sweep_presets"
local sweep_folder = require "rt.sweep_folder"
local sweep_run = require "rt.sweep_run"
local sweep_work = require "rt.sweep_work"

local again = {}

local FORMAT = 1
local pack, unpack_text = sweep_run.pack, sweep_run.unpack

local function packed(list)
  local copy = {}
  for i, text in ipairs(list or {}) do
    copy[i] = pack(text)
  end
  return copy
end

local function unpacked(list)
  local copy = {}
  for i, value in ipairs(list or {}) do
    copy[i] = unpack_text(value)
  end
  return copy
end

local TEXTS = { "key", "label", "description", "picture", "failed" }

-- Writes the plan of a sweep whose points have been described.
function again.keep(s)
  local axes, points = {}, {}
  for i, a in ipairs(s.axes) do
    axes[i] = json.object():set("name", a.name):set("kind", a.kind):set("type", a.type):set("help", a.help):set("values", packed(a.values))
  end
  for i, p in ipairs(s.points) do
    local values = {}
    for k, a in ipairs(s.axes) do
      values[k] = pack(p.values[a.name])
    end
    points[i] = json.object():set("values", values):set("reference", p.compared and p.compared.key)
    for _, key in ipairs(TEXTS) do
      points[i]:set(key, p[key] and pack(p[key]))
    end
  end
  s.store:replace("plan.json", json.encode(json.object():set("format", FORMAT):set("title", pack(s.title))
    :set("command", s.command and packed(s.command))
    :set("scene", pack(s.scene_name)):set("mode", s.base.mode):set("preset", s.preset and s.preset.name):set("zip", s.zip):set("runs", s.count)
    :set("warmup", s.warmup):set("reference", s.reference and pack(s.reference)):set("machine", s.machine.fingerprint):set("axes", axes)
    :set("points", points)) .. "\n")
end

local function read_plan(path)
  local file = core.file_stat(path) == "file" and io.open(path, "rb") or nil
  local text = file and file:read "a"
  if file then
    file:close()
  end
  local plan = text and json.decode(text)
  return type(plan) == "table" and plan.format == FORMAT and plan or nil
end

local function points_of(plan, axes)
  local points = {}
  for i, t in ipairs(plan.points) do
    local p = { values = {}, compared = t.reference and { key = t.reference } or nil }
    for k, a in ipairs(axes) do
      p.values[a.name] = unpack_text(t.values[k])
    end
    for _, key in ipairs(TEXTS) do
      p[key] = t[key] and unpack_text(t[key]) or nil
    end
    points[i] = p
  end
  return points
end

-- The sweep as far as its results tell of it.
local function sweep_of(folder, plan)
  local store = sweep_folder.look(folder)
  local machine = store.machines[plan.machine]
  if not machine then
    return nil -- it was killed in its first moments
  end
  local axes = {}
  for i, a in ipairs(plan.axes) do
    axes[i] = { name = a.name, kind = a.kind, type = a.type, help = a.help, values = unpacked(a.values) }
  end
  return {
    title = unpack_text(plan.title), command = plan.command and unpacked(plan.command), scene_name = unpack_text(plan.scene),
    base = { mode = plan.mode },
    preset = plan.preset and presets[plan.preset], zip = plan.zip, count = plan.runs, warmup = plan.warmup, output = folder,
    reference = plan.reference and unpack_text(plan.reference), axes = axes, points = points_of(plan, axes), machine = machine,
    machines = store.machine_list, store = store, looks_again = true,
  }
end

local function changed(path)
  local _, _, time = core.file_stat(path)
  return time
end

-- Makes the tables of a folder whose journal is newer than they are. True when it did; a folder of tables alone is left as it is.
function again.refresh(folder)
  local journal, tables = changed(folder .. "/journal.jsonl"), changed(folder .. "/results.json")
  if not journal or tables and tables >= journal then
    return false
  end
  local plan = read_plan(folder .. "/plan.json")
  local s = plan and sweep_of(folder, plan)
  if not s then
    return false
  end
  sweep_work.write_tables(s, sweep_work.results_of(s))
  return true
end

return again
