-- rtray convert FILE.sdf -o FILE.lua

local sys = require "rtray.sys"
local files = require "rtray.files"
local output = require "rtray.output"
local types = require "rtray.types"
local script = require "rt.sdf_script"

local convert = {}

-- Textures are named relative to the file; the script may stand in another folder.
local function texture_path(input, target)
  local step = target == "-" and "" or files.relative(files.folder_of(target), files.folder_of(input))
  return function(name)
    return (name:sub(1, 1) == "/" or not step) and name or step .. name
  end
end

function convert.run(_, values, arguments)
  local input = arguments[1]
  local target = values.output or files.folder_of(input) .. "/" .. files.stem_of(input) .. ".lua"
  files.check_output(target)
  if target ~= "-" and not values.force and sys.stat(target) == "file" then
    error({ status = 1, message = ("%s is there already; --force replaces it, -o names another file"):format(types.quote(target)) }, 0)
  end
  local paths = texture_path(input, target)
  if target == "-" then
    script.convert(input, paths, output.write)
  else
    files.stream(target, function(write)
      script.convert(input, paths, write)
    end)
  end
  return 0
end

return convert
