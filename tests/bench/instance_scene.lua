-- A mesh as itself, placed once, or placed often, for `rtray bench-rays`: what instances cost.
--   rtray bench-rays tests/bench/instance_scene.lua -D mesh=MESH -D count=N --trust [--eye X,Y,Z --at X,Y,Z --fov D]
--   count = 0: the mesh itself; 1: one instance; more: a square of them, turned and raised at random
local rt = require "rt"
local p = rt.params {
  mesh = { "", help = "a mesh file" },
  count = { 1, min = 0, max = 100000, help = "how often it is placed; 0: it stands in the scene itself" },
}

local mesh = rt.mesh { file = p.mesh }
if p.count == 0 then return rt.scene { mesh } end
if p.count == 1 then return rt.scene { rt.instance { mesh } } end

local edge, items = math.ceil(math.sqrt(p.count)), {}
math.randomseed(3)
for i = 0, p.count - 1 do
  local x, z = 0.2 * (i % edge - edge / 2), 0.2 * (i // edge - edge / 2)
  items[#items + 1] = rt.instance { mesh, transform = rt.translate(x, 0.3 * math.random(), z) * rt.rotate({0, 1, 0}, 360 * math.random()) }
end
return rt.scene(items)
