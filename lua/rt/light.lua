-- Lights.

local check = require "rt.check"
local class = require "rt.class"

local light = {}

local function new(name, kind, example, required, own)
  local fields = {
    color = check.color(), intensity = check.number { low = 0, most = check.LARGEST }, samples = check.integer { low = 0, high = 65536 },
  }
  for key, field in pairs(own) do
    fields[key] = field
  end
  return (class.new {
    name = name, kind = "light", example = example, fields = fields, required = required, shared = { light = kind },
  })
end

local falloff = check.choice { "none", "inverse_square" }

light.point = new("point_light", "point", "rt.point_light { at = {0, 5, 0} }", { "at" }, { at = check.place, falloff = falloff })
light.sphere = new("sphere_light", "sphere", "rt.sphere_light { at = {0, 5, 0}, radius = 0.5 }", { "at", "radius" }, {
  at = check.place, radius = check.number { above = 0, most = check.LARGEST }, falloff = falloff, visible = check.boolean,
})
light.directional = new("directional_light", "directional", "rt.directional_light { direction = {0, -1, 0} }", { "direction" }, {
  direction = check.direction,
})

return light
