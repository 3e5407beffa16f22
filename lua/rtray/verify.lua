-- rtray verify SCENE: the same image for any number of workers, tile size and structure; the same description from two runs of the script.

local sys = require "rtray.sys"
local child = require "rtray.child"
local files = require "rtray.files"
local json = require "rtray.json"
local output = require "rtray.output"
local source = require "rtray.source"

local verify = {}

local BRUTE_LIMIT = 10000 -- primitives
local CHEAP = 100000      -- samples of an image, when the command line does not say its size

local OWN = { cost = true, steps = true } -- views of the structure itself

local CAUSES = [[
The script describes another scene each time it runs. Usual causes: building in the order of `pairs` (walk sorted keys or a list), the time
(os.time, os.clock), random numbers from outside (math.randomseed without a fixed seed, files), addresses (tostring of a table).]]

-- Small enough that many renders take seconds; the shape stays.
local function size_of(scene, values)
  local settings = scene:effective()
  local width, height, samples = settings.width, settings.height, settings.samples
  if not values.size then
    samples = values.samples or math.min(samples, 2)
    local shrink = math.sqrt(math.min(1, CHEAP / (width * height * samples)))
    width, height = math.max(1, math.floor(width * shrink)), math.max(1, math.floor(height * shrink))
  end
  return width, height, samples
end

local function tracers_of(scene, values)
  if values.tracers_list then
    return values.tracers_list
  end
  local facts = scene:info()
  local count = facts.triangles + facts.shapes + facts.planes
  return count <= BRUTE_LIMIT and { "brute", "kdtree", "octree", "bvh" } or { "kdtree", "octree", "bvh" }, count > BRUTE_LIMIT and count or nil
end

-- Where an image begins to differ from the first one.
local function difference(first, image)
  local d = first:compare(image)
  return d.differing > 0 and ("%s of its pixels differ, the first is %d, %d"):format(output.count(d.differing), d.first[1], d.first[2])
    or "only coverage differs"
end

-- Renders every arrangement. Returns rows of { tracer, workers, hashes by tile, the hash expected } and the faults found. A view of the
-- structure itself is an image of its own for each.
local function render_all(scene, tracers, workers, tiles, size)
  local rows, faults, first, expected = {}, {}, nil, nil
  local own = OWN[scene:effective().integrator]
  for _, tracer in ipairs(tracers) do
    first = not own and first or nil
    for _, count in ipairs(workers) do
      local row = { tracer = tracer, workers = count, hashes = {} }
      for i, tile in ipairs(tiles) do
        local image = scene:render { tracer = tracer, workers = count, tile = tile, width = size[1], height = size[2], samples = size[3] }
        local hash = image:hash()
        row.hashes[i] = hash
        if not first then
          first, expected = image, hash
        else
          if hash ~= expected then
            faults[#faults + 1] = ("%s with %d worker%s and tiles of %d: %s"):format(tracer, count, count == 1 and "" or "s", tile,
              difference(first, image))
          end
          image:release()
        end
      end
      row.expected = expected
      rows[#rows + 1] = row
    end
  end
  return rows, faults, rows[1].expected
end

local function print_table(rows, tiles)
  local head = { "structure", "workers" }
  for i, tile in ipairs(tiles) do
    head[i + 2] = "tile " .. tile
  end
  local lines = { head }
  for _, row in ipairs(rows) do
    local line = { row.tracer, tostring(row.workers) }
    for i, hash in ipairs(row.hashes) do
      line[i + 2] = hash:sub(1, 12) .. (hash == row.expected and "" or " !")
    end
    lines[#lines + 1] = line
  end
  output.table(lines, { true, false, true, true, true, true, true, true, true })
end

local function as_json(path, rows, tiles, expected, same_description, equal)
  local list = {}
  for _, row in ipairs(rows) do
    for i, hash in ipairs(row.hashes) do
      list[#list + 1] = json.object():set("tracer", row.tracer):set("workers", row.workers):set("tile", tiles[i]):set("hash", hash)
    end
  end
  return json.object():set("scene", path):set("equal", equal):set("hash", expected):set("same_description", same_description):set("renders", list)
end

-- The description's hash from a second process, for scripts; nil for data files.
local function second_hash(path, values)
  if files.ending_of(path) ~= "lua" then
    return nil
  end
  return child.run("describe", path, values):match "^(%x+)"
end

function verify.run(command, values, arguments)
  local path = arguments[1]
  local workers, tiles = values.workers_list or { 1, 2, 3, 8 }, values.tiles_list or { 8, 16, 64 }
  local most = math.max(table.unpack(workers))
  require("rt").configure { workers = most }
  local scene = source.open(path, values, command).scene
  local width, height, samples = size_of(scene, values)
  local tracers, too_many = tracers_of(scene, values)
  if not values.quiet and not values.json then
    output.print("%s at %dx%d, %d sample%s", path, width, height, samples, samples == 1 and "" or "s")
    if too_many then
      output.print("brute force is left out: %s primitives (--tracers brute,kdtree,octree,bvh asks for it)", output.count(too_many))
    end
  end
  local begun = sys.now()
  local described, again = scene:hash(), second_hash(path, values) -- before a render frames a scene that has no camera
  local rows, faults, expected = render_all(scene, tracers, workers, tiles, { width, height, samples })
  local same = again == nil or again == described
  local equal = #faults == 0 and same
  if values.json then
    output.print("%s", json.encode(as_json(path, rows, tiles, expected, same, equal)))
    return equal and 0 or 4
  elseif not values.quiet then
    print_table(rows, tiles)
  end
  for _, fault in ipairs(faults) do
    output.print("differs: %s", fault)
  end
  if not same then
    output.print("the script gave the description %s here and %s in a second process.\n%s", described, again, CAUSES)
  end
  if equal and not values.quiet then
    local what = OWN[scene:effective().integrator] and "one image of each structure, the first " .. expected or "one image, " .. expected
    output.print("%s, in %d arrangements%s (%s)", what, #rows * #tiles,
      again and "; one description in two processes" or "", output.seconds(sys.now() - begun))
  end
  return equal and 0 or 4
end

return verify
