-- Drawing into images: other sizes, rectangles, labels, contact sheets.

local support = require "support"
local rt = support.rt

local function refused(sentence, f, ...)
  local arguments = table.pack(...)
  support.raises(sentence, function()
    f(table.unpack(arguments, 1, arguments.n))
  end)
end

local function plain(width, height, value)
  return rt.image { width = width, height = height, pixel = function() return value, value, value end }
end

describe("image:resize", function()
  it("keeps the shape, the mean and the old image", function()
    local image = rt.image { width = 40, height = 20, pixel = function(x) return x / 40, 0.5, 0 end }
    local small = image:resize(10)
    assert.same({ 10, 5 }, { small:size() })
    assert.same({ 8, 4 }, { image:resize(nil, 4):size() })
    assert.same({ 3, 9 }, { image:resize(3, 9, { filter = "lanczos" }):size() })
    assert.is_true(math.abs(small:stats().mean[1] - image:stats().mean[1]) < 1e-3)
    assert.same({ 40, 20 }, { image:size() })
    assert.equal(image:hash(), image:resize(40, 20):hash())
  end)

  it("gives the same bits on every machine", function()
    local image = rt.image { width = 9, height = 7, pixel = function(x, y) return rt.random(x, y), x / 8, y / 6 end }
    local hashes = {}
    for _, filter in ipairs { "box", "mitchell", "lanczos" } do
      hashes[#hashes + 1] = image:resize(5, 11, { filter = filter }):hash()
    end
    assert.same({ "f17d022dec665884861e658c7a2b6350", "525186c3425274b42d876a2225989de9", "d941fd49b9e6c948ff283d15b7702bc1" },
      hashes)
  end)

  it("refuses", function()
    local image = plain(2, 2, 1)
    refused("image:resize: a width or a height is missing", image.resize, image)
    refused("image:resize: the width must be a whole number from 1 to 1048576; got 0", image.resize, image, 0)
    refused("image:resize: filter must be one of auto, box, mitchell, lanczos; got 'lancos' (did you mean lanczos?)", image.resize, image, 1,
      1, { filter = "lancos" })
  end)
end)

describe("image:fill, place and label", function()
  it("draw and return the image", function()
    local image = plain(60, 30, 0)
    assert.equal(image, image:fill { x = 50, y = 20, width = 100, height = 100, color = { 1, 0, 0 }, coverage = 0.5 })
    assert.same({ 1, 0, 0, 0.5 }, { image:pixel(59, 29) })
    assert.same({ 0, 0, 0, 1 }, { image:pixel(49, 29) })
    assert.equal(image, image:place(plain(2, 2, 0.5), -1, -1))
    assert.same({ 0.5, 0.5, 0.5, 1 }, { image:pixel(0, 0) })
    assert.same({ 0, 0, 0, 1 }, { image:pixel(1, 0) })
    assert.equal(image, image:label("I", { x = 20, y = 2, size = 24, color = { 0, 1, 0 } }))
    local _, g = image:pixel(22, 12)
    assert.is_true(g > 0.9)
  end)

  it("take any bytes", function()
    local image = plain(200, 20, 0)
    image:label("\0\1\255<script>\u{1f600}\n\t$(x)", { size = 18 })
    local w, h = rt.label_size("a\nbb", { size = 18 })
    assert.is_true(w > 10 and h == 36)
    assert.equal(0, (rt.label_size ""))
  end)

  it("refuse", function()
    local image = plain(2, 2, 0)
    refused("image:fill: color is missing", image.fill, image, {})
    refused("image:label: the text must be a string; got 7", image.label, image, 7)
    refused("image:label: size must be from 4 to 1000; got 2", image.label, image, "a", { size = 2 })
    refused("image:place: the first argument must be an image, as rt.image gives it; got 'a.png'", image.place, image, "a.png")
    assert.is_truthy(support.message(image.place, image, image):find("cannot be placed in itself", 1, true))
  end)
end)

describe("rt.contact_sheet", function()
  it("takes images, files and holes", function()
    support.in_folder(function(folder)
      plain(30, 20, 1):save(folder .. "/white.png")
      local sheet = rt.contact_sheet { images = { plain(300, 200, 0.25), folder .. "/white.png", false, [5] = plain(1, 1, 1) }, columns = 2,
        labels = { "one", { "two", "this one is far too long for its cell and cut" }, [5] = "\255<b>" }, width = 60, height = 40, gap = 10,
        background = { 0, 0, 1 }, color = { 1, 1, 1 } }
      local w = sheet:size()
      assert.equal(2 * 60 + 3 * 10, w)
      assert.is_true(math.abs(sheet:pixel(40, 30) - 0.25) < 1e-6)
      assert.equal(1, (sheet:pixel(110, 30))) -- the file, enlarged to 60 x 40 by two
      assert.equal(0, (sheet:pixel(5, 5)))
      local copy = rt.contact_sheet { images = { plain(4, 4, 1) } }
      assert.same({ 240 + 2 * 16, 240 + 2 * 16 }, { copy:size() })
    end)
  end)

  it("refuses", function()
    local sheet = rt.contact_sheet
    refused("rt.contact_sheet: images is missing", sheet, {})
    refused("rt.contact_sheet: images is empty; a sheet needs one at least", sheet, { images = {} })
    refused("rt.contact_sheet: images[2] must be an image, the name of a file or false; got 3", sheet, { images = { false, 3 } })
    refused("rt.contact_sheet: images must be a list; it has the key 'x'", sheet, { images = { x = 1 } })
    refused("rt.contact_sheet: labels[1] must be a string or a list of strings, one a line; got true", sheet, { images = { false },
      labels = { true } })
    refused("rt.contact_sheet: a sheet of 1000 images in 1 columns is 4128 x 3088016 pixels, more than 67 million; " ..
      "take smaller cells or several sheets", sheet, { images = { [1000] = false }, columns = 1, width = 4096 })
    assert.is_truthy(support.message(sheet, { images = { "/nowhere/a.png" } }):find("/nowhere/a.png", 1, true))
  end)
end)
