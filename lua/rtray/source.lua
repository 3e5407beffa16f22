-- Opens a SCENE of the command line: runs a script with the parameters and settings the options give, reads an .sdf or mesh file.

local sys = require "rtray.sys"
local cli = require "rtray.cli"
local files = require "rtray.files"
local inputs = require "rtray.inputs"
local types = require "rtray.types"
local options = require "rtray.options"
local output = require "rtray.output"
local recipe = require "rtray.recipe"
local sandbox = require "rtray.sandbox"

local source = {}

-- The settings among the options, as the module names them.
function source.settings(values)
  local settings = {}
  for _, option in ipairs(options.list) do
    local value = values[option.key]
    if option.setting and value ~= nil then
      settings[option.setting] = value
    end
  end
  if values.size then
    settings.width, settings.height = values.size[1], values.size[2]
  end
  if values.no_shadows then
    settings.shadows = false
  end
  return settings
end

local function overrides_of(values)
  local overrides = {}
  for _, define in ipairs(values.define or {}) do
    overrides[define.name] = define.text
  end
  return overrides
end

-- Complaints about -D and --set are about the command line.
local function blame(command, raised)
  if type(raised) ~= "string" then
    error(raised, 0)
  end
  local message = raised
  if message:find("%-D[: ]") or message:find("--set", 1, true) then
    cli.fault(command, "%s", message)
  end
  error(message, 0)
end

-- The scene of an animation's frame: the one asked for, or the first.
local function frame_of(animation, values, command)
  local frame = values.frame or 0
  if frame >= animation.frames then
    cli.fault(command, "--frame %d: the animation has %d frame%s, 0 to %d", frame, animation.frames, animation.frames == 1 and "" or "s",
      animation.frames - 1)
  end
  return animation:scene_at(frame)
end

local MESHES = { ply = true, obj = true, stl = true }

-- --eye, --at, --fov: a mesh file has no camera of its own.
local function set_view(scene, path, values, command)
  local given = values.eye and "--eye" or values.at and "--at" or values.fov and "--fov"
  if not given then
    return
  elseif not MESHES[files.ending_of(path)] then
    cli.fault(command, "%s is for mesh files (.ply, .obj, .stl); %s has a camera of its own", given, types.quote(path))
  end
  local framed = scene.view -- of the whole mesh, which reading it gives
  scene:set_camera(require("rt").camera {
    eye = values.eye or framed.eye, look_at = values.at or framed.look_at, up = framed.up, fov = values.fov or framed.fov,
  })
end

-- Runs what stands at `path`: the value it returns, and the run with the script's parameters and sets.
-- more: settings of the command's own, stronger than the options.
function source.load(path, values, command, more)
  local kind, why = sys.stat(path)
  if kind ~= "file" and not sandbox.stands_in(path) then -- a device may never end
    local reason = kind == "other" and "it is a device or a pipe, not a regular file" or kind and "it is a folder" or why
    error({ status = 1, message = ("%s cannot be read: %s"):format(types.quote(path), reason) }, 0)
  end
  local rt = require "rt"
  rt.on_log(function(level, message)
    if level == "error" or level == "warning" then
      output.note("rtray: %s: %s", level, message)
    end
  end)
  if values.json or values.output == "-" then -- standard output carries an image or JSON
    sandbox.print_to(io.stderr)
    io.output(io.stderr)
  end
  sandbox.configure(path, values, function(...)
    cli.fault(command, ...)
  end)
  local settings = source.settings(values)
  for name, value in pairs(more or {}) do
    settings[name] = value
  end
  local ok, value, run = pcall(rt.load, path, overrides_of(values), { set = values.set, settings = settings, seed = values.seed or 0 })
  if not ok then
    blame(command, value)
  end
  set_view(value, path, values, command)
  recipe.remember(run, path, values)
  inputs.opened(run)
  return value, run
end

local function kind_of(value)
  local meta = getmetatable(value)
  return type(meta) == "table" and meta.__name
end

-- { scene, run, animation } of what stands at `path`; of an animation, the scene of the frame that the options ask for.
function source.open(path, values, command, more)
  local value, run = source.load(path, values, command, more)
  local animation
  if kind_of(value) == "rt.animation" then
    animation = value
    value = frame_of(animation, values, command)
  elseif kind_of(value) ~= "rt.scene" then
    error({ status = 1, message = ("%s: the script returns a %s; it must return a scene, as in `return rt.scene { ... }`"):format(path,
      type(value)) }, 0)
  elseif values.frame then
    cli.fault(command, "--frame: %s is a single picture; rt.animation { frames = ..., scene = function(t) ... end } makes frames", types.quote(path))
  end
  return { scene = value, run = run, animation = animation, frame = animation and (values.frame or 0) or nil }
end

-- The animation at `path`, and the run of its script.
function source.animation(path, values, command)
  local value, run = source.load(path, values, command)
  if kind_of(value) ~= "rt.animation" then
    local what = kind_of(value) == "rt.scene" and "scene" or type(value)
    error({ status = 1, message = ("%s: the script returns a %s, not an animation; `return rt.animation { frames = ..., "
      .. "scene = function(t) ... end }` makes one"):format(path, what) }, 0)
  end
  return value, run
end

return source
