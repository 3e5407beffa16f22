-- rtray tree SCENE: the trees of a scene in numbers, and drawn: cells in a plane, histograms, what rays cost.

local cli = require "rtray.cli"
local costs = require "rtray.tree_costs"
local cut = require "rtray.tree_cut"
local files = require "rtray.files"
local json = require "rtray.json"
local output = require "rtray.output"
local source = require "rtray.source"
local svg = require "rtray.svg"
local sys = require "rtray.sys"
local trees = require "rtray.trees"
local types = require "rtray.types"

local tree = {}

local BRUTE_LIMIT = 10000 -- primitives, as for verify
local PICTURE = 480       -- longer side of a cost layer, when --size does not say it
local BAR = 50            -- longest bar of a text histogram

-- ---- what is asked for ----

-- The tracers whose trees are shown, and those whose costs are: brute force has no tree.
local function tracers_of(values, facts)
  local all = {}
  for _, row in ipairs(require("rt").tracers()) do
    all[#all + 1] = row.name ~= "auto" and row.name or nil
  end
  local with_tree, has = {}, {}
  for _, t in ipairs(facts.trees) do
    if not has[t.name] then
      has[t.name] = true
      with_tree[#with_tree + 1] = t.name
    end
  end
  if values.shown_tracers then
    return with_tree, values.shown_tracers
  end
  local walkers = {}
  for _, name in ipairs(all) do
    if name ~= "brute" or facts.triangles + facts.shapes <= BRUTE_LIMIT then
      walkers[#walkers + 1] = name
    end
  end
  return with_tree, walkers
end

-- The trees that are drawn, by what they stand over: the group named, else the scene's own geometry, else the top level, else the first
-- child. { group, part, label }
local function group_of(command, values, facts)
  local by_label, names = {}, {}
  for _, t in ipairs(facts.trees) do
    local label = trees.label(t)
    if not by_label[label] then
      by_label[label] = { group = t.group, part = t.part, label = label }
      names[#names + 1] = label
    end
  end
  if values.group and not by_label[values.group] then
    cli.fault(command, "--group %s: there is no such tree; there are %s", values.group, table.concat(names, ", "))
  end
  return by_label[values.group or "0"] or by_label.top or by_label[names[1]]
end

local function size_of(scene, values)
  local s = scene:effective()
  if values.size then
    return s.width, s.height
  end
  local shrink = math.min(1, PICTURE / math.max(s.width, s.height))
  return math.max(1, math.floor(s.width * shrink)), math.max(1, math.floor(s.height * shrink))
end

-- ---- histograms ----

local function bar_name(bar)
  return bar.low == bar.high and tostring(bar.low) or bar.low .. "-" .. bar.high
end

local function print_bars(title, bars)
  local most, rows = 1, { { title, "leaves", "references", "" } }
  for _, bar in ipairs(bars) do
    most = math.max(most, bar.leaves)
  end
  for _, bar in ipairs(bars) do
    local length = math.ceil(bar.leaves / most * BAR)
    rows[#rows + 1] = { bar_name(bar), output.count(bar.leaves), output.count(bar.references), ("#"):rep(length) }
  end
  output.table(rows, { [4] = true })
end

local function draw_bars(page, x, y, width, height, title, bars)
  local most = 1
  for _, bar in ipairs(bars) do
    most = math.max(most, bar.leaves)
  end
  page:text(x, y - 10, title, { weight = true })
  local ticks = svg.ticks(0, most, 4)
  for _, tick in ipairs(ticks) do
    local at = y + height * (1 - tick / most)
    page:line(x, at, x + width, at, "#dddddd")
    page:text(x - 6, at + 4, output.count(math.floor(tick + 0.5)), { anchor = "end", size = 11 })
  end
  local step = width / math.max(#bars, 1)
  local every = math.ceil(#bars / (width / 34))
  for i, bar in ipairs(bars) do
    local h = height * bar.leaves / most
    page:rect(x + (i - 1) * step + step * 0.1, y + height - h, step * 0.8, h, "#3a78a0")
    if (i - 1) % every == 0 then
      page:text(x + (i - 0.5) * step, y + height + 15, bar_name(bar), { anchor = "middle", size = 10 })
    end
  end
  page:line(x, y + height, x + width, y + height)
end

local function draw_histograms(title, list)
  local page = svg.page(940, 40 + 270 * #list, title)
  page:text(16, 26, title, { size = 16, weight = true })
  for i, h in ipairs(list) do
    local y = 80 + (i - 1) * 270
    draw_bars(page, 76, y, 370, 180, h.name .. ": leaves by depth", h.leaves.depths)
    draw_bars(page, 540, y, 370, 180, h.name .. ": leaves by references", h.leaves.sizes)
  end
  return page:finish()
end

-- ---- files ----

local function write(state, name, text)
  local path = state.folder .. "/" .. name
  files.replace(path, text)
  state.files[#state.files + 1] = path
end

local function prepare_folder(path)
  local kind = sys.stat(path)
  if kind == "folder" then
    return
  elseif kind then
    error({ status = 1, message = ("the output %s is a file; name a folder"):format(types.quote(path)) }, 0)
  end
  local ok, why = sys.make_folder(path)
  if not ok then
    error({ status = 1, message = ("the folder %s cannot be made: %s"):format(types.quote(path), why) }, 0)
  end
end

local function draw_cuts(state, scene, values, with_tree, over)
  for _, name in ipairs(with_tree) do
    local shape = scene:tree_shape { tracer = name, group = over.group, part = over.part }
    if shape then
      local plane = cut.plane(values.cut, shape)
      local title = ("%s of %s, group %s"):format(name, state.name, over.label)
      local text, facts = cut.draw(scene, { tracer = name, over = over, plane = plane, color = values.color or "depth", title = title })
      if text then
        facts.tracer, facts.plane = name, plane
        state.cuts[#state.cuts + 1] = facts
        write(state, "cells-" .. name .. ".svg", text)
      else
        error({ status = 1, message = "--cut: " .. facts }, 0)
      end
    end
  end
end

local function draw_costs(state, list)
  local high = costs.scale_of(list)
  for _, c in ipairs(list) do
    local png = ("%s/cost-%s.png"):format(state.folder, c.tracer)
    local text = costs.layer(c, high, ("cost of %s: %s"):format(state.name, c.tracer), png)
    state.files[#state.files + 1] = png
    write(state, "cost-" .. c.tracer .. ".svg", text)
  end
end

-- ---- the command ----

local function numbers(s)
  return json.object():set("mean", s.mean):set("p95", s.p95):set("max", s.max)
end

local function bars_json(bars)
  local list = {}
  for i, bar in ipairs(bars) do
    list[i] = json.object():set("low", bar.low):set("high", bar.high):set("leaves", bar.leaves):set("references", bar.references)
  end
  return list
end

local function to_json(path, scene, found)
  local rows, leaves, rays, model, cuts = {}, {}, {}, {}, {}
  for i, t in ipairs(found.facts.trees) do
    rows[i] = trees.json(t)
  end
  for i, h in ipairs(found.histograms) do
    leaves[i] = json.object():set("name", h.name):set("depths", bars_json(h.leaves.depths)):set("sizes", bars_json(h.leaves.sizes))
  end
  for i, c in ipairs(found.costs) do
    rays[i] = json.object():set("tracer", c.tracer):set("rays", c.rays):set("nodes", numbers(c.nodes)):set("leaves", numbers(c.leaves))
      :set("tests", numbers(c.tests))
  end
  for i, m in ipairs(found.models) do
    model[i] = json.object():set("name", m.tracer):set("lines", m.lines):set("predicted", m.predicted):set("measured", m.through)
      :set("first_hit", m.first_hit)
  end
  for i, c in ipairs(found.state.cuts) do
    cuts[i] = json.object():set("name", c.tracer):set("plane", c.plane.words):set("cells", c.cells):set("drawn", c.drawn):set("whole", c.whole)
      :set("pieces", c.pieces)
  end
  return json.encode(json.object():set("scene", path):set("hash", scene:hash()):set("trees", rows):set("group", found.over.label)
    :set("leaves", leaves):set("camera_rays", rays):set("model", model):set("cuts", cuts):set("files", found.state.files))
end

local function print_text(found)
  trees.print(found.facts.trees)
  for _, h in ipairs(found.histograms) do
    output.print("\n%s, group %s: leaves by depth", h.name, found.over.label)
    print_bars("depth", h.leaves.depths)
    output.print("\n%s, group %s: leaves by references", h.name, found.over.label)
    print_bars("references", h.leaves.sizes)
  end
  local c = found.costs[1]
  output.print("\ncamera rays, %dx%d: inner nodes and leaves visited, primitives tested (kdtree, octree: all that a leaf lists)", c.width, c.height)
  costs.print(found.costs)
  if #found.models > 0 then
    output.print("\nSAH cost of group %s, and what random lines cost", found.over.label)
    costs.print_model(found.models)
  end
  for _, path in ipairs(found.state.files) do
    output.print("%s%s", path == found.state.files[1] and "\n" or "", path)
  end
end

local function look(command, scene, values, state)
  local facts = scene:info()
  local with_tree, walkers = tracers_of(values, facts)
  if #facts.trees == 0 then
    error({ status = 1, message = "the scene has no tree: nothing in it needs one" }, 0)
  end
  local found = { facts = facts, over = group_of(command, values, facts), histograms = {}, costs = {}, models = {}, state = state }
  for _, name in ipairs(with_tree) do
    local query = { tracer = name, group = found.over.group, part = found.over.part }
    if scene:tree_shape(query) then
      found.histograms[#found.histograms + 1] = { name = name, leaves = scene:tree_leaves(query) }
      found.models[#found.models + 1] = costs.model(scene, name, found.over)
    end
  end
  local width, height = size_of(scene, values)
  for _, name in ipairs(walkers) do
    found.costs[#found.costs + 1] = costs.camera(scene, name, width, height)
  end
  if state.folder then
    draw_cuts(state, scene, values, with_tree, found.over)
    write(state, "leaves.svg", draw_histograms(("leaves of %s, group %s"):format(state.name, found.over.label), found.histograms))
    draw_costs(state, found.costs)
  end
  return found
end

function tree.run(command, values, arguments)
  local path = arguments[1]
  local state = { name = files.name_of(path), folder = values.folder, files = {}, cuts = {} }
  if state.folder then
    prepare_folder(state.folder)
    state.folder = state.folder:gsub("(.)/+$", "%1")
  end
  local wanted = {}
  for _, name in ipairs(values.shown_tracers or {}) do
    wanted[#wanted + 1] = name
  end
  local scene = source.open(path, values, command, { accel = #wanted > 0 and table.concat(wanted, ",") or "kdtree,octree,bvh" }).scene
  local found = look(command, scene, values, state)
  if values.json then
    output.print("%s", to_json(path, scene, found))
  else
    print_text(found)
  end
  return 0
end

return tree
