-- The frames of an animation, rendered one after the other or several at once: what is finished is taken up, what others render is waited for, a
-- fault is a frame's own.

local sys = require "rtray.sys"
local claims = require "rtray.claims"
local faults = require "rtray.faults"
local inputs = require "rtray.inputs"
local json = require "rtray.json"
local ledger = require "rtray.ledger"
local limits = require "rtray.limits"
local output = require "rtray.output"
local progress = require "rtray.progress"
local shot = require "rtray.shot"
local types = require "rtray.types"

local SHORT = 2      -- seconds: frames that take less are rendered several at once, each by one thread
local WAIT = 0.05    -- seconds between two looks at the jobs
local POLL = 0.25    -- seconds between two looks at what other processes do

local work = {}
work.__index = work

-- stage: see shot.lua; list: the frames.
function work.new(stage, list, animation)
  ledger.make_folder(stage.target.folder)
  local claim = claims.new(stage.target.state)
  local book = ledger.open(stage.target.state, claim.tag)
  book:sweep(function(tag)
    return claim:alive(tag)
  end)
  local self = setmetatable({
    stage = stage, values = stage.values, animation = animation, claims = claim, ledger = book, list = list,
    todo = {}, next = 1, flying = {}, waiting = {},                 -- frames: to come, being rendered, of other processes
    state = {}, results = {}, failures = {}, stamps = {},           -- by frame; faults in their order; files
    rendered = 0, taken = 0, others = 0, begun = sys.now(), rays = 0, seconds = 0, build_seconds = 0,
    shown = progress.new(stage.values, stage.target.out), at_once = stage.values.at_once or 0,
  }, work)
  self.workers = (stage.values.workers or 0) > 0 and stage.values.workers or require("rt").machine().workers
  return self
end

-- Ends what runs; finished frames stay.
function work:close()
  for _, f in ipairs(self.flying) do
    if f.job then
      f.job:release()
    end
  end
  self.flying = {}
  self.claims:drop_all()
  self.ledger:sync(true)
end
work.__close = work.close

-- Ends what runs after a signal. What is done of it is kept in its checkpoint: a sentence about that, or nil.
function work:halt()
  limits.grace(30)
  local words = {}
  for _, f in ipairs(self.flying) do
    f.job:cancel()
  end
  for _, f in ipairs(self.flying) do
    local ok, _, done = pcall(f.job.wait, f.job)
    if ok and sys.stat(f.checkpoint) then
      words[#words + 1] = ("frame %d is done to %d%%"):format(f.frame, math.floor(done * 100))
    end
  end
  return words[1] and table.concat(words, ", ") or nil
end

-- What became of a frame, in words.
function work.words(state)
  return state == "other" and "rendered by another process" or state == "taken" and "taken over" or state
end

local function event(self, frame, what, hash, seconds)
  if self.values.progress == "json" and not self.values.quiet then
    output.note("%s", json.encode(json.object():set("event", "frame"):set("frame", frame):set("state", work.words(what))
      :set("file", self.stage.target.place(frame)):set("hash", hash):set("seconds", seconds)))
  end
end

local function settle(self, frame, what, record)
  self.state[frame], self.results[frame] = what, record
  local counter = what == "rendered" and "rendered" or what == "other" and "others" or "taken"
  self[counter] = self[counter] + 1
  event(self, frame, what, record.image, tonumber(record.seconds))
end

-- Progress over what is left to render: frames taken over cost nothing.
local function show(self, flight_done)
  local free = self.taken + self.others
  local total = math.max(#self.list - free, 1)
  local finished = self.rendered + free
  self.shown.name = ("%s %d/%d"):format(types.quote(self.stage.target.out):sub(2, -2), finished, #self.list)
  self.shown:update(math.min((self.rendered + flight_done) / total, 1), self.rays)
end

-- The frame from the ledger, when its record matches and its file is whole. Says why not when there was one.
local function take_up(self, described, what, silent)
  local frame = described.frame
  local record = self.ledger:read(frame)
  local how = record and shot.matches(described, record)
  if not how then
    return false
  end
  local path = self.stage.target.place(frame)
  local whole, why = ledger.check(record, path)
  if not whole then
    if not silent then
      output.note("rtray animate: frame %d: %s %s; it is rendered again", frame, types.quote(path), why)
    end
    return false
  end
  if how ~= "key" then
    shot.renew(record, described)
    self.ledger:write(frame, record)
  end
  settle(self, frame, what, record)
  return true
end

local function fail(self, frame, raised)
  local fault = faults.of(raised)
  if sys.interrupted() then
    error(raised, 0)
  end
  if not fault.message:find("frame " .. frame, 1, true) then
    fault.message = ("frame %d: %s"):format(frame, fault.message)
  end
  self.claims:drop(frame)
  self.state[frame] = "failed"
  self.failures[#self.failures + 1] = { frame = frame, fault = fault }
  event(self, frame, "failed")
  if fault.status == 1 and self.values.keep_going then
    output.note("rtray animate: %s", fault.message)
  else
    self.stopped = fault
  end
end

function work.stamp(path)
  local kind, size, changed, inode = sys.stat(path)
  return kind and ("%d %d %d"):format(size, changed, inode) or "none"
end

-- Remembers the state of the files that a script and its frames come from.
local function note_files(self, run)
  for _, path in ipairs { run.path, table.unpack(run.files) } do
    if not self.stamps[path] then
      self.stamps[path] = work.stamp(path)
      self.stamps[#self.stamps + 1] = path
    end
  end
end

-- Is one of them another by now? Then frames of one run may be of two scripts.
local function files_changed(self)
  for _, path in ipairs(self.stamps) do
    if work.stamp(path) ~= self.stamps[path] then
      return true
    end
  end
  return false
end

-- Describes a frame and takes it up or starts its render.
local function prepare(self, frame)
  sys.defer(false) -- a script that runs for ever is ended by a signal
  local described = shot.describe(self.stage, frame)
  sys.defer(true)
  self.run = described.opened.run
  note_files(self, self.run)
  if take_up(self, described, self.state[frame] == "waiting" and "other" or "taken") then
    self.claims:clear(frame)
    described.scene:release()
    return
  end
  local target = self.stage.target
  inputs.check(target.place(frame))
  if target.film then
    inputs.check(target.out)
  end
  local mine, owner = self.claims:take(frame)
  if not mine then
    described.scene:release()
    self.state[frame], self.waiting[#self.waiting + 1], self.owner = "waiting", frame, owner
    return
  end
  if take_up(self, described, "other", true) then -- finished since the first look
    self.claims:drop(frame)
    described.scene:release()
    return
  end
  local together = math.max(1, math.min(self.limit, #self.list - self.rendered - self.taken - self.others))
  shot.start(self.stage, self.ledger, described, self.limit > 1 and math.max(1, self.workers // together) or nil)
  self.flying[#self.flying + 1] = described
  if self.last and not self.last.job then
    self.last.scene:release() -- not earlier: what both scenes have in common is not built again
  end
  self.last = described
end

local function finish(self, described)
  local stats = shot.finish(self.stage, self.ledger, described)
  if self.values.stats then
    local note = self.values.json and output.note or output.print
    local w = described.work
    note("frame %-6d %d trees built, %d of the top level, %d taken over, %d refitted; %d files read; %s", described.frame, w.trees_built,
      w.top_trees_built, w.trees_kept, w.trees_refitted, w.files_read, output.seconds(stats.seconds))
  end
  self.claims:drop(described.frame)
  if self.last ~= described then
    described.scene:release()
  end
  self.rays, self.seconds = self.rays + stats.rays, self.seconds + stats.seconds
  self.build_seconds = self.build_seconds + stats.build_seconds
  self.width, self.height = described.width, described.height
  if self.at_once == 0 and stats.seconds > 0 and not self.measured then
    self.measured = true
    local memory = described.scene:memory() * self.workers
    self.limit = stats.seconds < SHORT and memory < require("rt").machine().memory_available // 4 and self.workers or 1
  end
  settle(self, described.frame, "rendered", {
    image = described.image, seconds = ("%.3f"):format(stats.seconds), work = described.work, resumed = stats.tiles_resumed,
  })
end

-- Looks at the jobs; finishes those that are done.
local function attend(self)
  local partial, still = 0, {}
  for i, f in ipairs(self.flying) do
    local state, done = f.job:wait(i == 1 and WAIT or 0)
    if state == "running" then
      partial, still[#still + 1] = partial + done, f
    elseif state == "done" then
      local ok, raised = xpcall(finish, faults.of, self, f)
      if not ok then
        fail(self, f.frame, raised)
      end
    else
      self.claims:drop(f.frame)
    end
  end
  self.flying = still
  self.claims:beat()
  show(self, partial)
end

-- Starts frames while there is room. Errors of a frame are that frame's.
local function launch(self)
  while #self.flying < self.limit and self.next <= #self.todo and not self.stopped and not sys.interrupted() do
    local frame = self.todo[self.next]
    self.next = self.next + 1
    local ok, raised = xpcall(prepare, faults.of, self, frame)
    sys.defer(true)
    if not ok then
      fail(self, frame, raised)
    end
    self.claims:beat()
    show(self, 0)
  end
end

-- All frames once. False when it was interrupted.
local function pass(self)
  self.todo, self.next = self.list, 1
  self.limit = self.at_once > 0 and self.at_once or self.limit or 1
  repeat
    launch(self)
    attend(self)
    if sys.interrupted() then
      return false
    elseif #self.flying == 0 and self.next > #self.todo and #self.waiting > 0 and not self.stopped then
      if not self.told and not self.values.quiet then
        output.note("rtray animate: waiting for %d frame%s that %s renders", #self.waiting, #self.waiting == 1 and "" or "s", self.owner)
        self.told = true
      end
      sys.sleep(POLL)
      self.todo, self.next, self.waiting = self.waiting, 1, {}
    end
  until #self.flying == 0 and (self.stopped or self.next > #self.todo and #self.waiting == 0)
  return true
end

-- All frames; again when the script changed meanwhile. False when it was interrupted; self.stopped is the fault that ended it.
function work:all()
  while true do
    if not pass(self) then
      return false
    elseif self.stopped or not files_changed(self) then
      return true
    end
    output.note("rtray animate: the script or a file it names has changed meanwhile; every frame is looked at again")
    self.stamps, self.rendered, self.taken, self.others, self.failures = {}, 0, 0, 0, {}
  end
end

return work
