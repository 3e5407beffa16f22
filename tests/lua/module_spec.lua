-- The module as a whole: its stub for editors, its neighbours, many states.

local support = require "support"
local rt = support.rt

local function stub()
  local file = assert(io.open(os.getenv "RT_STUB" or "lua/rt.d.lua"))
  local text = file:read "a"
  file:close()
  return text
end

local function sorted(set)
  local list = {}
  for name in pairs(set) do
    list[#list + 1] = name
  end
  table.sort(list)
  return table.concat(list, " ")
end

-- The names that `pattern` captures in the stub.
local function declared(pattern, text)
  local set = {}
  for name in (text or stub()):gmatch(pattern) do
    set[name] = true
  end
  return set
end

describe("the stub rt.d.lua", function()
  it("is Lua", function()
    assert(load(stub()))
  end)

  it("names what the module has", function()
    local set = declared "\nfunction rt%.([%w_]+)"
    set.version, set.build = true, true
    assert.equal(sorted(rt), sorted(set))
    for name, value in pairs(rt) do
      assert.equal((name == "version" or name == "build") and "string" or "function", type(value))
    end
  end)

  it("names every method", function()
    local scene = support.ball()
    local job = scene:start()
    local objects = {
      Scene = getmetatable(scene).__index, Job = getmetatable(job).__index, Image = getmetatable(rt.image { width = 1, height = 1 }).__index,
      Transform = getmetatable(rt.transform()).__index,
      Animation = getmetatable(rt.animation { frames = 1, scene = print }).__index, Keys = getmetatable(rt.keys { { 0, 1 } }).__index,
      Quat = getmetatable(rt.quat()).__index, Path = getmetatable(rt.path { { 0, 0, 0 }, { 1, 0, 0 } }).__index,
      Orbit = getmetatable(rt.orbit { radius = 1 }).__index,
    }
    for class, methods in pairs(objects) do
      assert.equal(sorted(methods), sorted(declared("\nfunction " .. class .. ":([%w_]+)")))
    end
    for name in pairs(declared "\nfunction Vec:([%w_]+)") do
      assert.is_function(rt.vec(1, 2, 3)[name])
    end
    for name in pairs(declared "\nfunction Buffer:([%w_]+)") do
      assert.is_function(rt.buffer("u8", 1)[name])
    end
  end)

  -- The keys that a constructor takes, from what it says about a wrong one.
  local function keys_of(constructor)
    local _, message = pcall(constructor, { qqqqqqqqqqqqqqqq = 1 })
    local set = {}
    for name in message:match "known are (.*)$":gmatch "[%w_]+" do
      set[name] = true
    end
    return set
  end

  local function fields_of(class)
    local text = stub()
    local head, body = text:match("%-%-%-@class rt%." .. class .. "([^\n]*)\n(.-)\n\n")
    local set = declared("%-%-%-@field ([%w_]+)", body)
    if head:find "rt.shape_desc" then
      for name in pairs(fields_of and declared("%-%-%-@field ([%w_]+)", text:match "%-%-%-@class rt%.shape_desc\n(.-)\n\n")) do
        set[name] = true
      end
    end
    return set
  end

  it("names every key of the constructors", function()
    for _, name in ipairs { "scene", "camera", "point_light", "sphere_light", "directional_light", "classic", "emissive", "texture", "sphere",
      "spheres", "plane", "box", "cylinder", "cylinders", "cone", "cones", "torus", "mesh", "polyhedron", "group", "instance", "animation",
      "orbit", "contact_sheet", "sweep" } do
      assert.equal(sorted(keys_of(rt[name])), sorted(fields_of(name .. "_desc")), name)
    end
    assert.equal(sorted(keys_of(function(t) return rt.scene { settings = t } end)), sorted(fields_of "settings"))
  end)
end)

describe("the defaults in rt.d.lua", function()
  -- Those of a class, as the brackets behind its fields have them.
  local function defaults_of(class)
    local body, values = stub():match("%-%-%-@class rt%." .. class .. "[^\n]*\n(.-)\n\n"), {}
    for name, value in (body .. "\n"):gmatch "%-%-%-@field ([%w_]+)%? [^\n]- %(([^()]+)%)\n" do
      values[name] = load("return " .. value)() -- nil for a word
      values[name] = values[name] == nil and value or values[name]
    end
    return values
  end

  it("are the settings'", function()
    local told, count = defaults_of "settings", 0
    for _, row in ipairs(rt.settings()) do
      if row.default ~= nil then
        assert.equal(row.default, told[row.name], row.name)
        count = count + 1
      end
    end
    assert.is_true(count > 15)
  end)

  -- What is described with the defaults given is what is described without them.
  local function same(make, given, class)
    local told = defaults_of(class)
    assert.is_not_nil(next(told), class)
    for key, value in pairs(given) do
      told[key] = value
    end
    assert.equal(make(given):hash(), make(told):hash(), class)
  end

  it("are those of descriptions", function()
    local function item(constructor)
      return function(t) return rt.scene { constructor(t) } end
    end
    local at, ball = { 1, 2, 3 }, { center = { 0, 0, 0 }, radius = 1 }
    same(function(t) return rt.scene { rt.sphere { center = { 0, 0, 0 }, radius = 1, material = rt.classic(t) } } end, {}, "classic_desc")
    same(item(rt.point_light), { at = at }, "point_light_desc")
    same(item(rt.sphere_light), { at = at, radius = 1 }, "sphere_light_desc")
    same(item(rt.directional_light), { direction = at }, "directional_light_desc")
    same(item(rt.sphere), ball, "shape_desc")
    same(item(rt.plane), { point = at, normal = at }, "plane_desc")
    same(item(rt.cone), { from = { 0, 0, 0 }, to = at, radius = 1 }, "cone_desc")
    same(function(t) return rt.scene { ambient = t.ambient, background = t.background } end, {}, "scene_desc")
    local view = { eye = at, look_at = { 0, 0, 0 } }
    local told = defaults_of "camera_desc"
    local seen = rt.scene { camera = rt.camera(view) }:get_camera()
    for _, key in ipairs { "up", "fov", "height", "aperture", "blades", "blade_rotation", "projection" } do
      assert.same(told[key], seen[key], key)
    end
  end)
end)

describe("the guide docs/lua.md", function()
  it("has code that runs", function()
    local file = assert(io.open "docs/lua.md")
    local text = file:read "a"
    file:close()
    local count = 0
    for code in text:gmatch "```lua\n(.-)```" do
      count = count + 1
      local result = assert(load(code, "=docs/lua.md block " .. count))()
      if result then
        result = result.scene_at and result:scene_at(0) or result
        assert.is_true(result:info().geometries > 0)
      end
    end
    assert.equal(9, count)
  end)
end)

describe("the module", function()
  it("guesses what is meant where it has no such name", function()
    local scene, raises = support.ball(), support.raises
    for _, row in ipairs {
      { function() return rt.spere {}, nil end, "rt has no function 'spere'; did you mean rt.sphere?" },
      { function() return rt.triangle {}, nil end, "rt has no function 'triangle'; rt.mesh { vertices = ..., faces = {{1, 2, 3}} } makes triangles" },
      { function() return rt.light {}, nil end, "rt has no function 'light'; there are rt.point_light, rt.sphere_light and rt.directional_light" },
      { function() scene:rendr() end, "rt.scene has no method 'rendr'; did you mean scene:render?" },
      { function() return scene.camera, nil end, "rt.scene has no method 'camera'; scene:get_camera() tells the camera" },
      { function() return rt.classic { diffuse = 1 }, nil end, "rt.classic has no key 'diffuse'; did you mean diffusion?" },
    } do
      raises(row[2], row[1])
    end
    assert.is_nil(rt.foo) -- a script may ask
    assert.is_nil(rt[1])
    assert.is_nil(scene.scene_at)
  end)

  it("does not guess wildly", function()
    local words = require "rt.words"
    assert.is_nil(words.nearest("foo", { "ior" }))
    assert.is_nil(words.nearest("x", { "xy" }))
    assert.is_nil(words.nearest("bottom", { "motion" }))
    assert.equal("fov", words.nearest("fvo", { "ior", "fov" }))
  end)

  it("says what it is", function()
    assert.is_truthy(rt.version:find "^%d+%.%d+%.%d+$")
    assert.is_truthy(rt.build:find "stb=")
    local machine = rt.machine()
    assert.is_true(machine.cpus >= 1 and machine.workers >= 1 and machine.memory_available > 0)
    assert.equal("whitted", rt.integrators()[1].name)
    assert.is_string(rt.tracers()[1].help)
  end)

  it("stands beside other C modules", function()
    local ok, cjson = pcall(require, "cjson")
    if not ok then
      pending "cjson is not installed"
      return
    end
    assert.equal('{"a":1}', cjson.encode { a = 1 })
    local program = os.getenv "RT_PROGRAM"
    if program then -- which has the module inside and shares liblua; a sanitizer for stock lua5.4 is not for it
      support.in_folder(function(folder)
        support.write(folder .. "/s.lua", [[
          local rt, cjson = require "rt", require "cjson"
          return rt.scene { rt.sphere(cjson.decode '{"center": [0, 0, 0], "radius": 1}') }]])
        assert.is_true(os.execute(("LD_PRELOAD= %s render %s/s.lua --trust --size 4x4 -n 1 -o %s/s.png --quiet"):format(program, folder, folder)))
      end)
    end
  end)

  local function lua(code)
    local pipe = io.popen("lua5.4 - 2>&1 <<'END'\n" .. code .. "\nEND\necho status $?")
    local text = pipe:read "a"
    pipe:close()
    return text
  end

  it("is configured before it is used", function()
    assert.equal("1\nstatus 0\n", lua 'local rt = require "rt"; rt.configure { workers = 1 }; print(rt.machine().workers)')
    assert.is_truthy(lua('local rt = require "rt"; rt.scene {}; rt.configure { workers = 1 }')
      :find "rt.configure must come before the first scene or image")
  end)

  it("says what it lacks when memory is limited, and goes on", function()
    assert.equal("status 0\n", lua [[
      local rt = require "rt"
      rt.configure { memory_limit = 2^24 | 0 }
      local list = {}
      for i = 1, 100000 do list[i] = rt.sphere { center = {i, 0, 0}, radius = 1 } end
      local ok, message = pcall(function() return rt.scene(list):commit() end)
      assert(not ok and message:find "memory", message)
      local scene = rt.scene { list[1] }
      ok, message = pcall(scene.render, scene, { width = 2000, height = 2000, samples = 1 })
      assert(not ok and message:find "2000 x 2000 pixels need %d+ bytes", message)
      collectgarbage()
      assert(scene:render { width = 8, height = 8, samples = 1 })
    ]])
  end)

  it("reads and writes numbers the same in a German locale", function()
    if not os.setlocale("de_DE.UTF-8", "numeric") then
      pending "the locale de_DE.UTF-8 is not installed"
      return
    end
    local hash = support.ball():hash()
    os.setlocale("C", "numeric")
    assert.equal(hash, support.ball():hash())
  end)

  it("hands on what the library says", function()
    local lines = {}
    local before = rt.on_log(function(level, text)
      lines[#lines + 1] = level .. " " .. text
    end)
    assert.is_nil(before)
    support.in_folder(function(folder)
      support.write(folder .. "/t.mtl", "newmtl m\nmap_Kd missing.png\n")
      support.write(folder .. "/t.obj", "mtllib t.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
      assert.equal(1, rt.scene { rt.mesh { file = folder .. "/t.obj" } }:info().triangles)
    end)
    assert.is_function(rt.on_log(nil))
    assert.is_truthy(table.concat(lines, "\n"):find("missing.png", 1, true))
  end)

  it("ends cleanly with objects alive, in any order", function()
    assert.equal("status 0\n", lua [[
      local rt = require "rt"
      local function scene() return rt.scene { rt.sphere { center = {0, 0, 0}, radius = 1 } } end
      a = scene()
      b = rt.scene { rt.instance { a } }
      c = b:start { width = 64, height = 64, samples = 4096 }
      d = b:render { width = 8, height = 8, samples = 1 }
      setmetatable({}, { __gc = function() a:release() d:release() end })
      e = scene():start { width = 64, height = 64, samples = 4096 }
      rt, package.loaded.rt = nil, nil
      collectgarbage()
    ]])
  end)

  it("can be used by many states and opened again", function()
    assert.equal("status 0\n", lua [[
      for i = 1, 50 do
        local rt = require "rt"
        assert(rt.scene { rt.sphere { center = {0, 0, 0}, radius = 1 } }:render { width = 4, height = 4, samples = 1 })
        for name in pairs(package.loaded) do
          if name == "rt" or name:find "^rt%." then
            package.loaded[name] = nil
          end
        end
      end
    ]])
  end)
end)
