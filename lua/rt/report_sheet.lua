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

-- The point's image; when it cannot be read false and why: its cell stays empty, and the first of them is told.
local function load(folder, p)
  local path = folder .. "/" .. p.image
  guard.own(path)
  local loaded, why = image.try(path)
  return loaded or false, why
end

-- The images of a sheet, no larger than its cells, so that few bytes are held; the cells' size, which the first image's shape decides; why one lacks.
local function load_all(folder, points)
  local images, note, width, height = {}, nil, nil, nil
  for i, p in ipairs(points) do
    local loaded, why = load(folder, p)
    note = note or why and "an image is left out: " .. why
    if loaded then
      local w, h = loaded:size()
      if not width then
        width = math.max(120, math.min(240, w))
        height = math.max(60, math.min(360, math.floor(width * h / w + 0.5)))
      end
      if w > width or h > height then
        local large <close> = loaded
        local small_width, small_height = contact_sheet.fit(w, h, width, height)
        loaded = large:resize(small_width, small_height)
      end
    end
    images[i] = loaded
  end
  return images, width or 120, height or 90, note
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
    local points = table.move(shown, (s - 1) * A_SHEET + 1, math.min(#shown, s * A_SHEET), 1, {})
    local labels = {}
    for i, p in ipairs(points) do
      labels[i] = label(study, p)
    end
    local images, width, height, why = load_all(folder, points)
    note = note or why
    local sheet_image <close> = contact_sheet.make {
      images = images, labels = labels, width = width, height = height,
      title = text.short(study.title .. (many > 1 and (" (%d of %d)"):format(s, many) or ""), 120),
    }
    for _, loaded in ipairs(images) do
      if loaded then
        loaded:release()
      end
    end
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
