-- rtray render --watch: renders again when the script, or a file it uses, changes. A change ends the render that runs; a faulty script is
-- reported, and the next change tried.

local sys = require "rtray.sys"
local faults = require "rtray.faults"
local output = require "rtray.output"
local source = require "rtray.source"

local watch = {}

local EVERY = 0.25 -- seconds between two looks

-- What tells one state of a file from another: size, time of change, inode (editors write a new file and rename it).
local function stamp(path)
  local kind, size, changed, inode = sys.stat(path)
  return kind and ("%s %d %d %d"):format(kind, size, changed, inode) or "none"
end

-- The first of the files that is not as it was, or nil.
local function changed(stamps)
  for _, entry in ipairs(stamps) do
    if stamp(entry.path) ~= entry.stamp then
      return entry.path
    end
  end
  return nil
end

local function stamps_of(paths)
  local list, seen = {}, {}
  for _, path in ipairs(paths) do
    if not seen[path] then
      seen[path] = true
      list[#list + 1] = { path = path, stamp = stamp(path) }
    end
  end
  return list
end

-- A look at the files at most every EVERY seconds.
local function eye(stamps)
  local next_look = sys.now() + EVERY
  return function()
    if sys.now() < next_look then
      return false
    end
    next_look = sys.now() + EVERY
    return changed(stamps) ~= nil
  end
end

-- once(opened, stale) renders, and returns a status, or nil when it gave up because the files had changed.
function watch.run(path, values, command, once)
  local stamps = stamps_of { path }
  while true do
    local before = stamp(path)
    local opened
    local ok, result = xpcall(function()
      opened = source.open(path, values, command)
      stamps = stamps_of { path, table.unpack(opened.run.files) }
      stamps[1].stamp = before -- a change while the script ran counts
      return once(opened, eye(stamps))
    end, faults.of)
    if not ok and type(result) ~= "table" then -- Lua calls no handler when memory is lacking
      result = faults.of(result)
    end
    if sys.interrupted() then
      return 1
    elseif not ok then
      if result.status == 2 then
        error(result, 0)
      end
      sys.defer(false)
      output.note("rtray render: %s", result.message)
      if not opened then
        stamps = stamps_of { path, table.unpack(watch.files_of(stamps)) }
        stamps[1].stamp = before
      end
    end
    if opened then
      opened.scene:release()
    end
    local what = changed(stamps)
    if not what and not values.quiet then
      output.note("rtray render: waiting for a change of %s", path)
    end
    sys.defer(true)
    while not what do
      sys.sleep(EVERY)
      if sys.interrupted() then
        return 0
      end
      what = changed(stamps)
    end
    sys.defer(false)
    if not values.quiet then
      output.note("rtray render: %s has changed", what)
    end
  end
end

function watch.files_of(stamps)
  local paths = {}
  for i, entry in ipairs(stamps) do
    paths[i] = entry.path
  end
  return paths
end

return watch
