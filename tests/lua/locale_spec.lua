-- A host program that has set a German locale, where Lua itself writes 1,5: what the module reads and writes keeps its points.

local support = require "support"
local rt = support.rt

local SCRIPT = [[
local rt = require "rt"
local p = rt.params { ior = { 1.5, min = 1, max = 2.5 }, tint = { {1, 0.5, 0.25}, type = "color" } }
return rt.scene {
  rt.sphere { center = {0, 0, p.ior}, radius = 0.5, material = rt.classic { color = p.tint } },
  rt.point_light { at = {0.5, 1.5, 2.5} },
}
]]

-- f under a locale; nil when the machine lacks it.
local function under(locale, f)
  if not os.setlocale(locale) then
    return nil
  end
  local ok, result = pcall(f)
  os.setlocale "C"
  return assert(ok and result, result)
end

local function all_of(folder)
  local path = support.write(folder .. "/scene.lua", SCRIPT)
  local loaded = rt.load(path, { ior = "1.25", tint = "0.25,0.5,0.75" })
  local paper = rt.load "scenes/paper.sdf"
  local message = support.message(rt.load, path, { ior = "9.5" })
  local script = {}
  local reader, writer = require "rt.sdf", require "rt.sdf_script"
  assert(reader and writer)
  loaded:render { size = { 8, 8 }, samples = 1 }:save(folder .. "/x.hdr")
  script[1] = loaded:hash()
  script[2] = paper:hash()
  script[3] = message:match "scene.lua.*"
  script[4] = tostring(rt.vec(1.5, 2, -0.25))
  script[5] = tostring(rt.translate { 0.5, 0, 0 })
  script[6] = support.message(rt.sphere, { center = { 0, 0, 0 }, radius = -0.5 }):match "radius.*"
  script[7] = rt.image(folder .. "/x.hdr"):hash()
  return table.concat(script, "\n")
end

describe("a German locale in the host", function()
  it("changes no number that is read or written", function()
    support.in_folder(function(folder)
      local plain = under("C", function() return all_of(folder) end)
      assert.truthy(plain:find("must be from 1 to 2.5; got 9.5", 1, true), plain)
      local german = under("de_DE.UTF-8", function()
        assert(tostring(1.5) == "1,5")
        return all_of(folder)
      end)
      if not german then
        pending "the machine has no de_DE.UTF-8"
        return
      end
      assert.equal(plain, german)
    end)
  end)
end)
