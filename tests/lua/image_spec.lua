-- Images.

local support = require "support"
local rt, raises = support.rt, support.raises

local function gradient()
  return rt.image { width = 4, height = 2, pixel = function(x, y) return x / 4, y / 2, 0.5 end }
end

describe("an image", function()
  it("has pixels counted from 0, from the top", function()
    local image = gradient()
    assert.same({ 0.75, 0.5, 0.5, 1 }, { image:pixel(3, 1) })
    image:set_pixel(0, 0, 1, 2, 3, 0.5)
    assert.same({ 1, 2, 3, 0.5 }, { image:pixel(0, 0) })
    assert.equal("rt.image(4 x 2)", tostring(image))
    raises("rt.image: pixel(0, 1) must return three numbers; got 1, nil, nil", function()
      return rt.image { width = 1, height = 2, pixel = function(_, y) if y == 0 then return 1, 1, 1 end return 1 end }, nil
    end)
    raises("pixel 4, 0 is outside of the image's 0 ... 3, 0 ... 1", function() return image:pixel(4, 0), nil end)
    raises("pixel -1, 0 is outside of the image's 0 ... 3, 0 ... 1", function() return image:pixel(-1, 0), nil end)
    raises("pixel 0.5, 0 is outside of the image's 0 ... 3, 0 ... 1", function() return image:pixel(0.5, 0), nil end)
  end)

  it("has statistics and a hash", function()
    local stats = gradient():stats()
    assert.same({ 0, 0, 0.5 }, stats.min)
    assert.same({ 0.75, 0.5, 0.5 }, stats.max)
    assert.same({ 0.375, 0.25, 0.5 }, stats.mean)
    assert.equal(0, stats.not_finite)
    assert.equal(gradient():hash(), gradient():hash())
    local other = gradient()
    other:set_pixel(0, 0, 0 / 0, 0, 0)
    assert.not_equal(gradient():hash(), other:hash())
    assert.equal(1, other:stats().not_finite)
  end)

  it("is compared", function()
    local a, b = gradient(), gradient()
    assert.equal(0, rt.compare(a, b).differing)
    assert.equal(math.huge, a:compare(b).psnr)
    assert.is_true(math.abs(a:compare(b).ssim - 1) < 1e-12)
    b:set_pixel(2, 1, 0, 0, 0)
    local d = a:compare(b, { map = true })
    assert.equal(1, d.differing)
    assert.is_true(d.ssim < 0.999 and d.ssim > -1)
    assert.same({ 2, 1 }, d.first)
    assert.same({ 4, 2 }, { d.map:size() })
    assert.is_nil(a:compare(b).map)
    assert.is_nil(a:compare(b).flip)
    assert.equal(0, a:compare(a, { flip = true }).flip)
    local near, far = a:compare(b, { map = "flip" }), a:compare(b, { flip = true, ppd = 10 })
    assert.is_true(near.flip > 0 and near.flip < 1 and far.flip > 0 and far.flip ~= near.flip)
    assert.equal(near.flip, b:compare(a, { flip = true }).flip)
    assert.is_true(math.abs(near.map:stats().mean[1] - near.flip) < 1e-6)
    local similar = a:compare(b, { map = "ssim" }) -- of an image below 11 x 11 all windows count
    assert.is_true(math.abs(1 - similar.map:stats().mean[1] - similar.ssim) < 1e-6)
    assert.is_truthy(support.message(a.compare, a, b, { map = "hue" }):find('true, false, "difference", "ssim" or "flip"; got', 1, true))
    assert.is_truthy(support.message(a.compare, a, b, { ppd = 0 }):find("ppd must be", 1, true))
    local message = support.message(rt.compare, a, rt.image { width = 3, height = 2 })
    assert.is_truthy(message:find "4" and message:find "3", message)
  end)

  it("shows its values as colours", function()
    local values = rt.image { width = 3, height = 1, pixel = function(x) return 0, 2 * x, x end } -- the largest counts: 0, 2, 4
    local shown = values:color_map("magma", { high = 4 })
    for x = 0, 2 do
      local r, g, b, coverage = shown:pixel(x, 0)
      for k, want in ipairs(rt.color_map("magma", x / 2)) do
        assert.is_true(math.abs(({ r, g, b })[k] - want) < 1e-6)
      end
      assert.equal(1, coverage)
    end
    assert.same({ 0, 0, 0 }, rt.color_map("grey", -1))
    assert.is_truthy(support.message(rt.color_map, "jet", 0):find "viridis")
    assert.is_truthy(support.message(values.color_map, values, "grey", { low = 2, high = 1 }):find("low must be below high", 1, true))
  end)

  it("is saved and read", function()
    support.in_folder(function(folder)
      for _, ending in ipairs { "png", "bmp", "tga" } do
        local path = folder .. "/an image." .. ending
        assert.equal("rt.image(4 x 2)", tostring(gradient():save(path)))
        local back = rt.image(path)
        assert.same({ 4, 2 }, { back:size() })
        assert.is_true(math.abs(back:pixel(3, 1) - 0.75) < 0.01)
      end
      gradient():save(folder .. "/x.dat", { format = "png", alpha = true, exposure = -1 })
      assert.is_true(math.abs(rt.image(folder .. "/x.dat"):pixel(3, 1) - 0.375) < 0.01)
      local message = support.message(gradient().save, gradient(), folder .. "/none/x.png")
      assert.is_truthy(message:find("none/x.png", 1, true), message)
      message = support.message(gradient().save, gradient(), folder .. "/x.xyz")
      assert.is_truthy(message:find("xyz", 1, true), message)
      message = support.message(rt.image, folder)
      assert.is_truthy(message:find(folder, 1, true), message)
      message = support.message(rt.image, support.write(folder .. "/cut.png", "\137PNG\r\n\26\n"))
      assert.is_truthy(message:find("cut.png", 1, true), message)
    end)
    raises("image:save has no key 'exposur'; did you mean exposure?", function() return gradient():save("x.png", { exposur = 1 }), nil end)
    raises("image:save: quality must be a whole number from 1 to 100; got 0", function() return gradient():save("x.jpg", { quality = 0 }), nil end)
  end)

  it("has text entries", function()
    local image = gradient()
    image:set_text("Author", "nobody")
    assert.equal("nobody", image:text "Author")
    assert.is_nil(image:text "Title")
    raises("set_text: the value has a NUL byte inside", function() return image:set_text("a", "b\0c"), nil end)
    raises("the key has 0 bytes; it must have 1 ... 79", function() return image:set_text("", "x"), nil end)
  end)

  it("has its text read from its file", function()
    support.in_folder(function(folder)
      local script = "return '<script>$(x)%s\"\\\r\n\n\255' -- \195\164\n"
      for _, ending in ipairs { "png", "hdr" } do
        local path = folder .. "/it's $(an) image." .. ending
        local image = gradient()
        image:set_text("Author", "nobody")
        image:save(path, { text = { Script = script, Hash = image:hash(), Author = "me" } })
        assert.same({ Author = "me", Hash = image:hash(), Script = script }, rt.image_text(path))
        assert.equal("nobody", image:text "Author")
        image:save(path, { text = false })
        assert.same({}, rt.image_text(path))
        support.ball():render_to_file(path, { save = { text = { Script = script } } })
        assert.same({ Script = script }, rt.image_text(path))
      end
      assert.same({}, rt.image_text(gradient():save(folder .. "/x.bmp") and folder .. "/x.bmp"))
      local message = support.message(rt.image_text, support.write(folder .. "/cut.png", "\137PNG\r\n\26\n"))
      assert.is_truthy(message:find("cut.png: byte 8: this PNG file is cut", 1, true), message)
    end)
    local function text(value)
      return function() return gradient():save("x.png", { text = value }), nil end
    end
    raises("image:save: text must be true, false or a table { Title = \"...\" }; got 3", text(3))
    raises("image:save: text has the key 1; its keys must be strings, as in { Title = \"...\" }", text { "x" })
    raises("image:save: text.Title must be a string; got 4", text { Title = 4 })
    raises("image:save: text.Title must be a string; got one with a NUL byte inside", text { Title = "a\0" })
    raises("saving an image: the key has 0 bytes; it must have 1 ... 79", text { [""] = "a" })
  end)

  it("is released twice, and says so", function()
    local image = gradient()
    image:release()
    image:release()
    assert.equal("rt.image (released)", tostring(image))
    raises("the image has been released", function() return image:hash(), nil end)
    local closed <close> = gradient()
    assert.equal(32, #closed:hash())
  end)

  it("tells the collector its size", function()
    collectgarbage()
    local _, before = rt.machine(), rt.machine().memory
    for _ = 1, 200 do
      rt.image { width = 512, height = 512 } -- 4 MiB each
    end
    local held = rt.machine().memory - before
    assert.is_true(held < 400 << 20, ("%d MiB of images wait for the collector"):format(held >> 20))
    collectgarbage()
    collectgarbage()
    rt.drop_kept()
    assert.is_true(rt.machine().memory - before <= 0)
  end)

  it("is a texture", function()
    local image = rt.image { width = 2, height = 2, pixel = function(x) return x, 0, 1 end }
    local scene = rt.scene {
      camera = rt.camera { eye = { 1, 1, 5 }, look_at = { 1, 1, 0 }, projection = "orthographic", height = 2 }, ambient = { 1, 1, 1 },
      rt.plane { point = { 0, 0, 0 }, normal = { 0, 0, 1 }, texture_size = 2, material = rt.classic {
        ambient = 1, diffusion = 0, texture = rt.texture { image = image, nearest = true },
      } },
    }
    local made = scene:render { width = 2, height = 2, samples = 1 }
    assert.same({ 0, 0, 1 }, { table.unpack({ made:pixel(0, 0) }, 1, 3) })
    assert.same({ 1, 0, 1 }, { table.unpack({ made:pixel(1, 0) }, 1, 3) })
  end)
end)
