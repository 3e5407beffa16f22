-- scenes/paper.lua: the glass ball and flower wall. paper.sdf is the same scene in the paper's own syntax and gives the same pixels.
local rt = require "rt"

local p = rt.params {
  ior    = { 1.5, min = 1, max = 2.5, help = "index of refraction of the ball" },
  radius = { 200, min = 10, max = 400, help = "radius of the ball" },
  sets   = { draft = { radius = 100 } },
}

return rt.scene {
  settings = { width = 1000, height = 700, samples = 4 },
  camera   = rt.camera { eye = {250, 150, 600}, look_at = {250, 150, 0}, fov = 50 },
  ambient  = {0.2, 0.2, 0.2},
  rt.point_light { at = {-500, -100, 200} },
  rt.sphere { center = {-500, -100, 200}, radius = 120, -- the visible lamp; casts no shadow from a light inside it
    material = rt.classic { color = {1, 1, 0.9}, reflectiveness = 0.5, diffusion = 0.3 } },
  rt.sphere { center = {350, 149, -300}, radius = p.radius,
    material = rt.classic { refractiveness = p.ior, transparency = 0.6, reflectiveness = 0.3, diffusion = 0 } },
  rt.plane  { point = {500, 0, -400}, normal = {-1, 0, 2}, texture_size = 500,
    material = rt.classic { texture = "flower.jpg", diffusion = 1 } },
}
