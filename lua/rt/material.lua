-- Textures and materials.

local check = require "rt.check"
local class = require "rt.class"
local run = require "rt.run"
local image = require "rt.image"

local material = {}

local function file_name(value, who, key)
  return run.resolve(check.string(value, who, key))
end

-- rt.texture { file = "wood.png" } or { image = rt.image }
local new_texture, texture_meta = class.new {
  name = "texture", kind = "texture", example = [[rt.texture { file = "wood.png" }]],
  fields = {
    file = file_name, image = image.field, wrap = check.choice { "repeat", "clamp" }, linear = check.boolean, nearest = check.boolean,
  },
  finish = function(o, _, who)
    if (o.file == nil) == (o.image == nil) then
      check.fail("%s: give either file or image", who)
    end
    o.found = o.file
  end,
}
material.texture = new_texture

-- A field that takes a texture, an image or a file's name. Equal names are one texture (bare).
function material.texture_field(value, who, key)
  if getmetatable(value) == texture_meta then
    return value
  elseif type(value) == "string" then
    check.string(value, who, key)
    local texture = new_texture { file = value }
    rawset(texture, "bare", true)
    return texture
  elseif image.is(value) then
    return new_texture { image = value }
  end
  return check.fail("%s: %s must be a file's name, a texture as rt.texture { file = ... } or an image; got %s", who, key, check.describe(value))
end

-- The texture that a description has, or nil. What a script has given it since then is taken as the constructor would.
function material.texture_of(o, key)
  local texture = o[key]
  if texture ~= nil and getmetatable(texture) ~= texture_meta then
    texture = check.at(o.place, material.texture_field, texture, tostring(o), key)
    rawset(o, key, texture)
  end
  if texture and texture.file and texture.file ~= texture.found then
    rawset(texture, "file", check.at(texture.place, file_name, texture.file, tostring(texture), "file"))
    rawset(texture, "found", texture.file)
  elseif texture and not texture.file and not texture.image then
    check.at(texture.place, check.fail, "%s: give either file or image", tostring(texture))
  end
  return texture
end

local weight = check.number { low = 0, high = 1 }

-- The model of paper 000 with a highlight: each part has its weight.
material.classic = class.new {
  name = "classic", kind = "material", example = "rt.classic { color = {1, 0, 0} }",
  fields = {
    color = check.color(1), texture = material.texture_field, diffusion = weight, reflectiveness = weight, transparency = weight,
    refractiveness = check.number { low = 0, high = 10 }, ambient = weight, specular = check.number { low = 0, most = 1e6 },
    shininess = check.number { low = 1, high = 100000 }, alpha_texture = material.texture_field, alpha_cut = weight,
    opaque_shadow = check.boolean,
  },
  shared = { model = "classic" },
}

-- A body that shines and scatters nothing.
material.emissive = class.new {
  name = "emissive", kind = "material", example = "rt.emissive { emission = {4, 4, 4} }",
  fields = { emission = check.color() }, required = { "emission" }, shared = { model = "emissive" },
}

material.field = class.field("material", "rt.classic { ... } gives it")

return material
