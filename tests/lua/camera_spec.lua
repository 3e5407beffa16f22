-- Cameras: the lens, the shutter, the way.

local support = require "support"
local rt = support.rt
local raises = support.raises

local function camera(t)
  t.eye, t.look_at = t.eye or { 0, 0, 5 }, t.look_at or { 0, 0, 0 }
  local c = rt.camera(t) -- no tail call: the message names this place
  return c
end

local function of(t)
  return rt.scene { camera = camera(t) }:get_camera()
end

describe("rt.camera", function()
  it("takes a lens", function()
    local c = of { aperture = 0.25, focus_distance = 3, blades = 6, blade_rotation = 15 }
    assert.equal(0.25, c.aperture)
    assert.equal(3, c.focus_distance)
    assert.equal(6, c.blades)
    assert.equal(15, c.blade_rotation)
    assert.is_nil(c.motion)
    assert.equal(4, of { aperture = 0.25, focus_at = { 3, -2, 1 } }.focus_distance)
    assert.is_nil(of({ aperture = 0.25 }).focus_distance) -- where look_at is
  end)

  it("turns an f-number into an aperture", function()
    -- 24 mm of film seen under 2 atan(12 / 50) degrees are a lens of 50 mm: f/2 is 12.5 mm of radius.
    local fov = math.deg(2 * math.atan(12 / 50))
    assert.is_true(math.abs(of({ f_stop = 2, fov = fov }).aperture - 0.0125) < 1e-8)
    assert.is_true(math.abs(of({ f_stop = 2, fov = fov, unit = 0.01 }).aperture - 1.25) < 1e-6)
  end)

  it("takes a shutter", function()
    assert.same({ 0, 1 }, of({}).shutter)
    assert.same({ 0, 0.5 }, of({ shutter = 0.5 }).shutter)
    assert.same({ 0.25, 0.5 }, of({ shutter = { 0.25, 0.5 } }).shutter)
  end)

  it("takes a way, on which the rest stays", function()
    local c = of { aperture = 0.25, focus_at = { 0, 0, 1 }, fov = 40, motion = { eye = { 0, 0, 7 } } }
    assert.same({ 0, 0, 7 }, c.motion.eye)
    assert.same({ 0, 0, 0 }, c.motion.look_at)
    assert.equal(40, c.motion.fov)
    assert.equal(4, c.focus_distance)
    assert.equal(6, c.motion.focus_distance) -- the same point stays sharp
    assert.equal(2, of({ focus_at = { 0, 0, 1 }, motion = { focus_distance = 2 } }).motion.focus_distance)
    assert.same({ 1, 2, 3 }, of({ motion = rt.camera { eye = { 1, 2, 3 }, look_at = { 0, 0, 0 } } }).motion.eye)
    local scene = rt.scene { camera = camera { motion = { eye = { 1, 0, 5 } } } }
    scene:set_camera(camera {})
    assert.is_nil(scene:get_camera().motion)
  end)

  it("says what is wrong", function()
    raises("rt.camera: aperture must be from 0 to 1e+12; got -1", camera, { aperture = -1 })
    raises("rt.camera: aperture is not a number (NaN); look for 0/0 or a root of a negative number", camera, { aperture = 0 / 0 })
    raises("rt.camera: aperture and f_stop both say how wide the lens is; give one", camera, { aperture = 1, f_stop = 2 })
    raises("rt.camera: focus_distance and focus_at both say what is sharp; give one", camera, { focus_distance = 1, focus_at = { 0, 0, 0 } })
    raises("rt.camera: focus_distance must be greater than 0 and at most 1e+12; got -3", camera, { focus_distance = -3 })
    raises("rt.camera: focus_at lies behind the camera; what is sharp is ahead of it", camera, { focus_at = { 0, 0, 9 } })
    raises("rt.camera: blades must be a whole number from 3 to 64, or 0 for a round lens; got 2", camera, { blades = 2 })
    raises("rt.camera: shutter must be from 0 to 1; got 2", camera, { shutter = 2 })
    raises("rt.camera: shutter closes at 0.2, before it opens at 0.5", camera, { shutter = { 0.5, 0.2 } })
    raises("rt.camera: f_stop belongs to a pinhole camera; an orthographic one has an aperture", camera, { f_stop = 2, projection = "orthographic" })
    raises("rt.camera: unit says how many metres a scene unit is for f_stop, which is not given", camera, { unit = 2 })
    raises("rt.camera: eye and look_at are the same point", camera, { look_at = { 0, 0, 5 } })
    raises("rt.camera: motion: eye and look_at are the same point", camera, { motion = { eye = { 0, 0, 0 } } })
    raises("rt.camera: motion has no key 'eys'; did you mean eye?", camera, { motion = { eys = { 0, 0, 0 } } })
    raises("rt.camera: motion: height belongs to projection = 'orthographic'; a pinhole camera has fov", camera, { motion = { height = 2 } })
    raises("rt.camera: motion has another projection; a camera keeps its own", camera,
      { projection = "pinhole", motion = camera { projection = "orthographic" } })
    local message = support.message(of, { motion = { look_at = { 0, 0, 10 } } })
    assert.is_truthy(message:find("on the camera's way there is a time when eye and look_at meet", 1, true))
  end)

  it("blurs what is not sharp", function()
    local function at(t)
      local scene = rt.scene {
        camera = camera(t), background = { 0, 0, 0 },
        rt.sphere { center = { 0, 0, 0 }, radius = 0.5, material = rt.emissive { emission = { 1, 1, 1 } } },
      }
      local shown, half = scene:render { size = { 48, 48 }, samples = 32 }, 0
      for x = 0, 47 do
        local light = shown:pixel(x, 24)
        half = half + (light > 0.02 and light < 0.98 and 1 or 0)
      end
      return half
    end
    assert.is_true(at {} <= 2)
    assert.is_true(at { aperture = 0.5 } <= 4) -- sharp where look_at is
    assert.is_true(at { aperture = 0.5, focus_distance = 2 } > 12)
    assert.is_true(at { motion = { eye = { 1, 0, 5 }, look_at = { 1, 0, 0 } } } > 12)
    assert.is_true(at { motion = { eye = { 1, 0, 5 }, look_at = { 1, 0, 0 } }, shutter = 0 } <= 2)
    assert.is_true(at { motion = { eye = { 0.3, 0, 5 } } } <= 4) -- what look_at follows stays sharp
  end)
end)
