-- Runs a scene script with several values of one of its parameters and lays the pictures side by side.
-- lua5.4 series.lua scenes/paper.lua ior 1 1.2 1.5 2

local rt = require "rt"

local script, name = arg[1], arg[2]
if not (script and name and arg[3]) then
  io.stderr:write "usage: lua5.4 series.lua SCRIPT PARAMETER VALUE ...\n"
  os.exit(2)
end

-- What does not depend on the parameter (trees above all) is built once: librt knows it again by its content.
local pictures = {}
for i = 3, #arg do
  local scene = rt.load(script, { [name] = arg[i] }, { settings = { width = 240, height = 168, samples = 4 } })
  pictures[#pictures + 1] = scene:render()
  print(name .. " = " .. arg[i], pictures[#pictures]:hash())
end

local width, height = pictures[1]:size()
local sheet = rt.image {
  width = width * #pictures, height = height,
  pixel = function(x, y)
    return pictures[x // width + 1]:pixel(x % width, y)
  end,
}
sheet:save "series.png"
