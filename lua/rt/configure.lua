-- The renderer behind the module: what it runs on, and which settings there are.

local core = require "rt.core"
local check = require "rt.check"
local settings = require "rt.settings"

local configure = {}

local fields = { workers = check.integer { low = 0, high = 1024 }, memory_limit = check.integer { low = 0, high = math.maxinteger } }

-- rt.configure { workers = 1, memory_limit = 2^30 } before the first scene or image: workers = 1 means no thread of librt's own.
function configure.configure(t)
  check.plain_table(t, "rt.configure", "rt.configure { workers = 2 }")
  if not core.configure(check.fields(t, fields, "rt.configure")) then
    check.fail("rt.configure must come before the first scene or image")
  end
end

-- { cpus, isa, memory_available, workers, memory, memory_peak }: what the machine has, and what the renderer takes.
function configure.machine()
  local cpus, available, isa = core.machine()
  local now, peak = core.memory()
  return { cpus = cpus, isa = isa, memory_available = available, workers = core.workers(), memory = now, memory_peak = peak }
end

-- { files_read, files_kept, trees_built, top_trees_built, trees_kept, trees_refitted, read_seconds, build_seconds, saved_seconds } since the program
-- began: what reading files and building trees cost, and what was taken over from earlier scenes.
function configure.counts()
  return core.counts()
end

-- Lets go of files and trees that are only kept for later scenes.
function configure.drop_kept()
  core.drop_kept()
end

-- The settings in their order, each { name, kind, low, high, choices, help, default }.
function configure.settings()
  local defaults, list = settings.defaults(), {}
  for i, row in ipairs(settings.list) do
    list[i] = {
      name = row.name, kind = row.kind, low = row.low, high = row.high, choices = row.choices, help = row.help, default = defaults[row.name],
    }
  end
  return list
end

return configure
