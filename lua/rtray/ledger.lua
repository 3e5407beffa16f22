-- What is known of finished frames: a small file for each in a state folder. A record says what the frame described and what its file's bytes are,
-- so that a frame is taken up again only when both still hold. Records, as frames, are written aside and renamed: a kill leaves the old or the new.

local sys = require "rtray.sys"
local files = require "rtray.files"
local types = require "rtray.types"

local ledger = {}
ledger.__index = ledger

local HEAD = "librt frame 1"
local EVERY = 2 -- seconds between two syncs of folders: files are synced each; a name that a power cut loses is rendered again, not mistaken

-- A folder for output: made when it is missing.
function ledger.make_folder(path)
  local made, why = sys.make_folder(path)
  if made == nil then
    local kind = sys.stat(path)
    why = kind and kind ~= "folder" and "a file of this name is there" or why
    error(("the folder %s cannot be made: %s"):format(types.quote(path), why), 0)
  end
end

-- folder: of the records; tag: names this process among all that share the folder.
function ledger.open(folder, tag)
  ledger.make_folder(folder)
  local ok, why = sys.can_create(folder)
  if not ok then
    error(("the folder %s cannot be written into: %s"):format(types.quote(folder), why), 0)
  end
  return setmetatable({ folder = folder, tag = tag, unsynced = {}, next_sync = 0 }, ledger)
end

-- The place of a file that is being written for a frame (a number) or a film (a name).
function ledger:part(name)
  return ("%s/%s.%s.part"):format(self.folder, type(name) == "number" and ("%06d"):format(name) or name, self.tag)
end

-- The file for the state of a frame's unfinished render, which belongs to one key: those of other keys are removed.
function ledger:checkpoint(frame, key)
  if not self.checkpoints then
    self.checkpoints = {}
    for _, name in ipairs(sys.list_folder(self.folder) or {}) do
      local number = name:match "^(%d+)%.%x+%.checkpoint$"
      if number then
        local list = self.checkpoints[number] or {}
        list[#list + 1] = name
        self.checkpoints[number] = list
      end
    end
  end
  local number = ("%06d"):format(frame)
  local wanted = ("%s.%s.checkpoint"):format(number, key:sub(1, 16))
  for _, name in ipairs(self.checkpoints[number] or {}) do
    if name ~= wanted then
      os.remove(self.folder .. "/" .. name)
    end
  end
  self.checkpoints[number] = { wanted }
  return self.folder .. "/" .. wanted
end

-- The same beside `path`, which may lie on another disk than the records; what the dead have left there is removed.
function ledger.new_part(path, claims)
  local folder, name = files.folder_of(path), files.name_of(path) .. "."
  for _, entry in ipairs(sys.list_folder(folder) or {}) do
    local tag = entry:sub(1, #name) == name and entry:sub(#name + 1):match "^([^.]+)%.part$"
    if tag and not claims:alive(tag) then
      os.remove(folder .. "/" .. entry)
    end
  end
  return ("%s.%s.part"):format(path, claims.tag)
end

-- Removes what a process has left behind unfinished: alive(tag) tells of each.
function ledger:sweep(alive)
  for _, name in ipairs(sys.list_folder(self.folder) or {}) do
    local tag = name:match "^[^.]+%.([^.]+)%.part$"
    if tag and not alive(tag) then
      os.remove(self.folder .. "/" .. name)
    end
  end
end

local function path_of(self, name)
  return ("%s/%s"):format(self.folder, type(name) == "number" and ("%06d"):format(name) or name)
end

-- ---- records as text ----

local WORDS = { "key", "rest", "description", "image", "settings", "seconds" } -- in their order

-- { key, rest, description, file, bytes, image, settings, seconds, materials = { { hash, touched }, ... } } as lines.
local function encode(name, record)
  local lines = { HEAD, "frame " .. tostring(name) }
  for _, word in ipairs(WORDS) do
    if record[word] then
      lines[#lines + 1] = word .. " " .. tostring(record[word])
    end
  end
  lines[#lines + 1] = ("file %s %d"):format(record.file, record.bytes)
  for _, m in ipairs(record.materials or {}) do
    lines[#lines + 1] = ("material %s %d"):format(m.hash, m.touched and 1 or 0)
  end
  lines[#lines + 1] = "end\n"
  return table.concat(lines, "\n")
end

local KNOWN = {}
for _, word in ipairs(WORDS) do
  KNOWN[word] = true
end

-- The record of a text, or nil when it is none, of another frame, or cut.
local function decode(name, text)
  if text:sub(1, #HEAD + 1) ~= HEAD .. "\n" or text:sub(-5) ~= "\nend\n" then
    return nil
  end
  local record = {}
  for line in text:gmatch "([^\n]*)\n" do
    local word, rest = line:match "^(%l+) (.*)$"
    if KNOWN[word] then
      record[word] = rest
    elseif word == "frame" then
      record.name = rest
    elseif word == "file" then
      local hash, bytes = rest:match "^(%x+) (%d+)$"
      record.file, record.bytes = hash, math.tointeger(tonumber(bytes))
    elseif word == "material" then
      local hash, touched = rest:match "^(%x+) ([01])$"
      if not hash then
        return nil
      end
      record.materials = record.materials or {}
      record.materials[#record.materials + 1] = { hash = hash, touched = touched == "1" }
    end
  end
  return record.name == tostring(name) and record.key and record.file and record.bytes and record or nil
end

-- ---- reading, writing ----

-- The record of a frame (a number) or a film (a name); nil when there is none that holds.
function ledger:read(name)
  local path = path_of(self, name)
  local file = sys.stat(path) == "file" and io.open(path, "rb") or nil -- a pipe would wait for ever
  local text = file and file:read(1 << 20) or nil
  if file then
    file:close()
  end
  return text and decode(name, text) or nil
end

-- Brings the folders' names to disk, when it is time or by force.
function ledger:sync(force)
  if force or sys.now() >= self.next_sync then
    for _, folder in ipairs(self.unsynced) do
      sys.sync_folder(folder)
    end
    self.unsynced, self.next_sync = {}, sys.now() + EVERY
  end
end

local function touched(self, folder)
  if not self.unsynced[folder] then
    self.unsynced[folder] = true
    self.unsynced[#self.unsynced + 1] = folder
  end
  self:sync()
end

local function must(path, ok, why)
  if not ok then
    error(("%s cannot be written: %s"):format(types.quote(path), (tostring(why):gsub("^.*: ", ""))), 0)
  end
  return ok
end

function ledger:write(name, record)
  local path, part = path_of(self, name), self:part "record"
  local file = must(path, io.open(part, "wb"))
  local wrote, why = file:write(encode(name, record))
  local closed, closing = file:close()
  must(path, wrote and closed, why or closing)
  must(path, sys.put_in_place(part, path))
  touched(self, self.folder)
end

-- Is the file at `path` the one that the record is about? True, or nil and a word.
function ledger.check(record, path)
  local kind, size = sys.stat(path)
  if not kind then
    return nil, "is gone"
  elseif kind ~= "file" or size ~= record.bytes then
    return nil, kind == "file" and size < record.bytes and "was cut off" or "is not the file that was written"
  elseif sys.sha256_file(path) ~= record.file then
    return nil, "has changed or is damaged"
  end
  return true
end

-- Puts the finished file `part` in the place of `path` and records it; the record's file and bytes are filled in.
function ledger:put(name, record, part, path)
  local hash, bytes = sys.sha256_file(part)
  if not hash then
    error(("%s cannot be read back: %s"):format(types.quote(part), bytes), 0)
  end
  record.file, record.bytes = hash, bytes
  must(path, sys.put_in_place(part, path))
  touched(self, files.folder_of(path))
  self:write(name, record)
end

return ledger
