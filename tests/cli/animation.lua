-- What the tests of rtray animate share: an animation of tiny frames, and what the program says of it.

local assert = require "luassert"
local support = require "support"
local rtray, quote = support.rtray, support.quote

local animation = {}

-- An animation of tiny frames; `body` may use t and frame.
function animation.script(folder, options)
  options = options or {}
  return support.write(folder .. "/" .. (options.name or "a.lua"), ([[
local rt = require "rt"
%s
return rt.animation { frames = %d, fps = 12%s, scene = function(t, frame, seconds)
  %s
  return rt.scene {
    settings = { size = {%s}, samples = %d }, camera = rt.camera { eye = {0, 0, 6}, look_at = {0, 0, 0} }, ambient = {0.3, 0.3, 0.3},
    rt.point_light { at = {4, 4, 4} }, rt.sphere { center = {2 * t - 1, 0, 0}, radius = 1, material = %s },
  }
end }]]):format(options.head or "", options.frames or 5, options.more or "", options.body or "", options.size or "16, 12", options.samples or 1,
    options.material or "nil"))
end

function animation.animate(path, ...)
  return rtray { "animate", path, ... }
end

function animation.list(folder)
  return (support.shell("ls " .. quote(folder)).out:gsub("\n", " "))
end

-- The hash of an image's pixels, as the file says.
function animation.hash_of(path)
  return support.read(path):match("Hash%z(" .. ("%x"):rep(32) .. ")")
end

-- The number of frames rendered and taken over, as the closing line says.
function animation.counts(r)
  return tonumber(r.err:match "(%d+) rendered"), tonumber(r.err:match "(%d+) taken over" or 0)
end

function animation.has(r, text)
  assert.truthy(r.err:find(text, 1, true), ("not in: %s"):format(r.err))
end

return animation
