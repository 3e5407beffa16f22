-- The rays of a pixel's sample as a drawing: a slice through the scene along the camera ray, upright, with the rays laid into it.

local output = require "rtray.output"
local svg = require "rtray.svg"

local pixel_svg = {}

local PICTURE = 760 -- longer side of the slice
local ROWS = 40     -- rays told beside it at most
local number = svg.number

local COLORS = {
  camera = "#1f4e9c", reflect = "#b3261e", refract = "#12856f", diffuse = "#8a5a00", shadow = "#a88600", ao = "#888888",
}
local NAMES = { camera = "camera", reflect = "mirror", refract = "refracted", diffuse = "diffuse", shadow = "shadow", ao = "occlusion" }
local ORDER = { "camera", "reflect", "refract", "diffuse", "shadow", "ao" }

local function dot(a, b)
  return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

local function cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function unit(v)
  local l = math.sqrt(dot(v, v))
  return { v[1] / l, v[2] / l, v[3] / l }
end

-- The plane through the camera ray that stands upright: normal, axes to the right (along the ray) and up.
local function plane_of(root)
  local d = unit(root.dir)
  local up = math.abs(d[2]) > 0.999 and { 1, 0, 0 } or { 0, 1, 0 }
  local normal = unit(cross(d, up))
  local right = unit(cross(up, normal))
  return { point = root.org, normal = normal, right = right, up = cross(normal, right) }
end

local function along(ray, t)
  return { ray.org[1] + t * ray.dir[1], ray.org[2] + t * ray.dir[2], ray.org[3] + t * ray.dir[3] }
end

-- Where a ray ends: at what it hits, at its light, or nowhere.
local function end_of(ray)
  if ray.hit and not ray.arrived then
    return along(ray, ray.hit.t)
  elseif ray.arrived and ray.tmax < 1e30 then
    return along(ray, ray.tmax)
  end
  return nil
end

-- Box of the points at which rays begin and end, with a margin; rays that leave do not widen it.
local function view_of(rays, plane)
  local box = { math.huge, -math.huge, math.huge, -math.huge }
  local function take(p)
    local u, v = dot(p, plane.right), dot(p, plane.up)
    box[1], box[2], box[3], box[4] = math.min(box[1], u), math.max(box[2], u), math.min(box[3], v), math.max(box[4], v)
  end
  for _, ray in ipairs(rays) do
    take(ray.org)
    local at = end_of(ray)
    if at then
      take(at)
    end
  end
  for i = 1, 3, 2 do -- not narrower than half of the longer side
    local lack = (math.max(box[2] - box[1], box[4] - box[3]) / 2 - (box[i + 1] - box[i])) / 2
    if lack > 0 then
      box[i], box[i + 1] = box[i] - lack, box[i + 1] + lack
    end
  end
  local margin = 0.08 * math.max(box[2] - box[1], box[4] - box[3])
  margin = margin > 0 and margin or 1
  return { u0 = box[1] - margin, u1 = box[2] + margin, v0 = box[3] - margin, v1 = box[4] + margin }
end

local function line(page, x1, y1, x2, y2, color, more)
  page:add(('<line x1="%s" y1="%s" x2="%s" y2="%s" stroke="%s"%s/>\n'):format(number(x1), number(y1), number(x2), number(y2), color, more or ""))
end

local function draw_outlines(page, scene, plane, to_page)
  local parts = {}
  for _, group in ipairs { 0, "top" } do
    local lines = scene:cut { cut = { point = plane.point, normal = plane.normal }, group = group }
    for i = 1, #lines, 6 do
      local ax, ay, az, bx, by, bz = lines:get(i, 6)
      local x1, y1 = to_page { ax, ay, az }
      local x2, y2 = to_page { bx, by, bz }
      if math.abs(x1 - x2) + math.abs(y1 - y2) >= 0.05 and math.max(math.abs(x1), math.abs(y1), math.abs(x2), math.abs(y2)) < 1e5 then
        parts[#parts + 1] = ("M%s %sL%s %s"):format(number(x1), number(y1), number(x2), number(y2))
      end
    end
  end
  page:add(('<path fill="none" stroke="#9a9a9a" stroke-width="1" d="%s"/>\n'):format(table.concat(parts)))
end

-- A ray, and a stroke of the surface that it meets, which shows infinite planes too.
local function draw_ray(page, ray, plane, to_page, length)
  local x1, y1 = to_page(ray.org)
  local at = end_of(ray)
  local x2, y2 = to_page(at or along(ray, length / math.sqrt(dot(ray.dir, ray.dir))))
  local dashed = (ray.kind == "shadow" or ray.kind == "ao") and ' stroke-dasharray="5 3"' or ""
  local faint = ray.arrived == false and ' opacity="0.55"' or ""
  line(page, x1, y1, x2, y2, COLORS[ray.kind], ' stroke-width="1.6"' .. dashed .. faint)
  if not ray.hit or ray.kind == "shadow" or ray.kind == "ao" then
    return
  end
  local nu, nv = dot(ray.hit.ng, plane.right), dot(ray.hit.ng, plane.up)
  local l = math.sqrt(nu * nu + nv * nv)
  if l > 0.05 then
    line(page, x2 - 9 * nv / l, y2 - 9 * nu / l, x2 + 9 * nv / l, y2 + 9 * nu / l, "#222222", ' stroke-width="2"')
  end
  page:text(x2 + 6, y2 - 6, tostring(ray.index - 1), { size = 11, color = COLORS[ray.kind] })
end

-- The rays of a sample, each behind its parent and before what comes of it.
local function in_order(root)
  local stack, list = { root }, {}
  while #stack > 0 do
    local ray = table.remove(stack)
    list[#list + 1] = ray
    for i = #(ray.children or {}), 1, -1 do
      stack[#stack + 1] = ray.children[i]
    end
  end
  return list
end

-- SVG text of the rays of one sample. words(ray) tells one in few words.
function pixel_svg.draw(scene, root, title, words)
  local plane, rays, used = plane_of(root), in_order(root), {}
  for _, ray in ipairs(rays) do
    used[ray.kind] = true
  end
  local view = view_of(rays, plane)
  local scale = PICTURE / math.max(view.u1 - view.u0, view.v1 - view.v0)
  local box = { x = 20, y = 84, width = (view.u1 - view.u0) * scale, height = (view.v1 - view.v0) * scale }
  local function to_page(p)
    return box.x + (dot(p, plane.right) - view.u0) * scale, box.y + (view.v1 - dot(p, plane.up)) * scale
  end
  local rows = math.min(#rays, ROWS)
  local page = svg.page(box.x + box.width + 480, box.y + math.max(box.height, 18 * rows + 40) + 30, title)
  page:text(box.x, 26, title, { size = 16, weight = true })
  page:text(box.x, 46, ("sample %d, %s rays; a slice through the camera ray; rays off its plane are laid into it"):format(root.sample,
    output.count(#rays)), { color = "#555555" })
  local at = box.x
  for _, kind in ipairs(ORDER) do
    if used[kind] then
      line(page, at, 64, at + 22, 64, COLORS[kind], ' stroke-width="2"' .. ((kind == "shadow" or kind == "ao") and ' stroke-dasharray="5 3"' or ""))
      page:text(at + 28, 68, NAMES[kind])
      at = at + 48 + 7 * #NAMES[kind]
    end
  end
  page:add(('<clipPath id="view"><rect x="%s" y="%s" width="%s" height="%s"/></clipPath>\n<g clip-path="url(#view)">\n'):format(number(box.x),
    number(box.y), number(box.width), number(box.height)))
  draw_outlines(page, scene, plane, to_page)
  local length = 2 * math.max(view.u1 - view.u0, view.v1 - view.v0)
  for i = #rays, 1, -1 do -- the camera ray on top
    draw_ray(page, rays[i], plane, to_page, length)
  end
  page:add "</g>\n"
  page:rect(box.x, box.y, box.width, box.height, "none", 'stroke="#222222"')
  for i = 1, rows do
    local ray = rays[i]
    page:text(box.x + box.width + 16 + 10 * math.min(ray.depth + ((ray.kind == "shadow" or ray.kind == "ao") and 1 or 0), 8),
      box.y + 18 * i - 4, ("%d  %s"):format(ray.index - 1, words(ray)), { size = 11, color = COLORS[ray.kind] })
  end
  if #rays > rows then
    page:text(box.x + box.width + 16, box.y + 18 * rows + 16, ("and %s more"):format(output.count(#rays - rows)), { size = 11 })
  end
  return page:finish()
end

return pixel_svg
