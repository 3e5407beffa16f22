-- A mesh file as a picture: the mesh on a floor under a lamp, with a camera that frames it.

local camera = require "rt.camera"
local light = require "rt.light"
local material = require "rt.material"
local mesh = require "rt.mesh"
local scene = require "rt.scene"
local shapes = require "rt.shapes"

local present = {}

-- What stands around a box low ... high. The camera looks from the right and ahead (scene.framing): the lamp hangs on the left, so that
-- shapes show in shade, and a weak light from the camera's side opens the shadows.
local function surroundings(low, high)
  local size = math.max(high[1] - low[1], high[2] - low[2], high[3] - low[3], 1e-6)
  local x, z = (low[1] + high[1]) / 2, (low[3] + high[3]) / 2
  return {
    shapes.plane { point = { x, low[2], z }, normal = { 0, 1, 0 }, material = material.classic { color = { 0.6, 0.59, 0.57 } } },
    light.sphere {
      at = { x - 1.5 * size, low[2] + 2.6 * size, z + 1.5 * size }, radius = 0.35 * size, color = { 0.8, 0.77, 0.71 }, visible = false,
    },
    light.directional { direction = { -0.8, -0.35, -0.5 }, color = { 0.1, 0.11, 0.14 } },
  }
end

-- The scene of the mesh file at `path`, whose name in messages is `name`.
function present.load(path, name)
  local clay = material.classic { color = { 0.7, 0.62, 0.53 }, diffusion = 0.95, specular = 0.15, shininess = 30 }
  local shown = scene.new {
    settings = { max_depth = 4 }, ambient = { 0.2, 0.21, 0.23 }, background = { 0.8, 0.84, 0.88 }, background_top = { 0.35, 0.5, 0.72 },
    mesh.mesh { file = path, smooth = true, material = clay },
  }
  local low, high = shown:bounds()
  if not low then
    error(name .. ": the file has no triangle to show", 0)
  end
  shown:set_camera(camera.new(scene.framing(shown))) -- before the floor, which the camera need not hold
  shown:add(surroundings(low, high))
  return shown
end

return present
