-- Statistics of trees, as info and tree show them.

local json = require "rtray.json"
local output = require "rtray.output"

local trees = {}

local function ratio(a, b)
  return b > 0 and a / b or 0
end

-- The columns of paper 002's table 2, and SAH cost and bytes. A tree a row.
local HEAD = {
  "tree", "group", "primitives", "references", "growth", "build", "depth", "nodes", "leaves", "empty", "empty%", "largest", "SAH", "bytes",
}

-- A group with things of very different scale has several trees: 0, 0.1, 0.2.
function trees.label(t)
  return t.part > 0 and ("%s.%d"):format(t.group, t.part) or tostring(t.group)
end

local function row(t)
  return {
    t.name, trees.label(t), output.count(t.primitives), output.count(t.references), ("%.2f"):format(ratio(t.references, t.primitives)),
    output.seconds(t.build_seconds), tostring(t.depth), output.count(t.nodes), output.count(t.leaves), output.count(t.empty_leaves),
    ("%.1f"):format(100 * ratio(t.empty_leaves, t.leaves)), tostring(t.largest_leaf), ("%.2f"):format(t.sah_cost), output.bytes(t.bytes),
  }
end

function trees.json(t)
  return json.object():set("name", t.name):set("group", t.group):set("part", t.part):set("primitives", t.primitives)
    :set("references", t.references):set("growth", ratio(t.references, t.primitives)):set("build_seconds", t.build_seconds)
    :set("depth", t.depth):set("nodes", t.nodes):set("leaves", t.leaves)
    :set("empty_leaves", t.empty_leaves):set("empty_ratio", ratio(t.empty_leaves, t.leaves))
    :set("largest_leaf", t.largest_leaf):set("sah_cost", t.sah_cost):set("bytes", t.bytes)
end

function trees.print(list)
  local rows = { HEAD }
  for _, t in ipairs(list) do
    rows[#rows + 1] = row(t)
  end
  output.table(rows, { true, true })
end

return trees
