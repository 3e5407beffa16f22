-- rtray pixel SCENE X,Y: the rays that made a pixel, what they met and what each brought.

local cli = require "rtray.cli"
local json = require "rtray.json"
local output = require "rtray.output"
local drawing = require "rtray.pixel_svg"
local files = require "rtray.files"
local source = require "rtray.source"

local pixel = {}

local TELL = 4 -- samples told in full, when neither --sample nor --json asks

-- ---- words ----

local function vec(v, form)
  form = form or "%.6g"
  return (("(" .. form .. ", " .. form .. ", " .. form .. ")"):format(v[1], v[2], v[3]):gsub("%-0([,)])", "0%1"))
end

local KINDS = {
  camera = "camera ray", shadow = "shadow ray", reflect = "mirror ray", refract = "refracted ray", diffuse = "diffuse ray", ao = "occlusion ray",
}

-- Foreign names may hold anything: shown with control bytes spelled out.
local function quoted(name)
  return "'" .. require("rt.words").quote(name) .. "'"
end

local function what_is_hit(hit)
  local kind = hit.object and tostring(hit.object):match "^[%w_.]+" or nil
  local words = hit.name and (kind and kind .. " " or "") .. quoted(hit.name) or kind or "geometry " .. hit.geom_id
  local ids = ("geometry %d, primitive %d"):format(hit.geom_id, hit.prim_id)
  if hit.inst_id then
    ids = ("instance %d%s, "):format(hit.inst_id, hit.instance_name and " " .. quoted(hit.instance_name) or "") .. ids
  end
  return ("%s (%s)"):format(words, ids)
end

local function material_words(hit)
  if hit.material_name then
    return quoted(hit.material_name)
  end
  local kind = hit.material and tostring(hit.material):match "^[%w_.]+"
  return ("%s %d"):format(kind or "material", hit.material_id)
end

local function is_zero(units)
  return units[1] == 0 and units[2] == 0 and units[3] == 0
end

local function amount(units, unit)
  return { units[1] * unit, units[2] * unit, units[3] * unit }
end

-- What a ray brought, by what it met.
local function source_of(told, ray)
  local hit = ray.hit
  if ray.kind == "shadow" or ray.kind == "ao" then
    return ray.kind == "ao" and "openness" or "light"
  elseif not hit then
    return "background"
  elseif told.integrator == "path" or hit.material and hit.material.model == "emissive" or not hit.object and hit.name then
    return "emission"
  end
  return (hit.material or hit.material_id == 0) and "ambient light" or "ambient light or emission"
end

local function shadow_words(ray)
  local to = ray.kind == "ao" and "" or ray.light and " to light " .. quoted(ray.light) or ray.light_id and " to light " .. ray.light_id or ""
  local how
  if ray.arrived then
    how = ray.crossed > 0 and ("arrives, through %d transparent surface%s"):format(ray.crossed, ray.crossed > 1 and "s" or "") or "arrives"
  else
    how = ("stopped at t = %.6g by %s"):format(ray.hit.t, what_is_hit(ray.hit))
  end
  return to .. ": " .. how
end

-- ---- the tree as text ----

local function lines_of(told, ray, indent, out)
  local pad = ("  "):rep(indent)
  local function add(...)
    out[#out + 1] = pad .. string.format(...)
  end
  local cost = ("nodes %d, leaves %d, tests %d"):format(ray.nodes, ray.leaves, ray.tests)
  if ray.kind == "shadow" or ray.kind == "ao" then
    add("%s%s", KINDS[ray.kind], shadow_words(ray))
    add("    dir %s, carries %s; %s", vec(ray.dir), vec(ray.throughput), cost)
  else
    add("%s, depth %d%s", KINDS[ray.kind], ray.depth, ray.hit and ("  hits %s"):format(what_is_hit(ray.hit)) or "  leaves the scene")
    add("    from %s dir %s, weight %s; %s", vec(ray.org), vec(ray.dir), vec(ray.throughput), cost)
    if ray.hit then
      local h = ray.hit
      add("    t = %.6g, position %s, normal %s%s, uv (%.4g, %.4g), material %s, colour %s", h.t, vec(h.position), vec(h.ng, "%.4f"),
        vec(h.ns, "%.4f") ~= vec(h.ng, "%.4f") and ", shading normal " .. vec(h.ns, "%.4f") or "", h.texture_u, h.texture_v, material_words(h),
        vec(h.color, "%.4g"))
    end
  end
  if not is_zero(ray.brought) then
    add("    + %s %s", vec(amount(ray.brought, told.unit)), source_of(told, ray))
  end
  if not is_zero(ray.unshadowed) then
    add("    + %s light, shadows are off", vec(amount(ray.unshadowed, told.unit)))
  end
end

-- Not recursive: a path may be as deep as the settings say, and as wide.
local function tell_tree(told, root, out)
  local stack = { { root, 0 } }
  while #stack > 0 do
    local ray, indent = table.unpack(table.remove(stack))
    lines_of(told, ray, indent, out)
    for i = #(ray.children or {}), 1, -1 do
      stack[#stack + 1] = { ray.children[i], indent + 1 }
    end
  end
end

-- Light of a sample: what all its rays brought.
local function sample_sums(told)
  local sums = {}
  for _, ray in ipairs(told.rays) do
    local s = sums[ray.sample] or { 0, 0, 0, rays = 0 }
    for c = 1, 3 do
      s[c] = s[c] + ray.brought[c] + ray.unshadowed[c]
    end
    s.rays = s.rays + 1
    sums[ray.sample] = s
  end
  return sums
end

local function print_text(told, values)
  output.print("pixel %d,%d of %dx%d, %s, %d sample%s", told.x, told.y, told.width, told.height, told.integrator, told.samples,
    told.samples > 1 and "s" or "")
  output.print("  colour   %s, coverage %.6g", vec(told.value, "%.9g"), told.value[4])
  if told.unit > 0 then
    output.print("  film     %d, %d, %d units of 2^%d, divided by %d", told.sum[1], told.sum[2], told.sum[3],
      math.floor(math.log(told.unit, 2) + 0.5), told.samples)
  end
  if told.clamped + told.dropped > 0 then
    output.print("  film     %d contributions were limited, %d were no numbers", told.clamped, told.dropped)
  end
  local sums, shown = sample_sums(told), 0
  for _, root in ipairs(told.roots) do
    local s = sums[root.sample]
    if shown < TELL or values.sample or values.all_samples then
      local out = {}
      output.print("\nsample %d: %d ray%s%s", root.sample, s.rays, s.rays > 1 and "s" or "",
        told.unit > 0 and ", brings " .. vec(amount(s, told.unit)) or "")
      tell_tree(told, root, out)
      output.write(table.concat(out, "\n") .. "\n")
    end
    shown = shown + 1
  end
  if shown > TELL and not values.sample and not values.all_samples then
    output.print("\n%d of %d samples are told; --sample N tells one, --all tells all", TELL, shown)
  end
end

-- ---- JSON ----

local function list(v)
  return { table.unpack(v, 1, 3) }
end

local function hit_json(h)
  return json.object():set("t", h.t):set("object", h.object and tostring(h.object):match "^[%w_.]+"):set("name", h.name):set("instance", h.inst_id)
    :set("instance_name", h.instance_name):set("geometry", h.geom_id):set("primitive", h.prim_id):set("position", list(h.position))
    :set("normal", list(h.ng)):set("shading_normal", list(h.ns)):set("uv", { h.texture_u, h.texture_v }):set("material", h.material_id)
    :set("material_name", h.material_name):set("color", list(h.color))
end

local function ray_json(ray)
  return json.object():set("ray", ray.index - 1):set("parent", ray.parent and ray.parent - 1):set("kind", ray.kind):set("sample", ray.sample)
    :set("depth", ray.depth):set("light", ray.light_id):set("light_name", ray.light):set("origin", list(ray.org)):set("direction", list(ray.dir))
    :set("tmax", ray.tmax):set("weight", list(ray.throughput)):set("arrived", ray.arrived):set("crossed", ray.crossed)
    :set("brought", list(ray.brought)):set("unshadowed", not is_zero(ray.unshadowed) and list(ray.unshadowed) or nil):set("nodes", ray.nodes)
    :set("leaves", ray.leaves):set("tests", ray.tests):set("hit", ray.hit and hit_json(ray.hit))
end

-- Rays in a list, each with its parent's number: as deep as a path may be, the text is flat.
local function print_json(path, told, costs)
  local rays, sums = {}, {}
  for i, c in ipairs(costs) do
    sums[i] = json.object():set("tracer", c.tracer):set("rays", c.rays):set("nodes", c.nodes):set("leaves", c.leaves):set("tests", c.tests)
  end
  for i, ray in ipairs(told.rays) do
    rays[i] = ray_json(ray)
  end
  output.print("%s", json.encode(json.object():set("scene", path):set("x", told.x):set("y", told.y):set("width", told.width)
    :set("height", told.height):set("integrator", told.integrator):set("samples", told.samples):set("unit", told.unit):set("sum", list(told.sum))
    :set("value", { table.unpack(told.value, 1, 4) }):set("clamped", told.clamped):set("dropped", told.dropped)
    :set("costs", #sums > 0 and sums or nil):set("rays", rays)))
end

-- ---- what the rays cost in other structures ----

-- Steps of the told rays in each tracer, whose pixels are the same.
local function costs_of(scene, told, values)
  local sums = {}
  for _, tracer in ipairs(values.tracers_list or {}) do
    local other = scene:explain(told.x, told.y, { sample = values.sample, tracer = tracer })
    local sum = { tracer = tracer, rays = #other.rays, nodes = 0, leaves = 0, tests = 0 }
    for _, ray in ipairs(other.rays) do
      sum.nodes, sum.leaves, sum.tests = sum.nodes + ray.nodes, sum.leaves + ray.leaves, sum.tests + ray.tests
    end
    sums[#sums + 1] = sum
  end
  return sums
end

local function print_costs(costs)
  local rows = { { "tracer", "rays", "nodes", "leaves", "tests" } }
  for _, c in ipairs(costs) do
    rows[#rows + 1] = { c.tracer, output.count(c.rays), output.count(c.nodes), output.count(c.leaves), output.count(c.tests) }
  end
  output.print ""
  output.table(rows, { true })
end

-- One line about a ray, for the drawing.
local function few_words(told)
  return function(ray)
    local text = KINDS[ray.kind]:gsub(" ray", "")
    if ray.kind == "shadow" or ray.kind == "ao" then
      text = text .. (ray.light and " to " .. quoted(ray.light) or ray.light_id and " to light " .. ray.light_id or "")
        .. (ray.arrived and ray.crossed > 0 and (", through %d"):format(ray.crossed) or not ray.arrived and ", stopped" or "")
    else
      text = text .. (ray.hit and ": " .. what_is_hit(ray.hit):gsub(" %(.*", "") or ": leaves")
    end
    return is_zero(ray.brought) and text or text .. "  + " .. vec(amount(ray.brought, told.unit), "%.3g")
  end
end

local function draw(scene, told, values, path)
  local title = ("pixel %d,%d of %s"):format(told.x, told.y, files.name_of(path))
  files.replace(values.svg, drawing.draw(scene, told.roots[1], title, few_words(told)))
end

function pixel.run(command, values, arguments)
  local path, where = arguments[1], arguments[2]
  local x, y = where:match "^(%d+),(%d+)$"
  x, y = math.tointeger(tonumber(x)), math.tointeger(tonumber(y))
  if not x or not y or #where > 24 then
    cli.fault(command, "X,Y in pixels from the top left is expected, as in 320,200; got %s", require("rtray.types").quote(where))
  end
  local scene = source.open(path, values, command).scene
  local settings = scene:effective()
  if x >= settings.width or y >= settings.height then
    cli.fault(command, "pixel %d,%d lies outside of the image of %dx%d; the last one is %d,%d", x, y, settings.width, settings.height,
      settings.width - 1, settings.height - 1)
  elseif values.sample and values.sample >= settings.samples then
    cli.fault(command, "--sample %d: the pixel has samples 0 to %d; --samples sets their number", values.sample, settings.samples - 1)
  end
  if values.svg then
    files.check_output(values.svg)
  end
  local told = scene:explain(x, y, { sample = values.sample })
  local costs = costs_of(scene, told, values)
  if values.json then
    print_json(path, told, costs)
  else
    print_text(told, values)
    if #costs > 0 then
      print_costs(costs)
    end
  end
  if values.svg then
    draw(scene, told, values, path)
  end
  return 0
end

return pixel
