-- What an old scene definition means in constructors of the module rt. Each object becomes a node { constructor, { key, value }, ... }:
-- sdf_scene.load calls the constructors, sdf_script.lua prints them, so that both give the same scene.

local guard = require "rt.guard"
local sdf = require "rt.sdf"

local scene = {}

-- The file names no size: it is rendered as large as the paper's second picture.
scene.settings = { "", { "width", 1000 }, { "height", 700 }, { "samples", 4 } }

-- Width of a texture on a plane that gives no TEXTURESIZE: the paper's scene is measured in pixels, and its small picture is 500 wide.
local TEXTURE_WIDTH = 500

local WHITE = { 1, 1, 1 }

local function material(object, texture_path)
  local node = {
    "classic", { "color", object.color or WHITE }, { "refractiveness", object.refractiveness or 0 }, { "transparency", object.transparency or 0 },
    { "reflectiveness", object.reflectiveness or 0 }, { "diffusion", object.diffusion or 1 },
  }
  if object.texture then
    node[#node + 1] = { "texture", texture_path(object.texture) }
  end
  return node
end

local shapes = {}

function shapes.SPHERE(object, with)
  return { "sphere", { "center", object.center }, { "radius", object.radius }, { "material", with } }
end

shapes.LIGHT = shapes.SPHERE -- a visible body; LIGHTPOINT is what illuminates

function shapes.PLANE(object, with)
  local node = { "plane", { "point", object.center }, { "normal", object.normal }, { "material", with } }
  if object.texture then
    local size = object.texturesize or { TEXTURE_WIDTH }
    node[#node + 1] = { "texture_size", size[1] }
    if size[2] then
      node[#node + 1] = { "texture_height", size[2] }
    end
  end
  return node
end

function shapes.POLYHEDRON(object, with)
  return { "polyhedron", { "vertices", object.vertices }, { "faces", object.faces }, { "material", with } }
end

-- texture_path(name): the name as the scene shall have it.
function scene.object(object, texture_path)
  return shapes[object.kind](object, material(object, texture_path))
end

-- The view goes along -z: to z = 0 when the viewer stands before it, else past him.
local function look_at(header)
  local x, y, z = table.unpack(header.viewpoint)
  return header.lookat or { x, y, z >= 1 and 0 or z - (1 + math.abs(z)) }
end

function scene.camera(header)
  local node = { "camera", { "eye", header.viewpoint }, { "look_at", look_at(header) }, { "fov", header.fov or 50 } }
  if header.up then
    node[#node + 1] = { "up", header.up }
  end
  return node
end

function scene.ambient(header)
  return header.ambient or { 0, 0, 0 }
end

-- nil without a LIGHTPOINT.
function scene.light(header)
  return header.lightpoint and { "point_light", { "at", header.lightpoint } } or nil
end

-- Reads a file with a sink, naming it in every message.
function scene.read(path, sink)
  local file, why = guard.open(path)
  if not file then
    error(why, 0)
  end
  local ok, message = pcall(sdf.read, sdf.over_file(file, path), sink)
  file:close()
  if not ok then
    error(message, 0)
  end
end

local function build(rt, node)
  local fields = {}
  for i = 2, #node do
    local key, value = node[i][1], node[i][2]
    fields[key] = type(value) == "table" and type(value[1]) == "string" and build(rt, value) or value
  end
  return node[1] == "" and fields or rt[node[1]](fields)
end

-- The scene of the file at `path`, made with the constructors of `rt`. Equal materials are made once.
function scene.load(rt, path)
  local folder = path:match "^(.*/)[^/]*$" or ""
  local function texture_path(name)
    return name:sub(1, 1) == "/" and name or folder .. name
  end
  local description, materials = {}, {}
  local function shared(node)
    local parts = {}
    for i = 2, #node do
      local value = node[i][2]
      parts[i - 1] = type(value) == "table" and table.concat(value, ",") or tostring(value)
    end
    local key = table.concat(parts, "\0")
    local made = materials[key]
    if not made then
      made = build(rt, node)
      materials[key] = made
    end
    return made
  end
  scene.read(path, {
    header = function(header)
      description.settings = build(rt, scene.settings)
      description.camera = build(rt, scene.camera(header))
      description.ambient = scene.ambient(header)
      local light = scene.light(header)
      description[1] = light and build(rt, light)
    end,
    object = function(object)
      local node = scene.object(object, texture_path)
      for i = 2, #node do
        if node[i][1] == "material" then
          node[i][2] = shared(node[i][2])
        end
      end
      description[#description + 1] = build(rt, node)
    end,
  })
  return rt.scene(description)
end

return scene
