-- What a script writes is not what it consists of.

local core = require "rt.core"
local check = require "rt.check"
local run = require "rt.run"
local words = require "rt.words"

local outputs = {}

-- What tells a regular file, whatever its name and through links; nil where there is none.
function outputs.mark(path)
  local kind, _, _, inode, device = core.file_stat(path)
  return kind == "file" and ("%d %d"):format(device, inode) or nil
end

-- Raises when `path` is the file of the script that runs or of one that has loaded it. Other files a script may replace: it knows what it does.
function outputs.check(path, who)
  local mark, r = not path:find "\0" and outputs.mark(path), run.current()
  while mark and r do
    if r.path and outputs.mark(r.path) == mark then
      check.fail("%s: '%s' is the script itself; name another file", who, words.quote(path, 4096))
    end
    r = r.outer
  end
end

-- The file among those that the script of run r has named which `path` is, or nil.
function outputs.read_by(r, path)
  local mark = outputs.mark(path)
  for _, name in ipairs(mark and r.files or {}) do
    if outputs.mark(name) == mark then
      return name
    end
  end
  return nil
end

return outputs
