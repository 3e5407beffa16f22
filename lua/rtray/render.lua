-- rtray render SCENE

local sys = require "rtray.sys"
local check = require "rt.check"
local guard = require "rt.guard"
local bands = require "rtray.bands"
local cli = require "rtray.cli"
local files = require "rtray.files"
local hints = require "rtray.hints"
local json = require "rtray.json"
local limits = require "rtray.limits"
local output = require "rtray.output"
local options = require "rtray.options"
local progress = require "rtray.progress"
local recipe = require "rtray.recipe"
local report = require "rtray.report"
local source = require "rtray.source"
local types = require "rtray.types"
local watch = require "rtray.watch"

local render = {}

local PREVIEW_EVERY = 2 -- seconds
local FORMATS = { png = "png", jpg = "jpg", jpeg = "jpg", bmp = "bmp", tga = "tga", hdr = "hdr" }

-- Can all of them be written? Asked again when the scene is open, and known what it reads.
local function check_outputs(path, values)
  files.check_output(path)
  for _, key in ipairs { "checkpoint", "preview" } do
    if values[key] then
      files.check_output(values[key])
    end
  end
end

-- Where the image goes and how it is written: { path, save, format, rows, clear }; rows: the format can be written band by band;
-- clear: pixels that are not finished are transparent in it.
local function target_of(command, values, path)
  local out = values.output or files.stem_of(path) .. ".png"
  local save = {}
  for _, option in ipairs(options.list) do
    if option.save then
      save[option.key] = values[option.key]
    end
  end
  save.bits = save.bits and math.tointeger(tonumber(save.bits))
  if out == "-" then
    save.format = save.format or "png"
  elseif not save.format and not FORMATS[files.ending_of(out)] then
    cli.fault(command, "the ending of %s names no image format; known are .png, .jpg, .bmp, .tga, .hdr (or --format says it)", types.quote(out))
  end
  if out == "-" and (values.json or values.watch) then
    cli.fault(command, "-o - and %s both want standard output", values.json and "--json" or "--watch")
  end
  if values.every and not values.checkpoint then
    cli.fault(command, "--every says how often the file of --checkpoint is written; name one")
  elseif values.checkpoint == "-" then
    cli.fault(command, "--checkpoint needs the name of a file; standard output is none")
  elseif values.checkpoint and values.watch then
    cli.fault(command, "--checkpoint keeps one picture, --watch renders many")
  elseif values.preview and not FORMATS[files.ending_of(values.preview)] then
    cli.fault(command, "the ending of %s names no image format; known are .png, .jpg, .bmp, .tga, .hdr", types.quote(values.preview))
  end
  check_outputs(out, values)
  local format = save.format or FORMATS[files.ending_of(out)]
  return { path = out, save = save, format = format, rows = format ~= "jpg", clear = save.alpha and (format == "png" or format == "tga") }
end

local function rays_of(job)
  return function()
    return job:stats().rays
  end
end

-- Waits for the job with progress, previews, an eye on signals and (stale) on changed files. Returns its state and progress.
local function attend(job, values, shown, stale)
  local next_preview = sys.now() + PREVIEW_EVERY
  local asked
  while true do
    local state, done = job:wait(0.1)
    if state ~= "running" then
      output.clear_line()
      return state, done
    end
    shown:update(done, rays_of(job))
    if not asked and (sys.interrupted() or stale and stale()) then
      asked = true
      limits.grace(30)
      job:cancel()
    end
    if values.preview and sys.now() >= next_preview then
      guard.own(values.preview)
      job:image():save(values.preview)
      next_preview = sys.now() + PREVIEW_EVERY
    end
  end
end

local function interrupted(target, done, saved, checkpoint)
  local percent, what = math.floor(done * 100), limits.told() or "interrupted"
  if checkpoint then
    output.note("rtray render: %s at %d%%; %s keeps what is done%s. The same command goes on from it.", what, percent, types.quote(checkpoint),
      saved and (" and %s shows it"):format(types.quote(target.path)) or "")
  elseif not saved then
    output.note("rtray render: %s at %d%%; nothing was finished, so nothing was written", what, percent)
  else
    output.note("rtray render: %s at %d%%; what is finished is in %s, the rest is %s. The same command renders it whole.",
      what, percent, types.quote(target.path), target.clear and "transparent" or "black")
  end
  return 1 -- the signal ends the process, see main.c
end

local function finish(opened, job, target, values)
  local image, stats = job:image(), job:stats()
  local save = { text = report.texts(opened, job.settings, values, target.save) }
  save.text.Hash = not values.no_metadata and image:hash() or nil
  for key, value in pairs(target.save) do -- a copy: the order is of no matter
    save[key] = value
  end
  guard.own(target.path)
  image:save(target.path, save)
  recipe.beside(target.path, target.save.format, save.text)
  if values.preview then
    guard.own(values.preview)
    image:save(values.preview)
  end
  if values.checkpoint then
    os.remove(values.checkpoint)
  end
  local note = target.path == "-" and output.note or output.print
  if values.json then
    output.print("%s", json.encode(report.render_json(target.path, image, job.settings, stats)))
    return
  end
  if values.stats then
    report.print_stats(note, stats)
  end
  if not values.quiet then
    output.note("%s", report.render_line(target.path, image, job.settings, stats))
  end
end

-- The render in progress. What has no room as a whole would have some in bands, if the format took them.
local function start(scene, target, values)
  local ok, job = pcall(scene.start, scene, {
    preview = values.preview ~= nil, checkpoint = values.checkpoint, checkpoint_every = values.every, checkpoint_keep = true, -- until it is saved
  })
  local failure = not ok and check.refusal(job)
  if failure and failure.status == "RT_ERROR_MEMORY_LIMIT" and not target.rows then
    error({ status = 3, message = ("%s; a JPEG is written from the whole image: .png, .bmp, .tga and .hdr take one band after the other"):format(
      failure.text) }, 0)
  elseif not ok then
    error(job, 0)
  end
  return job
end

-- Renders once. `stale` (or nil) says that the scene's files have changed, so that this render is pointless.
local function once(opened, target, values, stale)
  local scene = opened.scene
  if values.settings then
    local settings, sources = scene:effective()
    report.print_settings(target.path == "-" and output.note or output.print, settings, sources, opened.run)
  end
  check_outputs(target.path, values)
  hints.tell(scene, (scene:effective()), target.format, values)
  guard.own(target.path)
  if values.checkpoint then
    guard.own(values.checkpoint)
    guard.own(values.checkpoint .. ".band")
  end
  if values.bands or target.rows and bands.needed(scene) then
    return bands.render(opened, target, values)
  end
  local job <close> = start(scene, target, values)
  sys.defer(true)
  local state, done = attend(job, values, progress.new(values, target.path), stale)
  if state == "cancelled" and not sys.interrupted() then
    sys.defer(false)
    return nil -- stale
  elseif state == "cancelled" then
    local some = job:stats().tiles_done > 0
    if some then
      guard.own(target.path)
      job:image():save(target.path, target.save)
    end
    return interrupted(target, done, some, values.checkpoint)
  end
  finish(opened, job, target, values)
  sys.defer(false)
  return 0
end

-- Renders for another command: the image and its settings; raises when it is interrupted.
function render.wait(opened, values, name)
  local job <close> = opened.scene:start {}
  sys.defer(true)
  local state = attend(job, values, progress.new(values, name))
  if state == "cancelled" then
    error "interrupted"
  end
  sys.defer(false)
  sys.limit_time(nil)
  return job:image(), job.settings
end

function render.run(command, values, arguments)
  local path = arguments[1]
  local target = target_of(command, values, path)
  if values.watch then
    return watch.run(path, values, command, function(opened, stale)
      return once(opened, target, values, stale)
    end)
  end
  return once(source.open(path, values, command), target, values)
end

return render
