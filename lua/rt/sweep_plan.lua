-- What a sweep is going to measure: its points, each with the key under which its runs are kept.

local core = require "rt.core"
local settings = require "rt.settings"

local sweep_plan = {}

local function file_text(path)
  local file, why = io.open(path, "rb")
  local text = file and file:read "a"
  if file then
    file:close()
  end
  return text or error({ status = 1, message = ("the measure file %s cannot be read: %s"):format(path, tostring(why):gsub("^.*: ", "")) }, 0)
end

-- What names a measure function: the file's bytes, or the code of a function (what it holds on to is not seen).
function sweep_plan.measure_hash(measure)
  if measure == nil then
    return ""
  end
  return core.text_hash(type(measure) == "string" and file_text(measure) or string.dump(measure, true))
end

-- Splits a point's values into what the script and what the render gets: lists of { name, text }; set and transport by name.
local function arrange(point, axes, base)
  local request = {
    scene = base.scene, seed = base.seed, fixed = base.fixed, set = base.set, measure = base.measure_file, label = point.label, parameters = {},
    settings = {}, transport = "threads",
  }
  table.move(base.parameters, 1, #base.parameters, 1, request.parameters)
  for _, a in ipairs(axes) do
    local value = point.values[a.name]
    if a.kind == "parameter" then
      request.parameters[#request.parameters + 1] = { a.name, value }
    elseif a.name == "set" or a.name == "transport" then
      request[a.name] = value
    else
      request.settings[#request.settings + 1] = { a.name, value }
    end
  end
  return request
end

-- The values of a point for a function that makes the scene.
local function live_values(p, axes)
  local values = {}
  for _, a in ipairs(axes) do
    if a.kind == "parameter" then
      local text = p.values[a.name]
      values[a.name] = a.type == "number" and (math.tointeger(tonumber(text)) or tonumber(text)) or a.type == "boolean" and text == "true" or text
    end
  end
  return values
end

-- The request of a point, and what of it decides the description.
function sweep_plan.request(point, axes, base)
  local request = arrange(point, axes, base)
  local parts = { request.set or "" }
  for _, pair in ipairs(request.parameters) do
    parts[#parts + 1] = pair[1] .. "=" .. pair[2]
  end
  request.values = type(base.scene) == "function" and live_values(point, axes) or nil
  point.request, point.describes = request, table.concat(parts, "\0")
end

-- The settings that hold at a point: those of its description, with the axes over them.
local function settings_at(point, described)
  local values, over = {}, {}
  for _, pair in ipairs(point.request.settings) do
    if pair[1] == "size" then
      over.width, over.height = pair[2]:match "^(%d+)x(%d+)$"
    else
      over[pair[1]] = pair[2]
    end
  end
  for _, pair in ipairs(described.settings) do
    values[pair[1]] = pair[2]
  end
  for _, row in ipairs(settings.list) do
    values[row.name] = over[row.name] or values[row.name]
  end
  return values
end

-- Texts in the order of the settings' list, the ones that `skip` has left out.
local function setting_texts(values, skip)
  local parts = {}
  for _, row in ipairs(settings.list) do
    if values[row.name] and not skip[row.name] then
      parts[#parts + 1] = row.name .. "=" .. values[row.name]
    end
  end
  return parts
end

-- Gives a described point its key and the text of what its image depends on.
function sweep_plan.identify(point, described, base)
  local values = settings_at(point, described)
  point.description = described.description
  local parts = setting_texts(values, {})
  for _, text in ipairs { base.mode, described.description, point.describes, point.request.transport, base.measure_hash } do
    parts[#parts + 1] = text
  end
  point.key = core.text_hash(table.concat(parts, "\0"))
  local picture = setting_texts(values, settings.arrangement)
  picture[#picture + 1] = described.description
  local view = values.integrator == "cost" or values.integrator == "steps" -- of the structure itself
  picture[#picture + 1] = view and values.tracer .. values.builder or ""
  point.picture = table.concat(picture, "\0")
end

-- A point that could not be described has a key too, of its values alone.
function sweep_plan.fail(point, message)
  point.key = core.text_hash("failed\0" .. point.label)
  point.failed = message
end

-- ---- the reference ----

-- "samples=1024" or "workers=1, ior=1.5": for each point, the point with these values in the place of its own.
function sweep_plan.references(points, axes, text)
  local wanted, by_label = {}, {}
  for part in (text .. ","):gmatch "%s*(.-)%s*," do
    local name, value = part:match "^([%w_-]+)=(.*)$"
    local a
    for _, candidate in ipairs(axes) do
      a = candidate.name == name and candidate or a
    end
    local known = false
    for _, v in ipairs(a and a.values or {}) do
      known = known or v == value
    end
    if not a or not known then
      error({ status = 2, message = ("--reference: %s; it takes AXIS=VALUE with a value of that axis, as in %s=%s"):format(
        a and ("%s has no value '%s'"):format(name, value) or ("'%s' names no axis"):format(part), axes[1] and axes[1].name or "samples",
        axes[1] and axes[1].values[1] or "64"), usage = "sweep" }, 0)
    end
    wanted[name] = value
  end
  for _, p in ipairs(points) do
    by_label[p.label] = p
  end
  for _, p in ipairs(points) do
    local parts = {}
    for i, a in ipairs(axes) do
      parts[i] = a.name .. "=" .. (wanted[a.name] or p.values[a.name])
    end
    local other = by_label[table.concat(parts, ", ")]
    if other then
      p.compared, other.is_reference = other, true
    end
  end
end

-- ---- names of images ----

-- Letters, digits and a few marks of the label; the key's first digits where that is not all of it, or another point has the name.
function sweep_plan.name_images(points, axes)
  local taken = {}
  for _, p in ipairs(points) do
    local parts = {}
    for i, a in ipairs(axes) do
      parts[i] = a.name .. "-" .. p.values[a.name]
    end
    local exact = #parts > 0 and table.concat(parts, "_") or "image"
    local name = exact:gsub("[^%w_.-]", "-"):gsub("^[.-]", "_"):sub(1, 100)
    if name ~= exact or taken[name:lower()] then
      name = name .. "-" .. core.text_hash(p.label):sub(1, 8)
    end
    taken[name:lower()] = true
    p.file, p.saved = "images/" .. name .. ".png", false
  end
end

return sweep_plan
