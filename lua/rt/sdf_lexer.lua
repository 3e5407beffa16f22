-- Words, numbers and names of the old scene definition files (scenes/SDF.md), read block by block so that a file of many million lines
-- takes memory for one block. A token never crosses the end of a line, so a block is cut behind its last line.

local words = require "rt.words"

local lexer = {}
lexer.__index = lexer

local find, sub, byte, format = string.find, string.sub, string.byte, string.format
local BLOCK, LONGEST_LINE = 65536, 1048576
local NEWLINE, HASH, SLASH, COMMA, QUOTE, APOSTROPHE, LETTER = 10, 35, 47, 44, 34, 39, 65

-- read(n): the next at most n bytes; nil at the end; nil and a reason when reading fails.
function lexer.new(read, name)
  local self = setmetatable({ read = read, name = words.quote(name, 4096), buffer = "", rest = "", pos = 1, line = 1, at = 1, first = true }, lexer)
  return self
end

-- Raises "file:line: message"; the line is the current token's unless one is given.
function lexer:fail(line, message, ...)
  error(format("%s:%d: ", self.name, line or self.at) .. format(message, ...), 0)
end

-- The next whole lines into the buffer.
local function fill(self)
  local parts, size = { self.rest }, #self.rest
  self.rest, self.pos = "", 1
  while true do
    local block, why = self.read(BLOCK)
    if not block then
      if why then
        error(self.name .. ": cannot be read: " .. why, 0)
      end
      self.ended = true
      break
    end
    local last = find(block, "\n[^\n]*$")
    if last then
      parts[#parts + 1] = sub(block, 1, last)
      self.rest = sub(block, last + 1)
      break
    end
    parts[#parts + 1] = block
    size = size + #block
    if size > LONGEST_LINE then
      self:fail(self.line, "this line is longer than %d bytes; is this a scene definition file?", LONGEST_LINE)
    end
  end
  self.buffer = table.concat(parts)
  if self.first then -- editors of other systems begin a file with a byte order mark
    self.first = false
    self.pos = sub(self.buffer, 1, 3) == "\xEF\xBB\xBF" and 4 or 1
  end
end

-- Skips blanks, ends of lines and comments; returns the first byte of a token, or nil at the end of the file.
local function skip(self)
  local buffer, pos = self.buffer, self.pos
  while true do
    local _, blank = find(buffer, "^[ \t\r\v\f]+", pos)
    pos = blank and blank + 1 or pos
    local c = byte(buffer, pos)
    if c == nil then
      if self.ended then
        self.pos = pos
        return nil
      end
      fill(self)
      buffer, pos = self.buffer, self.pos
    elseif c == NEWLINE then
      self.line = self.line + 1
      pos = pos + 1
    elseif c == HASH or (c == SLASH and byte(buffer, pos + 1) == SLASH) then
      pos = find(buffer, "\n", pos, true) or #buffer + 1
    else
      self.pos = pos
      return c
    end
  end
end

-- A name in quotes; the quote itself is written twice inside.
local function quoted(self, quote)
  local buffer, from, parts = self.buffer, self.pos + 1, {}
  while true do
    local stop = find(buffer, quote == QUOTE and '["\n]' or "['\n]", from)
    if not stop or byte(buffer, stop) == NEWLINE then
      self:fail(nil, "the quote that opens here is not closed on its line")
    end
    parts[#parts + 1] = sub(buffer, from, stop - 1)
    from = stop + 1
    if byte(buffer, from) ~= quote then
      break
    end
    parts[#parts + 1] = string.char(quote)
    from = from + 1
  end
  self.pos = from
  self.kind, self.text = "name", table.concat(parts)
end

-- A word, or a number: what Lua reads as one, but for hexadecimal.
local function classify(self, text)
  self.text, self.kind = text, "word"
  if byte(text) < LETTER and not find(text, "[xX]") then
    local value = tonumber(text)
    if value then
      self.kind, self.value = "number", value + 0.0
    end
  end
end

-- Moves to the next token: kind is "word", "number", "comma", "name" (was in quotes) or "end"; text is what stands in the file,
-- value the number, at the line.
function lexer:advance()
  local _, plain_stop, plain = find(self.buffer, "^[ \t]*([%w+.-][^%s,]*)", self.pos)
  if plain then -- most tokens, at one look
    self.pos, self.at = plain_stop + 1, self.line
    classify(self, plain)
    return
  end
  local c = skip(self)
  self.at = self.line
  if c == nil then
    self.kind, self.text = "end", "the end of the file"
  elseif c == COMMA then
    self.kind, self.text, self.pos = "comma", ",", self.pos + 1
  elseif c == QUOTE or c == APOSTROPHE then
    quoted(self, c)
  else
    local _, stop = find(self.buffer, "^[^%s,]+", self.pos)
    local text = sub(self.buffer, self.pos, stop)
    self.pos = stop + 1
    classify(self, text)
  end
end

return lexer
