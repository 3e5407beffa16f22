-- The shapes of few numbers.

local core = require "rt.core"
local check = require "rt.check"
local class = require "rt.class"
local material = require "rt.material"
local arrays = require "rt.arrays"
local words = require "rt.words"

local shapes = {}

local U32 = check.integer { low = 0, high = 0xffffffff }

-- The fields that every shape has, and its own.
function shapes.fields(own)
  local fields = { material = material.field, mask = U32, user_id = U32, uv_transform = check.numbers(6) }
  for key, field in pairs(own) do
    fields[key] = field
  end
  return fields
end

local function new(name, example, required, own, finish, settles)
  return (class.new {
    name = name, kind = "shape", example = example, fields = shapes.fields(own), required = required, finish = finish,
    shared = { add = "add_" .. name }, settles = settles,
  })
end

local LARGEST, NOTHING = check.LARGEST, check.NOTHING
local positive, not_negative = check.number { above = 0, most = LARGEST }, check.number { low = 0, most = LARGEST }
local texture_length = check.number { low = 1e-12, most = LARGEST }

local function distinct(a, b)
  return function(o, _, who)
    if o[a] == o[b] then
      check.fail("%s: %s and %s are the same point", who, a, b)
    end
  end
end

shapes.sphere = new("sphere", "rt.sphere { center = {0, 1, 0}, radius = 1 }", { "center", "radius" }, { center = check.place, radius = positive })

shapes.plane = new("plane", "rt.plane { point = {0, 0, 0}, normal = {0, 1, 0} }", { "point", "normal" }, {
  point = check.place, normal = check.direction, u_axis = check.direction, texture_size = texture_length, texture_height = texture_length,
})

shapes.box = new("box", "rt.box { low = {-1, 0, -1}, high = {1, 2, 1} }", { "low", "high" }, { low = check.place, high = check.place },
  function(o, _, who)
    for i, axis in ipairs { "x", "y", "z" } do
      if o.low[i] >= o.high[i] then
        check.fail("%s: low must be below high on each axis; %s goes from %s to %s", who, axis, words.number(o.low[i]), words.number(o.high[i]))
      end
    end
  end)

shapes.cylinder = new("cylinder", "rt.cylinder { from = {0, 0, 0}, to = {0, 2, 0}, radius = 1 }", { "from", "to", "radius" }, {
  from = check.place, to = check.place, radius = positive,
}, distinct("from", "to"))

-- A cone from its base to its tip, or a frustum when `to_radius` is given.
shapes.cone = new("cone", "rt.cone { from = {0, 0, 0}, to = {0, 2, 0}, radius = 1 }", { "from", "to", "radius" }, {
  from = check.place, to = check.place, radius = not_negative, to_radius = not_negative,
}, function(o, t, who)
  distinct("from", "to")(o, t, who)
  o.to_radius = o.to_radius or 0
  if o.radius <= NOTHING and o.to_radius <= NOTHING then
    check.fail("%s: radius and to_radius are both 0", who)
  end
end)

shapes.torus = new("torus", "rt.torus { center = {0, 1, 0}, axis = {0, 1, 0}, major_radius = 2, minor_radius = 0.5 }",
  { "center", "axis", "major_radius", "minor_radius" }, {
    center = check.place, axis = check.direction, major_radius = positive, minor_radius = positive,
  }, function(o, _, who)
    if o.minor_radius >= o.major_radius then
      check.fail("%s: minor_radius must be less than major_radius; got %s and %s", who, words.number(o.minor_radius), words.number(o.major_radius))
    end
  end)

-- Many shapes as one: places, three numbers a shape, have so many as the arrays beside them.
local function one_each(o, who, noun, places)
  if (o.radii == nil) == (o.radius == nil) then
    check.fail("%s: give either radii, one a %s, or radius, one for all", who, noun)
  end
  local count = #o[places] // 3
  arrays.same_count(o, who, "radii", 1, count, places)
  arrays.same_count(o, who, "colors", 3, count, places)
  arrays.same_count(o, who, "materials", 1, count, places)
  return count
end

-- Many bodies between two points each.
local function between(o, who, noun)
  local count = one_each(o, who, noun, "from")
  arrays.same_count(o, who, "to", 3, count, "from")
  local i = core.same_item(o.from, o.to, 3)
  if i then
    check.fail("%s: from and to of %s %d are the same point", who, noun, i)
  end
  return count
end

local points, above_zero, from_zero = arrays.places, arrays.floats(1, LARGEST, { above = 0 }), arrays.floats(1, LARGEST, { low = 0 })

shapes.spheres = new("spheres", "rt.spheres { centers = buffer, radii = buffer }", { "centers" }, {
  centers = points, radii = above_zero, radius = positive, colors = arrays.colors, materials = arrays.materials,
}, function(o, _, who)
  one_each(o, who, "sphere", "centers")
end, { "centers", "radii", "colors" })

shapes.cylinders = new("cylinders", "rt.cylinders { from = buffer, to = buffer, radius = 0.1 }", { "from", "to" }, {
  from = points, to = points, radii = above_zero, radius = positive, colors = arrays.colors, materials = arrays.materials,
}, function(o, _, who)
  between(o, who, "cylinder")
end, { "from", "to", "radii", "colors" })

shapes.cones = new("cones", "rt.cones { from = buffer, to = buffer, radii = buffer, to_radii = buffer }", { "from", "to" }, {
  from = points, to = points, radii = from_zero, radius = not_negative, to_radii = from_zero, to_radius = not_negative, colors = arrays.colors,
  materials = arrays.materials,
}, function(o, _, who)
  arrays.same_count(o, who, "to_radii", 1, between(o, who, "cone"), "from")
  if o.to_radii and o.to_radius then
    check.fail("%s: give either to_radii, one a cone, or to_radius, one for all; 0 without both", who)
  elseif not o.radii and not o.to_radii and o.radius <= NOTHING and (o.to_radius or 0) <= NOTHING then
    check.fail("%s: radius and to_radius are both 0", who)
  end
end, { "from", "to", "radii", "to_radii", "colors" })

return shapes
