-- scenes/real.lua: the benchmark meshes with their usual cameras, told by the file's name: rtray render scenes/real.lua -D mesh=FOLDER/sibenik.ply
-- A script reads files beside itself and those that -D names, so the mesh has to be named unless the script is trusted.
local rt = require "rt"

local views = {  -- the cameras that the field uses, and a light
  sponza  = { eye = {14.4499, 6.89415, -1.18547}, look_at = {13.4563, 6.78438, -1.15861}, fov = 74.096, light = {0, 12, 0} },
  sibenik = { eye = {24, 3, 0}, look_at = {0, 4, 0}, fov = 60, light = {10, 14, 0} },
  bunny   = { eye = {-0.0168, 0.125, 0.33}, look_at = {-0.0168, 0.108, 0}, fov = 35, light = {0.3, 0.6, 0.6} },
}
local p = rt.params { mesh = { "../../shared/scenes/sponza.ply", type = "file", help = "sponza.ply, sibenik.ply or bunny.ply" } }
local name = p.mesh:match "([^/]*)%.ply$"
local view = views[name] or error(("mesh: there is no camera for '%s'; known are sponza.ply, sibenik.ply and bunny.ply"):format(p.mesh), 0)

return rt.scene {
  settings = { width = 1000, height = 700, samples = 4 },
  camera = rt.camera { eye = view.eye, look_at = view.look_at, fov = view.fov },
  ambient = {0.25, 0.26, 0.28},
  background = {0.6, 0.7, 0.85},
  rt.point_light { at = view.light, color = {0.9, 0.87, 0.8} },
  rt.mesh { file = p.mesh, material = rt.classic { color = {0.8, 0.76, 0.7}, diffusion = 0.9 } },
}
