-- Spheres, and cylinders, for against_tachyon.sh, as a scene of librt or of Tachyon. usage: shape_scene.lua NAME librt|tachyon OUT
--   flake     Haines' sphereflake of 7,381 spheres, matte
--   mirrors   100 spheres in a square, four fifths mirrors, five bounces deep
--   molecule  ball and stick: a chain of 1,000 atoms wound up in a ball, with a stick from each half way to its neighbours
--   protein   the same of 20,000
local name, program, out = table.unpack(arg)
local VIEWS = {
  flake = { eye = { 2.7, 2.1, 4.2 }, at = { 0, 0.05, 0 }, fov = 42, light = { 4, 6, 5 }, diffuse = 0.9, mirror = 0, depth = 1 },
  mirrors = { eye = { 6, 6, 9 }, at = { 0, 0, 0 }, fov = 45, light = { 4, 10, 5 }, diffuse = 0.2, mirror = 0.8, depth = 5 },
  molecule = { atoms = 1000 },
  protein = { atoms = 20000 },
}
local view = assert(VIEWS[name], "flake, mirrors, molecule or protein")
local spheres, sticks = {}, {}
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

-- A chain that turns a little at each atom, and back towards the middle where it would leave a ball.
local function chain(count, room)
  local seed = 12345
  local function random()
    seed = (seed * 1103515245 + 12345) % 2147483648
    return seed / 2147483648
  end
  local at, way = { 0, 0, 0 }, { 1, 0, 0 }
  for i = 1, count do
    sphere(at[1], at[2], at[3], i % 3 == 0 and 0.45 or 0.3)
    local to
    repeat
      local z, turn = 2 * random() - 1, 2 * math.pi * random()
      local across = math.sqrt(1 - z * z)
      local next_way = unit { way[1] + 1.2 * across * math.cos(turn), way[2] + 1.2 * across * math.sin(turn), way[3] + 1.2 * z }
      to = { at[1] + 1.5 * next_way[1], at[2] + 1.5 * next_way[2], at[3] + 1.5 * next_way[3] }
      local inside = to[1] * to[1] + to[2] * to[2] + to[3] * to[3] < room * room
      way = inside and next_way or { -at[1] / room, -at[2] / room, -at[3] / room }
    until inside
    if i < count then
      local half = { (at[1] + to[1]) / 2, (at[2] + to[2]) / 2, (at[3] + to[3]) / 2 }
      sticks[#sticks + 1] = { at, half, 0.15 }
      sticks[#sticks + 1] = { half, to, 0.15 }
    end
    at = to
  end
end

if view.atoms then
  local room = 7 * (view.atoms / 1000) ^ (1 / 3)
  local e = 2.6 * room
  view = { eye = { 0, 0, e }, at = { 0, 0, 0 }, fov = 42, light = { e, 1.2 * e, e }, diffuse = 0.9, mirror = 0, depth = 1, atoms = view.atoms }
  chain(view.atoms, room)
elseif name == "flake" then
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
  for i, s in ipairs(spheres) do balls[i] = string.format("%.9g %.9g %.9g %.9g\n", s[1], s[2], s[3], s[4]) end
  local rods = {}
  for i, s in ipairs(sticks) do rods[i] = string.format("%s %s %.9g\n", three(s[1]), three(s[2]), s[3]) end
  f:write(string.format([==[
local rt = require "rt"
local centers, radii, sticks = {}, {}, {}
local matter = rt.classic { color = {1, 1, 1}, diffusion = %g, reflectiveness = %g, ambient = 0 }
local number = "(%%S+) "
for line in ([[%s]]):gmatch "[^\n]+" do
  local x, y, z, r = line:match "(%%S+) (%%S+) (%%S+) (%%S+)"
  centers[#centers + 1], radii[#radii + 1] = { tonumber(x), tonumber(y), tonumber(z) }, tonumber(r)
end
for line in ([[%s]]):gmatch "[^\n]+" do
  local x, y, z, u, v, w, r = line:match(number:rep(6) .. "(%%S+)")
  sticks[#sticks + 1] = rt.cylinder {
    from = { tonumber(x), tonumber(y), tonumber(z) }, to = { tonumber(u), tonumber(v), tonumber(w) }, radius = tonumber(r), material = matter,
  }
end
return rt.scene {
  settings = { width = 1000, height = 700, samples = 1, integrator = "whitted", max_depth = %d },
  camera = rt.camera { eye = {%s}, look_at = {%s}, fov = %g },
  rt.point_light { at = {%s} },
  rt.spheres { centers = centers, radii = radii, material = matter },
  table.unpack(sticks),
}
]==], view.diffuse, view.mirror, table.concat(balls), table.concat(rods), view.depth, commas(view.eye), commas(view.at), view.fov,
    commas(view.light)))
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
  for _, s in ipairs(sticks) do f:write(string.format("fcylinder base %s apex %s rad %.9g matter\n", three(s[1]), three(s[2]), s[3])) end
  f:write("end_scene\n")
end
f:close()
