-- The folder of a sweep: one process at a time works on it, and a journal holds each finished run, so that a kill at any moment loses the run it
-- hit and nothing else. Every other file in it can be made from the journal again.

local core = require "rt.core"
local facts = require "rt.facts"
local json = require "rt.json"
local words = require "rt.words"

local sweep_folder = {}
local methods = {}
methods.__index = methods

local FORMAT = 1
local OURS = { "results.csv", "results.json", "runs.csv", "machine.json", "plan.json", "images", "maps", "reference", "index.html", "contact.png",
  "plots" }
local IS_OURS = {}
for _, name in ipairs(OURS) do
  IS_OURS[name] = true
end

local function quote(path)
  return "'" .. words.quote(path, 4096) .. "'"
end

local function fault(message, ...)
  error({ status = 1, message = message:format(...) }, 0)
end

-- ---- making and locking ----

local function make(path)
  local made, why, number = core.make_folder(path)
  local parent = path:match "^(.*[^/])/+[^/]+/*$"
  if made == nil and number == 2 and parent then -- a folder above is missing
    make(parent)
    made, why = core.make_folder(path)
  end
  if made == nil then
    fault("the folder %s cannot be made: %s", quote(path), why)
  end
end

-- The lock at `path`; waits for it when told to, after a word.
local function take_lock(path, wait, note, words_of)
  local lock, why = core.lock_file(path)
  if lock == false and wait then
    note(words_of .. "; waiting for it")
    repeat
      core.sleep(0.05)
      lock, why = core.lock_file(path)
    until lock ~= false
  end
  return lock, why
end

local MACHINE_LOCK = os.getenv "LIBRT_MEASURE_LOCK" or "/tmp/librt-measure.lock"

-- While this lock is held, no other measurement of this machine runs. Where it cannot be had (another user's folder rules) nothing is locked.
-- Who waits holds a shared lock of a second file, and who has just measured lets them go first.
function sweep_folder.machine_lock(note)
  local queue = MACHINE_LOCK .. ".queue"
  local nobody = core.lock_file(queue)
  if nobody then
    nobody:release()
  elseif nobody == false then
    core.sleep(0.12)
  end
  local lock = core.lock_file(MACHINE_LOCK)
  if lock == false then
    local waiting = core.lock_file(queue, true)
    lock = take_lock(MACHINE_LOCK, true, note, "another measurement runs on this machine")
    if waiting then
      waiting:release()
    end
  end
  return lock or nil
end

-- ---- the journal ----

local function read_file(path)
  local kind = core.file_stat(path)
  if kind and kind ~= "file" then -- a pipe would wait for ever, a device never end
    fault("%s is no regular file; remove it", quote(path))
  end
  local file = kind and io.open(path, "rb")
  local text = file and file:read "a"
  if file then
    file:close()
  end
  return text
end

local takers = {}

function takers.sweep(self, t)
  self.header = t
end

-- Facts that are counts or texts; a journal that another has written may hold anything.
local function is_machine(t)
  for _, key in ipairs { "logical_cpus", "cores", "memory_bytes", "memory_available_bytes" } do
    if t[key] ~= nil and not math.type(t[key]) then
      return false
    end
  end
  for _, key in ipairs { "cpu", "isa", "host", "version", "build" } do
    if t[key] ~= nil and type(t[key]) ~= "string" then
      return false
    end
  end
  return type(t.fingerprint) == "string" and math.type(t.cpus) == "integer"
end

function takers.machine(self, t)
  if is_machine(t) and not self.machines[t.fingerprint] then
    self.machines[t.fingerprint] = t
    self.machine_list[#self.machine_list + 1] = t
  end
end

function takers.run(self, t)
  if type(t.key) == "string" and math.type(t.run) == "integer" and type(t.machine) == "string" then
    self.runs[t.key] = self.runs[t.key] or {}
    self.runs[t.key][t.run] = self.full and t or { hash = t.hash, machine = t.machine }
  end
end

function takers.image(self, t)
  self.images[t.key or ""] = t
end

function takers.failed(self, t)
  self.failures[t.key or ""] = t.message
end

function takers.metrics(self, t)
  self.metrics[t.key or ""] = t
end

-- Reads whole lines as far as they can be read; gives the bytes they take.
local function replay(self, text, note)
  local at = 1
  while true do
    local stop = text:find("\n", at, true)
    if not stop then
      return at - 1
    end
    local t = json.decode(text:sub(at, stop - 1))
    local take = type(t) == "table" and takers[t.t]
    if not take then
      note(("%s: byte %d is no line of a sweep's journal; what stands there and behind is measured again"):format(
        quote(self.path "journal.jsonl"), at))
      return at - 1
    end
    take(self, t)
    at = stop + 1
  end
end

local function forget(self)
  for _, list in ipairs { self.images, self.metrics } do
    for _, record in next, list do -- in any order
      local name = record.file or record.map
      local folder, file = tostring(name):match "^(%l+)/([^/]+)$" -- a journal may come from anybody
      if (folder == "images" or folder == "maps") and file ~= "." and file ~= ".." then
        os.remove(self.path(name))
      end
    end
  end
  for _, name in ipairs(core.list_folder(self.path "reference") or {}) do
    os.remove(self.path("reference/" .. name))
  end
  self.runs, self.images, self.metrics, self.failures, self.machines, self.machine_list, self.header = {}, {}, {}, {}, {}, {}, nil
end

-- Removes what a process that was killed had half written: tables (methods.replace) and images (rt_image_save). Only who holds the lock may.
local function remove_unfinished(self)
  for _, folder in ipairs { "", "images/", "maps/", "reference/" } do
    for _, name in ipairs(core.list_folder(self.path(folder)) or {}) do
      local table_name = folder == "" and name:match "^(.+)%.%d+%.part$"
      if name:find "^%.rtray%-%d+%-%d+%.part$" or table_name and IS_OURS[table_name] then
        os.remove(self.path(folder .. name))
      end
    end
  end
end

local function refuse_strangers(self, scene)
  local h = self.header
  if not h then
    return
  elseif h.format ~= FORMAT then
    fault("%s was written by another version of librt (format %s); choose another folder, or --restart drops what is in it", quote(self.folder),
      tostring(h.format))
  elseif h.scene ~= words.quote(scene, 4096) then
    fault("%s holds a sweep of %s; choose another folder, or --restart drops what is in it", quote(self.folder), quote(tostring(h.scene)))
  end
end

-- Rows that this machine and this librt have not made.
local function refuse_mixing(self)
  local count, by_machine, other = 0, {}, nil
  for _, runs in next, self.runs do
    for _, r in next, runs do
      if r.machine ~= self.machine.fingerprint then
        count, by_machine[r.machine] = count + 1, true
      end
    end
  end
  for _, m in ipairs(self.machine_list) do
    other = other or by_machine[m.fingerprint] and m or nil
  end
  if count > 0 then
    fault("%s holds %d run%s of another machine or version (%s), and this is %s; --restart drops them, --force keeps them, marked",
      quote(self.folder), count, count == 1 and "" or "s", other and facts.words(other) or "unknown", facts.words(self.machine))
  end
end

-- Whether the folder has files with our names that no journal speaks of.
local function refuse_foreign(self)
  local function refuse(name)
    fault("%s holds %s, but no journal of a sweep; choose another folder", quote(self.folder), name)
  end
  for _, name in ipairs(OURS) do
    if core.file_stat(self.path(name)) then
      refuse(name)
    end
  end
  for _, name in ipairs(core.list_folder(self.path "") or {}) do
    if name:find "^contact%-%d+%.png$" then
      refuse(name)
    end
  end
end

-- Opens (and makes) a folder for a sweep of `scene`. o: restart, force, wait, note(text).
function sweep_folder.open(folder, scene, o)
  folder = folder:gsub("(.)/+$", "%1")
  local self = setmetatable({
    folder = folder, runs = {}, images = {}, metrics = {}, failures = {}, machines = {}, machine_list = {}, machine = facts.machine(),
    path = function(name) return folder .. "/" .. name end,
  }, methods)
  make(folder)
  local ok, why = core.can_create(folder)
  if not ok then
    fault("the folder %s cannot be written: %s", quote(folder), why)
  end
  self.lock, why = take_lock(self.path ".lock", o.wait, o.note, "another process works on " .. quote(folder))
  if self.lock == nil then
    fault("the folder %s cannot be locked: %s", quote(folder), why)
  elseif not self.lock then
    fault("another process works on %s; --wait waits until it has ended", quote(folder))
  end
  local text = read_file(self.path "journal.jsonl")
  if not text then
    refuse_foreign(self)
  end
  local size = replay(self, text or "", o.note)
  if o.restart then
    forget(self)
    size = 0
  end
  refuse_strangers(self, scene)
  if not o.force then
    refuse_mixing(self)
  end
  remove_unfinished(self)
  self.journal, why = core.journal_open(self.path "journal.jsonl", size)
  if not self.journal then
    fault("the journal in %s cannot be written: %s", quote(folder), why)
  end
  self.synced = core.clock()
  if not self.header then
    self.header = { format = FORMAT }
    self:add(json.object():set("t", "sweep"):set("format", FORMAT):set("scene", words.quote(scene, 4096)):set("version", self.machine.version))
  end
  if not self.machines[self.machine.fingerprint] then
    self:add(sweep_folder.machine_json(self.machine, json.object():set("t", "machine")))
    takers.machine(self, self.machine)
  end
  return self
end

-- A line more. Each is with the system when this returns, which a kill of the program cannot undo; on disk within a second.
function methods.add(self, o)
  local now = core.clock()
  local sync = now - self.synced > 1
  local ok, why, number = self.journal:add(json.encode(o) .. "\n", sync)
  if not ok then
    error({ status = 3, message = ("the journal in %s cannot be written: %s (errno %d)"):format(quote(self.folder), why, number) }, 0)
  end
  self.synced = sync and now or self.synced
end

-- The whole records of all runs: while points are measured only hashes and machines are held, so that many of them take little memory.
function methods.all_records(self)
  local all = { runs = {}, images = {}, metrics = {}, failures = {}, machines = {}, machine_list = {}, full = true, path = self.path }
  replay(all, read_file(self.path "journal.jsonl") or "", function() end)
  return all
end

-- The records of a folder for who only looks, and may replace tables.
function sweep_folder.look(folder)
  local self = setmetatable({ folder = folder, path = function(name) return folder .. "/" .. name end }, methods)
  local all = self:all_records()
  self.machines, self.machine_list = all.machines, all.machine_list
  return self
end

-- Replaces a file by text when all of it is on disk.
function methods.replace(self, name, text)
  local part = self.path(("%s.%d.part"):format(name, core.process_id()))
  local file, why = io.open(part, "wb")
  local ok = file
  if file then
    ok, why = file:write(text)
    local closed, why_not = file:close()
    if ok then
      ok, why = closed, why_not
    end
  end
  if ok then
    ok, why = core.put_in_place(part, self.path(name))
  end
  if not ok then
    os.remove(part)
    error({ status = 3, message = ("%s cannot be written: %s"):format(quote(self.path(name)), tostring(why)) }, 0)
  end
end

function methods.sub_folder(self, name)
  make(self.path(name))
end

function methods.release(self)
  if self.journal then
    self.journal:add ""
    self.journal:release()
  end
  if self.lock then
    self.lock:release()
  end
end
methods.__close = methods.release

-- ---- facts as JSON ----

function sweep_folder.machine_json(f, o)
  o = o or json.object()
  for _, key in ipairs(facts.keys) do
    local value = f[key]
    if key == "caches" then
      value = {}
      for i, c in ipairs(f.caches or {}) do
        value[i] = json.object():set("level", c.level):set("type", c.type):set("bytes", c.bytes):set("line_bytes", c.line_bytes)
          :set("shared_by", c.shared_by)
      end
    end
    o:set(key, value)
  end
  return o
end

return sweep_folder
