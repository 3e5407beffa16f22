-- rtray bench rays SCENE...: how fast rays are answered. The benchmark is C (tests/bench/rays), and the judge of its options; here scripts are run
-- and its table of options becomes rows of the program's.

local sys = require "rtray.sys"
local files = require "rtray.files"
local options = require "rtray.options"

local rays = {}

local table_of_options, definitions, columns = sys.bench_rays_options()
local SHORT = { ["--output"] = "-o", ["--quiet"] = "-q" }
local FILES = { ["--output"] = true, ["--camera"] = true, ["--rays"] = true }

-- The rows for commands.lua: what a script takes, then the benchmark's own.
function rays.options()
  local list = options.take("define", "set", "frame")
  local help = table.remove(list)
  for _, row in ipairs(table_of_options) do
    if row.name ~= "--help" then
      list[#list + 1] = {
        key = row.name, names = { SHORT[row.name] or row.name, SHORT[row.name] and row.name or nil }, value = row.value, many = row.value and true,
        type = row.value and (FILES[row.name] and "file" or "text") or nil, help = row.help, rays = true,
        reads = row.name == "--rays" or row.name == "--camera",
      }
    end
  end
  list[#list + 1] = help
  return list
end

rays.text = [[
Measures how fast rays are answered: by each tracer of the library and, with --against embree, by Embree 3, on the same rays in the same run, the
repeats of all rows interleaved. A SCENE is a script, a mesh file, a saved snapshot, or a name: sphere is generated (998,000 triangles), and so are
spheres1k, spheres100k and spheres1m (so many spheres in a box); others as sponza are NAME.ply in the folder of scenes. The camera is the scene's, of
a mesh the one in cameras.json beside it; --eye and --at give another. A file called rays is written ./rays.

]] .. definitions .. "\n\n" .. columns

local function arguments_of(command, values, scenes)
  local list = {}
  for _, option in ipairs(command.options) do
    local given = option.rays and values[option.key]
    for _, value in ipairs(type(given) == "table" and given or {}) do
      list[#list + 1] = option.key .. "=" .. value
    end
    list[#list + 1] = given == true and option.key or nil
  end
  list[#list + 1] = "--"
  return table.move(scenes, 1, #scenes, #list + 1, list)
end

local function check_output(values)
  for _, path in ipairs(values["--output"] or {}) do
    files.check_output(path)
  end
end

function rays.run(command, values, scenes)
  local kept = {} -- scenes live as long as the benchmark
  local function open(name)
    if not (name:find "%.lua$" or name:find "%.sdf$") then
      return nil
    end
    local scene = require("rtray.source").open(name, values, command).scene
    check_output(values)
    scene:commit()
    kept[#kept + 1] = scene
    return scene.handle
  end
  local function stop()
    return sys.interrupted() ~= nil
  end
  check_output(values)
  sys.defer(true)
  local ok, status = pcall(sys.bench_rays, arguments_of(command, values, scenes), open, stop)
  sys.defer(false)
  if not ok then
    error(status, 0)
  end
  return status
end

return rays
