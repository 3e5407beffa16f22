-- Names and files: where output goes, and whether it can go there.

local sys = require "rtray.sys"
local inputs = require "rtray.inputs"
local types = require "rtray.types"

local files = {}

function files.folder_of(path)
  local folder = path:match "^(.*/)[^/]*$"
  return folder == nil and "." or folder == "/" and "/" or folder:gsub("/+$", "") == "" and "/" or (folder:gsub("/+$", ""))
end

function files.name_of(path)
  return path:match "([^/]*)$"
end

-- NAME of a/b/NAME.ending
function files.stem_of(path)
  local name = files.name_of(path)
  return name:match "^(.+)%.[^.]*$" or name
end

function files.ending_of(path)
  return (files.name_of(path):match "^.+%.([^.]*)$" or ""):lower()
end

-- Raises when `path` can not be written, or is what the command reads: asked before a long computation, not after it.
-- shown: the name in messages, where the user has written another.
function files.check_output(path, shown)
  if path == "-" then
    return
  end
  inputs.check(path)
  shown = types.quote(shown or path)
  local kind = sys.stat(path)
  if kind == "folder" then
    error({ status = 1, message = ("the output %s is a folder; name a file in it"):format(shown) }, 0)
  elseif kind == "other" then
    return
  end
  local folder = files.folder_of(path)
  local folder_kind, why = sys.stat(folder)
  if folder_kind ~= "folder" then
    error({ status = 1, message = ("the output %s cannot be written: the folder %s %s"):format(shown, types.quote(folder),
      folder_kind and "is a file" or "cannot be used: " .. why) }, 0)
  end
  local ok
  ok, why = sys.can_create(folder)
  if not ok then
    error({ status = 1, message = ("the output %s cannot be written into the folder %s: %s"):format(shown, types.quote(folder), why) }, 0)
  end
end

local function check(path, ok, why)
  if not ok then
    error(("%s cannot be written: %s"):format(types.quote(path), tostring(why):gsub("^.*: ", "")), 0)
  end
  return ok
end

-- Calls produce(write) and puts what it writes in the place of `path` when all of it is on disk; at any fault the old file stays. What is no
-- regular file is written to directly.
function files.stream(path, produce)
  files.check_output(path)
  local kind = sys.stat(path)
  local direct = kind == "other"
  local part = direct and path or ("%s.%d.part"):format(path, sys.process_id())
  local file = check(path, io.open(part, "wb"))
  local ok, raised = pcall(produce, function(text)
    check(path, file:write(text))
  end)
  local closed, why = file:close()
  if ok then
    ok, raised = pcall(check, path, closed, why)
  end
  if ok and not direct then
    ok, raised = pcall(check, path, sys.put_in_place(part, path))
  end
  if not ok then
    if not direct then
      os.remove(part)
    end
    error(raised, 0)
  end
end

function files.replace(path, text)
  files.stream(path, function(write)
    write(text)
  end)
end

-- Path of the folder `to` as seen from the folder `from`, both existing; "" when they are the same.
function files.relative(from, to)
  from, to = sys.real_path(from), sys.real_path(to)
  if not from or not to then
    return nil
  end
  local a, b = {}, {}
  for part in from:gmatch "[^/]+" do
    a[#a + 1] = part
  end
  for part in to:gmatch "[^/]+" do
    b[#b + 1] = part
  end
  local same = 0
  while same < #a and same < #b and a[same + 1] == b[same + 1] do
    same = same + 1
  end
  return ("../"):rep(#a - same) .. table.concat(b, "/", same + 1) .. (same < #b and "/" or "")
end

return files
