-- scenes/sphereflake.lua: Haines' sphereflake; 4 levels are the 7,381 spheres of the old benchmark
local rt = require "rt"

local p = rt.params { levels = { 4, min = 0, max = 6, help = "levels of recursion: 1, 10, 91, 820, 7381, 66430 spheres" } }

local centers, radii = {}, {}

-- Nine children: six around the equator, three above, in the frame whose third axis is dir.
local function flake(c, r, dir, level)
  centers[#centers + 1], radii[#radii + 1] = c, r
  if level == 0 then return end
  local side = math.abs(dir.x) > 0.7 and rt.vec(0, 1, 0) or rt.vec(1, 0, 0)
  local a = dir:cross(side):normalize()
  local b = dir:cross(a)
  local function child(turn, lift)
    local t, l = math.rad(turn), math.rad(lift)
    local d = (a * math.cos(t) + b * math.sin(t)) * math.cos(l) + dir * math.sin(l)
    flake(c + d * (r * 4 / 3), r / 3, d, level - 1)
  end
  for i = 0, 5 do child(60 * i, 0) end
  for i = 0, 2 do child(120 * i + 30, 54.7) end
end
flake(rt.vec(0, 0, 0), 1, rt.vec(0, 1, 0), p.levels)

return rt.scene {
  settings = { width = 1000, height = 700, samples = 8 },
  camera = rt.camera { eye = {2.7, 2.1, 4.2}, look_at = {0, 0.05, 0}, fov = 42 },
  ambient = {0.12, 0.13, 0.16},
  background = {0.75, 0.8, 0.86}, background_top = {0.2, 0.35, 0.6},
  rt.point_light { at = {4, 6, 5}, color = {0.8, 0.78, 0.7} },
  rt.point_light { at = {-5, 3, 3}, color = {0.25, 0.28, 0.35} },
  rt.plane { point = {0, -1.5, 0}, normal = {0, 1, 0}, material = rt.classic { color = {0.5, 0.42, 0.33}, diffusion = 0.9 } },
  rt.spheres { centers = centers, radii = radii,
    material = rt.classic { color = {0.9, 0.75, 0.45}, diffusion = 0.45, reflectiveness = 0.5, specular = 0.5, shininess = 120 } },
}
