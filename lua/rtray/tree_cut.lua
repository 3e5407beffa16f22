-- The cells of a tree where a plane meets them, drawn as SVG with the outlines of what stands in the plane.

local output = require "rtray.output"
local svg = require "rtray.svg"

local tree_cut = {}

local PICTURE = 820      -- longer side of the drawing, in pixels of the page
local TINY = 1.5         -- cells below so many pixels are drawn whole, with what is below them
local CELLS = 20000      -- at most
local PIECES = 60000     -- of outlines

-- ---- the plane ----

-- Where a plane along an axis is seen from: the axes to the right and upwards, and whether they run backwards.
local VIEWS = { x = { 3, -1, 2, 1 }, y = { 1, 1, 3, -1 }, z = { 1, 1, 2, 1 } }
local AXES = { x = 1, y = 2, z = 3 }
local NAMES = { "x", "y", "z" }

local function axis_vector(i, sign)
  local v = { 0, 0, 0 }
  v[i] = sign
  return v
end

local function cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function unit(v)
  local l = math.sqrt(v[1] * v[1] + v[2] * v[2] + v[3] * v[3])
  return { v[1] / l, v[2] / l, v[3] / l }
end

-- The plane that an option names, for a tree of this shape: { point, normal, right, up, words, axis }. None: through the middle, across the
-- shortest side.
function tree_cut.plane(option, shape)
  local low, high = shape.low, shape.high
  if option and option.normal then
    local n = unit(option.normal)
    local right = unit(math.abs(n[2]) > 0.999 and cross({ 0, 0, -1 }, n) or cross({ 0, 1, 0 }, n))
    return {
      point = option.point, normal = n, right = right, up = cross(n, right),
      words = ("through %g, %g, %g across %g, %g, %g"):format(option.point[1], option.point[2], option.point[3], option.normal[1], option.normal[2],
        option.normal[3]),
    }
  end
  local axis = option and option.axis
  if not axis then
    axis = "z"
    for _, name in ipairs { "y", "x" } do
      local i, k = AXES[name], AXES[axis]
      axis = high[i] - low[i] < high[k] - low[k] and name or axis
    end
  end
  local i, view = AXES[axis], VIEWS[axis]
  local at = option and option.at or low[i] + (option and option.part or 0.5) * (high[i] - low[i])
  local point = { (low[1] + high[1]) / 2, (low[2] + high[2]) / 2, (low[3] + high[3]) / 2 }
  point[i] = at
  return {
    point = point, normal = axis_vector(i, 1), right = axis_vector(view[1], view[2]), up = axis_vector(view[3], view[4]), axis = axis, at = at,
    words = ("%s = %.6g"):format(axis, at), low = low[i], high = high[i], horizontal = view[1], vertical = view[3],
  }
end

-- ---- the cells ----

-- All cells in the plane, and those that are drawn: tiny ones whole, and ever larger ones while there are too many.
local function cells_of(scene, query, size)
  local all = scene:tree_cells(query)
  local longest = math.max(size[1], size[2])
  local min_size = TINY * longest / PICTURE
  local function at(limit)
    return scene:tree_cells { tracer = query.tracer, group = query.group, part = query.part, cut = query.cut, min_size = limit }
  end
  local shown = at(min_size)
  while #shown > CELLS do
    min_size = 1.5 * min_size
    shown = at(min_size)
  end
  local whole = 0
  for _, cell in ipairs(shown) do
    whole = whole + (cell.leaves > 1 and 1 or 0)
  end
  return shown, #all, whole, min_size
end

-- What a cell's colour shows.
local MEASURES = {
  depth = { caption = "depth", of = function(cell) return cell.deepest end },
  references = { caption = "references", of = function(cell) return cell.largest end },
}

local function extent(corners, place)
  local x0, x1, y0, y1 = math.huge, -math.huge, math.huge, -math.huge
  for _, corner in ipairs(corners) do
    local x, y = place(corner)
    x0, x1, y0, y1 = math.min(x0, x), math.max(x1, x), math.min(y0, y), math.max(y1, y)
  end
  return x0, x1, y0, y1
end

local number = svg.number

local function path_of(corners, to_page)
  local parts = {}
  for i, corner in ipairs(corners) do
    local x, y = to_page(corner)
    parts[i] = (i == 1 and "M" or "L") .. number(x) .. " " .. number(y)
  end
  return table.concat(parts) .. "Z"
end

-- One path for each colour keeps the file small.
local function draw_cells(page, cells, to_page, of, high)
  local paths, order = {}, {}
  for _, cell in ipairs(cells) do
    local value = of(cell)
    local key = value == 0 and "none" or svg.color(high > 0 and math.floor(value / high * 40 + 0.5) / 40 or 0)
    if not paths[key] then
      paths[key] = {}
      order[#order + 1] = key
    end
    table.insert(paths[key], path_of(cell.corners, to_page))
  end
  table.sort(order)
  page:add '<g stroke="#404040" stroke-width="0.4" stroke-linejoin="round">\n'
  for _, key in ipairs(order) do
    page:add(('<path fill="%s" d="%s"/>\n'):format(key, table.concat(paths[key])))
  end
  page:add "</g>\n"
end

-- Outlines of primitives. Returns the pieces that there are, those too short to be seen and those too many.
local function draw_outlines(page, scene, query, to_page)
  local lines = scene:cut { cut = query.cut, group = query.group }
  local parts, count, short = {}, #lines // 6, 0
  for i = 0, count - 1 do
    local ax, ay, az, bx, by, bz = lines:get(6 * i + 1, 6)
    local x1, y1 = to_page { ax, ay, az }
    local x2, y2 = to_page { bx, by, bz }
    if math.abs(x1 - x2) + math.abs(y1 - y2) < 0.02 then
      short = short + 1
    elseif #parts < PIECES then
      parts[#parts + 1] = ("M%s %sL%s %s"):format(number(x1), number(y1), number(x2), number(y2))
    end
  end
  page:add(('<path fill="none" stroke="#ff2a1c" stroke-width="1" stroke-linecap="round" d="%s"/>\n'):format(table.concat(parts)))
  return count, short, count - short - #parts
end

local function draw_axes(page, plane, box, to_page_x, to_page_y)
  page:rect(box.x, box.y, box.width, box.height, "none", 'stroke="#222222"')
  if not plane.axis then
    return
  end
  for _, x in ipairs(svg.ticks(math.min(box.x0, box.x1), math.max(box.x0, box.x1))) do
    local at = to_page_x(x)
    page:line(at, box.y + box.height, at, box.y + box.height + 4)
    page:text(at, box.y + box.height + 17, svg.tick_text(x), { anchor = "middle", size = 11 })
  end
  for _, y in ipairs(svg.ticks(math.min(box.y0, box.y1), math.max(box.y0, box.y1))) do
    local at = to_page_y(y)
    page:line(box.x - 4, at, box.x, at)
    page:text(box.x - 7, at + 4, svg.tick_text(y), { anchor = "end", size = 11 })
  end
  page:text(box.x + box.width / 2, box.y + box.height + 34, NAMES[plane.horizontal], { anchor = "middle" })
  page:text(box.x - 46, box.y + box.height / 2, NAMES[plane.vertical], { anchor = "middle" })
end

local function dot(a, b)
  return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

-- SVG text of a tree's cells, and numbers about it; nil and why where there is nothing. options: tracer, over (group and part), plane, title,
-- color ("depth" or "references").
function tree_cut.draw(scene, options)
  local plane = options.plane
  local over = options.over
  local query = { tracer = options.tracer, group = over.group, part = over.part, cut = { point = plane.point, normal = plane.normal } }
  local root = scene:tree_cells({ tracer = query.tracer, group = over.group, part = over.part, cut = query.cut, max_depth = 0 })[1]
  if not root then
    local where = plane.axis and (", which has %s = %.6g ... %.6g"):format(plane.axis, plane.low, plane.high) or ""
    return nil, ("the plane %s does not meet the tree%s"):format(plane.words, where)
  end
  local function place(p)
    return dot(p, plane.right), dot(p, plane.up)
  end
  local u0, u1, v0, v1 = extent(root.corners, place)
  local width, height = u1 - u0, v1 - v0
  local scale = PICTURE / math.max(width, height)
  local box = { x = 66, y = 84, width = math.max(width * scale, 1), height = math.max(height * scale, 1) }
  local function to_page(p)
    local u, v = place(p)
    return box.x + (u - u0) * scale, box.y + (v1 - v) * scale
  end
  local cells, met, whole, min_size = cells_of(scene, query, { width, height })
  local measure, high = MEASURES[options.color], 0
  for _, cell in ipairs(cells) do
    high = math.max(high, measure.of(cell))
  end
  local page = svg.page(box.x + box.width + 110, box.y + math.max(box.height, 200) + 50, options.title)
  draw_cells(page, cells, to_page, measure.of, high)
  local pieces, short, left_out = draw_outlines(page, scene, query, to_page)
  local us, vs = plane.axis and plane.right[plane.horizontal], plane.axis and plane.up[plane.vertical]
  if plane.axis then -- the axes' own coordinates, which may run backwards
    box.x0, box.x1, box.y0, box.y1 = us * u0, us * u1, vs * v0, vs * v1
  end
  draw_axes(page, plane, box, function(x)
    return box.x + (us * x - u0) * scale
  end, function(y)
    return box.y + (v1 - vs * y) * scale
  end)
  page:scale(box.x + box.width + 24, box.y + 20, math.min(math.max(box.height - 40, 160), 400), 0, high, measure.caption, nil,
    options.color == "references")
  page:text(box.x, 24, options.title, { size = 16, weight = true })
  local words = ("%s; %s cells met"):format(plane.words, output.count(met))
  if whole > 0 then
    words = words .. (", drawn as %s: %s stand for the leaves in them, all below %.3g units"):format(output.count(#cells),
      output.count(whole), min_size)
  end
  page:text(box.x, 44, words, { color = "#555555" })
  words = ("red: outlines of primitives in the plane, %s pieces"):format(output.count(pieces))
  words = words .. (short > 0 and (", %s of them too short to be seen"):format(output.count(short)) or "")
    .. (left_out > 0 and (", %s left out"):format(output.count(left_out)) or "") .. (options.color == "references" and "; white: empty leaves" or "")
  page:text(box.x, 62, words, { color = "#555555" })
  return page:finish(), { cells = met, drawn = #cells, whole = whole, pieces = pieces }
end

return tree_cut
