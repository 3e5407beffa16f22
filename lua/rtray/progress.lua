-- Progress of a render on standard error: on a terminal one line as wide as it, else a line every ten seconds; or JSON lines.

local sys = require "rtray.sys"
local json = require "rtray.json"
local output = require "rtray.output"

local progress = {}
progress.__index = progress

local EVERY = { terminal = 0.1, file = 10, json = 0.5 }

local function kind_of(options)
  if options.quiet or options.progress == "none" then
    return nil
  elseif options.progress == "json" then
    return "json"
  end
  local plain = os.getenv "TERM" == "dumb"
  return sys.is_terminal(2) and not plain and "terminal" or "file"
end

-- For one render called `name`; options are those of the command line.
function progress.new(options, name)
  local now = sys.now()
  local kind = kind_of(options)
  -- A short render off a terminal says nothing: the first line comes after the first interval.
  return setmetatable({ kind = kind, name = name, begun = now, last = kind == "file" and now or -math.huge, seen = 0, seen_at = now }, progress)
end

-- Seconds left, from the pace since the first progress; nil while nothing is known.
local function left(self, done, now)
  if done <= 0 or now - self.begun < 0.5 then
    return nil
  end
  return (now - self.begun) * (1 - done) / done
end

local function plain_line(self, done, rays, now)
  local elapsed = math.max(now - self.begun, 1e-9)
  local rest = left(self, done, now)
  local parts = { ("%s %3d%%"):format(self.name, math.floor(done * 100)), output.duration(elapsed) }
  if rays and rays > 0 then
    parts[#parts + 1] = output.rate(rays / elapsed) .. " rays/s"
  end
  parts[#parts + 1] = rest and output.duration(rest) .. " left"
  return table.concat(parts, "  ")
end

-- A bar fills what the text leaves of the line; the text is cut when the terminal is narrower.
local function terminal_line(self, done, rays, now)
  local width = (sys.columns(2) or 80) - 1
  local text = plain_line(self, done, rays, now)
  local length = utf8.len(text) or #text
  local room = width - length - 3
  if room >= 10 then
    local filled = math.floor(done * room + 0.5)
    text = ("%s [%s%s]"):format(text, ("#"):rep(filled), ("-"):rep(room - filled))
  elseif length > width then
    text = text:sub(1, (utf8.offset(text, width + 1) or width + 1) - 1)
  end
  return text
end

local function json_line(self, done, rays, now)
  local elapsed = now - self.begun
  return json.encode(json.object():set("event", "progress"):set("image", self.name):set("done", done):set("seconds", elapsed)
    :set("rays", rays):set("seconds_left", left(self, done, now)))
end

-- done: 0 ... 1; rays: traced so far, or a function that says so (asked only when a line is written), or nil.
function progress:update(done, rays)
  local now = sys.now()
  if not self.kind or now - self.last < EVERY[self.kind] then
    return
  end
  self.last = now
  rays = type(rays) == "function" and rays() or rays
  if self.kind == "json" then
    output.note("%s", json_line(self, done, rays, now))
  elseif self.kind == "file" then
    output.note("%s", plain_line(self, done, rays, now))
  else
    output.line(terminal_line(self, done, rays, now))
  end
end

return progress
