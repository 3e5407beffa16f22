-- Films: frames handed to ffmpeg through a pipe. The film is written aside and put in place when it is whole.

local sys = require "rtray.sys"
local types = require "rtray.types"

local film = {}

local PROGRAM = "ffmpeg"
local ALL = { mp4 = "mp4", mov = "mov", mkv = "matroska", webm = "webm", gif = "gif", webp = "webp", apng = "apng" } -- muxers

-- ---- what ffmpeg can do ----

-- The set of its encoders' names; nil and a sentence when there is no ffmpeg.
function film.encoders()
  local text, status = sys.run { PROGRAM, "-hide_banner", "-loglevel", "error", "-encoders", stdin = "null", stderr = "null" }
  if not text then
    return nil, ("ffmpeg was not found (%s); install it (on Debian: apt install ffmpeg)"):format(status)
  elseif status ~= 0 then
    return nil, ("ffmpeg does not run: `ffmpeg -encoders` ended with status %d"):format(status)
  end
  local set = {}
  for name in text:gmatch "\n %S+ (%S+)" do
    set[name] = true
  end
  return set
end

local function first(encoders, ...)
  for _, name in ipairs { ... } do
    if encoders[name] then
      return name
    end
  end
  return nil
end

-- ---- the arguments ----

-- Video players expect even sizes in yuv420p: the last column or row is repeated.
local function yuv(width, height)
  local w, h = width + width % 2, height + height % 2
  local steps = {}
  if w ~= width or h ~= height then
    steps[1] = ("pad=%d:%d:0:0,fillborders=left=0:top=0:right=%d:bottom=%d:mode=smear"):format(w, h, w - width, h - height)
  end
  steps[#steps + 1] = "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:flags=accurate_rnd+full_chroma_int,format=yuv420p"
  return { "-vf", table.concat(steps, ","), "-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1" }
end

local coders = {}

function coders.libx264(o, kind)
  local list = { "-c:v", "libx264", "-preset", "medium", "-crf", "17", table.unpack(yuv(o.width, o.height)) }
  if kind ~= "mkv" then
    table.move({ "-movflags", "+faststart" }, 1, 2, #list + 1, list)
  end
  return list
end

coders["libvpx-vp9"] = function(o, kind)
  local list = { "-c:v", "libvpx-vp9", "-crf", "22", "-b:v", "0", "-row-mt", "1", table.unpack(yuv(o.width, o.height)) }
  if kind == "mp4" then
    table.move({ "-movflags", "+faststart" }, 1, 2, #list + 1, list)
  end
  return list
end

function coders.gif(o)
  return {
    "-filter_complex", "[0:v]split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a:diff_mode=rectangle", "-c:v", "gif",
    "-loop", o.once and "-1" or "0",
  }
end

local function webp(name)
  return function(o)
    return { "-c:v", name, "-quality", "90", "-loop", o.once and "1" or "0" }
  end
end
coders.libwebp_anim, coders.libwebp = webp "libwebp_anim", webp "libwebp"

function coders.apng(o)
  return { "-c:v", "apng", "-plays", o.once and "1" or "0" }
end

local CHOICES = {
  mp4 = { "libx264", "libvpx-vp9" }, mov = { "libx264" }, mkv = { "libx264", "libvpx-vp9" }, webm = { "libvpx-vp9" }, gif = { "gif" },
  webp = { "libwebp_anim", "libwebp" }, apng = { "apng" },
}

-- Shortest decimal of a frame rate.
local function rate(fps)
  return math.type(fps) == "integer" and ("%d"):format(fps) or ("%.10g"):format(fps)
end

-- How a film of this kind is made: { coder, arguments }, the file's name left out; nil and a sentence when ffmpeg lacks the coder.
-- o: { width, height, fps, once (plays once), texts (a list of { name, text }) }
function film.plan(kind, encoders, o)
  local coder = first(encoders, table.unpack(CHOICES[kind]))
  if not coder then
    return nil, ("this ffmpeg lacks %s, which a .%s film needs"):format(table.concat(CHOICES[kind], " and "), kind)
  end
  local list = { "-hide_banner", "-loglevel", "error", "-y", "-f", "image2pipe", "-framerate", rate(o.fps), "-c:v", "png", "-i", "pipe:0" }
  local function add(more)
    table.move(more, 1, #more, #list + 1, list)
  end
  add(coders[coder](o, kind))
  for _, pair in ipairs(o.texts or {}) do
    add { "-metadata", pair[1] .. "=" .. pair[2] }
  end
  add { "-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", ALL[kind] }
  return { coder = coder, arguments = list }
end

-- ---- making it ----

-- The last lines of what ffmpeg said.
local function complaint(text)
  local lines = {}
  for line in text:gmatch "[^\r\n]+" do
    lines[#lines + 1] = line
  end
  return table.concat(lines, "; ", math.max(1, #lines - 2))
end

-- Feeds the files at `paths` to ffmpeg, which writes the film to `part`. each(i) is called before every frame and may return true to stop.
-- True; false when it was stopped; an error names what ffmpeg said.
function film.encode(plan, paths, part, each)
  local command = { PROGRAM, stdin = "pipe", stdout = "null", stderr = "pipe", group = true }
  table.move(plan.arguments, 1, #plan.arguments, 2, command)
  command[#command + 1] = "file:" .. part
  local child <close>, why = sys.spawn(command)
  if not child then
    error({ status = 3, message = "ffmpeg cannot be started: " .. why }, 0)
  end
  for i, path in ipairs(paths) do
    if each(i) then
      child:stop()
      os.remove(part)
      return false
    end
    local file = assert(io.open(path, "rb"))
    local text = file:read "a"
    file:close()
    if not child:write(text) then
      break -- it has ended; why, it has said
    end
  end
  local result = child:communicate("")
  if result.status ~= 0 then
    os.remove(part)
    local said = complaint(result.err)
    local how = result.signal and "was ended by signal " .. tostring(result.signal) or "ended with status " .. tostring(result.status)
    error({ status = 3, message = ("ffmpeg %s%s"):format(how, said ~= "" and ": " .. said or "") }, 0)
  end
  return true
end

-- Text for a film's metadata: at most so long, without what tag readers choke on.
function film.text(text)
  return (types.quote(text):sub(2, -2))
end

return film
