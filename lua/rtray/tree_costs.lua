-- What rays cost in each tracer: camera rays pixel by pixel, and random lines against the model that trees are built by.

local guard = require "rt.guard"
local files = require "rtray.files"
local output = require "rtray.output"
local svg = require "rtray.svg"

local tree_costs = {}

local LINES = 20000
local MEASURES = { "nodes", "leaves", "tests" }

-- ---- camera rays ----

local function summary(counts, total)
  local sum, most, seen, at95 = 0, 0, 0, nil
  for value = 0, counts.most do
    local n = counts[value]
    if n then
      sum, most, seen = sum + n * value, value, seen + n
      at95 = at95 or seen >= 0.95 * total and value or nil
    end
  end
  return { mean = sum / total, p95 = at95, max = most }
end

local function add(counts, value)
  counts[value] = (counts[value] or 0) + 1
  counts.most = math.max(counts.most, value)
end

-- Renders the view "steps" and counts: { image, rays, nodes, leaves, tests, steps }, the last four with mean, p95, max. steps: nodes + tests.
function tree_costs.camera(scene, tracer, width, height)
  local image = scene:render { integrator = "steps", tracer = tracer, width = width, height = height, samples = 1 }
  local counts = { { most = 0 }, { most = 0 }, { most = 0 }, { most = 0 } }
  for y = 0, height - 1 do
    for x = 0, width - 1 do
      local nodes, leaves, tests = image:pixel(x, y)
      add(counts[1], nodes // 1 | 0)
      add(counts[2], leaves // 1 | 0)
      add(counts[3], tests // 1 | 0)
      add(counts[4], (nodes + tests) // 1 | 0)
    end
  end
  local result = { tracer = tracer, image = image, width = width, height = height, rays = width * height, steps = summary(counts[4], width * height) }
  for i, name in ipairs(MEASURES) do
    result[name] = summary(counts[i], width * height)
  end
  return result
end

function tree_costs.print(list)
  local rows = { { "tracer", "nodes", "95%", "max", "leaves", "95%", "max", "tests", "95%", "max" } }
  for _, c in ipairs(list) do
    local row = { c.tracer }
    for _, name in ipairs(MEASURES) do
      row[#row + 1] = ("%.2f"):format(c[name].mean)
      row[#row + 1] = tostring(c[name].p95)
      row[#row + 1] = tostring(c[name].max)
    end
    rows[#rows + 1] = row
  end
  output.table(rows, { true })
end

local function linear(byte)
  local x = byte / 255
  return x <= 0.04045 and x / 12.92 or ((x + 0.055) / 1.055) ^ 2.4
end

-- The costs as colours, up to `high` steps.
local function picture(cost, high)
  local rt = require "rt"
  local image, table_of = cost.image, {}
  for i = 0, 255 do
    local r, g, b = svg.ramp(i / 255)
    table_of[i] = { linear(r), linear(g), linear(b) }
  end
  return rt.image {
    width = cost.width, height = cost.height,
    pixel = function(x, y)
      local nodes, _, tests = image:pixel(x, y)
      local color = table_of[math.floor(math.min(1, (nodes + tests) / high) * 255 + 0.5)]
      return color[1], color[2], color[3]
    end,
  }
end

-- Writes the cost layer of a tracer as DIR/cost-TRACER.png, and with scale and numbers as SVG text, the picture inside. high: the end of the scale.
function tree_costs.layer(cost, high, title, png_path)
  files.check_output(png_path)
  guard.own(png_path)
  picture(cost, high):save(png_path)
  local file <close> = assert(io.open(png_path, "rb"))
  local bytes = file:read "a"
  local page = svg.page(cost.width + 170, math.max(cost.height, 260) + 90, title)
  page:text(16, 26, title, { size = 16, weight = true })
  page:text(16, 46, ("inner nodes visited + primitives tested a camera ray; mean %.1f, 95%% at most %d, max %d"):format(cost.steps.mean,
    cost.steps.p95, cost.steps.max), { color = "#555555" })
  page:add(('<image x="16" y="64" width="%d" height="%d" href="data:image/png;base64,%s"/>\n'):format(cost.width, cost.height, svg.base64(bytes)))
  page:scale(cost.width + 36, 90, math.max(160, math.min(cost.height - 60, 360)), 0, high, "steps",
    cost.steps.max > high and ("dark: %d and above"):format(high) or nil)
  return page:finish()
end

-- A common end of the scales: where the dearest tracer but brute force has 99 of 100 rays, so that a few rays do not darken the rest.
function tree_costs.scale_of(list)
  local high = 1
  for _, c in ipairs(list) do
    if c.tracer ~= "brute" or #list == 1 then
      high = math.max(high, math.min(c.steps.max, math.ceil(1.25 * c.steps.p95)))
    end
  end
  return high
end

-- ---- the model ----

-- Lines through a box at random, each as likely as a surface is large: through a disc across a random direction that holds the box's
-- sphere. The numbers are those of the R2 and R1 sequences, so that they are the same everywhere.
local function random_lines(low, high)
  local rt = require "rt"
  local rays = rt.buffer("f32", 8 * LINES)
  local c, r2 = {}, 0
  for i = 1, 3 do
    c[i] = (low[i] + high[i]) / 2
    r2 = r2 + (high[i] - low[i]) ^ 2 / 4
  end
  local r = math.sqrt(r2)
  for i = 0, LINES - 1 do
    local a, b = rt.random("tree line", i, 1), rt.random("tree line", i, 2)
    local z, phi = 2 * a - 1, 2 * math.pi * b
    local rho, psi = r * math.sqrt(rt.random("tree line", i, 3)), 2 * math.pi * rt.random("tree line", i, 4)
    local q, x, y = math.sqrt(math.max(0, 1 - z * z)), rho * math.cos(psi), rho * math.sin(psi)
    local cp, sp = math.cos(phi), math.sin(phi)
    local d = { q * cp, q * sp, z }
    local o = { -x * sp - y * z * cp, x * cp - y * z * sp, y * q }
    rays:set(8 * i + 1, c[1] + o[1] - 2 * r * d[1], c[2] + o[2] - 2 * r * d[2], c[3] + o[3] - 2 * r * d[3], 0, d[1], d[2], d[3], math.huge)
  end
  return rays
end

local function mean_cost(shape, costs)
  local sum, crossed = 0, 0
  for i = 1, LINES do
    local nodes, leaves, tests = costs.nodes[i], costs.leaves[i], costs.tests[i]
    if nodes + leaves > 0 then
      crossed = crossed + 1
      sum = sum + shape.cost_traverse * nodes + shape.cost_intersect * tests
    end
  end
  return crossed > 0 and sum / crossed or 0, crossed
end

-- Predicted and measured cost of a tree: { tracer, predicted, through, first_hit, lines }; nil where no such tree stands.
-- Rays of the top level go on into groups, which its model does not know.
function tree_costs.model(scene, tracer, over)
  local group, part = over.group, over.part
  local shape = scene:tree_shape { tracer = tracer, group = group, part = part }
  if not shape or group == "top" then
    return nil
  end
  local rays = random_lines(shape.low, shape.high)
  local through, crossed = mean_cost(shape, scene:ray_costs(rays, { tracer = tracer, group = group, part = part, blind = true }))
  local first_hit = mean_cost(shape, scene:ray_costs(rays, { tracer = tracer, group = group, part = part }))
  return { tracer = tracer, predicted = shape.sah_cost, through = through, first_hit = first_hit, lines = crossed }
end

function tree_costs.print_model(list)
  local rows = { { "tree", "predicted", "measured", "ratio", "to the first hit" } }
  for _, m in ipairs(list) do
    rows[#rows + 1] = {
      m.tracer, ("%.2f"):format(m.predicted), ("%.2f"):format(m.through), ("%.3f"):format(m.predicted > 0 and m.through / m.predicted or 0),
      ("%.2f"):format(m.first_hit),
    }
  end
  output.table(rows, { true })
end

return tree_costs
