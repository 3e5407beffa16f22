-- Looking inside: the cells of trees, planes through a scene, what rays cost, one pixel explained.

local core = require "rt.core"
local check = require "rt.check"
local arrays = require "rt.arrays"

local look = {}
local methods = {}

-- ---- trees ----

local function group_field(value, who, key)
  if value == "top" or value == "all" then
    return value
  end
  return check.integer { low = 0, high = 0xfffffffe }(value, who, key)
end

local plane_fields = { point = check.vec3, normal = check.direction }
local function plane(value, who, key)
  local o = check.fields(check.plain_table(value, who .. ": " .. key, "{ point = {0, 1, 0}, normal = {0, 1, 0} }"), plane_fields, who .. ": " .. key)
  check.required(o, { "point", "normal" }, who .. ": " .. key)
  return o
end

local query_fields = {
  tracer = check.string, group = group_field, part = check.integer { low = 0, high = 0xffffffff }, cut = plane,
  max_depth = check.integer { low = 0, high = 4096 }, min_size = check.number { low = 0 },
}

-- The checked query as the library takes it. group: the given one, else `group`; a name stands for no number.
local function query(t, who, group)
  local o = check.fields(check.plain_table(t or {}, who, "{ tracer = 'kdtree', group = 0 }"), query_fields, who)
  local given = o.group or group
  return {
    tracer = o.tracer, group = math.type(given) and given or nil, part = o.part, max_depth = o.max_depth, min_size = o.min_size,
    point = o.cut and o.cut.point, normal = o.cut and o.cut.normal,
  }
end

-- scene:tree_cells { tracer = "octree", group = 0, cut = { point = ..., normal = ... }, max_depth = 8, min_size = 0.1 }: the cells of a tree in
-- its order, a table each: low, high, depth, leaves (1: a leaf), empty_leaves, references, deepest, largest, and with a cut its corners.
-- group "top": the top level.
function methods.tree_cells(self, t)
  self:commit()
  return core.tree_cells(self.handle, query(t, "scene:tree_cells", 0))
end

-- Leaves counted by depth and by references: { depths = list, sizes = list } of { low, high, leaves, references }.
function methods.tree_leaves(self, t)
  self:commit()
  return core.tree_leaves(self.handle, query(t, "scene:tree_leaves", 0))
end

-- { low, high, sah_cost, cost_traverse, cost_intersect } of a tree; nil where none stands.
function methods.tree_shape(self, t)
  self:commit()
  return core.tree_shape(self.handle, query(t, "scene:tree_shape", 0))
end

-- scene:cut { cut = { point = ..., normal = ... }, group = 0 }: the outlines of primitives in a plane: a buffer of six numbers a piece (from,
-- to), and one of its ids (prim, geom, inst; 0xffffffff: none). group "top": all instances, placed.
function methods.cut(self, t)
  self:commit()
  local q = query(t, "scene:cut", 0)
  if not q.point then
    check.fail("scene:cut needs cut, as in scene:cut { cut = { point = {0, 1, 0}, normal = {0, 1, 0} } }")
  end
  return core.scene_cut(self.handle, q)
end

-- What each of many rays (a buffer as for scene:intersect) costs: buffers nodes, leaves, tests. options: tracer; group, the group whose tree
-- alone is asked ("all": the whole scene); blind = true: the rays see nothing and run through all.
function methods.ray_costs(self, rays, options)
  local who = "scene:ray_costs"
  self:commit()
  if not arrays.is_buffer(rays) or rays:type() ~= "f32" or #rays % 8 ~= 0 then
    check.fail("%s: rays must be a buffer of type f32 with 8 numbers a ray (org, tmin, dir, tmax); got %s", who, check.describe(rays))
  end
  local o = {}
  for key, value in next, check.plain_table(options or {}, who, "{ tracer = 'kdtree' }") do
    o[key] = value
  end
  local blind = o.blind ~= nil and check.boolean(o.blind, who, "blind")
  o.blind = nil
  return core.ray_costs(self.handle, query(o, who, "all"), rays, blind)
end

-- ---- one pixel ----

-- The name of the light whose body is the geometry behind the described ones: bodies stand in the order of visible lights.
local function body_name(self, geom_id)
  local count, id = 0, 0
  while self.objects[count] do
    count = count + 1
  end
  while self.lights[id] do
    local light = self.lights[id]
    if light.light == "sphere" and light.visible then
      if geom_id == count then
        return light.name and "body of " .. light.name or "body of light " .. id
      end
      count = count + 1
    end
    id = id + 1
  end
  return nil
end

-- Puts the descriptions and their names to a hit.
local function name_hit(self, hit)
  local owner = self
  if hit.inst_id then
    hit.instance = self.instances[hit.inst_id]
    hit.instance_name = hit.instance and hit.instance.name
    owner = hit.instance and self.child_of_instance[hit.inst_id]
  end
  hit.object = owner and owner.objects[hit.geom_id]
  hit.name = hit.object and hit.object.name or owner and not hit.object and body_name(owner, hit.geom_id) or nil
  owner = hit.material_group > 0 and self.children[hit.material_group] or hit.material_group == 0 and self or nil
  hit.material = owner and owner.materials[hit.material_id]
  hit.material_name = hit.material and hit.material.name
end

local explain_fields = { sample = check.integer { low = 0, high = 65535 } }

-- Installs the methods. prepare(self, settings) commits for a render with them and gives those that hold; split(t, who, fields): the
-- settings among a call's arguments, and the rest checked by `fields`.
function look.install(into, prepare, split)
  for name, f in next, methods do
    into[name] = f
  end

  -- scene:explain(x, y, { sample = 3, and settings }): how the pixel came about: { x, y, samples, unit, sum, value, clamped, dropped, rays,
  -- roots }. Each ray has kind, sample, depth, org, dir, throughput, hit, brought (whole numbers in film units), its children; roots are
  -- the camera rays.
  function into.explain(self, x, y, t)
    local who = "scene:explain"
    local pixel = check.integer { low = 0, high = 0xfffffffe }
    local asked = { x = pixel(x, who, "x"), y = pixel(y, who, "y") }
    local given, rest = split(t, who, explain_fields)
    if rest.sample then
      asked.first_sample, asked.sample_count = rest.sample, 1
    end
    local values = prepare(self, given)
    local told = core.explain(self.handle, values, asked)
    told.x, told.y, told.width, told.height, told.integrator, told.roots = x, y, values.width, values.height, values.integrator, {}
    for i, ray in ipairs(told.rays) do
      local parent = ray.parent and told.rays[ray.parent]
      local list = parent and (parent.children or {}) or told.roots
      if parent then
        parent.children = list
      end
      list[#list + 1] = told.rays[i]
      local light = ray.light_id and self.lights[ray.light_id]
      ray.light = light and light.name
      if ray.hit then
        name_hit(self, ray.hit)
      end
    end
    return told
  end
end

return look
