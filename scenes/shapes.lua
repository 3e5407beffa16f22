-- scenes/shapes.lua: one of everything, on a floor, under a soft lamp
local rt = require "rt"

local function matte(r, g, b) return rt.classic { color = {r, g, b}, diffusion = 0.85, specular = 0.4, shininess = 60 } end

return rt.scene {
  settings = { width = 960, height = 540, samples = 16 },
  camera = rt.camera { eye = {0, 4.2, 10.5}, look_at = {0, 0.75, 0}, fov = 34 },
  ambient = {0.16, 0.17, 0.2},
  background = {0.82, 0.86, 0.92}, background_top = {0.35, 0.5, 0.75},

  rt.sphere_light { at = {-6, 9, 7}, radius = 1.2, color = {0.95, 0.9, 0.8} },
  rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.55, 0.54, 0.52}, diffusion = 0.9, reflectiveness = 0.06 } },

  rt.box { low = {-4.6, 0, -0.8}, high = {-3.2, 1.4, 0.6}, material = matte(0.75, 0.25, 0.2) },
  rt.cylinder { from = {-2.1, 0, 0}, to = {-2.1, 1.7, 0}, radius = 0.65, material = matte(0.85, 0.6, 0.2) },
  rt.cone { from = {-0.35, 0, 0}, to = {-0.35, 1.8, 0}, radius = 0.75, to_radius = 0.12, material = matte(0.3, 0.6, 0.3) },
  rt.torus { center = {1.55, 0.8, 0}, axis = {0.35, 0.5, 1}, major_radius = 0.62, minor_radius = 0.2, material = matte(0.2, 0.45, 0.75) },
  rt.sphere { center = {3.7, 0.8, -0.1}, radius = 0.8, material = rt.classic { color = {1, 1, 1}, diffusion = 0.05, reflectiveness = 0.85, specular = 0.6, shininess = 200 } },
  rt.polyhedron {  -- an octahedron
    vertices = { {2.6, 0, 2.2}, {2.6, 1.1, 2.2}, {2.05, 0.55, 2.2}, {3.15, 0.55, 2.2}, {2.6, 0.55, 1.65}, {2.6, 0.55, 2.75} },
    faces = { {2, 6, 4}, {2, 4, 5}, {2, 5, 3}, {2, 3, 6}, {1, 4, 6}, {1, 5, 4}, {1, 3, 5}, {1, 6, 3} },
    material = matte(0.6, 0.35, 0.7),
  },
  rt.sphere { center = {-0.9, 0.5, 2.3}, radius = 0.5,
    material = rt.classic { color = {0.95, 1, 0.97}, refractiveness = 1.5, transparency = 0.9, reflectiveness = 0.1, diffusion = 0, specular = 0.8, shininess = 300 } },
}
