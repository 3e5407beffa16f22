-- Scenes: descriptions handed to librt, renders and ray queries.

local core = require "rt.core"
local camera_numbers = require("rt.camera").numbers
local check = require "rt.check"
local class = require "rt.class"
local guard = require "rt.guard"
local image = require "rt.image"
local items = require "rt.items"
local job = require "rt.job"
local log = require "rt.log"
local look = require "rt.look"
local outputs = require "rt.outputs"
local run = require "rt.run"
local settings = require "rt.settings"
local material = require "rt.material"
local missing = require "rt.missing"
local query = require "rt.query"
local vertices = require "rt.vertices"
local words = require "rt.words"

local scene = {}
local methods = {}
local meta = { __name = "rt.scene", __index = methods }
query.install(methods)
vertices.install(methods)

local children = setmetatable({}, { __mode = "k" }) -- what instances place -> its scene: placed again, it is the same trees

function scene.is(value)
  return getmetatable(value) == meta
end

local function empty(handle)
  return setmetatable({
    handle = handle, dirty = true, ids = {}, objects = {}, instances = {}, lights = {}, children = {}, child_of_instance = {}, materials = {},
    keeps = {}, settings = {}, run = run.current() or false, name = false, view = false, world = {}, read_only = false, framed = false,
    committed = false, -- all there is, so that what a script assigns besides is seen (meta.__newindex)
  }, meta)
end

-- ---- adding ----

local subject -- the item or material that is being handed to the library; after an error the one that it is about

-- The id of a description's texture, or nil.
local function texture_id(self, o, key)
  local texture = material.texture_of(o, key)
  if texture == nil then
    return nil
  end
  local what = texture.bare and texture.file or texture
  local id = self.ids[what]
  if not id then
    if texture.file then
      id = core.texture_load(self.handle, texture.file, texture)
    else
      id = core.texture_image(self.handle, texture.image, texture)
    end
    self.ids[what] = id
  end
  return id
end

-- The id of a material; the same description is one material, none is the default one.
local function material_id(self, description)
  if description == nil then
    return 0
  end
  local id = self.ids[description]
  if not id then
    local before = subject
    subject = description
    class.settle(description)
    id = core.material(self.handle, description, texture_id(self, description, "texture"), texture_id(self, description, "alpha_texture"))
    self.ids[description], self.materials[id], subject = id, description, before
  end
  return id
end

-- The description with its list of materials as ids.
local function with_material_ids(self, description)
  local ids = {}
  for i, m in ipairs(description.materials) do
    ids[i] = material_id(self, m)
  end
  return setmetatable({ material_ids = core.buffer("u32", ids) }, { __index = description })
end

local adders = {}

function adders.shape(self, o)
  class.settle(o)
  local described = o.materials and with_material_ids(self, o) or o
  local first, count = core[o.add](self.handle, described, material_id(self, o.material))
  for id = first, first + (count or 1) - 1 do
    self.objects[id] = o
  end
end

function adders.light(self, o)
  class.settle(o)
  self.lights[core.add_light(self.handle, o)] = o
end

-- The scene that an instance places: what stands in it as its one item, or a scene made of its items.
local function child_of(o)
  local key, only = next(o.items)
  if next(o.items, key) ~= nil then
    only = nil
  elseif scene.is(only) then
    return only
  end
  key = type(only) == "table" and only or o
  local child = children[key]
  if not child then
    child = empty(core.scene())
    items.walk(o.items, "rt.instance", function(item, place)
      local kind = class.kind(item)
      if kind == "light" or kind == "instance" or scene.is(item) then
        check.fail("rt.instance: %s is %s; an instance places one scene, or shapes and groups of them", place(), check.describe(item))
      end
      scene.add_item(child, item, place)
    end)
    children[key] = child
  end
  return child
end

function adders.instance(self, o)
  class.settle(o)
  local child = child_of(o)
  local id = core.add_instance(self.handle, o, o.material and material_id(self, o.material), child.handle)
  self.instances[id], self.child_of_instance[id] = o, child
  if not self.keeps[child] then
    self.keeps[child] = true
    self.children[#self.children + 1] = child
  end
end

-- One object; place() words where it stands in the user's lists.
function scene.add_item(self, item, place)
  local adder = adders[class.kind(item)]
  if not adder then
    local hint = scene.is(item) and "; rt.instance { scene } places a scene" or class.kind(item) and "; it has a key of its own" or ""
    check.fail("rt.scene: %s is %s; an item is an object, a list of items or false%s", place(), check.describe(item), hint)
  end
  local before = subject
  subject = item
  adder(self, item, place)
  subject = before
end

-- What was raised about an item, with its place. A description that the script has changed is looked at again, for only it can say what the script
-- calls the value; what the library refuses is told at the description's line, since the script's is only where the list ends.
local function about_item(message, item, place)
  local fault = class.fault(subject) or class.fault(item)
  if fault then
    return ("%s (%s, %s)"):format(fault, place, tostring(item))
  end
  local failure = check.refusal(message)
  if failure then
    local where = class.kind(subject) and subject.place or message:sub(1, -#failure.text - 1)
    return ("%s%s (%s): %s"):format(where, place, tostring(item), failure.text)
  end
  return message
end

-- Adds all items of a list.
local function add_items(self, list, who)
  local current, where
  subject = nil
  local ok, message = pcall(items.walk, list, who, function(item, place)
    current, where = item, place
    scene.add_item(self, item, place)
  end)
  if not ok then
    error(current ~= nil and about_item(message, current, where()) or message, 0)
  end
  log.deliver()
end

-- scene:add(item, ...): more objects, or lists of them. The next render or query sees them.
function methods.add(self, ...)
  local list = { ... }
  for i = 1, select("#", ...) do
    if list[i] == nil then
      check.fail("scene:add: argument %d is nil; an item is an object, a list of items or false", i)
    end
  end
  self.dirty = true
  add_items(self, list, "scene:add")
  return self
end

-- ---- surroundings and camera ----

local color = check.color()

local function background(value, who, key)
  if type(value) == "table" and getmetatable(value) == nil or getmetatable(value) and getmetatable(value).__name == "rt.vec" then
    return color(value, who, key)
  elseif type(value) == "string" then
    check.no_color_text(value, who, key)
  end
  return material.texture_field(value, who, key)
end

local fields = {
  settings = function(value) return settings.check(value, "rt.scene: settings") end,
  camera = class.field("camera", "rt.camera { eye = ..., look_at = ... } gives it"),
  ambient = color, background = background, background_top = color, name = check.string,
}

function scene.set_world(self, o)
  if not (o.ambient or o.background or o.background_top) then
    return
  end
  local world, texture = { ambient = o.ambient, background_top = o.background_top }, nil
  if class.kind(o.background) then
    texture = texture_id(self, o, "background")
  else
    world.background = o.background
  end
  core.set_world(self.handle, world, texture)
end

-- scene:set_camera(rt.camera { ... }): the camera of renders from now on.
function methods.set_camera(self, camera)
  fields.camera(camera, "scene:set_camera", "the argument")
  core.set_camera(self.handle, camera_numbers(camera))
  self.view, self.dirty = camera, true
  return self
end

-- What a made scene is told by methods; the rest of what rt.scene takes is for rt.scene alone.
local told_by = { camera = "scene:set_camera(rt.camera { ... }) sets it", settings = "scene.settings = { ... } sets them" }

-- Assigning to a made scene would change nothing.
function meta.__newindex(_, key)
  local shown = check.describe(key)
  if math.type(key) then
    check.fail("rt.scene: item %s cannot be assigned to a made scene; scene:add(object) adds one", shown)
  elseif settings.fields[key] then
    check.fail("rt.scene: %s cannot be assigned to a made scene; it is a setting, as in scene.settings.%s or scene:render { %s = ... }", shown,
      key, key)
  end
  local meant = fields[key] and key or type(key) == "string" and words.nearest(key, check.sorted_keys(fields))
  local guess = meant and meant ~= key and "did you mean " .. meant .. "? " or ""
  local hint = meant and (told_by[meant] or ("rt.scene { %s = ... } takes it"):format(meant)) or "scene:set_camera and scene:add change one"
  check.fail("rt.scene: %s cannot be assigned to a made scene; %s%s", shown, guess, hint)
end

-- Without a camera of its own a scene is framed for the image's shape.
local function frame(self, width, height)
  local aspect = width / height
  if not self.view and not self.read_only and self.framed ~= aspect then
    core.frame_camera(self.handle, aspect)
    self.framed, self.dirty = aspect, true
  end
end

-- What rt.camera takes for a view of everything finite, for an image of the settings' shape.
function scene.framing(self)
  local values = self:effective()
  core.frame_camera(self.handle, values.width / values.height)
  local c = core.get_camera(self.handle)
  return { eye = c.eye, look_at = c.look_at, up = c.up, fov = c.fov }
end

-- rt.scene { settings = ..., camera = ..., objects ... }
function scene.new(t)
  check.plain_table(t, "rt.scene", "rt.scene { camera = ..., objects }")
  local o = check.fields(t, fields, "rt.scene", true)
  local self = empty(core.scene())
  self.settings, self.name = o.settings or {}, o.name or false
  if o.camera then
    self:set_camera(o.camera)
  end
  scene.set_world(self, o)
  self.world = { ambient = o.ambient, background = o.background, background_top = o.background_top }
  local positional = {}
  for key, value in next, t do
    if math.type(key) then
      positional[key] = value
    end
  end
  add_items(self, positional, "rt.scene")
  return self
end

-- A scene that scene:save has written. It renders and answers queries; it takes no more objects.
function scene.load_snapshot(path)
  local self = empty(core.scene_load(run.resolve(check.string(path, "rt.load_snapshot", "the path"))))
  self.read_only, self.dirty = true, false
  return self
end

-- ---- settings ----

-- The settings that hold, and where each comes from ("argument", "command line", "set NAME", "script", "built in").
function methods.effective(self, arguments)
  local r, layers = self.run, { { settings.check(self.settings, "scene.settings"), "script" } } -- a script may have assigned them
  if r then
    local set = r.set and r.sets[r.set]
    if set then
      layers[#layers + 1] = { set.settings, "set " .. r.set }
    end
    layers[#layers + 1] = { r.settings, "command line" }
  end
  layers[#layers + 1] = { settings.check(arguments or {}, "scene:effective"), "argument" }
  return settings.merge(layers)
end

-- Of a job, as C takes them. A checkpoint's path is relative to where the program runs.
local job_fields = {
  background = check.boolean,
  checkpoint = check.string, checkpoint_every = check.number { above = 0, high = 1e9 }, checkpoint_keep = check.boolean,
}
local render_fields = setmetatable({ progress = check.callable, preview = check.boolean }, { __index = settings.fields })
for name, field in pairs(job_fields) do
  render_fields[name] = field
end
for name, field in pairs(settings.fields) do
  render_fields[name] = field
end

-- The checked arguments of a render: settings, and the rest.
local function arguments_of(t, who)
  t = t or {}
  check.plain_table(t, who, "scene:render { samples = 4 }")
  check.keys(t, render_fields, who, "setting")
  local given, rest = {}, {}
  for key, value in next, t do
    if settings.fields[key] then
      given[key] = value
    else
      rest[key] = render_fields[key](value, who, key)
    end
  end
  return settings.check(given, who), rest
end

local function add_job_fields(values, rest)
  for name in pairs(job_fields) do
    values[name] = rest[name]
  end
end

-- ---- committing, rendering ----

local COMMIT = {}
for _, row in ipairs(settings.list) do
  COMMIT[#COMMIT + 1] = row.commit and row.name or nil
end

-- Commits what has changed since, children first; returns whether there was something.
local function commit(self, values)
  if self.read_only then
    return false
  end
  local wanted, key = {}, {}
  for i, name in ipairs(COMMIT) do
    wanted[name] = values[name]
    key[i] = tostring(values[name])
  end
  key = table.concat(key, "\0")
  for _, child in ipairs(self.children) do
    self.dirty = commit(child, values) or self.dirty
  end
  if self.dirty or self.committed ~= key then
    local before = guard.phase "in the build of the trees"
    core.scene_commit(self.handle, wanted)
    guard.phase(before)
    self.dirty, self.committed = false, key
    log.deliver()
    return true
  end
  return false
end

-- Makes the trees now, with the settings that hold; renders and queries do it when needed.
function methods.commit(self)
  commit(self, (self:effective()))
  return self
end

local function start(self, t, who)
  local given, rest = arguments_of(t, who)
  local values = self:effective(given)
  frame(self, values.width, values.height)
  commit(self, values)
  values.preview = rest.preview
  add_job_fields(values, rest)
  local started = job.new(core.job_start(self.handle, values), self)
  started.settings = values
  return started, rest
end

-- scene:start { samples = 4, preview = true, ... }: a job.
function methods.start(self, t)
  return (start(self, t, "scene:start"))
end

-- scene:render { samples = 4, progress = function(done, job) end, ... }: the image.
function methods.render(self, t)
  local started <close>, rest = start(self, t, "scene:render")
  local state = started:wait(nil, rest.progress)
  if state ~= "done" then
    check.fail("the render was cancelled")
  end
  return started:image(), started:stats()
end

-- rt.render(scene, { samples = 4 }) is scene:render { samples = 4 }.
function scene.render(self, t)
  if not scene.is(self) then
    check.fail("rt.render: the first argument must be a scene; got %s", check.describe(self))
  end
  return self:render(t)
end

local file_fields = {
  progress = check.callable, band_memory = check.integer { low = 0, high = math.maxinteger },
  save = function(value, who, key)
    return image.save_options(check.plain_table(value, who .. ": " .. key, "{ tone = 'filmic' }"), who .. ": " .. key)
  end,
}

-- scene:render_to_file("big.png", { width = 32768, height = 32768, save = { tone = "filmic" }, band_memory = 2^28, progress = f }): renders by bands
-- straight into a PNG, BMP, TGA or HDR file, so that images larger than the memory can be made. f(done), the part from 0 to 1, is called for
-- each tile with more than before and about every 50 ms in between with the same; it may end the render by returning true: then false is returned and
-- the file is as it was.
function methods.render_to_file(self, path, t)
  local who = "scene:render_to_file"
  outputs.check(check.string(path, who, "the path"), who)
  local rest, given = {}, {}
  for key, value in next, check.plain_table(t or {}, who, "{ width = 32768, height = 32768 }") do
    if file_fields[key] then
      rest[key] = file_fields[key](value, who, key)
    else
      given[key] = value
    end
  end
  local settings_given, others = arguments_of(given, who)
  local values = self:effective(settings_given)
  frame(self, values.width, values.height)
  self:commit(values)
  add_job_fields(values, others)
  return core.render_to_file(self.handle, values, path, rest.save or {}, rest.band_memory or 0, rest.progress)
end

setmetatable(methods, { __index = missing.index("rt.scene", "method", methods, "scene:", { camera = "scene:get_camera() tells the camera" }) })

look.install(methods, function(self, given)
  local values = self:effective(given)
  frame(self, values.width, values.height)
  commit(self, values)
  return values
end, function(t, who, own)
  local given, rest = {}, {}
  for key, value in next, check.plain_table(t or {}, who, "{ samples = 4 }") do
    if own[key] then
      rest[key] = own[key](value, who, key)
    else
      given[key] = value
    end
  end
  return settings.check(given, who), rest
end)

-- Bytes that a render would take beside the scene.
function methods.memory(self, t)
  local values = self:effective((arguments_of(t, "scene:memory")))
  frame(self, values.width, values.height)
  commit(self, values)
  return core.render_memory(self.handle, values)
end

-- ---- facts ----

-- Counts, bytes and trees.
function methods.info(self)
  self:commit()
  return core.scene_info(self.handle)
end

-- Was something described since the last commit, here or in what instances place?
local function is_dirty(self)
  if self.dirty then
    return true
  end
  for _, child in ipairs(self.children) do
    if is_dirty(child) then
      return true
    end
  end
  return false
end

-- Committed for its hashes: with the camera that follows from the settings' shape, and without a tree.
local function commit_description(self)
  local values = self:effective()
  frame(self, values.width, values.height)
  if not self.read_only and is_dirty(self) then
    values.accel = "brute"
    commit(self, values)
  end
end

-- Hash of all that can change a picture, settings apart.
function methods.hash(self)
  commit_description(self)
  return core.scene_hash(self.handle)
end

-- The same in parts: { rest = hash of all but the looks of materials, hash of each material's look ... } in the order of stats.touched.
function methods.looks(self)
  commit_description(self)
  return core.scene_looks(self.handle)
end

-- Corners of the box around everything finite; nil when there is nothing.
function methods.bounds(self)
  return core.scene_bounds(self.handle)
end

-- The camera as it stands: of the description, or framed for the last image.
function methods.get_camera(self)
  return core.get_camera(self.handle)
end

-- scene:save "x.rts": the committed scene as one file for rt.load_snapshot.
function methods.save(self, path)
  outputs.check(check.string(path, "scene:save", "the path"), "scene:save")
  self:commit()
  core.scene_save(self.handle, path)
  return self
end

function methods.release(self)
  self.handle:release()
end
meta.__close = methods.release

function meta.__tostring(self)
  return self.name and "rt.scene '" .. self.name .. "'" or "rt.scene"
end

return scene
