-- Words and numbers in messages: quoting foreign ones, and guessing what was meant.

local words = {}

-- A number as text with a point, whatever locale the host has set; as tostring writes it, or by a format.
function words.number(x, form)
  local text = form and form:format(x) or tostring(x)
  return text:find "^[%d%-+e.infa]+$" and text or (text:gsub("[^%d%-+einfa]+", "."))
end

-- Foreign text for a message: control bytes and broken UTF-8 are shown as \xNN, text longer than `most` bytes (60) is cut.
function words.quote(text, most)
  most = most or 60
  if #text > most then
    text = text:sub(1, most - 3) .. "..."
  end
  local hex = function(c)
    return string.format("\\x%02X", c:byte())
  end
  if utf8.len(text) then
    return (text:gsub("[%c\127]", hex))
  end
  return (text:gsub("[%c\127-\255]", hex))
end

-- Foreign text as a terminal may show it: lines and tabs stay, other control characters become \xNN.
function words.visible(text)
  local hex = function(bytes)
    return (bytes:gsub(".", function(c)
      return ("\\x%02X"):format(c:byte())
    end))
  end
  if not utf8.len(text) then
    text = text:gsub("[\128-\255]", hex)
  end
  return (text:gsub("[%c\127]", function(c)
    return c ~= "\n" and c ~= "\t" and hex(c) or nil
  end):gsub("\xC2[\x80-\x9F]", hex)) -- the control characters of Latin-1, as UTF-8
end

-- Edits (insert, drop, replace, swap neighbours) between two words.
local function distance(a, b)
  local before, row = nil, {}
  for j = 0, #b do
    row[j] = j
  end
  for i = 1, #a do
    local next_row = { [0] = i }
    for j = 1, #b do
      local same = a:byte(i) == b:byte(j)
      local d = math.min(row[j] + 1, next_row[j - 1] + 1, row[j - 1] + (same and 0 or 1))
      if before and j > 1 and a:byte(i) == b:byte(j - 1) and a:byte(i - 1) == b:byte(j) then
        d = math.min(d, before[j - 2] + 1)
      end
      next_row[j] = d
    end
    before, row = row, next_row
  end
  return row[#b]
end

-- The name nearest to a word, or nil; the first of equals. At most a third of the word may differ, and one letter more (diffuse: diffusion) where
-- both begin alike. Nobody misspells a number.
function words.nearest(word, names)
  local best, best_distance = nil, math.huge
  if #word > 64 or tonumber(word) then
    return nil
  end
  for _, name in ipairs(names) do
    local d = distance(word, name)
    local most = math.max(1, #word // 3) + (#word > 4 and word:sub(1, 3) == name:sub(1, 3) and 1 or 0)
    if d < best_distance and d <= most and d < #name and d < #word then
      best, best_distance = name, d
    end
  end
  return best
end

return words
