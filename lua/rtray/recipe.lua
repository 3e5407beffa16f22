-- What an image says about how it was made, so that `rtray replay` can make it again: the script with its modules, parameters, settings, library
-- version, hash of the described scene, and the files that were read by relative name and SHA-256. One JSON text: the entry "Recipe" of PNG and HDR
-- files, a file NAME.json beside the others. It names no user, no time and no absolute path: equal pictures make equal files.

local sys = require "rtray.sys"
local files = require "rtray.files"
local json = require "rt.json"
local run = require "rt.run"
local sandbox = require "rtray.sandbox"
local types = require "rtray.types"

local recipe = {}

local FORM = 1
local TEXT_MAX = 2 ^ 20 | 0    -- bytes of scripts that an image takes along
local READ_MAX = 16 * TEXT_MAX -- bytes of a recipe that is read

-- ---- names ----

-- Path without ".", ".." and doubled slashes.
local function plain(path)
  local parts = {}
  for part in run.absolute(path):gmatch "[^/]+" do
    if part == ".." then
      parts[#parts] = nil
    elseif part ~= "." then
      parts[#parts + 1] = part
    end
  end
  return "/" .. table.concat(parts, "/")
end

-- The name below the scene's folder, or the last part and true.
local function name_below(path, folder)
  path, folder = plain(path), plain(folder)
  if folder == "/" or path:sub(1, #folder + 1) ~= folder .. "/" then
    return path:match "[^/]*$", true
  end
  return path:sub(#folder + 2)
end

-- ---- texts of any bytes in JSON ----

local DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"

local function to_base64(s)
  return (s:gsub("..?.?", function(three)
    local a, b, c = three:byte(1, 3)
    local n = a << 16 | (b or 0) << 8 | (c or 0)
    local out = {}
    for i = 1, 4 do
      local digit = n >> (24 - 6 * i) & 63
      out[i] = i <= #three + 1 and DIGITS:sub(digit + 1, digit + 1) or "="
    end
    return table.concat(out)
  end))
end

local VALUES = {}
for i = 1, #DIGITS do
  VALUES[DIGITS:byte(i)] = i - 1
end

local function from_base64(s)
  if #s % 4 ~= 0 or s:find "[^%w+/=]" then
    return nil
  end
  return (s:gsub("....", function(four)
    local n, count = 0, 3
    for i = 1, 4 do
      local c = four:byte(i)
      if c == 61 then
        count = math.min(count, i - 2)
      end
      n = n << 6 | (VALUES[c] or 0)
    end
    return string.pack(">I3", n):sub(1, count)
  end))
end

-- ---- writing ----

local hashed = {} -- by path: a film reads the same files for every frame

local function hash_of(path)
  local kind, size, changed, inode = sys.stat(path)
  local stamp = ("%s %s %s %s"):format(kind, size, changed, inode)
  if kind ~= "file" then
    return nil
  elseif not hashed[path] or hashed[path].stamp ~= stamp then
    local hash, bytes = sys.sha256_file(path)
    hashed[path] = { stamp = stamp, hash = hash, bytes = bytes }
  end
  return hashed[path].hash, hashed[path].bytes
end

-- The files of a run: the scene itself, then the others in the order of their names. facts: what the program knows of the run.
local function files_of(r, facts)
  local list, seen, left = {}, {}, TEXT_MAX
  local reads = sandbox.reads(r)
  local function take(path, text, name, outside)
    if seen[plain(path)] then
      return
    end
    seen[plain(path)] = true
    local entry = { name = name, outside = outside }
    if text then
      entry.hash, entry.bytes = sys.sha256(text), #text
      if #text <= left then
        left = left - #text
        entry.text = text
      end
    else
      entry.hash, entry.bytes = hash_of(path)
    end
    if entry.hash then
      list[#list + 1] = entry
    end
  end
  local others = {}
  for path, text in pairs(reads) do
    local name, outside = name_below(path, facts.folder)
    others[#others + 1] = { path = path, text = type(text) == "string" and text or nil, name = name, outside = outside }
  end
  table.sort(others, function(a, b)
    return a.name < b.name or a.name == b.name and a.path < b.path
  end)
  take(facts.path, facts.text or type(reads[facts.path]) == "string" and reads[facts.path] or nil, files.name_of(facts.path))
  for _, other in ipairs(others) do
    take(other.path, other.text, other.name, other.outside)
  end
  return list
end

local function file_json(entry)
  local object = json.object():set("name", entry.name):set("outside", entry.outside):set("bytes", entry.bytes):set("sha256", entry.hash)
  if entry.text and utf8.len(entry.text) and not entry.text:find "\0" then
    return object:set("text", entry.text)
  end
  return object:set("base64", entry.text and to_base64(entry.text))
end

-- Parameters of the command line as they were written; of a file its name and hash.
local function parameters_of(r, facts)
  local list, types_of = {}, {}
  for _, p in ipairs(r.params) do
    types_of[p.name] = p.type
  end
  for _, define in ipairs(facts.define) do
    local object = json.object():set("name", define.name)
    if types_of[define.name] == "file" then
      local name, outside = name_below(define.text, facts.folder)
      list[#list + 1] = object:set("file", name):set("outside", outside):set("sha256", (hash_of(define.text)))
    elseif utf8.len(define.text) then
      list[#list + 1] = object:set("text", define.text)
    else
      list[#list + 1] = object:set("base64", to_base64(define.text))
    end
  end
  return list
end

local SAVE = { "exposure", "tone", "bits", "quality", "alpha" }

local facts_of = setmetatable({}, { __mode = "k" })

-- Keeps what the command line said of a run, apart from the run itself, which scripts reach.
function recipe.remember(r, path, values)
  facts_of[r] = {
    path = path, folder = files.folder_of(path), define = values.define or {}, set = values.set, seed = values.seed or 0,
    view = (values.eye or values.at or values.fov) and { eye = values.eye, at = values.at, fov = values.fov } or nil,
    text = files.ending_of(path) == "sdf" and sandbox.text(path) or nil,
  }
end

-- The recipe's text for an image of opened = { scene, run, frame } with these settings, saved so, or nil. settings_json: of the settings that
-- decide a picture.
function recipe.of(opened, settings_json, save)
  local r = opened.run
  local facts = facts_of[r]
  if not facts then
    return nil
  end
  local entries = {}
  for i, entry in ipairs(files_of(r, facts)) do
    entries[i] = file_json(entry)
  end
  local saved = json.object()
  for _, name in ipairs(SAVE) do
    saved:set(name, save and save[name])
  end
  local view = facts.view and json.object():set("eye", facts.view.eye):set("at", facts.view.at):set("fov", facts.view.fov)
  return json.encode(json.object():set("recipe", FORM):set("librt", require("rt").version):set("scene", files.name_of(facts.path))
    :set("set", facts.set):set("seed", facts.seed):set("frame", opened.frame):set("view", view):set("parameters", parameters_of(r, facts))
    :set("settings", settings_json):set("save", saved):set("description", opened.scene:hash()):set("files", entries))
end

local INSIDE = { png = true, hdr = true }

-- Puts the texts beside an image whose format has no room for them.
function recipe.beside(path, format, texts)
  format = format or files.ending_of(path)
  if INSIDE[format] or path == "-" or sys.stat(path) ~= "file" or not texts.Recipe then
    return
  end
  local names, object = {}, json.object()
  for name in pairs(texts) do
    names[#names + 1] = name
  end
  table.sort(names)
  for _, name in ipairs(names) do
    object:set(name, texts[name])
  end
  files.replace(path .. ".json", json.encode(object) .. "\n")
end

-- ---- reading ----

local function broken(path, what)
  error({ status = 1, message = ("%s: the recipe is broken: %s"):format(types.quote(path), what) }, 0)
end

local function texts_of(path)
  local kind, why = sys.stat(path)
  if kind ~= "file" then
    error({ status = 1, message = ("%s cannot be read: %s"):format(types.quote(path), kind and "it is no regular file" or why) }, 0)
  end
  local texts = require("rt").image_text(path)
  local side, size = sys.stat(path .. ".json")
  if not texts.Recipe and side == "file" and size <= READ_MAX then
    local file = io.open(path .. ".json", "rb")
    local found = file and json.decode(file:read "a")
    if file then
      file:close()
    end
    texts = type(found) == "table" and found or texts
  end
  if type(texts.Recipe) ~= "string" then
    error({ status = 1, message = ("%s holds no recipe: it was not made by rtray, with --no-metadata, or another program has dropped it"):format(
      types.quote(path)) }, 0)
  elseif #texts.Recipe > READ_MAX then
    broken(path, ("it has %d bytes; %d are read"):format(#texts.Recipe, READ_MAX))
  end
  return texts
end

local function is_name(name)
  return type(name) == "string" and #name > 0 and #name <= 4096 and name:sub(1, 1) ~= "/" and not name:find "[%c]"
    and not ("/" .. name .. "/"):find("/../", 1, true)
end

local function optional(value, kind)
  return value == nil or type(value) == kind
end

local function check_file(path, entry)
  if type(entry) ~= "table" or not is_name(entry.name) then
    broken(path, ("the name of a file, %s, is none below a folder"):format(
      type(entry) == "table" and type(entry.name) == "string" and types.quote(entry.name) or "which is no text"))
  elseif type(entry.sha256) ~= "string" or not (optional(entry.text, "string") and optional(entry.base64, "string")) then
    broken(path, ("what it says of %s"):format(types.quote(entry.name)))
  end
  entry.text = entry.text or entry.base64 and from_base64(entry.base64)
  if entry.text and sys.sha256(entry.text) ~= entry.sha256 then
    broken(path, ("the text of %s has another hash than it says"):format(types.quote(entry.name)))
  end
end

local function is_point(value)
  return value == nil or type(value) == "table" and #value == 3 and math.type(value[1]) and math.type(value[2]) and math.type(value[3])
end

local function is_view(view)
  return type(view) == "table" and is_point(view.eye) and is_point(view.at) and optional(view.fov, "number")
end

-- The recipe of an image: a table as recipe.of writes it, checked; `image`: hash of the picture's pixels, or nil.
function recipe.read(path)
  local texts = texts_of(path)
  local r, why = json.decode(texts.Recipe)
  if type(r) ~= "table" then
    broken(path, why or "it is no object")
  elseif r.recipe ~= FORM then
    error({ status = 1, message = ("%s: the recipe is of form %s; this version reads %d"):format(types.quote(path), types.quote(tostring(r.recipe)),
      FORM) }, 0)
  end
  local shape = {
    librt = "string", scene = "string", description = "string", parameters = "table", settings = "table", save = "table", files = "table",
  }
  for _, key in ipairs { "description", "files", "librt", "parameters", "save", "scene", "settings" } do
    if type(r[key]) ~= shape[key] then
      broken(path, key .. " is missing")
    end
  end
  if not is_name(r.scene) or r.scene:find "/" or r.scene:sub(1, 1) == "." or not (optional(r.set, "string") and math.type(r.seed) == "integer") or
    not (r.frame == nil or math.type(r.frame) == "integer" and r.frame >= 0) then
    broken(path, "the scene, set, seed or frame")
  elseif r.view ~= nil and not is_view(r.view) then
    broken(path, "the view")
  end
  for _, entry in ipairs(r.files) do
    check_file(path, entry)
  end
  for _, p in ipairs(r.parameters) do
    if type(p) == "table" and type(p.base64) == "string" then
      p.text = from_base64(p.base64)
    end
    if type(p) ~= "table" or type(p.name) ~= "string" or not (type(p.text) == "string" or is_name(p.file)) then
      broken(path, "a parameter")
    end
  end
  r.image = type(texts.Hash) == "string" and texts.Hash or nil
  return r
end

return recipe
