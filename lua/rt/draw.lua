-- Drawing into images: image:resize, fill, place, label, and what a label takes. Pixels count from 0, colours are linear.

local core = require "rt.core"
local check = require "rt.check"
local image = require "rt.image"

local draw = {}
local methods = core.image_methods

local edge = check.integer { low = 1, high = 1048576 }
local pixel = check.integer { low = -2000000, high = 2000000 }

local resize_fields = { filter = check.choice { "auto", "box", "mitchell", "lanczos" } }

-- image:resize(width, height, { filter }): another image, resampled in linear light. Without a height (or width) the shape is kept.
function methods.resize(self, width, height, options)
  local who = "image:resize"
  local old_width, old_height = self:size()
  if width == nil and height == nil then
    check.fail("%s: a width or a height is missing", who)
  end
  local w = width and edge(width, who, "the width")
  local h = height and edge(height, who, "the height")
  w = w or math.max(1, math.floor(old_width * h / old_height + 0.5))
  h = h or math.max(1, math.floor(old_height * w / old_width + 0.5))
  local o = check.fields(options or {}, resize_fields, who)
  return core.image_resample(self, w, h, o.filter or "auto")
end

local fill_fields = { x = pixel, y = pixel, width = edge, height = edge, color = check.color(), coverage = check.number { low = 0, high = 1 } }

-- image:fill { x, y, width, height, color, coverage }: a rectangle, all of the image when no side is given. Returns the image.
function methods.fill(self, options)
  local o = check.fields(check.plain_table(options, "image:fill", "image:fill { color = {1, 1, 1} }"), fill_fields, "image:fill")
  check.required(o, { "color" }, "image:fill")
  local width, height = self:size()
  core.image_fill(self, o.x or 0, o.y or 0, o.width or width, o.height or height, o.color, o.coverage or 1)
  return self
end

-- image:place(other, x, y): copies an image into this one; what lies outside is left out. Returns the image.
function methods.place(self, other, x, y)
  local who = "image:place"
  image.field(other, who, "the first argument")
  core.image_place(self, other, pixel(x or 0, who, "x"), pixel(y or 0, who, "y"))
  return self
end

local coordinate = check.number { low = -1e6, high = 1e6 }
local label_fields = {
  x = coordinate, y = coordinate, size = check.number { low = 4, high = 1000 }, weight = check.number { low = 0.25, high = 4 },
  color = check.color(), opacity = check.number { low = 0, high = 1 },
}

local function words(text, who)
  if type(text) ~= "string" then
    check.fail("%s: the text must be a string; got %s", who, check.describe(text))
  end
  return (text:gsub("\0", "\1")) -- shown as a box, as other characters that the font lacks
end

-- image:label(text, { x, y, size, weight, color, opacity }): text in the built-in font, its top left corner at (x, y). Returns the image.
function methods.label(self, text, options)
  core.image_label(self, words(text, "image:label"), check.fields(options or {}, label_fields, "image:label"))
  return self
end

-- rt.label_size(text, { size, weight }): the width and height in pixels that the label takes.
function draw.label_size(text, options)
  local o = check.fields(options or {}, label_fields, "rt.label_size")
  return core.label_size(words(text, "rt.label_size"), o)
end

-- The text cut with an ellipsis so that it takes at most `width` pixels.
function draw.shorten(text, width, options)
  if draw.label_size(text, options) <= width then
    return text
  end
  local low, high = 0, #text
  while low < high do -- the longest start that fits
    local middle = (low + high + 1) // 2
    if draw.label_size(text:sub(1, middle) .. "\u{2026}", options) <= width then
      low = middle
    else
      high = middle - 1
    end
  end
  while low > 0 and (text:byte(low + 1) or 0) & 0xc0 == 0x80 do -- not in the middle of a character
    low = low - 1
  end
  return text:sub(1, low):gsub("%s+$", "") .. "\u{2026}"
end

return draw
