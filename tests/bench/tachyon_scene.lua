-- Writes the triangles of a binary little-endian PLY file (x y z vertices, faces of three) as a Tachyon scene with one white
-- point light and one matte texture: lua5.4 tachyon_scene.lua MESH.ply OUT.dat EYE LOOK_AT FOV LIGHT [FLOOR]
-- (vectors as x,y,z; FLOOR: half the edge of two huge triangles under the mesh).
local path, out, eye, look_at, fov, light, floor = table.unpack(arg)
local function vec(s)
  local x, y, z = s:match("^([^,]+),([^,]+),([^,]+)$")
  return { tonumber(x), tonumber(y), tonumber(z) }
end
eye, look_at, light, fov, floor = vec(eye), vec(look_at), vec(light), tonumber(fov), tonumber(floor)

local data = assert(io.open(path, "rb")):read("a")
local header_end = select(2, data:find("end_header\n", 1, true))
local vertex_count = tonumber(data:match("element vertex (%d+)"))
local face_count = tonumber(data:match("element face (%d+)"))
local at = header_end + 1
local v = {}
local low = { math.huge, math.huge, math.huge }
for i = 1, vertex_count do
  local x, y, z
  x, y, z, at = string.unpack("<fff", data, at)
  v[i] = string.format("%.9g %.9g %.9g", x, y, z)
  low[2] = math.min(low[2], y)
end

local f = assert(io.open(out, "w"))
-- Tachyon's image is one unit high at zoom 1 and distance 1.
local zoom = 0.5 / math.tan(math.rad(fov) / 2)
f:write(string.format([[
begin_scene
resolution 1000 700
camera
  zoom %.9g
  aspectratio 1.0
  antialiasing 0
  raydepth 1
  center %.9g %.9g %.9g
  viewdir %.9g %.9g %.9g
  updir 0 1 0
end_camera
background 0 0 0
texdef matte ambient 0.1 diffuse 0.9 specular 0 opacity 1 color 1 1 1 texfunc 0
light center %.9g %.9g %.9g rad 0.001 color 1 1 1
]], zoom, eye[1], eye[2], eye[3], look_at[1] - eye[1], look_at[2] - eye[2], look_at[3] - eye[3], light[1], light[2], light[3]))
local function triangle(a, b, c) f:write("tri\n v0 ", a, "\n v1 ", b, "\n v2 ", c, "\n matte\n") end
for _ = 1, face_count do
  local n, a, b, c
  n, a, b, c, at = string.unpack("<Bi4i4i4", data, at)
  assert(n == 3, "only triangles")
  triangle(v[a + 1], v[b + 1], v[c + 1])
end
if floor then
  local function corner(x, z) return string.format("%.9g %.9g %.9g", x * floor, low[2], z * floor) end
  triangle(corner(-1, -1), corner(1, -1), corner(1, 1))
  triangle(corner(-1, -1), corner(1, 1), corner(-1, 1))
end
f:write("end_scene\n")
f:close()
