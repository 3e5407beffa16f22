-- Reader of the old scene definition files. The grammar, and our reading of each doubtful number of the printed figure, stand in scenes/SDF.md.
-- The reader works in one pass and hands each object on as soon as it is whole: sdf.read(lexer, sink) calls sink.header(h) once and
-- sink.object(o) in the order of the file. sdf.load makes a scene of them, sdf_script.lua a Lua script.

local lexer = require "rt.sdf_lexer"
local hints = require "rt.sdf_hints"
local words = require "rt.words"

local sdf = {}

local FLOAT_MAX = 3.4028234e38

-- What a key takes: count of numbers (or a range of counts), limits, how the value is named in the result; `many` keys may be repeated.
local HEADER = {
  VIEWPOINT  = { field = "viewpoint", count = 3 },
  LIGHTPOINT = { field = "lightpoint", count = 3 },
  AMBIENT    = { field = "ambient", count = 3, low = 0 },
  LOOKAT     = { field = "lookat", count = 3 },
  UP         = { field = "up", count = 3, nonzero = true },
  FOV        = { field = "fov", count = 1, above = 0, below = 180 },
}
local MATERIAL = {
  COLOR          = { field = "color", count = 3, low = 0, high = 1 },
  REFRACTIVENESS = { field = "refractiveness", count = 1, low = 0, high = 10 },
  TRANSPARENCY   = { field = "transparency", count = 1, low = 0, high = 1 },
  REFLECTIVENESS = { field = "reflectiveness", count = 1, low = 0, high = 1 },
  DIFFUSION      = { field = "diffusion", count = 1, low = 0, high = 1 },
}
local CENTER = { field = "center", count = 3 }
local RADIUS = { field = "radius", count = 1, above = 0 }
local TEXTURE = { field = "texture", name = true }

local function with_material(keys)
  for key, rule in pairs(MATERIAL) do
    keys[key] = rule
  end
  return keys
end

local OBJECTS = {
  LIGHT  = { keys = with_material { CENTER = CENTER, RADIUS = RADIUS }, needs = { "CENTER", "RADIUS" } },
  SPHERE = { keys = with_material { CENTER = CENTER, RADIUS = RADIUS, TEXTURE = TEXTURE }, needs = { "CENTER", "RADIUS" } },
  PLANE  = {
    keys = with_material {
      CENTER = CENTER, NORMAL = { field = "normal", count = 3, nonzero = true }, TEXTURE = TEXTURE,
      TEXTURESIZE = { field = "texturesize", count = 1, most = 2, above = 0 },
    },
    needs = { "CENTER", "NORMAL" },
  },
  POLYHEDRON = {
    keys = with_material {
      VERTEX = { field = "vertices", count = 3, many = true },
      FACE = { field = "faces", count = 3, most = 65535, many = true, whole = true, low = 1 },
    },
    needs = { "VERTEX", "FACE" },
  },
}

local function sorted_keys(t)
  local list = {}
  for key in pairs(t) do
    list[#list + 1] = key
  end
  table.sort(list)
  return list
end

-- Every word of the language, to tell a forgotten value from a strange one.
local WORDS = { BEGIN_SCENE = true, END_SCENE = true }
for _, keys in ipairs { HEADER, OBJECTS } do
  for key in pairs(keys) do
    WORDS[key] = true
  end
end
for _, object in pairs(OBJECTS) do
  for key in pairs(object.keys) do
    WORDS[key] = true
  end
end

local function keyword(lex)
  return lex.kind == "word" and lex.text:upper() or nil
end

-- "the end of the file" or the quoted token, for messages.
local function seen(lex)
  return lex.kind == "end" and lex.text or "'" .. words.quote(lex.text) .. "'"
end

-- The numbers behind a key: a list separated by commas.
local function read_numbers(lex, key, rule)
  local values, texts, line = {}, {}, lex.at
  lex:advance()
  local most = rule.most or rule.count
  local wanted = hints.count(rule.count, most)
  if lex.kind ~= "number" then
    if lex.kind == "end" or WORDS[keyword(lex) or ""] then
      lex:fail(line, "%s has no value; it takes %s", key, wanted)
    end
    lex:fail(nil, "%s takes %s, but %s is no number", key, wanted, seen(lex))
  end
  while true do
    values[#values + 1], texts[#texts + 1] = lex.value, lex.text
    if #values > 70000 then
      lex:fail(line, "%s takes %s, but a list of more than 70000 stands here", key, wanted)
    end
    lex:advance()
    if lex.kind ~= "comma" then
      break
    end
    lex:advance()
    if lex.kind ~= "number" then
      lex:fail(nil, "a number must follow the comma behind %s %s, but %s stands here", key, texts[#texts], seen(lex))
    end
  end
  if #values < rule.count or #values > most then
    local behind = lex.kind == "number" and #values < rule.count and " (separate them with commas)" or ""
    lex:fail(line, "%s takes %s, not %d: %s%s%s", key, wanted, #values, hints.list(texts), hints.counts(texts, rule), behind)
  end
  return values, texts, line
end

local function check_range(lex, key, rule, values, texts, line)
  local all_zero = true
  for i, v in ipairs(values) do
    all_zero = all_zero and v == 0
    if not (v >= -FLOAT_MAX and v <= FLOAT_MAX) then
      lex:fail(line, "%s %s is beyond what a single precision number can hold", key, words.quote(texts[i]))
    end
    if not hints.fits(rule, v) then
      lex:fail(line, "%s is %s; it must be %s%s", key, words.quote(texts[i]), hints.range(rule), hints.lost_point(texts[i], rule))
    end
    if rule.whole and v ~= math.floor(v) then
      lex:fail(line, "%s counts vertices, and %s is not a whole number", key, texts[i])
    end
  end
  if rule.nonzero and all_zero then
    lex:fail(line, "%s 0,0,0 is no direction", key)
  end
end

local function read_name(lex, key)
  local line = lex.at
  lex:advance()
  if lex.kind == "end" or lex.kind == "comma" or WORDS[keyword(lex) or ""] then
    local quote = lex.kind == "word" and "; put it in quotes if " .. lex.text .. " is the file's name" or ""
    lex:fail(line, "%s has no value; it takes the name of an image file%s", key, quote)
  end
  local text = lex.text
  if text == "" or text:find("\0", 1, true) then
    lex:fail(nil, "%s takes the name of an image file; this one is empty or holds a NUL byte", key)
  end
  lex:advance()
  if lex.kind == "comma" then
    lex:fail(nil, "a comma follows the name of %s; a name with a comma or a blank is put in quotes", key)
  end
  return text
end

-- One key with its value into `into`.
local function read_key(lex, key, rule, into, owner)
  local line = lex.at
  if into[rule.field] ~= nil and not rule.many then
    lex:fail(line, "%s stands twice in this %s", key, owner)
  end
  if rule.name then
    into[rule.field] = read_name(lex, key)
    return
  end
  local values, texts = read_numbers(lex, key, rule)
  check_range(lex, key, rule, values, texts, line)
  local value = (rule.count == 1 and not rule.most) and values[1] or values
  if rule.many then
    local list = into[rule.field]
    if not list then
      list = {}
      into[rule.field] = list
    end
    list[#list + 1] = value
    if key == "FACE" then
      value.line = line
    end
  else
    into[rule.field] = value
  end
end

local function unknown(lex, names, where)
  local near = words.nearest(lex.text:upper(), names)
  local advice = near and ("; was " .. near .. " meant?") or ("; known are " .. table.concat(names, ", "))
  lex:fail(nil, "%s is no word of %s%s", seen(lex), where, advice)
end

local function read_header(lex)
  lex:advance()
  if keyword(lex) ~= "BEGIN_SCENE" then
    lex:fail(nil, "a scene definition begins with BEGIN_SCENE, but %s stands here", seen(lex))
  end
  local header, opened = { line = lex.at }, lex.at
  lex:advance()
  while keyword(lex) ~= "END_SCENE" do
    local word = keyword(lex)
    local rule = word and HEADER[word]
    if rule then
      read_key(lex, word, rule, header, "header")
    elseif lex.kind == "end" or OBJECTS[word] then
      lex:fail(nil, "END_SCENE is missing: the header that BEGIN_SCENE opened in line %d must be closed before %s", opened, seen(lex))
    elseif word == "BEGIN_SCENE" then
      lex:fail(nil, "BEGIN_SCENE stands twice (the first is in line %d)", opened)
    elseif lex.kind == "number" or lex.kind == "comma" then
      lex:fail(nil, "%s stands where a word of the header is expected", seen(lex))
    else
      unknown(lex, sorted_keys(HEADER), "the header")
    end
  end
  if not header.viewpoint then
    lex:fail(nil, "the header has no VIEWPOINT, so nobody looks at the scene; add VIEWPOINT x,y,z")
  end
  lex:advance()
  return header
end

-- FACE corners must name vertices, which may stand behind the face.
local function check_faces(lex, object)
  local count = #object.vertices
  for _, face in ipairs(object.faces) do
    local used = {}
    for _, corner in ipairs(face) do
      if corner > count then
        lex:fail(face.line, "FACE names vertex %d, but this POLYHEDRON has %d (they count from 1)", corner, count)
      end
      if used[corner] then
        lex:fail(face.line, "FACE names vertex %d twice", corner)
      end
      used[corner] = true
    end
  end
end

local function read_object(lex)
  local kind = keyword(lex)
  local rules = OBJECTS[kind]
  if not rules then
    if kind == "BEGIN_SCENE" or kind == "END_SCENE" then
      lex:fail(nil, "%s stands twice; the header is closed already", kind)
    elseif HEADER[kind] then
      lex:fail(nil, "%s belongs into the header, between BEGIN_SCENE and END_SCENE", kind)
    elseif lex.kind ~= "word" or MATERIAL[kind] or WORDS[kind] then
      lex:fail(nil, "%s stands where an object is expected (%s)", seen(lex), table.concat(sorted_keys(OBJECTS), ", "))
    end
    unknown(lex, sorted_keys(OBJECTS), "this language for an object")
  end
  local object = { kind = kind, line = lex.at }
  lex:advance()
  while lex.kind ~= "end" do
    local word = keyword(lex)
    local rule = word and rules.keys[word]
    if rule then
      read_key(lex, word, rule, object, kind)
    elseif OBJECTS[word] then
      break
    elseif word == "BEGIN_SCENE" or word == "END_SCENE" or HEADER[word] then
      break -- read_object's next call explains it
    elseif lex.kind == "word" and WORDS[word] then
      lex:fail(nil, "a %s has no %s; it takes %s", kind, word, table.concat(sorted_keys(rules.keys), ", "))
    elseif lex.kind == "word" then
      local names = sorted_keys(rules.keys)
      table.move(sorted_keys(OBJECTS), 1, 4, #names + 1, names)
      unknown(lex, names, "a " .. kind)
    else
      lex:fail(nil, "%s stands where a word is expected", seen(lex))
    end
  end
  for _, key in ipairs(rules.needs) do
    if object[rules.keys[key].field] == nil then
      lex:fail(object.line, "this %s has no %s", kind, key)
    end
  end
  if object.texturesize and not object.texture then
    lex:fail(object.line, "this PLANE has a TEXTURESIZE but no TEXTURE")
  end
  if kind == "POLYHEDRON" then
    check_faces(lex, object)
  end
  return object
end

-- Reads a whole file. sink.header(header) comes first, then sink.object(object) for each, both with defaults still unset.
function sdf.read(lex, sink)
  sink.header(read_header(lex))
  while lex.kind ~= "end" do
    sink.object(read_object(lex))
  end
end

-- A lexer over a string, or over a file; the caller closes the file.
function sdf.over_text(text, name)
  local at = 1
  return lexer.new(function(n)
    if at > #text then
      return nil
    end
    local block = text:sub(at, at + n - 1)
    at = at + n
    return block
  end, name)
end

function sdf.over_file(file, name)
  return lexer.new(function(n)
    local block, why = file:read(n)
    return block, why
  end, name)
end

return sdf
