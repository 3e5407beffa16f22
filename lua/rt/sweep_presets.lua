-- Sweeps by name: each gives axes { name, values as --over has them }, in their order; the command line's axes of the same name take their place.

local core = require "rt.core"

local presets = {}

-- 1, 2, 4, ... up to the CPUs of this machine, and these.
local function worker_counts()
  local cpus = core.machine()
  local list, w = {}, 1
  while w < cpus do
    list[#list + 1] = w
    w = w * 2
  end
  list[#list + 1] = cpus
  return list
end

local function round(x)
  return math.max(1, math.floor(x + 0.5))
end

presets.list = {
  {
    name = "jpvm", help = "workers 1, 2, 4, 8, 16 at 500x500 and 1000x700: the experiment of the paper on JPVM",
    axes = function()
      return { { "size", "500x500,1000x700" }, { "workers", "1,2,4,8,16" } }
    end,
  },
  {
    name = "strong", help = "workers 1, 2, 4, ... up to the CPUs",
    axes = function()
      return { { "workers", table.concat(worker_counts(), ",") } }
    end,
  },
  {
    name = "weak", help = "workers 1, 2, 4, ... up to the CPUs, with as many pixels more", zip = true, weak = true,
    axes = function(settings)
      local sizes, counts = {}, worker_counts()
      for i, w in ipairs(counts) do
        sizes[i] = ("%dx%d"):format(round(settings.width * w ^ 0.5), round(settings.height * w ^ 0.5))
      end
      return { { "workers", table.concat(counts, ",") }, { "size", table.concat(sizes, ",") } }
    end,
  },
  {
    name = "structures", help = "each structure by each of its builders", zip = true, -- a builder is of one structure
    axes = function()
      return { { "tracer", "bvh,bvh,bvh,kdtree,kdtree,kdtree,octree" }, { "builder", "auto,compact,spatial,exact,binned,paper,auto" } }
    end,
  },
  {
    name = "tiles", help = "tiles of 8 to 128 pixels, given out both ways",
    axes = function()
      return { { "schedule", "dynamic,static" }, { "tile", "8:128:*2" } }
    end,
  },
}

for _, preset in ipairs(presets.list) do
  presets[preset.name] = preset
end

return presets
