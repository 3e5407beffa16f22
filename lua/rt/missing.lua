-- Names that the module or an object does not have: where one can be guessed, asking for it is an error, as a wrong key is. Others are nil, so that
-- scripts may ask what there is.

local check = require "rt.check"
local words = require "rt.words"

local missing = {}

-- What scripts call what the module has by another name.
local HINTS = {
  triangle = "rt.mesh { vertices = ..., faces = {{1, 2, 3}} } makes triangles", triangles = "rt.mesh { vertices = ..., faces = ... } makes triangles",
  quad = "rt.polyhedron { vertices = ..., faces = {{1, 2, 3, 4}} } makes one", cube = "rt.box { low = ..., high = ... } makes one",
  ellipsoid = "rt.instance { ball, transform = rt.scale(1, 2, 1) } makes one",
  light = "there are rt.point_light, rt.sphere_light and rt.directional_light",
  material = "there are rt.classic and rt.emissive", color = "colors are {red, green, blue} or rt.srgb '#ff8000'",
}

-- An __index for names that `known` does not have. kind says what such names are called; prefix stands before a guess.
function missing.index(who, kind, known, prefix, hints)
  return function(_, key)
    local near = type(key) == "string" and words.nearest(key, check.names(known))
    local hint = hints[key] or near and ("did you mean %s%s?"):format(prefix, near)
    return hint and check.fail("%s has no %s %s; %s", who, kind, check.describe(key), hint) or nil
  end
end

-- The module's table, which guesses from now on.
function missing.guess(rt)
  return setmetatable(rt, { __index = missing.index("rt", "function", rt, "rt.", HINTS) })
end

return missing
