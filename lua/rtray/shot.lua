-- One frame of an animation: described, keyed, rendered, put in its place.

local sys = require "rtray.sys"
local check = require "rt.check"
local guard = require "rt.guard"
local json = require "rtray.json"
local output = require "rtray.output"
local recipe = require "rtray.recipe"
local report = require "rtray.report"
local source = require "rtray.source"

local LONG = 30 -- seconds: after such a frame, the next is worth to be kept until it is saved, which may fail

local shot = {}

-- stage: { path, values, command, target, save }, what all frames of a run share.

-- The options of saving that change a file's bytes, in the order of their names.
local function save_text(save)
  local object, names = json.object(), {}
  for name in pairs(save) do
    names[#names + 1] = name
  end
  table.sort(names)
  for _, name in ipairs(names) do
    object:set(name, save[name])
  end
  return json.encode(object)
end

-- Runs the script again and describes a frame: { frame, scene, opened, key, description, settings }. The key holds all that decides the file's
-- pixels and nothing else: what was described (with the bytes of meshes and textures), settings, saving, the library's version.
function shot.describe(stage, frame)
  local before = require("rt").counts()
  local animation, run = source.animation(stage.path, stage.values, stage.command)
  if frame >= animation.frames then
    error(("the script has changed: its animation now has %d frames, and frame %d is none of them"):format(animation.frames, frame), 0)
  end
  local scene = animation:scene_at(frame)
  local settings = json.encode(report.picture_settings((scene:effective())))
  local description, looks = scene:hash(), scene:looks()
  local function key(what)
    return sys.sha256(table.concat({ "librt " .. require("rt").version, settings, save_text(stage.save), what,
      stage.values.no_metadata and "no metadata" or nil }, "\n"))
  end
  return {
    before = before, frame = frame, scene = scene, opened = { scene = scene, run = run, frame = frame }, description = description,
    settings = settings, looks = looks, key = key(description), rest = key(looks.rest),
  }
end

-- The looks of a description's materials as a record holds them. touched: which of them the rays of its picture looked at.
local function materials_of(looks, touched)
  local list = {}
  for i, hash in ipairs(looks) do
    list[i] = { hash = hash, touched = touched(i) }
  end
  return list
end

-- May the picture that a record is about stand for this description? "key": it is the same; "looks": it differs in the looks of materials that no
-- ray of the picture met.
function shot.matches(described, record)
  if record.key == described.key then
    return "key"
  end
  local materials = record.materials or {}
  if record.rest ~= described.rest or #materials ~= #described.looks then
    return nil
  end
  for i, m in ipairs(materials) do
    if m.touched and m.hash ~= described.looks[i] then
      return nil
    end
  end
  return "looks"
end

-- Makes a record that matches by looks one of this description: its rays are the same, so they have met the same materials.
function shot.renew(record, described)
  local before = record.materials
  record.key, record.description = described.key, described.description
  record.materials = materials_of(described.looks, function(i)
    return before[i].touched
  end)
end

-- Starts the render with so many workers, beside others (nil: alone, with the settings'). It goes on from the checkpoint of an earlier one, and keeps
-- its own there.
function shot.start(stage, ledger, described, workers)
  local path = ledger:checkpoint(described.frame, described.key)
  local arguments = {
    workers = workers, background = workers ~= nil, checkpoint = path, checkpoint_every = stage.values.every,
    checkpoint_keep = (stage.seconds or 0) >= LONG, -- until it is saved
  }
  guard.own(path)
  local ok, job = pcall(described.scene.start, described.scene, arguments)
  local failure = not ok and check.refusal(job)
  if failure and not failure.status:find "^RT_ERROR_MEMORY" and sys.stat(path) then -- damaged, or of another build: begin anew
    output.note("rtray animate: frame %d begins anew: %s", described.frame, failure.text)
    os.remove(path)
    ok, job = true, described.scene:start(arguments)
  end
  if not ok then
    error(job, 0)
  end
  described.job, described.checkpoint = job, path
  described.work = {} -- what it took to come here
  for key, count in pairs(require("rt").counts()) do -- in any order
    described.work[key] = count - described.before[key]
  end
  return described
end

-- Saves the image of a finished job and records it.
function shot.finish(stage, ledger, described)
  local job = described.job
  local image, stats = job:image(), job:stats()
  local save = { text = report.texts(described.opened, job.settings, stage.values, stage.save), format = stage.target.format }
  save.text.Hash = not stage.values.no_metadata and image:hash() or nil
  for key, value in pairs(stage.save) do -- a copy: the order is of no matter
    save[key] = value
  end
  local part = ledger:part(described.frame)
  guard.own(part)
  local ok, raised = pcall(image.save, image, part, save)
  if not ok then -- the user knows the file by its own name
    local at, to = tostring(raised):find(part, 1, true)
    error(at and raised:sub(1, at - 1) .. stage.target.place(described.frame) .. raised:sub(to + 1) or raised, 0)
  end
  local width, height = image:size()
  stage.seconds = stats.seconds
  described.width, described.height, described.image, described.stats = width, height, image:hash(), stats
  ledger:put(described.frame, {
    key = described.key, rest = described.rest, description = described.description, image = described.image, settings = described.settings,
    seconds = ("%.3f"):format(stats.seconds),
    materials = materials_of(described.looks, function(i)
      return stats.touched[i] ~= false
    end),
  }, part, stage.target.place(described.frame))
  recipe.beside(stage.target.place(described.frame), save.format, save.text)
  image:release()
  job:release()
  os.remove(described.checkpoint)
  described.job = nil
  return stats
end

return shot
