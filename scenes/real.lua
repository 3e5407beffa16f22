-- scenes/real.lua: the benchmark meshes with their usual cameras: rtray render scenes/real.lua -D name=sibenik
-- They are looked for in the folder LIBRT_SCENES names, else ../shared/scenes beside the checkout.
local rt = require "rt"

local views = {  -- eye, look_at, fov, light
  sponza    = { eye = {-12.2, 4.6, 0.8}, look_at = {0, 3.4, 0}, fov = 60, light = {0, 12, 0} },
  sibenik   = { eye = {20, 8, 0}, look_at = {-5, 6, 0}, fov = 60, light = {10, 14, 0} },
  bunny     = { eye = {-0.02, 0.15, 0.3}, look_at = {-0.02, 0.11, 0}, fov = 40, light = {0.5, 1, 1} },
}
local names = {}
for name in pairs(views) do names[#names + 1] = name end
table.sort(names)

local p = rt.params { name = { "sponza", choices = names, help = "which mesh" } }
local folder = os.getenv("LIBRT_SCENES") or rt.here("../../shared/scenes")
local view = views[p.name]

return rt.scene {
  settings = { width = 1000, height = 700, samples = 4 },
  camera = rt.camera { eye = view.eye, look_at = view.look_at, fov = view.fov },
  ambient = {0.25, 0.26, 0.28},
  background = {0.6, 0.7, 0.85},
  rt.point_light { at = view.light, color = {0.9, 0.87, 0.8} },
  rt.mesh { file = folder .. "/" .. p.name .. ".ply", material = rt.classic { color = {0.8, 0.76, 0.7}, diffusion = 0.9 } },
}
