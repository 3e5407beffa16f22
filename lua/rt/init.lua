-- The module rt: a renderer in a table. lua/rt.d.lua describes each function for editors.

local core = require "rt.core"
local run = require "rt.run"
local vec = require "rt.vec"
local transform = require "rt.transform"
local material = require "rt.material"
local camera = require "rt.camera"
local light = require "rt.light"
local shapes = require "rt.shapes"
local mesh = require "rt.mesh"
local motion = require "rt.motion"
local image = require "rt.image"
local draw = require "rt.draw"
local scene = require "rt.scene"
local params = require "rt.params"
local load = require "rt.load"
local log = require "rt.log"
local missing = require "rt.missing"
local configure = require "rt.configure"
local animation = require "rt.animation"
local ease = require "rt.ease"
local keys = require "rt.keys"
local path = require "rt.path"
local quat = require "rt.quat"

local version, build = core.version()

-- A large part that few scripts need: loaded when it is called first.
local function later(part, name)
  return function(...)
    return require("rt." .. part)[name](...)
  end
end

local rt = {
  version = version, build = build,
  -- scenes
  scene = scene.new, load_snapshot = scene.load_snapshot, render = scene.render, camera = camera.new,
  point_light = light.point, sphere_light = light.sphere, directional_light = light.directional,
  classic = material.classic, emissive = material.emissive, texture = material.texture,
  sphere = shapes.sphere, spheres = shapes.spheres, plane = shapes.plane, box = shapes.box, cylinder = shapes.cylinder, cone = shapes.cone,
  cylinders = shapes.cylinders, cones = shapes.cones,
  torus = shapes.torus, mesh = mesh.mesh, polyhedron = mesh.polyhedron, group = mesh.group, instance = mesh.instance, motion = motion.join,
  -- values
  vec = vec.make, srgb = vec.srgb, transform = transform.make, translate = transform.translate, scale = transform.scale, rotate = transform.rotate,
  buffer = core.buffer, image = image.new, image_text = image.text, compare = image.compare, color_map = image.color_map, random = core.random,
  contact_sheet = later("contact_sheet", "make"), label_size = draw.label_size, report = later("report", "make"),
  -- animation
  animation = animation.new, keys = keys.make, ease = ease.make, quat = quat.make, path = path.make, orbit = path.orbit, look_at = path.look_at,
  -- scripts
  params = params.declare, load = load.load, main = load.main, sweep = later("sweep", "sweep"),
  -- the renderer
  configure = configure.configure, machine = configure.machine, counts = configure.counts, drop_kept = configure.drop_kept,
  integrators = core.integrators, tracers = core.tracers, settings = configure.settings,
  on_log = log.on_log,
}

run.detect_program()

return missing.guess(rt)
