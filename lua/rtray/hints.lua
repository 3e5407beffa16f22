-- A word before a render whose picture would say nothing: black for want of light, or white where values pass what the format holds.

local class = require "rt.class"
local output = require "rtray.output"

local hints = {}

local function is_black(color)
  return color == nil or (color[1] or color.x) == 0 and (color[2] or color.y) == 0 and (color[3] or color.z) == 0
end

-- A background that is seen: a texture, or a colour.
local function is_seen(background)
  return class.kind(background) ~= nil or not is_black(background)
end

-- May a body in it shine? The materials of an OBJ file are not known here.
local function glows(scene)
  for _, material in pairs(scene.materials) do -- in any order
    if material.model == "emissive" then
      return true
    end
  end
  for _, object in pairs(scene.objects) do
    if object.path and object.path:lower():find "%.obj$" then
      return true
    end
  end
  for _, child in ipairs(scene.children) do
    if next(child.lights) or glows(child) then
      return true
    end
  end
  return false
end

-- Why the picture will be black, or nil. Of a saved scene nothing is known.
local function why_black(scene)
  local world = scene.world
  if not world or is_seen(world.background) or is_seen(world.background_top) or next(scene.lights) then
    return nil
  elseif not next(scene.objects) and not next(scene.instances) then
    return "the scene is empty"
  elseif is_black(world.ambient) and not glows(scene) then
    return "the scene has no light; a lamp as rt.point_light { at = {5, 5, 5} }, ambient = {0.2, 0.2, 0.2} or background = {1, 1, 1} gives some"
  end
  return nil
end

-- format: of the image file.
function hints.tell(scene, settings, format, values)
  local view = settings.integrator
  local why = (view == "whitted" or view == "path") and why_black(scene)
  if why then
    output.note("rtray render: the picture will be black: %s", why)
  elseif (view == "depth" or view == "steps") and format ~= "hdr" and not values.quiet then
    output.note("rtray render: %s above 1 are white in this format; .hdr keeps them, --exposure -4 takes a sixteenth, and image:color_map "
      .. "makes colours of them", view == "depth" and "distances" or "steps")
  end
end

return hints
