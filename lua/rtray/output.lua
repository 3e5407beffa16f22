-- Standard output and standard error of the program. Writing past a full disk or a closed pipe is a fault of the machine, never silent.

local sys = require "rtray.sys"
local words = require "rt.words"

local output = {}

local function check(ok, why)
  if not ok then
    error({ status = 3, message = "standard output cannot be written: " .. why }, 0)
  end
end

-- Names and texts of scenes must not steer a terminal.
local function shown(fd, text)
  return sys.is_terminal(fd) and words.visible(text) or text
end

function output.write(text)
  check(io.stdout:flush()) -- what the script has written comes first
  check(sys.write(1, shown(1, text)))
end

-- At the end: what a script wrote must have arrived.
function output.finish()
  check(io.stdout:flush())
end

function output.print(...)
  output.write(string.format(...) .. "\n")
end

local line_shown = false -- a line of progress without its end stands on the terminal

-- Takes the line of progress away.
function output.clear_line()
  if line_shown then
    line_shown = false
    sys.write(2, "\r\27[K")
  end
end

-- Puts `text` in the place of the line of progress.
function output.line(text)
  line_shown = true
  sys.write(2, "\r" .. text .. "\27[K")
end

-- Remarks: a closed standard error is no reason to stop.
function output.note(...)
  output.clear_line()
  sys.write(2, shown(2, string.format(...)) .. "\n")
end

-- A column of numbers reads well right-aligned, names left-aligned: rows are lists of texts, `left` marks the columns aligned left.
function output.table(rows, left)
  local widths = {}
  for _, row in ipairs(rows) do
    for i, cell in ipairs(row) do
      widths[i] = math.max(widths[i] or 0, utf8.len(cell) or #cell)
    end
  end
  local lines = {}
  for _, row in ipairs(rows) do
    local cells = {}
    for i, cell in ipairs(row) do
      local pad = (" "):rep(widths[i] - (utf8.len(cell) or #cell))
      cells[i] = left[i] and cell .. pad or pad .. cell
    end
    lines[#lines + 1] = (table.concat(cells, "  "):gsub("%s+$", ""))
  end
  output.write(table.concat(lines, "\n") .. "\n")
end

-- 12.3 MiB
function output.bytes(n)
  local units, i = { "B", "KiB", "MiB", "GiB", "TiB" }, 1
  local x = n + 0.0
  while x >= 1024 and i < #units do
    x, i = x / 1024, i + 1
  end
  return i == 1 and ("%d B"):format(n) or ("%.1f %s"):format(x, units[i])
end

-- 12345678 as 12,345,678
function output.count(n)
  local digits = ("%d"):format(n)
  local head = (#digits - 1) % 3 + 1
  return digits:sub(1, head) .. digits:sub(head + 1):gsub("(%d%d%d)", ",%1")
end

-- 1.2M, for rates
function output.rate(n)
  if n >= 1e9 then
    return ("%.1fG"):format(n / 1e9)
  elseif n >= 1e6 then
    return ("%.1fM"):format(n / 1e6)
  elseif n >= 1e3 then
    return ("%.1fk"):format(n / 1e3)
  end
  return ("%d"):format(math.floor(n))
end

-- 0:07, 12:30, 1:02:03
function output.duration(seconds)
  local s = math.max(0, math.floor(seconds + 0.5))
  if s >= 3600 then
    return ("%d:%02d:%02d"):format(s // 3600, s // 60 % 60, s % 60)
  end
  return ("%d:%02d"):format(s // 60, s % 60)
end

-- 0.0123 s, 1.23 s, 123 s
function output.seconds(x)
  return ("%s s"):format(x < 0.1 and ("%.4f"):format(x) or x < 100 and ("%.2f"):format(x) or ("%.0f"):format(x))
end

return output
