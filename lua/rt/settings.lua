-- Settings: what a render does that is no part of the picture's description. The command line wins over the chosen set, that over the script's
-- `settings`, those over the built-in ones.

local core = require "rt.core"
local check = require "rt.check"
local words = require "rt.words"

local settings = {}

-- In the order in which they are listed. kind says how a text (command line) is read; `commit` settings are those of trees.
settings.list = {
  { name = "width", kind = "integer", low = 1, high = 1048576, help = "width of the image in pixels" },
  { name = "height", kind = "integer", low = 1, high = 1048576, help = "height of the image in pixels" },
  { name = "samples", kind = "integer", low = 1, high = 65536, help = "samples a pixel" },
  { name = "integrator", kind = "choice", source = "integrators", help = "what a pixel shows" },
  { name = "max_depth", kind = "integer", low = 0, high = 64, help = "bounces at most" },
  { name = "seed", kind = "integer", low = 0, high = math.maxinteger, help = "seed of the samples" },
  { name = "shadows", kind = "boolean", help = "false: lights are never shadowed" },
  { name = "shadow_samples", kind = "integer", low = 0, high = 4096, help = "rays to a spherical light a hit; 0: chosen" },
  { name = "opaque_shadows", kind = "boolean", help = "transparent bodies cast full shadows" },
  { name = "ao_samples", kind = "integer", low = 0, high = 4096, help = "ambient occlusion: rays a hit; 0: chosen" },
  { name = "ao_distance", kind = "number", low = 0, help = "ambient occlusion: reach; 0: a tenth of the scene" },
  { name = "filter", kind = "choice", choices = { "box", "gaussian" }, help = "pixel filter" },
  { name = "filter_width", kind = "number", low = 0, high = 16, help = "width of the filter in pixels; 0: its own" },
  { name = "tracer", kind = "choice", source = "tracers", help = "structure that answers rays; no effect on the picture" },
  { name = "workers", kind = "integer", low = 0, high = 1024, help = "threads that compute; 0: all CPUs" },
  { name = "tile", kind = "integer", low = 1, high = 4096, help = "edge of a tile in pixels" },
  { name = "schedule", kind = "choice", choices = { "dynamic", "static" }, help = "how tiles are given out" },
  { name = "memory_limit", kind = "integer", low = 0, high = math.maxinteger, help = "bytes a render may take; 0: what is free" },
  { name = "crop", kind = "crop", help = "part of the image that is rendered" },
  { name = "accel", kind = "text", commit = true, help = "trees that are built: auto (bvh), kdtree, octree, bvh, brute, or several with commas" },
  { name = "builder", kind = "choice", choices = { "auto", "exact", "binned", "paper", "compact", "spatial" }, commit = true,
    help = "of the kd-tree: exact, binned, paper; of the BVH: compact, spatial" },
  { name = "tree_depth", kind = "integer", low = 0, high = 4096, commit = true, help = "depth of the tree at most; 0: the builder's own" },
  { name = "leaf_size", kind = "integer", low = 0, high = 65535, commit = true, help = "primitives of a leaf; 0: the builder's own" },
  { name = "cost_traverse", kind = "number", low = 0, commit = true, help = "cost of a step in the tree; 0: the builder's own" },
  { name = "cost_intersect", kind = "number", low = 0, commit = true, help = "cost of a primitive's test; 0: the builder's own" },
  { name = "empty_bonus", kind = "number", low = 0, high = 1, commit = true, help = "bonus for cutting off empty space; 0: the builder's own" },
  { name = "duplication", kind = "number", low = 0, commit = true, help = "references a primitive at most; 0: the builder's own" },
  { name = "refit", kind = "number", low = 0, high = 1e6, commit = true,
    help = "of the BVH where vertices have moved: how many times more or less it may cost before it is built anew (1.25); 0: always built" },
}

-- Settings that change no bit of the picture.
settings.arrangement = {
  workers = true, tile = true, schedule = true, tracer = true, memory_limit = true, accel = true, builder = true, tree_depth = true, leaf_size = true,
  cost_traverse = true, cost_intersect = true, empty_bonus = true, duplication = true, refit = true, preview = true,
}

-- Names that sweeps have for axes besides the settings; like these, no parameter can bear them.
settings.reserved = { set = true, transport = true }

local function crop(value, who, key)
  local n = check.integer { low = 0, high = 1048576 }
  if type(value) ~= "table" then
    check.fail("%s: %s must be { x = ..., y = ..., width = ..., height = ... }; got %s", who, key, check.describe(value))
  end
  local o = check.fields(value, { x = n, y = n, width = n, height = n }, who .. ": " .. key)
  check.required(o, { "x", "y", "width", "height" }, who .. ": " .. key)
  return o
end

local function names_of(source)
  local names = {}
  for i, row in ipairs(core[source]()) do
    names[i] = row.name
  end
  return names
end

local function field_of(row)
  if row.kind == "integer" then
    return check.integer(row)
  elseif row.kind == "number" then
    return check.number(row)
  elseif row.kind == "boolean" then
    return check.boolean
  elseif row.kind == "choice" then
    row.choices = row.choices or names_of(row.source)
    return check.choice(row.choices)
  elseif row.kind == "crop" then
    return crop
  end
  return check.string
end

settings.by_name, settings.fields = {}, {}
for _, row in ipairs(settings.list) do
  settings.by_name[row.name] = row
  settings.fields[row.name] = field_of(row)
end

-- size = {1000, 700} stands for width and height.
function settings.fields.size(value, who, key)
  if type(value) ~= "table" or #value ~= 2 then
    check.fail("%s: %s must be {width, height}; got %s", who, key, check.describe(value))
  end
  return { settings.fields.width(value[1], who, key .. "[1]"), settings.fields.height(value[2], who, key .. "[2]") }
end

-- The checked copy of a table of settings.
function settings.check(t, who)
  if type(t) ~= "table" then
    check.fail("%s must be a table, as { width = 800, samples = 4 }; got %s", who, check.describe(t))
  end
  check.keys(t, settings.fields, who, "setting")
  local o = check.fields(t, settings.fields, who)
  if o.size then
    o.width, o.height, o.size = o.size[1], o.size[2], nil
  end
  return o
end

local readers = {
  integer = function(text) return math.tointeger(tonumber(text)) end,
  number = function(text) return tonumber(text) end,
  boolean = function(text)
    if text == "true" or text == "yes" or text == "1" then
      return true
    elseif text == "false" or text == "no" or text == "0" then
      return false
    end
  end,
}

local KIND_WORDS = { integer = "a whole number", number = "a number", boolean = "true or false" }

-- A setting from a text, as a command line gives it.
function settings.read(name, text, who)
  if name == "size" then
    local w, h = text:match "^(%d+)[xX](%d+)$"
    if not w then
      check.fail("%s: size must be WIDTHxHEIGHT, as 1000x700; got '%s'", who, words.quote(text))
    end
    return settings.fields.size({ math.tointeger(tonumber(w)) or 0, math.tointeger(tonumber(h)) or 0 }, who, name)
  end
  local row = settings.by_name[name] or check.unknown(who, name, settings.fields, "setting")
  local reader = readers[row.kind]
  local value = text
  if reader then
    value = reader(text)
    if value == nil then
      check.fail("%s: %s must be %s; got '%s'", who, name, KIND_WORDS[row.kind], words.quote(text))
    end
  end
  return settings.fields[name](value, who, name)
end

-- The built-in settings: the library's, with a size and a quality that one looks at.
function settings.defaults()
  local values = core.render_defaults()
  values.width, values.height, values.samples = 800, 600, 16
  return values
end

-- Layers from the weakest to the strongest, each { values, source }: the values that hold, and where each comes from.
function settings.merge(layers)
  local values, sources = settings.defaults(), {}
  for name in pairs(values) do
    sources[name] = "built in"
  end
  for _, layer in ipairs(layers) do
    for name, value in pairs(layer[1]) do
      values[name], sources[name] = value, layer[2]
    end
  end
  return values, sources
end

return settings
