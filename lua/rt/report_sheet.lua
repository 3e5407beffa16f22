-- Contact sheets of a study: its images small, with their values under them; many images on several sheets, a few of them held at a time.

local contact_sheet = require "rt.contact_sheet"
local core = require "rt.core"
local guard = require "rt.guard"
local image = require "rt.image"
local text = require "rt.report_text"

local sheet = {}

local A_SHEET, MOST_SHEETS = 96, 40 -- images on a sheet; then the page's gallery is the place to look

local function label(study, p)
  local lines = {}
  for _, axis in ipairs(study.axes) do
    if #axis.values > 1 then
      lines[#lines + 1] = text.short(axis.name .. " " .. p.values[axis.name], 60)
    end
    if #lines == 3 then
      break
    end
  end
  if p.median.seconds then
    lines[#lines + 1] = text.duration(p.median.seconds)
  end
  return lines
end

-- Images that cannot be read have an empty cell; the first of them is told.
local function readable(folder, p)
  local path = folder .. "/" .. p.image
  guard.own(path) -- the sheet reads it again
  local ok, loaded = pcall(image.new, path)
  if ok then
    local w, h = loaded:size()
    loaded:release()
    return path, w, h
  end
  return false, nil, nil, tostring(loaded)
end

-- Writes contact.png (contact-2.png, ...) into the folder: their names, and a sentence when an image could not be read or some are left out.
function sheet.write(study, folder)
  local shown = {}
  for _, p in ipairs(study.points) do
    if p.image then
      shown[#shown + 1] = p
    end
  end
  local names, note = {}, nil
  local many = math.ceil(#shown / A_SHEET)
  if many > MOST_SHEETS then
    many, note = MOST_SHEETS, ("the contact sheets show the first %d of %d images"):format(MOST_SHEETS * A_SHEET, #shown)
  end
  for s = 1, many do
    local images, labels, width, height = {}, {}, nil, nil
    for i = (s - 1) * A_SHEET + 1, math.min(#shown, s * A_SHEET) do
      local path, w, h, why = readable(folder, shown[i])
      images[#images + 1], labels[#labels + 1] = path, label(study, shown[i])
      width, height = width or w, height or h
      note = note or why and "an image is left out: " .. why
    end
    width, height = width or 4, height or 3
    local cell_width = math.max(120, math.min(240, width))
    local sheet_image <close> = contact_sheet {
      images = images, labels = labels, width = cell_width, height = math.max(60, math.min(360, math.floor(cell_width * height / width + 0.5))),
      title = text.short(study.title .. (many > 1 and (" (%d of %d)"):format(s, many) or ""), 120),
    }
    local name = s == 1 and "contact.png" or ("contact-%d.png"):format(s)
    guard.own(folder .. "/" .. name)
    sheet_image:save(folder .. "/" .. name, { text = false })
    names[s] = name
  end
  local s = many + 1 -- sheets of an older, longer study
  while s > 1 and core.file_stat(("%s/contact-%d.png"):format(folder, s)) == "file" do
    os.remove(("%s/contact-%d.png"):format(folder, s))
    s = s + 1
  end
  return names, note
end

return sheet
