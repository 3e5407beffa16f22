-- The measuring of a sweep: what is missing is run in rounds, kept in the journal at once, and put into tables.

local core = require "rt.core"
local guard = require "rt.guard"
local image = require "rt.image"
local json = require "rt.json"
local sweep_folder = require "rt.sweep_folder"
local sweep_plan = require "rt.sweep_plan"
local sweep_run = require "rt.sweep_run"
local sweep_tables = require "rt.sweep_tables"
local sweep_worker = require "rt.sweep_worker"
local words = require "rt.words"

local sweep_work = {}

local COLLECT_EVERY = 50 -- runs in this process between two full collections: memory stays flat, at some 0.1 ms a run
local METRICS = { "psnr", "mse", "ssim", "flip", "differing" } -- against a reference

-- ---- measuring ----

-- A point that did not come to its end because the sweep was interrupted has not failed.
local function raise_interruption(s, why)
  if s.interrupted and s.interrupted() or not s.interrupted and tostring(why):find "interrupted!$" then -- lua5.4's own word
    error("interrupted!", 0)
  end
end

-- Asks for a run or a description where the sweep runs them.
function sweep_work.ask(s, request)
  local answer, why
  if s.in_process then
    answer, why = sweep_run.answer(request)
  elseif request.kind == "describe" then
    answer, why = sweep_worker.kept(s.keeper, request, s)
  else
    answer, why = sweep_worker.fresh(request, s)
  end
  if not answer then
    raise_interruption(s, why)
  end
  return answer, why
end

-- Describes each point once for all that share the script's values.
function sweep_work.describe(s)
  local known = {}
  for _, p in ipairs(s.points) do
    sweep_plan.request(p, s.axes, s.base)
    local d = known[p.describes]
    if not d then
      p.request.kind = "describe"
      local wanted = p.request.settings
      p.request.settings = {}
      local answer, why = sweep_work.ask(s, p.request)
      p.request.settings = wanted
      d = answer or { failed = why }
      known[p.describes] = d
    end
    p.request.kind = "run"
    if d.failed then
      sweep_plan.fail(p, d.failed)
    else
      sweep_plan.identify(p, d, s.base)
    end
  end
end

-- Whether an image can be taken over: there, with the bytes it had, and saying that it is this image (another sweep of the folder may have had
-- a point of the same name).
local function is_whole(s, record)
  if not record or type(record.file) ~= "string" then
    return false
  elseif record.whole == nil then
    local file = io.open(s.store.path(record.file), "rb")
    local text = file and file:read "a" or ""
    if file then
      file:close()
    end
    record.whole = #text == record.bytes and text:find(record.hash or "?", 1, true) ~= nil
  end
  return record.whole
end

-- Where FLIP of each pixel against the reference is kept as a picture: below maps/ by the image's name.
local function map_file(p)
  return (p.file:gsub("^images/", "maps/"))
end

local function reference_file(p)
  return "reference/" .. p.key .. ".raw"
end

-- Whether a point lacks its picture (or what a comparison needs), though its runs may be there.
local function lacks_picture(s, p)
  if not s.store then
    return false
  end
  local metrics = s.store.metrics[p.key]
  return s.images and not is_whole(s, s.store.images[p.key])
    or p.is_reference and not core.file_stat(s.store.path(reference_file(p)))
    or p.compared and not (metrics and metrics.reference == p.compared.key and metrics.of == s.image_hash(p.compared)
      and (not s.images or not metrics.map or core.file_stat(s.store.path(metrics.map))))
end

-- How an image differs from its reference's, as far as their sizes are the same.
local function compare(s, p, made)
  local other = sweep_run.read_raw(s.store.path(reference_file(p.compared)))
  if not other then
    return
  end
  local w, h = made:size()
  local ow, oh = other:size()
  local o = json.object():set("t", "metrics"):set("key", p.key):set("reference", p.compared.key):set("of", other:hash())
  local found = w == ow and h == oh and image.compare(other, made, { flip = true, map = s.images and "flip" or nil }) or {}
  if found.map then
    s.store:sub_folder "maps"
    guard.own(s.store.path(map_file(p)))
    found.map:color_map("magma"):save(s.store.path(map_file(p)), { text = false })
    found.map:release()
    o:set("map", map_file(p))
  end
  for _, name in ipairs(METRICS) do
    local value = found[name]
    if math.type(value) and value == value and math.abs(value) ~= math.huge then
      o:set(name, value)
    end
  end
  other:release()
  s.store:add(o)
  s.store.metrics[p.key] = json.decode(json.encode(o))
end

-- The own columns of a run as fields of its record.
local function add_measured(record, measured)
  for _, pair in ipairs(measured or {}) do
    if sweep_tables.is_own(pair[1]) then
      error(("measure: %s is the name of a column of the sweep's own; choose another"):format(pair[1]), 0)
    end
    record[pair[1]] = pair[2]
  end
end

-- Runs a point once. picture: its image is kept, and compared. The answer, or nil and why.
local function measure(s, p, picture)
  local request = {}
  for key, value in next, p.request do
    request[key] = value
  end
  local in_lua = type(s.measure) == "function"
  local raw = s.store and picture and (p.is_reference and s.store.path(reference_file(p)) or p.compared and s.store.path "reference/.image")
    or in_lua and not s.in_process and os.tmpname() or nil
  local stays = s.store and picture and p.is_reference
  local _ <close> = raw and not stays and setmetatable({}, { __close = function() os.remove(raw) end }) or nil
  request.image = s.store and picture and s.images and s.store.path(p.file) or nil
  request.raw, request.progress = raw, s.breathe
  request.measure = s.in_process and s.measure or s.base.measure_file
  local lock = s.store and not s.in_process and sweep_folder.machine_lock(s.note)
  local answer, why = sweep_work.ask(s, request)
  if lock then
    lock:release()
  end
  if not answer then
    return nil, why
  elseif answer.description ~= p.description then
    return nil, "the script described another scene than a moment ago with the same values (pairs, time, random numbers?); rtray verify tells more"
  end
  local made = raw and (in_lua and not s.in_process or picture and p.compared) and sweep_run.read_raw(raw)
  if in_lua and not s.in_process then
    local ok, columns = pcall(sweep_run.columns_of, s.measure, made, answer, sweep_run.point_of(request))
    if not ok then
      raise_interruption(s, columns)
      return nil, tostring(columns)
    end
    answer.measured = columns
  end
  if picture and p.compared and made then
    compare(s, p, made)
  end
  if made then
    made:release()
  end
  return answer
end

-- The record of a run in the journal; in memory without a folder only, or when others are compared with its image, for a sweep of many points shall
-- not grow.
local function keep(s, p, number, answer)
  local record = { key = p.key, run = number, machine = s.machine.fingerprint }
  for _, key in ipairs(sweep_run.keys) do
    record[key] = answer[key]
  end
  record.process_seconds = answer.process_seconds
  add_measured(record, answer.measured)
  if not s.store or p.is_reference then
    s.runs[p.key] = s.runs[p.key] or {}
    s.runs[p.key][number] = record
  end
  if s.store then
    local o = json.object():set("t", "run"):set("key", p.key):set("run", number):set("machine", record.machine)
    for _, key in ipairs(sweep_run.keys) do
      o:set(key, record[key])
    end
    o:set("process_seconds", record.process_seconds)
    for _, pair in ipairs(answer.measured or {}) do
      o:set(pair[1], pair[2])
    end
    s.store:add(o)
  end
end

local function keep_picture(s, p, answer)
  if s.store and s.images then
    local _, bytes = core.file_stat(s.store.path(p.file))
    local o = json.object():set("t", "image"):set("key", p.key):set("file", p.file):set("bytes", bytes):set("hash", answer.hash)
    s.store:add(o)
    p.saved = true
  end
end

-- ---- the rounds ----

local function missing_runs(s, p)
  local have, count = s.runs[p.key] or {}, 0
  for i = 1, s.count do
    count = count + (have[i] and 0 or 1)
  end
  return count
end

-- What is left to do, in its order: { point, run = number (nil: a warm-up or a picture), picture }.
local function tasks(s)
  local order, list = {}, {}
  for _, wanted in ipairs { true, false } do -- what others are compared with comes first
    for _, p in ipairs(s.points) do
      if (p.is_reference or false) == wanted and not p.failed then
        order[#order + 1] = p
      end
    end
  end
  for round = 1 - s.warmup, s.count do
    for _, p in ipairs(order) do
      local have = s.runs[p.key] or {}
      if round <= 0 and missing_runs(s, p) > 0 then
        list[#list + 1] = { point = p, round = round }
      elseif round >= 1 and not have[round] then
        list[#list + 1] = { point = p, round = round, run = round, picture = not p.pictured and lacks_picture(s, p) }
        p.pictured = p.pictured or list[#list].picture
      elseif round == 1 and lacks_picture(s, p) then
        list[#list + 1] = { point = p, round = round, picture = true }
        p.pictured = true
      end
    end
  end
  return list
end

-- What was found of a point; all: the records; number: of machines by fingerprint, from 0.
local function point_of(s, p, index, all, number)
  local q = {
    index = index, key = p.key, values = p.values, label = p.label, message = p.failed, description = p.description, runs = {}, mixed = false,
    reference = p.compared and p.compared.key, picture = p.picture,
  }
  for i = 1, s.count do
    local record = all.runs[p.key] and all.runs[p.key][i]
    if record then
      local r = {}
      for key, value in next, record do
        r[key] = value
      end
      r.machine = number[record.machine] or 0
      r.t, r.key, r.description = nil, nil, nil
      q.hash, q.width, q.height = q.hash or r.hash, r.width, r.height
      q.mixed = q.mixed or q.machine ~= nil and q.machine ~= r.machine
      q.machine = math.max(q.machine or 0, r.machine)
      q.runs[#q.runs + 1] = r
    end
  end
  q.message = q.message or #q.runs < s.count and s.looks_again and all.failures[p.key] or nil
  q.status = q.message and "failed" or #q.runs == s.count and "done" or "missing"
  if s.store then
    local picture, metrics = all.images[p.key], all.metrics[p.key]
    q.image = picture and (p.saved or is_whole(s, picture)) and picture.file or nil
    q.metrics = {}
    if metrics and metrics.reference == q.reference then
      for _, name in ipairs(METRICS) do
        q.metrics[name] = metrics[name]
      end
      q.map = type(metrics.map) == "string" and core.file_stat(s.store.path(metrics.map)) and metrics.map or nil
    end
  end
  return q
end

function sweep_work.results_of(s)
  local results = {
    title = s.title, command = s.command, scene = s.scene_name, mode = s.base.mode, preset = s.preset and s.preset.name, zip = s.zip,
    runs = s.count, warmup = s.warmup, axes = s.axes, points = {}, machine = s.machine, machines = s.machines, reference = s.reference,
    weak = s.preset and s.preset.weak, folder = s.output,
  }
  local all, number = s.store and s.store:all_records() or { runs = s.runs }, {}
  for i, m in ipairs(s.machines) do
    number[m.fingerprint] = i - 1
  end
  for index, p in ipairs(s.points) do
    results.points[index] = point_of(s, p, index, all, number)
  end
  sweep_tables.judge(results, function(p) return p.picture end)
  return results
end

function sweep_work.write_tables(s, results)
  if s.store then
    s.store:replace("results.json", sweep_tables.json(results))
    s.store:replace("results.csv", sweep_tables.points_csv(results))
    s.store:replace("runs.csv", sweep_tables.runs_csv(results))
    s.store:replace("machine.json", json.encode(sweep_folder.machine_json(s.machine)) .. "\n")
  end
end

local function tell(s, event)
  if s.progress then
    s.progress(event)
  end
end

-- Measures what is missing, in rounds.
function sweep_work.work(s)
  local list = tasks(s)
  for i, task in ipairs(list) do
    local p = task.point
    if s.interrupted and s.interrupted() then
      error("interrupted!", 0)
    end
    if not p.failed then
      tell(s, { kind = "run", done = i - 1, total = #list, round = task.round, rounds = s.count, label = p.label })
      local answer, why = measure(s, p, task.picture)
      local ok, raised = true, nil
      if answer and task.run then
        ok, raised = pcall(keep, s, p, task.run, answer)
        if not ok and type(raised) == "table" then
          error(raised, 0)
        elseif not ok then
          raise_interruption(s, raised)
        end
      end
      if not answer or not ok then
        p.failed = why or raised
        if s.store then
          s.store:add(json.object():set("t", "failed"):set("key", p.key):set("message", words.quote(p.failed, 4096)))
        end
        tell(s, { kind = "failed", label = p.label, message = p.failed })
      elseif task.picture then
        keep_picture(s, p, answer)
      end
    end
    list[i] = false
    if s.in_process and i % COLLECT_EVERY == 0 then
      collectgarbage()
    end
  end
  tell(s, { kind = "end", done = #list, total = #list })
end

return sweep_work
