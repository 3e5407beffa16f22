-- rtray info: what this build is; rtray info SCENE: what the scene holds, the memory it takes, its trees.

local json = require "rtray.json"
local output = require "rtray.output"
local source = require "rtray.source"
local trees = require "rtray.trees"

local info = {}

-- What the machine is; a wrong RT_ISA is told of here.
local function machine_of(rt)
  rt.on_log(function(_, message)
    output.note("rtray: %s", message)
  end)
  local machine = rt.machine()
  require("rt.log").deliver()
  return machine
end

function info.version()
  local rt = require "rt"
  output.print("rtray %s (%s)", rt.version, machine_of(rt).isa)
  return 0
end

-- "lua=5.4 stb=yes png=yes" as pairs, in its order.
local function build_parts(text)
  local parts = {}
  for key, value in text:gmatch "(%S+)=(%S+)" do
    parts[#parts + 1] = { key, value }
  end
  return parts
end

local function names_of(list)
  local names = {}
  for i, row in ipairs(list) do
    names[i] = row.name
  end
  return names
end

local function build(values)
  local rt = require "rt"
  local machine = machine_of(rt)
  local integrators, tracers = names_of(rt.integrators()), names_of(rt.tracers())
  if values.json then
    local parts = json.object()
    for _, pair in ipairs(build_parts(rt.build)) do
      parts:set(pair[1], pair[2])
    end
    output.print("%s", json.encode(json.object():set("version", rt.version):set("build", parts):set("cpus", machine.cpus):set("isa", machine.isa)
      :set("workers", machine.workers):set("memory_available", machine.memory_available):set("integrators", integrators):set("tracers", tracers)))
    return 0
  end
  output.print("librt %s (%s), %s", rt.version, rt.build, _VERSION)
  output.print("cpus        %d", machine.cpus)
  output.print("isa         %s", machine.isa)
  output.print("memory      %s free", output.bytes(machine.memory_available))
  output.print("integrators %s", table.concat(integrators, ", "))
  output.print("tracers     %s", table.concat(tracers, ", "))
  return 0
end

-- ---- a scene ----

local COUNTS = {
  { "triangles", "triangles" }, { "shapes", "shapes" }, { "planes", "planes" }, { "geometries", "geometries" }, { "instances", "instances" },
  { "lights", "lights" }, { "materials", "materials" }, { "textures", "textures" },
}
local BYTES = {
  { "geometry_bytes", "geometry" }, { "attribute_bytes", "attributes" }, { "texture_bytes", "textures" }, { "tree_bytes", "trees" },
  { "total_bytes", "scene" },
}

local function scene_json(path, facts, memory, settings, scene)
  local object = json.object():set("scene", path):set("hash", scene:hash())
  for _, list in ipairs { COUNTS, BYTES } do
    for _, row in ipairs(list) do
      object:set(row[1], facts[row[1]])
    end
  end
  local rows = {}
  for i, t in ipairs(facts.trees) do
    rows[i] = trees.json(t)
  end
  object:set("render_bytes", memory):set("width", settings.width):set("height", settings.height):set("samples", settings.samples)
  object:set("moving_instances", facts.moving_instances):set("camera_moves", facts.camera_moves)
    :set("shutter", { facts.shutter_open, facts.shutter_close })
  return object:set("trees", rows)
end

local function scene_text(path, facts, memory, settings, low, high)
  output.print("%s", path)
  for _, row in ipairs(COUNTS) do
    if facts[row[1]] > 0 then
      output.print("%-11s %s", row[2], output.count(facts[row[1]]))
    end
  end
  local moves = facts.moving_instances > 0 and ("%s instance%s over %s places"):format(output.count(facts.moving_instances),
    facts.moving_instances == 1 and "" or "s", output.count(facts.motion_places)) or nil
  if moves or facts.camera_moves then
    local camera = facts.camera_moves and (moves and " and the camera" or "the camera") or ""
    output.print("%-11s %s%s, shutter from %g to %g", "motion", moves or "", camera, facts.shutter_open, facts.shutter_close)
  end
  if low then
    output.print("%-11s %g %g %g ... %g %g %g", "box", low[1], low[2], low[3], high[1], high[2], high[3])
  end
  output.print("memory")
  for _, row in ipairs(BYTES) do
    output.print("  %-11s %s", row[2], output.bytes(facts[row[1]]))
  end
  output.print("  %-11s %s for %dx%d (free: %s)", "render", output.bytes(memory), settings.width, settings.height,
    output.bytes(require("rt").machine().memory_available))
  if #facts.trees == 0 then
    output.print("no trees: nothing in it needs one")
    return
  end
  trees.print(facts.trees)
end

function info.run(command, values, arguments)
  local path = arguments[1]
  if not path then
    return build(values)
  end
  local scene = source.open(path, values, command, { accel = table.concat(values.tracers_list or { "kdtree", "octree", "bvh" }, ",") }).scene
  local facts = scene:info()
  local memory = scene:memory()
  local settings = scene:effective()
  if values.json then
    output.print("%s", json.encode(scene_json(path, facts, memory, settings, scene)))
  else
    scene_text(path, facts, memory, settings, scene:bounds())
  end
  return 0
end

return info
