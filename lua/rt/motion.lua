-- Two descriptions of a scene, at the shutter's open and close, made into one in which things move.

local core = require "rt.core"
local check = require "rt.check"
local arrays = require "rt.arrays"
local class = require "rt.class"
local image = require "rt.image"
local mesh = require "rt.mesh"
local new_camera = require("rt.camera").new
local scene = require "rt.scene"
local transform = require "rt.transform"

local motion = {}

-- ---- are two descriptions the same? ----

local same

local function same_buffer(a, b)
  if #a ~= #b then
    return false
  end
  for i = 1, #a do
    if a[i] ~= b[i] then
      return false
    end
  end
  return true
end

function same(a, b)
  if a == b then
    return true
  elseif type(a) ~= type(b) or getmetatable(a) ~= getmetatable(b) then
    return false
  elseif arrays.is_buffer(a) then
    return same_buffer(a, b)
  elseif image.is(a) or scene.is(a) then
    return a:hash() == b:hash()
  elseif type(a) ~= "table" then
    return false
  end
  for key, value in next, a do
    if key ~= "place" and not same(value, b[key]) then -- where it was described
      return false
    end
  end
  for key in next, b do
    if a[key] == nil and key ~= "place" then
      return false
    end
  end
  return true
end

-- ---- what becomes of a shape: a child that stands at its own origin, and its places ----

-- A copy with other fields.
local function with(o, fields)
  local copy = {}
  for key, value in next, o do
    copy[key] = value
  end
  for key, value in next, fields do
    copy[key] = value
  end
  return setmetatable(copy, getmetatable(o))
end

local function minus(a, b)
  return { a[1] - b[1], a[2] - b[2], a[3] - b[3] }
end

local function dot(a, b)
  return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

local function unit(a)
  local l = math.sqrt(dot(a, a))
  return { a[1] / l, a[2] / l, a[3] / l }, l
end

-- The shortest rotation that takes direction a to b.
local function turn(a, b)
  a, b = unit(a), unit(b)
  local axis = { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
  local sine, cosine = math.sqrt(dot(axis, axis)), dot(a, b)
  if sine < 1e-12 then
    if cosine > 0 then
      return transform.make()
    end
    axis = math.abs(a[1]) < 0.9 and { 0, a[3], -a[2] } or { -a[3], 0, a[1] } -- half a turn about some axis across a
  end
  return transform.make(core.rotate(axis, math.deg(math.atan(sine, cosine))))
end

-- Stretches by `along` in unit direction n and by `across` in all directions across it.
local function stretch(n, along, across)
  local m = {}
  for r = 1, 3 do
    for c = 1, 3 do
      m[4 * (r - 1) + c] = (r == c and across or 0) + (along - across) * n[r] * n[c]
    end
    m[4 * r] = 0
  end
  return transform.make(m)
end

local function near(a, b)
  return math.abs(a - b) <= 1e-6 * math.max(math.abs(a), math.abs(b))
end

-- The fields in which two shapes differ, beside the ones in `moved`.
local function differing(a, b, moved, who)
  local list = {}
  for _, o in ipairs { a, b } do
    for _, key in ipairs(check.sorted_keys(o)) do
      if not moved[key] and not same(a[key], b[key]) and key ~= "material" and key ~= "place" then
        list[key] = true
      end
    end
  end
  local key = check.sorted_keys(list)[1]
  if key then
    check.fail("%s: its %s differs between the shutter's open and close; a body may move there, not change", who, key)
  end
end

local ZERO = { 0, 0, 0 }
local movers = {}

function movers.add_sphere(a, b)
  return with(a, { center = ZERO }), transform.translate(a.center), transform.translate(b.center) * transform.scale(b.radius / a.radius),
    { center = true, radius = true }
end

function movers.add_box(a, b)
  local half, middle, other, by = {}, {}, {}, {}
  for k = 1, 3 do
    half[k], middle[k], other[k] = (a.high[k] - a.low[k]) / 2, (a.high[k] + a.low[k]) / 2, (b.high[k] + b.low[k]) / 2
    by[k] = (b.high[k] - b.low[k]) / (a.high[k] - a.low[k])
  end
  return with(a, { low = { -half[1], -half[2], -half[3] }, high = half }), transform.translate(middle),
    transform.translate(other) * transform.scale(by), { low = true, high = true }
end

local function along_axis(a, b, wider)
  local axis, length = unit(minus(a.to, a.from))
  local _, other = unit(minus(b.to, b.from))
  return with(a, { from = ZERO, to = minus(a.to, a.from) }), transform.translate(a.from),
    transform.translate(b.from) * turn(axis, minus(b.to, b.from)) * stretch(axis, other / length, wider),
    { from = true, to = true, radius = true, to_radius = true }
end

function movers.add_cylinder(a, b)
  return along_axis(a, b, b.radius / a.radius)
end

function movers.add_cone(a, b, who)
  if not near(a.radius * b.to_radius, a.to_radius * b.radius) then
    check.fail("%s: radius and to_radius change by different factors between the shutter's open and close; that is another cone, not a moving one",
      who)
  end
  return along_axis(a, b, a.radius > 0 and b.radius / a.radius or b.to_radius / a.to_radius)
end

function movers.add_torus(a, b, who)
  if not near(a.major_radius * b.minor_radius, a.minor_radius * b.major_radius) then
    check.fail("%s: major_radius and minor_radius change by different factors between the shutter's open and close; that is another torus, %s", who,
      "not a moving one")
  end
  return with(a, { center = ZERO }), transform.translate(a.center),
    transform.translate(b.center) * turn(a.axis, b.axis) * transform.scale(b.major_radius / a.major_radius),
    { center = true, axis = true, major_radius = true, minor_radius = true }
end

function movers.add_plane(a, b)
  return with(a, { point = ZERO }), transform.translate(a.point), transform.translate(b.point) * turn(a.normal, b.normal),
    { point = true, normal = true }
end

function movers.add_mesh_file(a, b)
  local child = with(a, {})
  child.transform = nil
  return child, a.transform or transform.make(), b.transform or transform.make(), { transform = true }
end

local function count_of(o)
  local faces = o.faces or o.centers or o.from
  return o.add == "add_polyhedron" and #o.face_sizes or faces and #faces // 3
end

-- What is a body's form, beside what it looks like.
local FORM = {
  vertices = true, faces = true, face_sizes = true, normals = true, centers = true, from = true, to = true, radii = true, radius = true,
  to_radii = true, to_radius = true,
}

-- Shapes of arrays move only as instances.
local function refuse_arrays(a, b, who)
  local noun = a.add:match "^add_(%l+s)$" or "faces"
  if count_of(a) ~= count_of(b) then
    check.fail("%s: it has %d %s when the shutter opens and %d when it closes; what moves keeps its %s", who, count_of(a), noun, count_of(b),
      noun)
  end
  differing(a, b, FORM, who)
  check.fail("%s: its %s differ between the shutter's open and close; a body of many numbers is not blurred, one that moves is an rt.instance", who,
    noun == "faces" and "vertices or faces" or noun)
end

local function move_shape(a, b, who)
  local mover = movers[a.add]
  if not mover then
    refuse_arrays(a, b, who)
  end
  local child, from, to, moved = mover(a, b, who)
  differing(a, b, moved, who)
  return mesh.instance { child, transform = from, motion = to, name = a.name }
end

-- ---- instances ----

local function move_instance(a, b, who)
  if not same(a.items, b.items) then
    check.fail("%s: it places other things when the shutter closes than when it opens; what moves stays the same", who)
  elseif a.motion or b.motion then
    check.fail("%s: it has a motion of its own, which differs between the shutter's open and close; describe its places there, %s", who,
      "or open no shutter")
  end
  return with(a, { motion = mesh.places(b.transform or transform.make()) })
end

-- ---- pairs ----

local function noun_of(o)
  return o.add and o.add:gsub("^add_", ""):gsub("_file$", "") or "instance"
end

-- a as it is when the shutter opens and b, its partner, when it closes.
local function move(a, b)
  local who = ("'%s'"):format(a.name)
  if noun_of(a) ~= noun_of(b) then
    check.fail("%s: it is rt.%s when the shutter opens and rt.%s when it closes; what moves stays the same", who, noun_of(a), noun_of(b))
  elseif same(a, b) then
    return a
  elseif class.kind(a) == "instance" then
    return move_instance(a, b, who)
  end
  local still = with(b, {}) -- materials of the close are not seen
  still.material = a.material
  if a.materials and b.materials and #a.materials == #b.materials then
    still.materials = a.materials
  end
  return same(a, still) and a or move_shape(a, still, who)
end

-- The shapes and instances of a scene in the order of their ids, each once.
local function bodies_of(s)
  local list, seen = {}, {}
  for _, from in ipairs { s.objects, s.instances } do
    for _, id in ipairs(check.sorted_keys(from)) do
      local o = from[id]
      if from == s.instances or not seen[o] then -- one mesh file may be many geometries
        seen[o] = true
        list[#list + 1] = o
      end
    end
  end
  return list, seen
end

local function by_name(list, left_out)
  local names = {}
  for _, o in ipairs(list) do
    if o.name and not left_out[o] then
      names[o.name] = names[o.name] or {}
      table.insert(names[o.name], o)
    end
  end
  return names
end

local function pair(open, close)
  local from, opened = bodies_of(open)
  local to, closed = bodies_of(close)
  local names, partners, items, used = by_name(from, closed), by_name(to, opened), {}, {}
  for i, a in ipairs(from) do
    items[i] = a
    local there = a.name and not closed[a] and partners[a.name]
    if there then
      local here = names[a.name]
      if #here ~= #there then
        check.fail("the name '%s' stands for %d objects when the shutter opens and for %d when it closes; what is to move needs a name of its own",
          a.name, #here, #there)
      end
      used[a.name] = (used[a.name] or 0) + 1
      items[i] = move(a, there[used[a.name]])
    end
  end
  return items
end

local CAMERA_KEYS = { "eye", "look_at", "up", "fov", "height", "aperture", "f_stop", "focus_distance", "focus_at" }

local function move_camera(a, b)
  if not a or not b or same(a, b) then
    return a or nil
  elseif (a.projection or "pinhole") ~= (b.projection or "pinhole") then
    check.fail("rt.motion: the camera's projection differs between the shutter's open and close; a camera keeps its own")
  elseif a.motion or b.motion then
    check.fail("rt.motion: the camera has a motion of its own; leave it to the two scenes, or open no shutter")
  end
  local keys = {}
  for key, value in next, a do
    keys[key] = key ~= "place" and value or nil
  end
  keys.motion = {}
  for _, key in ipairs(CAMERA_KEYS) do
    keys.motion[key] = b[key]
  end
  return new_camera(keys)
end

local function check_scene(value, which)
  if not scene.is(value) then
    check.fail("rt.motion: the %s argument must be a scene; got %s", which, check.describe(value))
  elseif value.read_only then
    check.fail("rt.motion: the %s scene comes from a snapshot file, which has no description to move", which)
  end
end

-- rt.motion(open, close): the first scene, in which what the second has elsewhere is on its way there while the shutter is open. Objects are
-- the same by identity, else by name; what has no partner stands still, and so do lights. The camera moves too.
function motion.join(open, close)
  check_scene(open, "first")
  check_scene(close, "second")
  if open == close then
    return open
  end
  local lights = {}
  for _, id in ipairs(check.sorted_keys(open.lights)) do
    lights[#lights + 1] = open.lights[id]
  end
  local world = open.world
  local joined = scene.new {
    name = open.name or nil, camera = move_camera(open.view, close.view), ambient = world.ambient, background = world.background,
    background_top = world.background_top, pair(open, close), lights,
  }
  joined.settings, joined.run = open.settings, open.run
  return joined
end

return motion
