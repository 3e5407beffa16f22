-- Claims: who is at work on which frame, for processes that share a folder. A claim is a file that only one process can make. Its owner touches it
-- every few seconds; a claim is void when its owner is a process of this machine that is gone, or when it was seen untouched for a minute
-- by our own clock (clocks of machines differ, so none is read). Two owners of one frame do no harm: they write the same bits.

local sys = require "rtray.sys"
local types = require "rtray.types"

local claims = {}
claims.__index = claims

local BEAT = 5                                                              -- seconds between two signs of life
local EXPIRY = tonumber(os.getenv "RTRAY_CLAIM_SECONDS" or "") or 60

local function first_line(path)
  local file = sys.stat(path) == "file" and io.open(path, "rb") or nil -- a pipe would wait for ever
  local line = file and (file:read(4096) or "") -- empty: its owner was ended before it wrote
  if file then
    file:close()
  end
  return line and line:match "^[^\n]*" or nil
end

-- When a process began, as the system counts it: a number that comes again gives another. "-" where the system does not say, and nil of what
-- has ended and only waits for its parent to notice.
local function began(id)
  local stat = first_line(("/proc/%d/stat"):format(id))
  local rest = stat and stat:match "^.*%) (.*)$" -- the name in parentheses may hold anything
  local at, i = "-", 0
  for word in (rest or ""):gmatch "%S+" do
    i = i + 1
    if i == 1 and (word == "Z" or word == "X") then
      return nil
    end
    at = i == 20 and word or at
  end
  return at
end

local function lives(id, start)
  return #id < 10 and sys.process_alive(math.tointeger(tonumber(id))) and began(id) == start
end

-- This machine since it was started, and its space of process numbers.
local function machine()
  local boot = first_line "/proc/sys/kernel/random/boot_id" or "-"
  local space = (sys.real_path "/proc/self/ns/pid" or ""):match "pid:%[(%d+)%]" or "-"
  return ("%s %s %s"):format((sys.host_name() or "-"):gsub("%s", "_"), boot, space)
end

-- folder: where the claims lie.
function claims.new(folder)
  local id = sys.process_id()
  local self = { folder = folder, machine = machine(), own = {}, seen = {}, next_beat = 0 }
  self.text = ("%s %d %s\n"):format(self.machine, id, began(id))
  self.home = sys.sha256(self.machine):sub(1, 8)
  self.tag = ("%s-%d-%s"):format(self.home, id, began(id)) -- names this process in names of files
  return setmetatable(self, claims)
end

local function path_of(self, name)
  return ("%s/%s.claim"):format(self.folder, type(name) == "number" and ("%06d"):format(name) or name)
end

-- Is the claim at `path` void?
local function is_void(self, path)
  local text = first_line(path)
  local kind, _, changed, inode = sys.stat(path)
  if kind == "other" then
    return true -- a pipe or a device, which no process of ours has made
  elseif not text or not changed then
    return false -- gone by now: the next try tells
  end
  local where, id, start = text:match "^(.*) (%d+) (%S+)$"
  if where == self.machine then
    return not lives(id, start)
  end
  local mark, seen = ("%s %d %d"):format(text, changed, inode), self.seen[path]
  if not seen or seen.mark ~= mark then
    self.seen[path] = { mark = mark, since = sys.now() }
    return false
  end
  return sys.now() - seen.since >= EXPIRY
end

-- Does the process of such a tag live? Of other machines' processes that is not known, so they do.
function claims:alive(tag)
  local home, id, start = tag:match "^(%x+)%-(%d+)%-(%w*%-?)$"
  return home ~= self.home or lives(id, start)
end

-- True when this process now has the claim; false and the owner's words when another has it.
function claims:take(name)
  local path = path_of(self, name)
  for _ = 1, 2 do
    local made, why = sys.make_file(path, self.text)
    if made then
      self.own[name], self.seen[path] = path, nil
      return true
    elseif made == nil then
      error(("%s cannot be written: %s"):format(types.quote(path), why), 0)
    elseif not is_void(self, path) then
      break
    end
    os.remove(path)
  end
  local host, id = (first_line(path) or ""):match "^(%S+) .* (%d+) %S+$"
  return false, host and ("process %s on %s"):format(id, host) or "another process"
end

-- Removes a void claim to what is finished: its owner was ended before it gave it back.
function claims:clear(name)
  local path = path_of(self, name)
  if is_void(self, path) then
    os.remove(path)
  end
end

-- Signs of life for all that is claimed; call it often.
function claims:beat()
  local now = sys.now()
  if now < self.next_beat then
    return
  end
  self.next_beat = now + math.min(BEAT, EXPIRY / 4)
  for _, path in pairs(self.own) do -- in any order
    sys.touch(path)
  end
end

-- Gives a claim back, if it is still ours.
function claims:drop(name)
  local path = self.own[name]
  self.own[name] = nil
  if path and (first_line(path) or "") .. "\n" == self.text then
    os.remove(path)
  end
end

function claims:drop_all()
  local names = {}
  for name in pairs(self.own) do -- in any order
    names[#names + 1] = name
  end
  for _, name in ipairs(names) do
    self:drop(name)
  end
end

return claims
