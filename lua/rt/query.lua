-- Rays asked of scenes: one as a table, many in a buffer.

local core = require "rt.core"
local check = require "rt.check"
local arrays = require "rt.arrays"

local query = {}
local queries = {}

local function name_hit(self, hit)
  if hit then
    local object = hit.inst_id and self.instances[hit.inst_id] or not hit.inst_id and self.objects[hit.geom_id] or nil
    hit.object, hit.name = object, object and object.name
  end
  return hit
end

local ray_fields = {
  org = check.vec3, dir = check.direction, tmin = check.number { low = 0 },
  tmax = function(value, who, key)
    return value == math.huge and value or check.number { low = 0 }(value, who, key)
  end,
  mask = check.integer { low = 0, high = 0xffffffff }, time = check.number { low = 0, high = 1 },
}

local function ray_of(ray, who)
  check.plain_table(ray, who, "{ org = {0, 0, 5}, dir = {0, 0, -1} } or a buffer of rays")
  local checked = check.fields(ray, ray_fields, who)
  check.required(checked, { "org", "dir" }, who)
  return checked
end

-- The closest hit of a ray { org, dir, tmin, tmax, mask, time } as a table, nil on a miss. A buffer of rays (f32, eight numbers a ray: org, tmin,
-- dir, tmax) gives a table of buffers t, u, v, prim_id, geom_id, inst_id, where a miss has prim_id 0xffffffff; `times` is a buffer of
-- their times or nil: time 0.
function queries.intersect(self, ray, times)
  self:commit()
  if arrays.is_buffer(ray) then
    return core.intersect_buffer(self.handle, ray, times)
  end
  return name_hit(self, core.intersect(self.handle, ray_of(ray, "scene:intersect")))
end

-- All hits along a ray in their order, `most` (1024) at most.
function queries.intersect_all(self, ray, most)
  self:commit()
  most = check.integer { low = 1, high = 1024 }(most or 1024, "scene:intersect_all", "the count")
  local hits = core.intersect_all(self.handle, ray_of(ray, "scene:intersect_all"), most)
  for _, hit in ipairs(hits) do
    name_hit(self, hit)
  end
  return hits
end

-- Is anything in the way? A buffer of rays gives a buffer of u8, 1 or 0.
function queries.occluded(self, ray, times)
  self:commit()
  if arrays.is_buffer(ray) then
    return core.occluded_buffer(self.handle, ray, times)
  end
  return core.occluded(self.handle, ray_of(ray, "scene:occluded"))
end

-- Adds the queries to a scene's methods.
function query.install(methods)
  for name, f in pairs(queries) do
    methods[name] = f
  end
end

return query
