-- rtray animate SCENE: every frame of an animation, and a film of them. Finished frames are taken up by what they describe; several processes may
-- work on one folder.

local guard = require "rt.guard"
local sys = require "rtray.sys"
local faults = require "rtray.faults"
local files = require "rtray.files"
local film = require "rtray.film"
local frames = require "rtray.frames"
local json = require "rtray.json"
local ledger = require "rtray.ledger"
local limits = require "rtray.limits"
local options = require "rtray.options"
local output = require "rtray.output"
local progress = require "rtray.progress"
local report = require "rtray.report"
local source = require "rtray.source"
local types = require "rtray.types"
local work = require "rtray.work"

local animate = {}

local POLL = 0.25 -- seconds between two looks at what other processes do

-- ---- the film ----

-- What decides a film's bytes, as far as it is known here.
local function film_key(self, plan)
  local lines = { table.concat(plan.arguments, "\n") }
  for _, frame in ipairs(self.list) do
    local record = self.ledger:read(frame)
    lines[#lines + 1] = record and record.file or "?"
  end
  return sys.sha256(table.concat(lines, "\n"))
end

-- Name and value of the film's tags.
local function film_texts(self)
  local run = self.run
  local list = {
    { "title", film.text(self.animation.name or files.stem_of(run.path)) },
  }
  local about = json.object():set("software", "librt " .. require("rt").version):set("scene", files.name_of(run.path))
    :set("frames", #self.list):set("fps", self.animation.fps)
  if #run.params > 0 then
    about:set("parameters", report.parameter_values(run))
  end
  list[#list + 1] = { "comment", json.encode(about) }
  return list
end

local function size_of(self)
  local path = self.stage.target.place(self.list[1])
  guard.own(path)
  local image = require("rt").image(path)
  local width, height = image:size()
  image:release()
  return width, height
end

-- Makes the film unless it is up to date. Returns what became of it: "made", "kept", or nil when it was interrupted.
local function make_film(self)
  local target = self.stage.target
  local encoders, why = film.encoders()
  local plan
  if encoders then
    local width, height = size_of(self)
    plan, why = film.plan(target.film, encoders, {
      width = width, height = height, fps = self.animation.fps, once = self.animation.once, texts = film_texts(self),
    })
  end
  if not plan then
    error({ status = 3, message = ("%s; the film is not made, its %d frames are finished in %s and the same command goes on from there"):format(why,
      #self.list, types.quote(target.folder)) }, 0)
  end
  local name = files.ending_of(target.out) .. "-film"
  while not self.claims:take(name) do -- another process is at it
    if sys.interrupted() then
      return nil
    end
    sys.sleep(POLL)
  end
  local key = film_key(self, plan)
  local record = self.ledger:read(name)
  if record and record.key == key and ledger.check(record, target.out) then
    self.claims:drop(name)
    return "kept"
  end
  local paths = {}
  for i, frame in ipairs(self.list) do
    paths[i] = target.place(frame)
  end
  local part = self.ledger.new_part(target.out, self.claims)
  local shown = progress.new(self.values, ("%s: %s"):format(types.quote(target.out):sub(2, -2), plan.coder))
  local ok, done
  for _ = 1, 5 do
    ok, done = pcall(film.encode, plan, paths, part, function(i)
      shown:update((i - 1) / #paths)
      self.claims:beat()
      return sys.interrupted() ~= nil
    end)
    local now = film_key(self, plan)
    if not (ok and done) or now == key then
      break
    end
    key = now -- another process has changed a frame meanwhile
  end
  output.clear_line()
  if ok and done then
    ok, done = pcall(self.ledger.put, self.ledger, name, { key = key }, part, target.out)
  end
  self.claims:drop(name)
  if not ok then
    os.remove(part)
    local fault = faults.of(done)
    fault.message = ("%s; the film %s is not made, its frames are in %s"):format(fault.message, types.quote(target.out), types.quote(target.folder))
    error(fault, 0)
  end
  return done ~= false and "made" or nil
end

-- ---- telling ----

local function plural(n, word)
  return ("%s %s%s"):format(output.count(n), word, n == 1 and "" or "s")
end

-- "12 rendered, 36 taken over"
local function counts(self)
  local parts = { ("%d rendered"):format(self.rendered) }
  if self.taken > 0 then
    parts[#parts + 1] = ("%d taken over"):format(self.taken)
  end
  if self.others > 0 then
    parts[#parts + 1] = ("%d by other processes"):format(self.others)
  end
  if #self.failures > 0 then
    parts[#parts + 1] = ("%d failed"):format(#self.failures)
  end
  return table.concat(parts, ", ")
end

local function go_on(self, begun)
  local finished = self.rendered + self.taken + self.others
  return ("%d of %s %s finished in %s%s; the same command goes on from there"):format(finished, plural(#self.list, "frame"),
    finished == 1 and "is" or "are", types.quote(self.stage.target.folder), begun and ", " .. begun or "")
end

local function frames_json(self)
  local list = {}
  for i, frame in ipairs(self.list) do
    local record = self.results[frame]
    list[i] = json.object():set("frame", frame):set("state", work.words(self.state[frame]))
      :set("file", self.stage.target.place(frame)):set("hash", record and record.image):set("seconds", record and tonumber(record.seconds))
      :set("work", record and record.work and report.work_json(record.work)):set("tiles_resumed", record and record.resumed)
  end
  return list
end

local function tell(self, film_state)
  local target, values = self.stage.target, self.values
  local seconds = sys.now() - self.begun
  if values.stats then
    local note = values.json and output.note or output.print
    note("frames   %s", counts(self))
    note("render   %s", output.seconds(self.seconds))
    note("trees    %s", output.seconds(self.build_seconds))
    note("rays     %s", output.count(self.rays))
    report.print_work(note, report.work())
  end
  if values.json then
    output.print("%s", json.encode(json.object():set("output", target.out):set("film", film_state):set("folder", target.folder)
      :set("fps", self.animation.fps):set("count", #self.list):set("rendered", self.rendered):set("taken_over", self.taken)
      :set("by_others", self.others):set("failed", #self.failures):set("seconds", seconds):set("rays", self.rays)
      :set("frames", frames_json(self))))
  elseif not values.quiet then
    local film_words = film_state and ("; the film is %s"):format(film_state == "kept" and "up to date" or "made") or ""
    output.note("%s: %s (%s), %s, %s%s", types.quote(target.out):sub(2, -2), plural(#self.list, "frame"),
      ("%g s at %g a second"):format(#self.list / self.animation.fps, self.animation.fps), counts(self), output.seconds(seconds), film_words)
  end
end

-- ---- the command ----

local function stage_of(command, values, path)
  local save = {}
  for _, option in ipairs(options.list) do
    if option.save and option.key ~= "format" then
      save[option.key] = values[option.key]
    end
  end
  save.bits = save.bits and math.tointeger(tonumber(save.bits))
  local target = frames.target(command, values.output or files.stem_of(path) .. ".mp4", values.format)
  return { path = path, values = values, command = command, target = target, save = save }
end

local function run(self)
  local target = self.stage.target
  if target.film and not self.values.quiet then
    local encoders, why = film.encoders()
    if not encoders then
      output.note("rtray animate: %s; the frames are rendered into %s, the film is not made", why, types.quote(target.folder))
    end
  end
  local whole = self:all()
  output.clear_line()
  if not whole then
    local begun = self:halt()
    output.note("rtray animate: %s: %s", limits.told() or "interrupted", go_on(self, begun))
    return 1 -- the signal ends the process, see main.c
  elseif self.stopped then
    local fault = self.stopped
    fault.message = ("%s\nrtray animate: %s"):format(fault.message, go_on(self))
    error(fault, 0)
  elseif #self.failures > 0 then
    tell(self, nil)
    output.note("rtray animate: %s failed, the first of them frame %d%s", plural(#self.failures, "frame"), self.failures[1].frame,
      target.film and "; the film is not made" or "")
    return 1
  end
  local film_state = target.film and make_film(self)
  if target.film and not film_state then
    output.note("rtray animate: interrupted while the film was made: %s", go_on(self))
    return 1
  end
  tell(self, film_state)
  return 0
end

function animate.run(command, values, arguments)
  local stage = stage_of(command, values, arguments[1])
  local folder = stage.target.folder
  if stage.target.film or not sys.stat(folder) then
    files.check_output(stage.target.film and stage.target.out or folder)
  else
    files.check_output(stage.target.place(0), stage.target.out)
  end
  local before = work.stamp(stage.path)
  local animation, first_run = source.animation(stage.path, values, command)
  local list = frames.expand(command, values.frames, animation.frames)
  local self <close> = work.new(stage, list, animation)
  self.run = first_run
  self.stamps = { stage.path, [stage.path] = before }
  local ok, status = xpcall(run, faults.of, self)
  output.clear_line()
  if not ok then
    if sys.interrupted() then
      sys.defer(true)
      local begun = self:halt()
      output.note("rtray animate: %s: %s", limits.told() or "interrupted", go_on(self, begun))
      return 1
    end
    error(status, 0)
  end
  return status
end

return animate
