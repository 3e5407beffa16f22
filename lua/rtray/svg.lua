-- Text of SVG files: escaping, numbers, colours, base64, and a page that collects parts.

local svg = {}

-- Foreign text: characters that XML forbids or that mean something to it are replaced.
function svg.escape(text)
  text = utf8.len(text) and text or text:gsub("[\128-\255]", function(c)
    return utf8.char(c:byte())
  end)
  text = text:gsub("[%z\1-\8\11\12\14-\31\127]", "\u{FFFD}"):gsub("\u{FFFE}", "\u{FFFD}"):gsub("\u{FFFF}", "\u{FFFD}")
  return (text:gsub('[&<>"\']', { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;", ["'"] = "&#39;" }))
end

-- Two digits behind the point at most, with a point in every locale.
function svg.number(x)
  local s = ("%.2f"):format(x):gsub("[^%d%-]", ".")
  s = s:gsub("0+$", ""):gsub("%.$", "")
  return s == "-0" and "0" or s
end
local number = svg.number

local ALPHABET = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"

function svg.base64(bytes)
  local out, letter = {}, {}
  for i = 0, 63 do
    letter[i] = ALPHABET:sub(i + 1, i + 1)
  end
  for i = 1, #bytes, 3 do
    local a, b, c = bytes:byte(i, i + 2)
    local n = a << 16 | (b or 0) << 8 | (c or 0)
    out[#out + 1] = letter[n >> 18] .. letter[n >> 12 & 63] .. (b and letter[n >> 6 & 63] or "=") .. (c and letter[n & 63] or "=")
  end
  return table.concat(out)
end

-- A ramp that is as light at its beginning as paper and darkens evenly, so that it reads in grey too; x in 0 ... 1.
local RAMP = {
  { 252, 249, 226 }, { 214, 232, 170 }, { 142, 204, 154 }, { 76, 165, 160 }, { 50, 120, 158 }, { 58, 74, 140 }, { 62, 34, 106 }, { 36, 10, 54 },
}

function svg.ramp(x)
  x = math.max(0, math.min(1, x)) * (#RAMP - 1)
  local i = math.min(math.floor(x), #RAMP - 2)
  local a, b, w = RAMP[i + 1], RAMP[i + 2], x - i
  return a[1] + w * (b[1] - a[1]), a[2] + w * (b[2] - a[2]), a[3] + w * (b[3] - a[3])
end

function svg.color(x)
  local r, g, b = svg.ramp(x)
  return ("#%02x%02x%02x"):format(math.floor(r + 0.5), math.floor(g + 0.5), math.floor(b + 0.5))
end

-- Round numbers in low ... high, eight or `about` at most, but for the ends.
function svg.ticks(low, high, about)
  local span, list = high - low, {}
  if span <= 0 then
    return { low }
  end
  local step = 10 ^ math.floor(math.log(span / (about or 8), 10))
  for _, factor in ipairs { 1, 2, 5, 10 } do
    if span / (step * factor) <= (about or 8) then
      step = step * factor
      break
    end
  end
  for i = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) do
    list[#list + 1] = i * step
  end
  return list
end

-- A tick's text: as short as its number allows.
function svg.tick_text(x)
  return (("%.6g"):format(math.abs(x) < 1e-12 and 0 or x):gsub("[^%d%-+e]", "."))
end

local page = {}
page.__index = page

function svg.page(width, height, title)
  local p = setmetatable({ parts = {} }, page)
  p.parts[1] = ('<svg xmlns="http://www.w3.org/2000/svg" width="%s" height="%s" viewBox="0 0 %s %s" font-family="Helvetica, Arial, sans-serif" '
    .. 'font-size="12">\n<title>%s</title>\n<rect width="100%%" height="100%%" fill="#ffffff"/>\n'):format(number(width), number(height),
    number(width), number(height), svg.escape(title))
  return p
end

function page:add(text)
  self.parts[#self.parts + 1] = text
end

-- options: size, anchor, color, weight
function page:text(x, y, text, options)
  local o = options or {}
  self:add(('<text x="%s" y="%s"%s%s%s fill="%s">%s</text>\n'):format(number(x), number(y), o.size and (' font-size="%d"'):format(o.size) or "",
    o.anchor and (' text-anchor="%s"'):format(o.anchor) or "", o.weight and ' font-weight="bold"' or "", o.color or "#222222", svg.escape(text)))
end

function page:rect(x, y, width, height, fill, more)
  self:add(('<rect x="%s" y="%s" width="%s" height="%s" fill="%s"%s/>\n'):format(number(x), number(y), number(width), number(height), fill,
    more and " " .. more or ""))
end

function page:line(x1, y1, x2, y2, color)
  self:add(('<line x1="%s" y1="%s" x2="%s" y2="%s" stroke="%s"/>\n'):format(number(x1), number(y1), number(x2), number(y2), color or "#222222"))
end

-- A scale of colours from `low` (bottom) to `high` at (x, y): boxes of whole numbers while there are few of them, else a ramp with ticks.
-- over: a remark below; empty: what is 0 is white.
function page:scale(x, y, height, low, high, caption, over, empty)
  self:text(x, y - 10, caption, { weight = true })
  if high - low <= 24 then
    local n = math.floor(high - low + 0.5) + 1
    local step = math.min(18, height / n)
    for i = 0, n - 1 do
      local top = y + (n - 1 - i) * step
      self:rect(x, top, 16, step, empty and i == 0 and "#ffffff" or svg.color(n > 1 and i / (n - 1) or 0), 'stroke="#666666" stroke-width="0.5"')
      if n <= 14 or i % 2 == 0 then
        self:text(x + 22, top + step / 2 + 4, svg.tick_text(low + i), { size = 11 })
      end
    end
    return
  end
  for i = 0, 63 do
    self:rect(x, y + height * (63 - i) / 64, 16, height / 64 + 0.5, svg.color(i / 63))
  end
  self:rect(x, y, 16, height, "none", 'stroke="#666666" stroke-width="0.5"')
  for _, tick in ipairs(svg.ticks(low, high, 8)) do
    local at = y + height * (1 - (tick - low) / (high - low))
    self:line(x + 16, at, x + 20, at, "#666666")
    self:text(x + 23, at + 4, svg.tick_text(tick), { size = 11 })
  end
  if over then
    self:text(x, y + height + 18, over, { size = 11 })
  end
end

function page:finish()
  self:add "</svg>\n"
  return table.concat(self.parts)
end

return svg
