-- Frames as the command line writes them: which ones (0:119:2), and where each goes (frame%04d.png).

local cli = require "rtray.cli"
local files = require "rtray.files"
local types = require "rtray.types"

local frames = {}

local MOST = 999999

-- ---- ranges ----

local function count_of(text)
  local n = text:find "^%d+$" and #text <= 9 and math.tointeger(tonumber(text))
  return n and n <= MOST and n or nil
end

-- "7", "0:119", "0:119:2", several with commas: a list of { first, last, step }; or nil and why not.
function frames.read_ranges(text)
  local list = {}
  for part in (text .. ","):gmatch "([^,]*)," do
    local first, last, step = part:match "^([^:]*):([^:]*):?([^:]*)$"
    if not first then
      first, last, step = part, part, ""
    elseif step == "" and part:sub(-1) == ":" then
      return nil, ("%s ends in a colon; A:B:STEP is expected"):format(types.quote(part))
    end
    local a, b, s = count_of(first), count_of(last), step == "" and 1 or count_of(step)
    if not (a and b and s) then
      local minus = part:find("-", 1, true) and "; frames count from 0" or ""
      return nil, ("A, A:B or A:B:STEP with whole numbers up to %d is expected, several with commas, as in 0:119 or 0:119:2 or 7,9%s"):format(
        MOST, minus)
    elseif s == 0 then
      return nil, ("the step of %s is 0; it must be at least 1"):format(types.quote(part))
    elseif b < a then
      return nil, ("%s is empty: it begins at %d and ends at %d"):format(types.quote(part), a, b)
    end
    list[#list + 1] = { a, b, s }
  end
  return list
end

-- The frames of some ranges (nil: all) of an animation with `count` frames: each once, in ascending order.
function frames.expand(command, ranges, count)
  local wanted, list = {}, {}
  for _, r in ipairs(ranges or { { 0, count - 1, 1 } }) do
    if r[2] >= count then
      local beyond = r[1] >= count and r[1] or r[2]
      cli.fault(command, "--frames: there is no frame %d; the animation has %d frame%s, 0 to %d", beyond, count, count == 1 and "" or "s", count - 1)
    end
    for frame = r[1], r[2], r[3] do
      wanted[frame] = true
    end
  end
  for frame = 0, count - 1 do
    if wanted[frame] then
      list[#list + 1] = frame
    end
  end
  return list
end

-- ---- places ----

-- A pattern with one %d or %0Nd (%% is a percent sign): a function from frame to name; or nil and why not.
function frames.pattern(text)
  local parts, numbers, at = {}, 0, 1
  local width = 0
  while at <= #text do
    local sign = text:find("%", at, true)
    parts[#parts + 1] = text:sub(at, (sign or 0) - 1)
    if not sign then
      break
    end
    local digits = text:match("^%%0(%d)d", sign)
    if text:sub(sign + 1, sign + 1) == "%" then
      parts[#parts + 1], at = "%", sign + 2
    elseif text:sub(sign + 1, sign + 1) == "d" then
      numbers, at = numbers + 1, sign + 2
      parts[#parts + 1] = false
    elseif digits and digits ~= "0" then
      numbers, width, at = numbers + 1, math.tointeger(tonumber(digits)), sign + 4
      parts[#parts + 1] = false
    else
      return nil, ("%s stands in it; %%d or %%0Nd (as %%04d) takes the frame's number, %%%% is a percent sign"):format(
        types.quote(text:sub(sign, sign + 1)))
    end
  end
  if numbers == 0 then
    return nil, "it has no place for the frame's number; write %d or %04d where it goes, as in frame%04d.png"
  elseif numbers > 1 then
    return nil, "it has more than one place for the frame's number; one %d is expected"
  end
  return function(frame)
    local name = {}
    for i, part in ipairs(parts) do
      name[i] = part or ("%0" .. width .. "d"):gsub("^%%0+d", "%%d"):format(frame)
    end
    return table.concat(name)
  end
end

local IMAGES = { png = "png", jpg = "jpg", jpeg = "jpg", bmp = "bmp", tga = "tga", hdr = "hdr" }
local FILMS = { mp4 = true, webm = true, gif = true, webp = true, apng = true, mkv = true, mov = true }

-- Where an animation goes: { out, film (kind or nil), folder (of the frames), place (frame -> path), state (folder), format }.
function frames.target(command, out, format)
  if out == "-" then
    cli.fault(command, "-o -: an animation is many files or a film, which standard output cannot be; name a film or a pattern such as frame%%04d.png")
  end
  local ending = files.ending_of(out)
  if FILMS[ending] then
    if format and format ~= "png" then
      cli.fault(command, "--format %s: a film's frames are kept as PNG", format)
    end
    local folder = files.folder_of(out) .. "/" .. files.stem_of(out) .. ".frames"
    return {
      out = out, film = ending, folder = folder, state = folder .. "/state", format = "png",
      place = function(frame)
        return ("%s/%06d.png"):format(folder, frame)
      end,
    }
  end
  local place, why = frames.pattern(out)
  if not place then
    if not IMAGES[ending] then
      why = "its ending names no film (.mp4, .webm, .gif, .webp, .apng, .mkv, .mov) and, as a pattern for images, " .. why
    end
    cli.fault(command, "-o %s: %s", types.quote(out), why)
  elseif not (format or IMAGES[ending]) then
    cli.fault(command, "the ending of %s names no image format; known are .png, .jpg, .bmp, .tga, .hdr (or --format says it)", types.quote(out))
  elseif files.folder_of(out):find("%", 1, true) and files.folder_of(place(0)) ~= files.folder_of(place(1)) then
    cli.fault(command, "-o %s: the frame's number stands in a folder's name; it belongs into the file's name", types.quote(out))
  end
  local folder = files.folder_of(place(0))
  return {
    out = out, folder = folder, state = ("%s/%s.state"):format(folder, files.name_of(out)), format = format or IMAGES[ending], place = place,
  }
end

return frames
