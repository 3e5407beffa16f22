-- Words and numbers of a report: escaped for HTML and SVG, and formatted so that a column of them lines up.

local text = {}

local ENTITIES = { ["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;", ['"'] = "&quot;", ["'"] = "&#39;" }
local REPLACEMENT = "\u{FFFD}"

-- Bytes that are no UTF-8, and characters that no page may hold (controls, surrogates, the two noncharacters), become U+FFFD.
function text.clean(s)
  s = tostring(s)
  if not utf8.len(s) then
    local parts, at = {}, 1
    while at <= #s do
      local _, bad = utf8.len(s, at)
      parts[#parts + 1] = s:sub(at, (bad or #s + 1) - 1)
      if bad then
        parts[#parts + 1] = REPLACEMENT
      end
      at = (bad or #s) + 1
    end
    s = table.concat(parts)
  end
  return (s:gsub("[%z\1-\8\11\12\14-\31\127]", REPLACEMENT):gsub("\u{FFFE}", REPLACEMENT):gsub("\u{FFFF}", REPLACEMENT):gsub("\r\n?", "\n"))
end

-- For element content and quoted attributes.
function text.escape(s)
  return (text.clean(s):gsub("[&<>\"']", ENTITIES))
end

-- A relative file name as the address in an attribute: every byte but the plain ones as %XX.
function text.address(path)
  return (path:gsub("[^%w%-%._~/]", function(c)
    return ("%%%02X"):format(c:byte())
  end))
end

-- On one line, at most `most` characters.
function text.short(s, most)
  s = text.clean(s):gsub("%s+", " ")
  if (utf8.len(s) or #s) <= most then
    return s
  end
  return s:sub(1, utf8.offset(s, most) - 1) .. "\u{2026}"
end

-- ---- numbers ----

-- With a point, whatever the locale says.
local function fixed(x, decimals)
  return (("%." .. decimals .. "f"):format(x):gsub(",", "."))
end
text.fixed = fixed

-- Three significant digits at most: 1.23, 12.3, 123, 1230, 0.0012.
function text.number(x)
  if x == math.floor(x) and math.abs(x) < 1e6 then
    return ("%d"):format(x)
  end
  local size = math.abs(x)
  if size >= 1e6 or size < 1e-4 then
    return (("%.3g"):format(x):gsub(",", "."))
  end
  local decimals = math.max(0, 2 - math.floor(math.log(size, 10) + 1e-9))
  local s = fixed(x, math.min(decimals, 6))
  return s:find(".", 1, true) and s:gsub("%.?0+$", "") or s
end

-- The name of a column or an axis as a title: Rays per second.
function text.title(name)
  return (name:gsub("_", " "):gsub("^%l", string.upper))
end

local SCALES = {
  s = { { 1, "s" }, { 1e-3, "ms" }, { 1e-6, "\u{B5}s" } },
  bytes = { { 2 ^ 30, "GiB" }, { 2 ^ 20, "MiB" }, { 2 ^ 10, "KiB" }, { 1, "bytes" } },
  ["1/s"] = { { 1e9, "G/s" }, { 1e6, "M/s" }, { 1e3, "k/s" }, { 1, "1/s" } },
}

-- The unit in which values up to `most` are read best: what to divide by, and its name.
function text.scale(unit, most)
  local rows = SCALES[unit]
  if not rows then
    return 1, unit
  end
  for _, row in ipairs(rows) do
    if most >= row[1] * 0.9995 then
      return row[1], row[2]
    end
  end
  return rows[#rows][1], rows[#rows][2]
end

local function is_whole(list)
  for _, x in ipairs(list) do
    if x ~= math.floor(x) or math.abs(x) >= 1e15 then
      return false
    end
  end
  return true
end

-- How a column of numbers is written: a function of a number, and the unit's name for the head. All get the same decimals, as many as
-- the value in the middle needs for three digits.
function text.column(unit, list)
  local sorted = table.move(list, 1, #list, 1, {})
  table.sort(sorted)
  local most = math.max(math.abs(sorted[1] or 0), math.abs(sorted[#sorted] or 0))
  local by, name = text.scale(unit, most)
  local scaled = {}
  for i, x in ipairs(sorted) do
    scaled[i] = x / by
  end
  local decimals = 0
  if most >= 1e15 then
    return text.number, unit
  elseif not is_whole(scaled) then
    local middle = math.abs(scaled[(#scaled + 1) // 2])
    middle = middle > 0 and middle or most / by
    decimals = middle > 0 and math.max(0, math.min(6, 2 - math.floor(math.log(middle, 10) + 1e-9))) or 0
  end
  return function(x)
    local s = fixed(x / by, decimals)
    return s:find "^%-[0.]*$" and s:sub(2) or s
  end, name
end

-- 3 points, 1 point
function text.count(n, one, many)
  return ("%d %s"):format(n, n == 1 and one or many or one .. "s")
end

-- 1 h 2 min, 3.4 s, 12 ms
function text.duration(s)
  if s >= 3600 then
    return ("%d h %d min"):format(s // 3600, s % 3600 // 60)
  elseif s >= 60 then
    return ("%d min %d s"):format(s // 60, s % 60 // 1)
  end
  local by, unit = text.scale("s", s)
  return text.number(s / by) .. " " .. unit
end

return text
