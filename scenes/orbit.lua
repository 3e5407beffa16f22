-- A glass ball rolls round a lamp in the dusk while the camera circles them: 96 frames that close into a loop.
local rt = require "rt"

local glass = rt.classic { transparency = 0.85, refractiveness = 1.5, reflectiveness = 0.12, diffusion = 0.05, specular = 0.8, shininess = 90 }
local floor = rt.classic { color = {0.42, 0.38, 0.36}, diffusion = 0.9, reflectiveness = 0.08 }

local camera = rt.orbit { radius = 8, height = 4 }
local way = rt.orbit { radius = 1.9, height = 0.6, turns = -2 }
local height = rt.keys { {0, 0}, {0.5, 1.3, ease = "out"}, {1, 0, ease = "in"}, loop = "repeat" }

local function pillar(i)
  local angle = rt.rotate({0, 1, 0}, 30 * i)
  local color = rt.srgb(0.95 - 0.5 * rt.random("red", i), 0.6 + 0.3 * rt.random("green", i), 0.7)
  return function(t)
    local top = 0.5 + height(2 * t + i / 6)
    local foot = angle * {0, 0, 3.4}
    return rt.cylinder { from = foot, to = foot + {0, top, 0}, radius = 0.22, material = rt.classic { color = color, diffusion = 0.9, specular = 0.3 } }
  end
end

return rt.animation {
  frames = 96, fps = 24, loop = true, name = "orbit",
  scene = function(t)
    local things = {}
    for i = 1, 12 do
      things[i] = pillar(i)(t)
    end
    return rt.scene {
      settings = { width = 640, height = 360, samples = 9 },
      camera = camera:camera(t, { look_at = {0, 0.8, 0}, fov = 42 }),
      ambient = {0.06, 0.07, 0.12}, background = {0.02, 0.03, 0.06}, background_top = {0.1, 0.13, 0.26},
      rt.sphere_light { at = {0, 2.6, 0}, radius = 0.35, color = {95, 72, 46}, falloff = "inverse_square", samples = 4 }, things,
      rt.plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = floor },
      rt.sphere { center = way(t), radius = 0.6, material = glass, name = "ball" },
    }
  end,
}
