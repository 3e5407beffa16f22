-- Images: linear float pixels. Most methods are C (image.c); here are the ones that take tables.

local core = require "rt.core"
local check = require "rt.check"
local outputs = require "rt.outputs"
local run = require "rt.run"

local image = {}
local methods = core.image_methods

function image.is(value)
  local meta = getmetatable(value)
  return type(value) == "userdata" and type(meta) == "table" and meta.__name == "rt.image"
end

function image.field(value, who, key)
  if not image.is(value) then
    check.fail("%s: %s must be an image, as rt.image gives it; got %s", who, key, check.describe(value))
  end
  return value
end

-- text = false leaves all text out; { key = "value" } adds entries.
local function text_field(value, who, key)
  if type(value) == "boolean" then
    return value
  elseif type(value) ~= "table" then
    check.fail("%s: %s must be true, false or a table { Title = \"...\" }; got %s", who, key, check.describe(value))
  end
  local list = {}
  for _, name in ipairs(check.sorted_keys(value)) do
    if type(name) ~= "string" then
      check.fail("%s: %s has the key %s; its keys must be strings, as in { Title = \"...\" }", who, key, check.describe(name))
    elseif type(value[name]) ~= "string" or value[name]:find("\0", 1, true) then
      local got = type(value[name]) == "string" and "one with a NUL byte inside" or check.describe(value[name])
      check.fail("%s: %s.%s must be a string; got %s", who, key, name, got)
    end
    list[#list + 1] = name
    list[#list + 1] = value[name]
  end
  return list
end

-- The checked options of saving, as C reads them; who: for messages.
function image.save_options(options, who)
  local checked = check.fields(options or {}, image.save_fields, who)
  if type(checked.text) == "table" then
    checked.texts, checked.text = checked.text, nil
  end
  return checked
end

image.save_fields = {
  format = check.choice { "png", "jpg", "bmp", "tga", "hdr" }, exposure = check.number { low = -32, high = 32 },
  tone = check.choice { "none", "filmic" }, bits = check.integer { low = 8, high = 16 }, quality = check.integer { low = 1, high = 100 },
  alpha = check.boolean, text = text_field,
}

-- image:save(path, { format, exposure, tone, bits, quality, alpha, text }): the path is relative to where the program runs. Returns the image.
function methods.save(self, path, options)
  local checked = image.save_options(options, "image:save")
  outputs.check(check.string(path, "image:save", "the path"), "image:save")
  core.image_save(self, path, checked)
  return self
end

local MAPS = { difference = true, ssim = true, flip = true }

local compare_fields = {
  map = function(value, who, key)
    if value == true then
      return "difference"
    elseif value ~= false and not MAPS[value] then
      check.fail("%s: %s must be true, false, \"difference\", \"ssim\" or \"flip\"; got %s", who, key, check.describe(value))
    end
    return value or nil
  end,
  flip = check.boolean, ppd = check.number { low = 1, high = 1000 },
}

-- image:compare(other, { map, flip, ppd }): { differing, first, max, mse, psnr, ssim, flip, map }. map: true or "difference" (of each channel),
-- "ssim" (1 less the local similarity), "flip"; flip: whether it is computed without a map of it; ppd: its pixels per degree, 67.02.
function methods.compare(self, other, options)
  image.field(other, "image:compare", "the argument")
  local checked = check.fields(options or {}, compare_fields, "image:compare")
  return core.image_compare(self, other, checked.map, checked.flip, checked.ppd)
end

local color_map = check.choice { "grey", "viridis", "magma" }
local color_map_fields = { low = check.number(), high = check.number() }

-- image:color_map(name, { low = 0, high = 1 }): another image, its values (the largest of r, g, b) as colours.
function methods.color_map(self, name, options)
  local o = check.fields(options or {}, color_map_fields, "image:color_map")
  return core.image_color_map(self, color_map(name, "image:color_map", "the name"), o.low or 0, o.high or 1)
end

-- rt.color_map(name, x): the linear colour of a value in 0 ... 1, { r, g, b }.
function image.color_map(name, x)
  return { core.color_map_at(color_map(name, "rt.color_map", "the name"), check.number()(x, "rt.color_map", "x")) }
end

local size = check.integer { low = 1, high = 1048576 }
local make_fields = { width = size, height = size, pixel = check.callable }

-- { width, height, pixel = function(x, y) return r, g, b end }
local function make(t)
  local o = check.fields(t, make_fields, "rt.image")
  check.required(o, { "width", "height" }, "rt.image")
  local made = core.image_new(o.width, o.height)
  if o.pixel then
    local pixel, set_pixel = o.pixel, methods.set_pixel
    for y = 0, o.height - 1 do
      for x = 0, o.width - 1 do
        local r, g, b, coverage = pixel(x, y)
        if not (math.type(r) and math.type(g) and math.type(b) and (coverage == nil or math.type(coverage))) then
          local got = ("%s, %s, %s"):format(check.describe(r), check.describe(g), check.describe(b))
          check.fail("rt.image: pixel(%d, %d) must return three numbers; got %s", x, y, got)
        end
        set_pixel(made, x, y, r, g, b, coverage)
      end
    end
  end
  return made
end

-- rt.image(path) reads a file; rt.image { width = 2, height = 2 } is black.
function image.new(what)
  if type(what) == "table" then
    return make(check.plain_table(what, "rt.image", [[rt.image { width = 64, height = 64 }]]))
  end
  return core.image_load(run.resolve(check.string(what, "rt.image", "the path")))
end

-- The image in a file, or nil and why it cannot be read. What is not the file's fault is raised: Ctrl-C, a limit, memory that lacks.
function image.try(path)
  local ok, loaded = pcall(core.image_load, path)
  if ok then
    return loaded
  end
  local failure = check.refusal(loaded)
  if not failure or failure.status:find "^RT_ERROR_MEMORY" then
    error(loaded, 0)
  end
  return nil, failure.text
end

-- rt.image_text(path): the text entries of an image file, { [key] = value }, without reading its pixels.
function image.text(path)
  return core.image_text(run.resolve(check.string(path, "rt.image_text", "the path")))
end

function image.compare(a, b, options)
  return methods.compare(image.field(a, "rt.compare", "the first argument"), b, options)
end

return image
