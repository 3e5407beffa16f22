-- The program run by itself, in a fresh process, for commands that compare or time runs. `describe` and `measure` are the hidden commands so run;
-- they print one line of words.

local sys = require "rtray.sys"
local output = require "rtray.output"
local sandbox = require "rtray.sandbox"
local source = require "rtray.source"

local child = {}

-- The options that decide what a scene is, as a command line has them.
local function scene_arguments(values)
  local list = sandbox.arguments(values)
  if values.set then
    list[#list + 1] = "--set=" .. values.set
  end
  if values.seed then
    list[#list + 1] = ("--seed=%d"):format(values.seed)
  end
  if values.frame then
    list[#list + 1] = ("--frame=%d"):format(values.frame)
  end
  return list
end

-- Runs `rtray NAME PATH` with the scene's options and further ones; gives its output.
function child.run(name, path, values, more)
  local program = sys.program()
  if not program then
    error({ status = 3, message = "the program cannot find its own file (/proc is missing), so it cannot start a second process" }, 0)
  end
  local command = { program, name }
  for _, list in ipairs { scene_arguments(values), more or {}, { "--", path } } do
    table.move(list, 1, #list, #command + 1, command)
  end
  local text, status = sys.run(command)
  if not text then
    error({ status = 3, message = "a second process could not be started: " .. status }, 0)
  elseif sys.interrupted() then
    error "interrupted"
  elseif status ~= 0 then
    error({ status = status < 128 and status or 3, message = ("the run in a process of its own ended with status %d"):format(status) }, 0)
  end
  return text
end

-- rtray describe SCENE: the hash of the description.
function child.describe(command, values, arguments)
  output.print("%s", source.open(arguments[1], values, command).scene:hash())
  return 0
end

-- rtray measure SCENE: one render without a file, timed: seconds, of the trees, rays, workers, hash.
function child.measure(command, values, arguments)
  local scene = source.open(arguments[1], values, command).scene
  local image, stats = scene:render()
  output.print("%.9g %.9g %d %d %s", stats.seconds, stats.build_seconds, stats.rays, stats.workers, image:hash())
  return 0
end

-- rtray build SCENE: its trees: name, group, seconds, nodes, depth, SAH cost, bytes; a line each.
function child.build(command, values, arguments)
  local more = { accel = values.tracers_list and table.concat(values.tracers_list, ",") }
  local facts = source.open(arguments[1], values, command, more).scene:info()
  for _, t in ipairs(facts.trees) do
    output.print("%s %s %.9g %d %d %.9g %d", t.name, t.group, t.build_seconds, t.nodes, t.depth, t.sah_cost, t.bytes)
  end
  return 0
end

return child
