-- rtray sweep SCENE --over AXIS ... -o DIR: the module's sweep, with a command line around it.

local sys = require "rtray.sys"
local cli = require "rtray.cli"
local files = require "rtray.files"
local output = require "rtray.output"
local source = require "rtray.source"
local sandbox = require "rtray.sandbox"
local sweep = require "rt.sweep"
local types = require "rtray.types"

local command_of = {}

-- How far it is, and how long it will take.
local function progress(values)
  local begun = sys.now()
  local shown = not values.quiet and values.progress ~= "none"
  local terminal = shown and sys.is_terminal(2) and values.progress ~= "json"
  local last = begun - 10
  return function(event)
    local now = sys.now()
    if event.kind == "failed" then
      output.note("rtray sweep: %s: %s", event.label == "" and "the scene" or event.label, event.message)
    elseif event.kind == "end" then
      output.clear_line()
    elseif not shown then
      return
    elseif values.progress == "json" then
      local json = require "rtray.json"
      local o = json.object():set("done", event.done):set("total", event.total):set("round", event.round):set("point", event.label)
      output.note("%s", json.encode(o))
    elseif terminal or now - last >= 10 then
      local left = event.done > 0 and output.duration((now - begun) / event.done * (event.total - event.done)) or "?"
      local text = ("%d of %d, %s%s, %s left"):format(event.done + 1, event.total, event.round <= 0 and "warm-up " or "",
        types.quote(event.label), left)
      last = now
      if terminal then
        output.line(text:sub(1, math.max(20, (sys.columns(2) or 80) - 1)))
      else
        output.note("rtray sweep: %s", text)
      end
    end
  end
end

local function number(x, form)
  return x and (form or "%.3g"):format(x) or ""
end

-- Medians on standard output.
local function print_table(results)
  local head, left, timed = {}, {}, results.runs > 0
  for i, a in ipairs(results.axes) do
    head[i], left[i] = a.name, a.type ~= "number" and a.type ~= "integer"
  end
  local n = #results.axes
  for i, name in ipairs { "render", "q1 ... q3", "build", "rays/s", "speedup", "efficiency", "image" } do
    head[n + i] = name
  end
  left[n + 7] = true
  local rows = { head }
  for _, p in ipairs(results.points) do
    local row = {}
    for i, a in ipairs(results.axes) do
      row[i] = types.quote(p.values[a.name]):sub(2, -2)
    end
    local m, done = p.median, p.median.seconds and timed
    row[n + 1] = done and output.seconds(m.seconds) or p.status
    row[n + 2] = done and ("%.3g ... %.3g"):format(p.q1.seconds, p.q3.seconds) or ""
    row[n + 3] = done and output.seconds(m.build_seconds) or ""
    row[n + 4] = done and output.rate(m.rays_per_second) or ""
    row[n + 5] = number(p.derived.speedup, "%.2f") .. (p.oversubscribed and "*" or "")
    row[n + 6] = number(p.derived.efficiency, "%.2f")
    row[n + 7] = (p.hash or ""):sub(1, 12)
    rows[#rows + 1] = row
  end
  output.table(rows, left)
end

local function group_words(g, axes)
  local parts = {}
  for _, a in ipairs(axes) do
    parts[#parts + 1] = g.values[a.name] and a.name .. "=" .. g.values[a.name] or nil
  end
  return #parts > 0 and table.concat(parts, ", ") .. ": " or ""
end

local function print_study(results)
  local marked = false
  for _, p in ipairs(results.points) do
    marked = marked or p.oversubscribed
  end
  if marked then
    output.print("* more workers than the %d CPUs", results.machine.cpus)
  end
  for _, g in ipairs(results.groups) do
    if g.fit then
      local form = "%sAmdahl's law by least squares over %d medians: %.3g s serial, %.3g s parallel, %.1f%% serial%s"
      output.print(form, group_words(g, results.axes), g.fit.points, g.fit.serial_seconds, g.fit.parallel_seconds, 100 * g.fit.serial_fraction,
        g.fit.r2 and (" (r2 %.3f)"):format(g.fit.r2) or "")
    end
  end
end

local function failures(results)
  local count, first = 0, nil
  for _, p in ipairs(results.points) do
    if p.status == "failed" then
      count, first = count + 1, first or p
    end
  end
  return count, first
end

-- 1: a point failed; 4: images differ that must not.
local function status_of(results)
  local failed, first = failures(results)
  for _, c in ipairs(results.conflicts) do
    output.note("rtray sweep: THE IMAGES DIFFER: %s", c.message)
  end
  if failed > 0 then
    output.note("rtray sweep: %d of %d points failed, the first is %s: %s", failed, #results.points, first.label == "" and "the scene" or first.label,
      first.message)
    return 1
  end
  return #results.conflicts > 0 and 4 or 0
end

local function parameters_of(values)
  local t = {}
  for _, define in ipairs(values.define or {}) do
    t[define.name] = define.text
  end
  return t
end

local function wanted(command, values, arguments)
  if #(values.over or {}) == 0 and not values.preset then
    cli.fault(command, "there is no axis; --over NAME=VALUES gives one, as in --over workers=1,2,4")
  end
  local over = {}
  for i, pair in ipairs(values.over or {}) do
    over[i] = { pair.name, pair.text }
  end
  return {
    scene = arguments[1], over = over, parameters = parameters_of(values), settings = source.settings(values), set = values.set, seed = values.seed,
    runs = values.runs, warmup = values.warmup, zip = values.zip, in_process = values.in_process, measure = values.measure,
    reference = values.reference, preset = values.preset, output = values.folder, images = not values.no_images, timeout = values.timeout,
    report = not values.no_report, restart = values.restart, force = values.force_mix, wait = values.wait, interrupted = sys.interrupted,
    dry = values.dry_run,
    command = table.move(values.words, 1, #values.words, 2, { "rtray" }), progress = progress(values),
    note = function(text)
      output.note("rtray sweep: %s", text)
    end,
  }
end

local function check_scene_file(path)
  local kind, why = sys.stat(path)
  if kind ~= "file" then
    error({ status = 1, message = ("%s cannot be read: %s"):format(types.quote(path), kind and "it is no regular file" or why) }, 0)
  end
end

local function guard_scene(command, values, path)
  sandbox.configure(path, values, function(...)
    cli.fault(command, ...)
  end)
end

-- Which page, or which command, shows what an interrupted sweep has found.
local function shown_by(t)
  if not sys.stat(t.output .. "/results.json") then
    return ""
  elseif t.report and sys.stat(t.output .. "/index.html") then
    return ("; %s shows it, and `rtray report %s` adds plots for papers"):format(types.quote(t.output .. "/index.html"), types.quote(t.output))
  end
  return ("; `rtray report %s` makes a page of it"):format(types.quote(t.output))
end

function command_of.run(command, values, arguments)
  local t = wanted(command, values, arguments)
  if not t.output and not t.dry then
    t.output = files.stem_of(arguments[1]) .. ".sweep"
  end
  check_scene_file(arguments[1])
  guard_scene(command, values, arguments[1])
  local ok, results = pcall(sweep.execute, t)
  if not ok then
    output.clear_line()
    if sys.interrupted() and t.output then
      error({ status = 1, message = ("interrupted; what is finished is in %s, and the same command goes on%s"):format(
        types.quote(t.output), shown_by(t)) }, 0)
    end
    error(results, 0)
  elseif t.dry then
    for _, p in ipairs(results.points) do
      output.print("%s", p.label)
    end
    return 0
  end
  if values.json then
    output.write(require("rt.sweep_tables").json(results))
  elseif not values.quiet then
    print_table(results)
    print_study(results)
    output.print("%s holds results.csv, runs.csv, results.json%s", types.quote(t.output), t.images and " and images" or "")
    if results.report then
      for _, note in ipairs(results.report.notes) do
        output.note("rtray sweep: %s", types.quote(note):sub(2, -2))
      end
      output.print("%s shows it", types.quote(results.report.page))
    end
  end
  return status_of(results)
end

-- rtray answer: requests on standard input, answers on standard output (rt.sweep_run).
function command_of.answer(command, values, arguments)
  sandbox.print_to(io.stderr)
  guard_scene(command, values, arguments[1])
  require("rt.sweep_run").serve(function(line)
    sys.write(1, line)
  end)
  return 0
end

return command_of
