-- scenes/motion.lua: a propeller, a ball that drops and a runaway hoop, seen by a lens while its shutter is open.
local rt = require "rt"

local p = rt.params { shutter = { 1, min = 0, max = 1, help = "how long the shutter is open" } }
local wood = rt.classic { color = rt.srgb "#c8813c", diffusion = 0.9, specular = 0.4, shininess = 60 }
local red = rt.classic { color = rt.srgb "#d03a2b", diffusion = 0.9, specular = 0.6, shininess = 90 }
local steel = rt.classic { color = {0.8, 0.82, 0.85}, diffusion = 0.35, reflectiveness = 0.5, specular = 0.8, shininess = 120 }
local floor = rt.classic { color = {0.55, 0.57, 0.6}, diffusion = 0.85, reflectiveness = 0.1 }

local blades = {}
for i = 0, 2 do
  blades[i + 1] = rt.cone { from = {0, 0, 0}, to = rt.rotate({0, 0, 1}, 120 * i) * {0, 1.3, 0}, radius = 0.05, to_radius = 0.16, material = wood }
end
local function turned(degrees)
  return rt.translate(-1.1, 1.7, 0) * rt.rotate({0, 0, 1}, degrees)
end

return rt.scene {
  settings = { width = 800, height = 450, samples = 64 },
  camera = rt.camera {
    eye = {0.6, 1.6, 7}, look_at = {0, 1.2, 0}, fov = 36, aperture = 0.07, focus_at = {-1.1, 1.7, 0}, blades = 6, shutter = p.shutter,
  },
  ambient = {0.12, 0.13, 0.15}, background = {0.62, 0.68, 0.76}, background_top = {0.25, 0.35, 0.55},
  rt.sphere_light { at = {4, 7, 5}, radius = 0.8, visible = false, color = {0.8, 0.78, 0.72} },
  rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = floor },
  rt.instance { rt.group { blades, rt.sphere { center = {0, 0, 0.05}, radius = 0.17, material = steel } }, transform = turned(0), motion = turned(50) },
  rt.cylinder { from = {-1.1, 0, -0.25}, to = {-1.1, 1.8, -0.25}, radius = 0.06, material = steel },
  rt.instance { rt.sphere { center = {0, 0, 0}, radius = 0.42, material = red }, transform = rt.translate(0.75, 1.9, 0.4), motion = rt.translate(0.75, 1.25, 0.4) },
  rt.instance { rt.torus { center = {0, 0, 0}, axis = {0, 0, 1}, major_radius = 0.55, minor_radius = 0.09, material = wood },
    transform = rt.translate(1.9, 0.64, -0.6), motion = rt.translate(2.5, 0.64, -0.6) * rt.rotate({0, 0, 1}, -55) },
  rt.box { low = {-3.4, 0, -5}, high = {-2.2, 2.6, -4}, material = red },
  rt.sphere { center = {0.2, 0.25, 2.6}, radius = 0.25, material = steel },
}
