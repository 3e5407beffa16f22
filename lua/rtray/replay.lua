-- rtray replay IMAGE: makes the picture again from what it says of itself (recipe.lua), always in the sandbox, and compares: the same bits, or what
-- differs.

local sys = require "rtray.sys"
local guard = require "rt.guard"
local cli = require "rtray.cli"
local faults = require "rtray.faults"
local files = require "rtray.files"
local json = require "rtray.json"
local output = require "rtray.output"
local recipe = require "rtray.recipe"
local render = require "rtray.render"
local report = require "rtray.report"
local sandbox = require "rtray.sandbox"
local source = require "rtray.source"
local types = require "rtray.types"
local words = require "rt.words"

local replay = {}

local FORMATS = { png = "png", jpg = "jpg", jpeg = "jpg", bmp = "bmp", tga = "tga", hdr = "hdr" }

-- ---- --print ----

local function print_recipe(path, r)
  local lines = { ("%s: made by librt %s from %s"):format(types.quote(path), r.librt, types.quote(r.scene)) }
  local function add(...)
    lines[#lines + 1] = string.format(...)
  end
  if r.set then
    add("set %s", types.quote(r.set))
  end
  if r.frame then
    add("frame %d", r.frame)
  end
  for _, p in ipairs(r.parameters) do
    add("parameter %s = %s", types.quote(p.name), types.quote(p.text or p.file))
  end
  for _, entry in ipairs(r.files) do
    add("file %s, %s bytes, sha256 %s%s", types.quote(entry.name), tostring(entry.bytes), types.quote(entry.sha256),
      entry.text and "" or ", not in the image")
  end
  for _, entry in ipairs(r.files) do
    if entry.text then
      add("---- %s ----", types.quote(entry.name))
      lines[#lines + 1] = (entry.text:gsub("\n$", ""))
    end
  end
  output.write(words.visible(table.concat(lines, "\n")) .. "\n")
end

-- ---- the files ----

-- Where a file of the recipe lies here: below the folder, or by its last part in a folder of --allow-read.
local function place_of(entry, folder, values)
  local candidates = { folder .. "/" .. entry.name }
  for _, other in ipairs(values.allow_read or {}) do
    candidates[#candidates + 1] = other .. "/" .. entry.name
    candidates[#candidates + 1] = other .. "/" .. files.name_of(entry.name)
  end
  for _, path in ipairs(candidates) do
    if sys.stat(path) == "file" then
      return path
    end
  end
  return nil
end

local function compare_file(entry, name, folder, values, differences)
  local path = place_of(entry, folder, values)
  local hash, why = nil, "is not here"
  if path then
    hash, why = sys.sha256_file(path)
  end
  if not hash then
    differences[#differences + 1] = ("the file %s %s (sha256 %s)"):format(types.quote(name), why, types.quote(entry.sha256))
  elseif hash ~= entry.sha256 then
    differences[#differences + 1] = ("the file %s is another: sha256 %s, not %s"):format(types.quote(name), hash, types.quote(entry.sha256))
  end
  return path
end

-- Puts the scripts in their places; notes what lacks or differs. Returns the path of the scene.
local function prepare(r, folder, values, differences)
  for _, entry in ipairs(r.files) do
    if entry.text then
      sandbox.stand_in(folder .. "/" .. entry.name, entry.text)
    else
      compare_file(entry, entry.name, folder, values, differences)
    end
  end
  return folder .. "/" .. r.scene
end

-- Parameters as the command line had them; files by their places here.
local function defines_of(r, folder, values, differences)
  local list = {}
  for i, p in ipairs(r.parameters) do
    local text = p.text
    if not text then
      text = compare_file({ name = p.file, sha256 = tostring(p.sha256) }, p.file, folder, values, differences) or folder .. "/" .. p.file
    end
    list[i] = { name = p.name, text = text }
  end
  return list
end

-- ---- making it again ----

local function option_values(values, r, defines)
  local t = { define = defines, set = r.set, seed = r.seed, frame = r.frame, quiet = true, stranger = true }
  for _, key in ipairs { "eye", "at", "fov" } do
    t[key] = r.view and r.view[key]
  end
  for _, key in ipairs { "allow_read", "limit", "workers", "json" } do
    t[key] = values[key]
  end
  if values.output == "-" then
    t.output = "-"
  end
  return t
end

local function settings_of(path, r)
  local settings = {}
  for name, value in pairs(r.settings) do
    if type(name) ~= "string" then
      error({ status = 1, message = ("%s: the recipe is broken: the settings"):format(types.quote(path)) }, 0)
    end
    settings[name] = value
  end
  return settings
end

local function save_of(r)
  local save = {}
  for _, name in ipairs { "exposure", "tone", "bits", "quality", "alpha" } do
    save[name] = r.save[name]
  end
  return save
end

-- Hash of the pixels of a saved image.
local function picture_hash(path)
  guard.own(path)
  local image <close> = require("rt").image(path)
  return image:hash()
end

-- Is what stands in the image's file what saving the picture gives?
local function compare_picture(path, image, save, differences)
  local format = FORMATS[files.ending_of(path)]
  if not format then
    return
  end
  local name = os.tmpname()
  local ok, raised = pcall(function()
    local how = { format = format, text = false }
    for key, value in pairs(save) do
      how[key] = value
    end
    guard.own(name)
    image:save(name, how)
    if picture_hash(name) ~= picture_hash(path) then
      differences[#differences + 1] = ("the picture in %s is not the one that its recipe gives: it was changed since, or is unfinished"):format(
        types.quote(path))
    end
  end)
  os.remove(name)
  if not ok then
    error(raised, 0)
  end
end

local function make(path, r, values, command, scene_path, defines, differences)
  local opened = source.open(scene_path, option_values(values, r, defines), command, settings_of(path, r))
  if values.output then
    files.check_output(values.output) -- again: now it is known what the scene reads
  end
  local description = opened.scene:hash()
  if description ~= r.description then
    differences[#differences + 1] = ("the script describes another scene here: %s, not %s"):format(description, types.quote(r.description))
  end
  local image, settings = render.wait(opened, values, path)
  local hash = image:hash()
  if r.image and hash ~= r.image then
    differences[#differences + 1] = ("the image is another: %s, not %s"):format(hash, types.quote(r.image))
  end
  local save = save_of(r)
  if #differences == 0 then
    compare_picture(path, image, save, differences)
  end
  if values.output then
    local how = save_of(r)
    how.text = report.texts(opened, settings, {}, save)
    how.text.Hash = hash
    how.format = values.output == "-" and "png" or nil
    guard.own(values.output)
    image:save(values.output, how)
    recipe.beside(values.output, nil, how.text)
  end
  return hash
end

local function tell(path, values, hash, differences)
  if values.json then
    output.print("%s", json.encode(json.object():set("image", path):set("equal", #differences == 0):set("hash", hash)
      :set("differences", differences)))
  elseif not values.quiet then
    local note = values.output == "-" and output.note or output.print
    for _, difference in ipairs(differences) do
      note("differs: %s", words.visible(difference))
    end
    if #differences == 0 then
      note("%s: the same bits, %s", types.quote(path), hash)
    end
  end
  return #differences == 0 and 0 or 4
end

function replay.run(command, values, arguments)
  local path = arguments[1]
  local r = recipe.read(path)
  if values.print then
    print_recipe(path, r)
    return 0
  end
  if values.output == "-" and values.json then
    cli.fault(command, "-o - and --json both want standard output")
  elseif values.output then
    if values.output ~= "-" and not FORMATS[files.ending_of(values.output)] then
      cli.fault(command, "the ending of %s names no image format; known are .png, .jpg, .bmp, .tga, .hdr", types.quote(values.output))
    end
    files.check_output(values.output)
  end
  local folder = values.files_folder or files.folder_of(path)
  if sys.stat(folder) ~= "folder" then
    cli.fault(command, "--files %s: there is no such folder", types.quote(folder))
  end
  local differences = {}
  local version = require("rt").version
  if r.librt ~= version then
    differences[1] = ("librt %s made it; this is %s"):format(types.quote(r.librt), version)
  end
  local scene_path = prepare(r, folder, values, differences)
  local defines = defines_of(r, folder, values, differences)
  local hash
  local ok, fault = xpcall(function()
    hash = make(path, r, values, command, scene_path, defines, differences)
  end, faults.of)
  if not ok and type(fault) ~= "table" then
    fault = faults.of(fault)
  end
  if not ok and fault.status == 2 then -- what it asks for stands in the image, not on the command line
    fault = { status = 1, message = ("%s: its recipe cannot be followed: %s"):format(types.quote(path), fault.message) }
  end
  if not ok and (#differences == 0 or fault.status > 1 or sys.interrupted()) then
    error(fault, 0)
  elseif not ok then -- what lacks is why
    differences[#differences + 1] = "it cannot be made here: " .. fault.message
  end
  return tell(path, values, hash, differences)
end

return replay
