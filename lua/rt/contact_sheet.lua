-- rt.contact_sheet: many images small on one, each with its label.

local check = require "rt.check"
local draw = require "rt.draw"
local image = require "rt.image"
local vec = require "rt.vec"

local MAX_PIXELS = 1 << 26 -- of a sheet: a gigabyte

local edge = check.integer { low = 8, high = 4096 }

local function list_of(item)
  return function(value, who, key)
    if type(value) ~= "table" then
      check.fail("%s: %s must be a list; got %s", who, key, check.describe(value))
    end
    local copy, last = {}, 0
    for _, index in ipairs(check.sorted_keys(value)) do
      if not (math.type(index) == "integer" and index >= 1) then
        check.fail("%s: %s must be a list; it has the key %s", who, key, check.describe(index))
      end
      copy[index], last = item(value[index], who, ("%s[%d]"):format(key, index)), index
    end
    return { n = last, items = copy }
  end
end

-- An image, a file's name, or false where there is none.
local function picture(value, who, key)
  if value == false or image.is(value) then
    return value
  elseif type(value) == "string" then
    return check.string(value, who, key)
  end
  return check.fail("%s: %s must be an image, the name of a file or false; got %s", who, key, check.describe(value))
end

local function lines(value, who, key)
  if type(value) == "string" then
    return { value }
  elseif type(value) ~= "table" then
    check.fail("%s: %s must be a string or a list of strings, one a line; got %s", who, key, check.describe(value))
  end
  for i = 1, #value do
    if type(value[i]) ~= "string" then
      check.fail("%s: %s[%d] must be a string; got %s", who, key, i, check.describe(value[i]))
    end
  end
  return table.move(value, 1, #value, 1, {})
end

local fields = {
  images = list_of(picture), labels = list_of(lines), columns = check.integer { low = 1, high = 1000 }, width = edge, height = edge,
  gap = check.integer { low = 0, high = 1000 }, background = check.color(), color = check.color(), text_size = check.number { low = 4, high = 200 },
  title = check.string, filter = check.choice { "auto", "box", "mitchell", "lanczos" },
}

local contact_sheet = {}

-- The size that fits into width x height in the picture's shape, and whether that is no smaller; pictures are enlarged by whole factors alone.
function contact_sheet.fit(w, h, width, height)
  local scale = math.min(width / w, height / h)
  if scale > 1 then
    scale = math.max(1, math.floor(scale))
  end
  return math.max(1, math.min(width, math.floor(w * scale + 0.5))), math.max(1, math.min(height, math.floor(h * scale + 0.5))), scale >= 1
end

-- A cell's picture; one from a file is held no longer than it takes.
local function place(sheet, item, o, x, y)
  local file = type(item) == "string" and image.new(item)
  local whole = file or item
  local w, h = whole:size()
  local fw, fh, enlarged = contact_sheet.fit(w, h, o.width, o.height)
  local small <close> = (fw ~= w or fh ~= h) and whole:resize(fw, fh, { filter = enlarged and "box" or o.filter }) or nil
  sheet:place(small or whole, x + (o.width - fw) // 2, y + (o.height - fh) // 2)
  if file then
    file:release()
  end
end

local function mix(a, b, t)
  return { a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t, a[3] + (b[3] - a[3]) * t }
end

local function draw_cell(sheet, o, index, x, y)
  local item = o.images.items[index]
  sheet:fill { x = x, y = y, width = o.width, height = o.height, color = mix(o.background, o.color, 0.05) }
  if item then
    place(sheet, item, o, x, y)
  else
    local text = "no image"
    local w, h = draw.label_size(text, { size = o.text_size })
    sheet:label(text, { x = x + (o.width - w) // 2, y = y + (o.height - h) // 2, size = o.text_size, color = mix(o.background, o.color, 0.65) })
  end
  for i, line in ipairs(o.labels and o.labels.items[index] or {}) do
    local style = { size = o.text_size, color = o.color, x = x, y = y + o.height + 3 + (i - 1) * math.ceil(o.text_size * 1.15) }
    sheet:label(draw.shorten(line, o.width, { size = o.text_size }), style)
  end
end

-- The widest picture's shape decides a cell's height when only the width is given.
local function cell_height(o)
  for i = 1, o.images.n do
    if image.is(o.images.items[i]) then
      local w, h = o.images.items[i]:size()
      return math.max(8, math.min(4096, math.floor(o.width * h / w + 0.5)))
    end
  end
  return math.max(8, o.width * 3 // 4)
end

local function defaults(o)
  o.width, o.gap, o.text_size = o.width or 240, o.gap or 16, o.text_size or 15
  o.height = o.height or cell_height(o)
  o.background = o.background or vec.srgb "#ffffff"
  o.color = o.color or vec.srgb "#1b1f24"
  o.background, o.color = { o.background[1], o.background[2], o.background[3] }, { o.color[1], o.color[2], o.color[3] }
  o.columns = math.min(o.columns or math.max(1, math.ceil(math.sqrt(o.images.n * o.height / o.width * 1.6))), math.max(1, o.images.n))
  local most = 0
  for i = 1, o.labels and o.images.n or 0 do
    most = math.max(most, o.labels.items[i] and #o.labels.items[i] or 0)
  end
  o.label_height = most > 0 and 3 + most * math.ceil(o.text_size * 1.15) + math.ceil(o.text_size * 0.3) or 0
  return o
end

-- { images = { image | "file.png" | false, ... }, labels = { "text" | { "line", ... } }, columns, width, height (of a cell), gap, background, color,
-- text_size, title, filter }
function contact_sheet.make(t)
  local who = "rt.contact_sheet"
  local o = check.fields(check.plain_table(t, who, "rt.contact_sheet { images = { a, b } }"), fields, who)
  check.required(o, { "images" }, who)
  if o.images.n == 0 then
    check.fail("%s: images is empty; a sheet needs one at least", who)
  end
  defaults(o)
  local rows = (o.images.n + o.columns - 1) // o.columns
  local top = o.title and math.ceil(o.text_size * 1.4) + o.gap or 0
  local step_x, step_y = o.width + o.gap, o.height + o.label_height + o.gap
  local width, height = o.columns * step_x + o.gap, rows * step_y + o.gap + top
  if width * height > MAX_PIXELS then
    check.fail("%s: a sheet of %d images in %d columns is %d x %d pixels, more than %d million; take smaller cells or several sheets", who,
      o.images.n, o.columns, width, height, MAX_PIXELS // 1000000)
  end
  local sheet = image.new { width = width, height = height }
  sheet:fill { color = o.background }
  if o.title then
    local size = o.text_size * 1.3
    sheet:label(draw.shorten(o.title, width - 2 * o.gap, { size = size }), { x = o.gap, y = o.gap, size = size, weight = 1.2, color = o.color })
  end
  for i = 1, o.images.n do
    draw_cell(sheet, o, i, o.gap + (i - 1) % o.columns * step_x, o.gap + top + (i - 1) // o.columns * step_y)
  end
  return sheet
end

return contact_sheet
