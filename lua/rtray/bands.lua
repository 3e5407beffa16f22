-- rtray render --bands: straight into the file, for images larger than the memory.

local sys = require "rtray.sys"
local json = require "rtray.json"
local limits = require "rtray.limits"
local output = require "rtray.output"
local progress = require "rtray.progress"
local recipe = require "rtray.recipe"
local report = require "rtray.report"
local types = require "rtray.types"

local bands = {}

local BAND = 2 ^ 28 | 0 -- bytes

-- The pixels of a band, so that with film and scratch it stays below the limit; 0 is the library's own choice.
local function band_memory(limit)
  return limit > 0 and math.min(limit // 6, BAND) or 0
end

function bands.render(opened, target, values)
  local scene = opened.scene
  local settings = scene:effective()
  local shown = progress.new(values, target.path)
  local begun = sys.now()
  sys.defer(true)
  local at = 0
  local save = { text = report.texts(opened, settings, values, target.save) }
  for key, value in pairs(target.save) do -- a copy: the order is of no matter
    save[key] = value
  end
  local whole = scene:render_to_file(target.path, {
    save = save, checkpoint = values.checkpoint, checkpoint_every = values.every,
    band_memory = values.band_memory or band_memory(settings.memory_limit or 0),
    progress = function(done)
      at = done
      shown:update(done)
      return sys.interrupted() ~= nil
    end,
  })
  output.clear_line()
  if not whole then
    local what, percent = limits.told() or "interrupted", math.floor(at * 100)
    if values.checkpoint then
      output.note("rtray render: %s at %d%%; %s keeps what is done, %s is as it was. The same command goes on from it.", what, percent,
        types.quote(values.checkpoint), types.quote(target.path))
      return 1
    end
    output.note("rtray render: %s at %d%%; an image in bands is written whole or not at all: %s is as it was", what, percent, target.path)
    return 1
  end
  recipe.beside(target.path, target.save.format, save.text)
  sys.defer(false)
  local seconds = sys.now() - begun
  if values.json then
    output.print("%s", json.encode(json.object():set("output", target.path):set("width", settings.width):set("height", settings.height)
      :set("seconds", seconds)))
  elseif not values.quiet then
    output.note("%s: %dx%d in bands, %s", target.path, settings.width, settings.height, output.seconds(seconds))
  end
  return 0
end

-- Does a render at once take more than the limit the user set, or than half of the free memory (others live on the machine too)?
function bands.needed(scene)
  local limit = scene:effective().memory_limit or 0
  local free = require("rt").machine().memory_available // 2
  return scene:memory() > (limit > 0 and math.min(limit, free) or free)
end

return bands
