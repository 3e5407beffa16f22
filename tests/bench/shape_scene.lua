-- Spheres for against_tachyon.sh, as a scene of librt or of Tachyon. usage: sphere_scene.lua flake|mirrors librt|tachyon OUT
--   flake    Haines' sphereflake of 7,381 spheres, matte
--   mirrors  100 spheres in a square, four fifths mirrors, five bounces deep
local name, program, out = table.unpack(arg)
local VIEWS = {
  flake = { eye = { 2.7, 2.1, 4.2 }, at = { 0, 0.05, 0 }, fov = 42, light = { 4, 6, 5 }, diffuse = 0.9, mirror = 0, depth = 1 },
  mirrors = { eye = { 6, 6, 9 }, at = { 0, 0, 0 }, fov = 45, light = { 4, 10, 5 }, diffuse = 0.2, mirror = 0.8, depth = 5 },
}
local view = assert(VIEWS[name], "flake or mirrors")
local spheres = {}
local function sphere(x, y, z, r) spheres[#spheres + 1] = { x, y, z, r } end

local function cross(a, b) return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] } end
local function unit(a)
  local l = math.sqrt(a[1] * a[1] + a[2] * a[2] + a[3] * a[3])
  return { a[1] / l, a[2] / l, a[3] / l }
end
local function flake(x, y, z, r, dir, level)
  sphere(x, y, z, r)
  if level == 0 then return end
  local a = unit(cross(dir, math.abs(dir[1]) > 0.7 and { 0, 1, 0 } or { 1, 0, 0 }))
  local b = cross(dir, a)
  local function child(turn, lift)
    local t, l, d = math.rad(turn), math.rad(lift), {}
    for i = 1, 3 do d[i] = (a[i] * math.cos(t) + b[i] * math.sin(t)) * math.cos(l) + dir[i] * math.sin(l) end
    local far = r * 4 / 3
    flake(x + d[1] * far, y + d[2] * far, z + d[3] * far, r / 3, d, level - 1)
  end
  for i = 0, 5 do child(60 * i, 0) end
  for i = 0, 2 do child(120 * i + 30, 54.7) end
end
if name == "flake" then
  flake(0, 0, 0, 1, { 0, 1, 0 }, 4)
else
  for i = 0, 9 do
    for j = 0, 9 do sphere(i - 4.5, 0.4 * math.sin(i * 1.7 + j), j - 4.5, 0.42) end
  end
end

local function three(v) return string.format("%.9g %.9g %.9g", v[1], v[2], v[3]) end
local function commas(v) return (three(v):gsub(" ", ", ")) end
local f = assert(io.open(out, "w"))
if program == "librt" then
  local balls = {}
  for i, s in ipairs(spheres) do balls[i] = string.format("ball(%.9g, %.9g, %.9g, %.9g)\n", s[1], s[2], s[3], s[4]) end
  f:write(string.format([[
local rt = require "rt"
local centers, radii = {}, {}
local function ball(x, y, z, r) centers[#centers + 1], radii[#radii + 1] = {x, y, z}, r end
%slocal matter = rt.classic { color = {1, 1, 1}, diffusion = %g, reflectiveness = %g, ambient = 0 }
return rt.scene {
  settings = { width = 1000, height = 700, samples = 1, integrator = "whitted", max_depth = %d },
  camera = rt.camera { eye = {%s}, look_at = {%s}, fov = %g },
  rt.point_light { at = {%s} },
  rt.spheres { centers = centers, radii = radii, material = matter },
}
]], table.concat(balls), view.diffuse, view.mirror, view.depth, commas(view.eye), commas(view.at), view.fov, commas(view.light)))
else
  f:write(string.format([[
begin_scene
resolution 1000 700
camera
  zoom %.9g
  aspectratio 1.0
  antialiasing 0
  raydepth %d
  center %s
  viewdir %s
  updir 0 1 0
end_camera
background 0 0 0
texdef matter ambient 0 diffuse %g specular %g opacity 1 color 1 1 1 texfunc 0
light center %s rad 0.001 color 1 1 1
]], 0.5 / math.tan(math.rad(view.fov) / 2), view.depth + 1, three(view.eye),
    three { view.at[1] - view.eye[1], view.at[2] - view.eye[2], view.at[3] - view.eye[3] }, view.diffuse, view.mirror, three(view.light)))
  for _, s in ipairs(spheres) do f:write(string.format("sphere center %s rad %.9g matter\n", three(s), s[4])) end
  f:write("end_scene\n")
end
f:close()
