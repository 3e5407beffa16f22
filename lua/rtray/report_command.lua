-- rtray report DIR: the page of a sweep made again from its data.

local files = require "rtray.files"
local json = require "rt.json"
local output = require "rtray.output"
local sys = require "rtray.sys"
local types = require "rtray.types"

local command = {}

function command.run(_, values, arguments)
  local folder = arguments[1]
  local kind, why = sys.stat(folder)
  if kind ~= "folder" then
    error({ status = 1, message = ("%s %s; name the folder that `rtray sweep -o` has written"):format(types.quote(folder),
      kind and "is no folder" or "cannot be used: " .. why) }, 0)
  end
  folder = folder:gsub("(.)/+$", "%1")
  files.check_output(folder .. "/index.html")
  local made = require("rt.report").write(folder, { plots = not values.no_plots })
  if values.json then
    output.print("%s", json.encode(json.object():set("page", made.page):set("files", made.files):set("notes", made.notes)))
  elseif not values.quiet then
    for _, note in ipairs(made.notes) do
      output.note("%s", types.quote(note):sub(2, -2))
    end
    output.print("%s", made.page)
  end
  return 0
end

return command
