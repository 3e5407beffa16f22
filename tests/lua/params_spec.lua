-- Declared parameters, sets, settings: what wins, and the sentences.

local support = require "support"
local rt = support.rt

local SCRIPT = [[
local rt = require "rt"
local p = rt.params {
  ior = { 1.5, min = 1, max = 2.5, step = 0.1, help = "index" },
  count = { 3, type = "integer" },
  lit = true,
  hue = { "red", choices = { "red", "green" } },
  tint = { { 1, 0.5, 0 }, type = "color" },
  axis = { 0, 1, 0 },
  title = "x",
  picture = { "a.png", type = "file" },
  sets = { draft = { ior = 1.2, samples = 2, size = { 20, 10 } } },
}
return { ior = p.ior, count = p.count, lit = p.lit, hue = p.hue, tint = p.tint, axis = p.axis, title = p.title, picture = p.picture, list = p }
]]

local function with_script(text, f)
  support.in_folder(function(folder)
    f(support.write(folder .. "/s.lua", text), folder)
  end)
end

-- A script's results, which are no scene, wrapped as a function.
local function run(path, ...)
  local f, r = rt.load(path, ...)
  return f(), r
end

local FUNCTION = SCRIPT:gsub("return { ior", "local result = { ior") .. "\nreturn function() return result end\n"

describe("rt.params", function()
  it("gives the defaults", function()
    with_script(FUNCTION, function(path)
      local v, r = run(path)
      assert.equal(1.5, v.ior)
      assert.is_true(v.lit)
      assert.equal("red", v.hue)
      assert.equal(rt.vec(0, 1, 0), v.axis)
      assert.equal(8, #r.params)
      assert.equal("axis", r.params[1].name)
      assert.equal("vector", r.params[1].type)
      assert.equal("default", r.params[1].source)
      assert.equal("integer", r.params[2].type)
      local ior = r.params[4]
      assert.same({ "ior", "number", 1, 2.5, 0.1, "index" }, { ior.name, ior.type, ior.min, ior.max, ior.step, ior.help })
    end)
  end)

  it("lets the command line win over a set, and a set over the default", function()
    with_script(FUNCTION, function(path)
      local v, r = run(path, {}, { set = "draft" })
      assert.equal(1.2, v.ior)
      assert.equal("set draft", r.params[4].source)
      v, r = run(path, { ior = "1.7" }, { set = "draft" })
      assert.equal(1.7, v.ior)
      assert.equal("command line", r.params[4].source)
      assert.equal(2, r.sets.draft.settings.samples)
      assert.equal(20, r.sets.draft.settings.width)
    end)
  end)

  it("reads texts by type", function()
    with_script(FUNCTION, function(path)
      local v = run(path, { count = "7", lit = "no", hue = "green", tint = "0,0.5,1", axis = "{1, 0, 0}", title = "1.5", picture = "/b.png" })
      assert.equal(7, v.count)
      assert.is_false(v.lit)
      assert.equal("green", v.hue)
      assert.equal(rt.vec(0, 0.5, 1), v.tint)
      assert.equal(rt.vec(1, 0, 0), v.axis)
      assert.equal("1.5", v.title)
      assert.equal("/b.png", v.picture)
      assert.is_truthy(run(path, { picture = "b.png" }).picture:find "^/.*/b.png$") -- from the command line, relative to where that is
      assert.equal(rt.srgb "#ff0000", run(path, { tint = "#ff0000" }).tint)
      assert.equal(9, run(path, { count = 9 }).count)
    end)
  end)

  local function fails(path, sentence, ...)
    local message = support.message(rt.load, path, ...)
    assert.is_truthy(message:find(sentence, 1, true), "expected: " .. sentence .. "\n     got: " .. message)
    assert.is_truthy(message:find("s.lua:2: ", 1, true) or message:find("s.lua: ", 1, true), "no place in: " .. message)
  end

  it("says what is wrong with a value", function()
    with_script(FUNCTION, function(path)
      fails(path, "-D ior: ior must be from 1 to 2.5; got 3.0", { ior = "3.0" })
      fails(path, "-D ior: ior must be a number from 1 to 2.5; got 'glass'", { ior = "glass" })
      fails(path, "-D ior: ior is not a number (NaN)", { ior = 0 / 0 })
      fails(path, "-D count: count must be a whole number; got '1.5'", { count = "1.5" })
      fails(path, "-D hue: hue must be one of red, green; got 'greem' (did you mean green?)", { hue = "greem" })
      fails(path, "-D axis: axis must be three numbers, as 1,0,0; got '1,0'", { axis = "1,0" })
      fails(path, "-D: the script has no parameter 'iro'; did you mean ior?", { iro = "1" })
      fails(path, "--set: the script has no set 'draf'; did you mean draft?", {}, { set = "draf" })
    end)
  end)

  local declarations = {
    { "width = 5", "rt.params: 'width' is a setting's name; a parameter needs another" },
    { "a = { min = 1 }", "rt.params: a: the default is missing; it stands first, as in { 1.5, min = 1 }" },
    { "a = { 1, mim = 1 }", "rt.params: a has no key 'mim'; did you mean min?" },
    { "a = { 1, min = 2 }", "rt.params: a must be at least 2; got 1" },
    { "a = { 1, min = 2, max = 1 }", "rt.params: a: min 2 is above max 1" },
    { "a = { true, min = 1 }", "rt.params: a: min is for numbers, and this is a boolean" },
    { "a = { {1, 0, 0}, step = 1 }", "rt.params: a: step is for numbers, and this is a vector" },
    { "a = { 1, type = 'integer', step = 0.5 }", "rt.params: a: the step of an integer must be a whole number; got 0.5" },
    { "a = { 1, type = 'number', choices = { 'b' } }", "rt.params: a: choices are for the type choice, and this is a number" },
    { "transport = 5", "rt.params: 'transport' is a setting's name; a parameter needs another" },
    { "a = { 'x', type = 'choice' }", "rt.params: a: choices are missing, as in choices = { 'red', 'green' }" },
    { "a = { 1, type = 'numbr' }", "rt.params: a: type must be one of number, integer, boolean, choice, color, vector, string, file; got 'numbr'" },
    { "['a b'] = 1", "rt.params: a parameter's name must be a word of letters, digits and _; got 'a b'" },
    { "a = print", "rt.params: a: the default must be a number, boolean, string or {x, y, z}; got a function" },
    { "a = 1, sets = { d = { b = 1 } }", "rt.params: set 'd' has no parameter or setting 'b'" },
    { "a = 1, sets = { d = { a = 'x' } }", "rt.params: set 'd': a must be a number; got 'x'" },
    { "a = 1, sets = { d = { samples = 0 } }", "rt.params: set 'd': samples must be a whole number from 1 to 65536; got 0" },
  }
  for _, row in ipairs(declarations) do
    it("refuses " .. row[1], function()
      with_script('local rt = require "rt"\nrt.params { ' .. row[1] .. " }\n", function(path)
        fails(path, row[2])
      end)
    end)
  end

  it("gives values that know their names", function()
    with_script('local rt = require "rt"\nlocal p = rt.params { ior = 1 }; print(p.iorr)\n', function(path)
      fails(path, "rt.params has no parameter 'iorr'; did you mean ior?")
    end)
    with_script('local rt = require "rt"\nlocal p = rt.params { ior = 1 }; p.x = 2\n', function(path)
      fails(path, "rt.params: 'x' cannot be assigned")
    end)
    with_script('local rt = require "rt"\nlocal p = rt.params { ior = 1 }; p.ior = 3\n', function(path)
      fails(path, "rt.params: 'ior' cannot be assigned; parameters are set on the command line, by a set, or by their default")
    end)
  end)

  it("gives values that pairs lists", function()
    local text = 'local rt = require "rt"\nlocal t = {}\nfor k, v in pairs(rt.params { ior = 1, n = 2 }) do t[k] = v end\n' ..
      "return function() return t end\n"
    with_script(text, function(path)
      assert.same({ ior = 7, n = 2 }, (run(path, { ior = 7 })))
    end)
  end)
end)

describe("settings", function()
  it("are won by the command line, then the set, then the script, then the built-in", function()
    with_script([[
      local rt = require "rt"
      rt.params { a = 1, sets = { draft = { samples = 2, tile = 9 } } }
      return rt.scene { settings = { samples = 4, tile = 8, height = 10, max_depth = 3 } }
    ]], function(path)
      local scene = rt.load(path, {}, { set = "draft", settings = { samples = 1 } })
      local values, sources = scene:effective { height = 11 }
      assert.same({ 1, 9, 11, 3, 800 }, { values.samples, values.tile, values.height, values.max_depth, values.width })
      assert.same({ "command line", "set draft", "argument", "script", "built in" },
        { sources.samples, sources.tile, sources.height, sources.max_depth, sources.width })
      assert.equal(4, (rt.load(path):effective()).samples)
    end)
  end)

  it("are listed with limits and defaults", function()
    local list = rt.settings()
    assert.equal("width", list[1].name)
    assert.equal(800, list[1].default)
    for _, row in ipairs(list) do
      assert.is_string(row.help)
    end
  end)

  it("are checked", function()
    support.raises("rt.scene: settings has no setting 'sampels'; did you mean samples?", function()
      return rt.scene { settings = { sampels = 4 } }, nil
    end)
    support.raises("rt.scene: settings: integrator must be one of whitted, path, ao, normal, uv, id, depth, cost, steps; got 'pathtracer'", function()
      return rt.scene { settings = { integrator = "pathtracer" } }, nil
    end)
  end)
end)
