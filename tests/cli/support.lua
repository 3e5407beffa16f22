-- What the tests of the program share: running it with exact arguments, files of their own, reading what it wrote.
-- RTRAY is the program, RTRAY_SOURCE the source tree, RTRAY_TMP a folder to make others in.

local support = {}

local program = assert(os.getenv "RTRAY", "RTRAY must name the program")
support.program = program
support.source = assert(os.getenv "RTRAY_SOURCE", "RTRAY_SOURCE must name the source tree")
local root = assert(os.getenv "RTRAY_TMP", "RTRAY_TMP must name a folder to write into") .. "/rtray-spec"

-- A word of the shell with exactly these bytes.
function support.quote(text)
  assert(not text:find "\0")
  return "'" .. text:gsub("'", "'\\''") .. "'"
end
local quote = support.quote

function support.read(path)
  local file = assert(io.open(path, "rb"))
  local text = file:read "a"
  file:close()
  return text
end

function support.write(path, text)
  local file = assert(io.open(path, "wb"))
  assert(file:write(text))
  assert(file:close())
  return path
end

function support.exists(path)
  local file = io.open(path, "rb")
  if file then
    file:close()
  end
  return file ~= nil
end

-- What the last run left, for whoever wants to look at a failure.
assert(os.execute("rm -rf " .. quote(root)))
local made = 0

-- A new empty folder.
function support.folder()
  made = made + 1
  local path = ("%s/%d"):format(root, made)
  assert(os.execute("mkdir -p " .. quote(path)))
  return path
end

local here = support.folder()

-- Runs a shell command line; gives { status, out, err }, the status 128 + n after signal n.
function support.shell(line, cwd)
  local out, err = here .. "/out", here .. "/err"
  local _, how, code = os.execute(("cd %s && { %s; } >%s 2>%s </dev/null"):format(quote(cwd or here), line, quote(out), quote(err)))
  return { status = how == "signal" and 128 + code or code, out = support.read(out), err = support.read(err) }
end

function support.command(args)
  local parts = { quote(program) }
  for _, arg in ipairs(args) do
    parts[#parts + 1] = quote(arg)
  end
  return table.concat(parts, " ")
end

-- Runs the program: rtray { "render", path, cwd = folder, env = "NAME=value ", tail = "> /dev/full" }
function support.rtray(args)
  return support.shell((args.env or "") .. support.command(args) .. " " .. (args.tail or ""), args.cwd)
end

-- The program in the background, its number and its end told by files; `looks` counts what takes too long on any machine.
local WATCH = [[
{ env -C %s --default-signal=INT,TERM %s >out 2>err & echo $! >pid; wait $!; echo $? >ended.part; mv ended.part ended; } &
met=1 looks=0
until [ -s pid ]; do sleep 0.005; done
until (cd %s && %s) >told 2>&1; do
  [ -e ended ] && { met=0; break; }
  [ $((looks += 1)) -gt 12000 ] && { echo "what was waited for does not come" >&2; break; }
  sleep 0.005
done
[ -e ended ] || kill -%s $(cat pid)
until [ -e ended ]; do
  [ $((looks += 1)) -gt 24000 ] && { echo "it does not end" >&2; kill -KILL $(cat pid); }
  sleep 0.005
  %s
done
wait
echo $met $(cat ended)]]

-- Runs the program in `folder` until the shell's condition `event` holds there ($LOG is its standard error so far), then sends it the signal: what is
-- seen decides, not the clock. r.met: it had not ended by itself before. more: a shell command given again and again from then on ($PID is it).
function support.ended(args, signal, event, folder, more)
  local place = support.folder()
  local head = ("LOG=%s; "):format(quote(place .. "/err"))
  local r = support.shell(head .. WATCH:format(quote(folder), support.command(args), quote(folder), event, signal, more or ":"), place)
  local met, status = r.out:match "(%d) (%d+)%s*$"
  r.met, r.status = met == "1", tonumber(status)
  r.err, r.out = r.err .. support.read(place .. "/err"), support.read(place .. "/out")
  return r
end

-- Runs `try(samples)` with more and more samples until it returns something: a render that a signal is to meet must last until it has come, which
-- takes other work on another machine.
function support.long_enough(try)
  local samples = 512 -- doubled: a render that lasts four times as long as need be is done to its end, twice
  while samples <= 65536 do
    local result = try(samples)
    if result then
      return result
    end
    samples = samples * 2
  end
  error "no number of samples is long enough"
end

-- A scene that renders in milliseconds.
support.SMALL = [[
local rt = require "rt"
local p = rt.params { radius = { 1, min = 0.1, max = 2, help = "radius of the ball" }, sets = { large = { radius = 2 } } }
return rt.scene {
  settings = { width = 40, height = 30, samples = 2 },
  camera = rt.camera { eye = {0, 1, 5}, look_at = {0, 0, 0}, fov = 45 },
  ambient = {0.2, 0.2, 0.2},
  rt.point_light { at = {5, 5, 5} },
  rt.sphere { center = {0, 0, 0}, radius = p.radius, material = rt.classic { color = {0.9, 0.3, 0.2} } },
  rt.plane { point = {0, -1, 0}, normal = {0, 1, 0} },
}
]]

function support.small(folder, name)
  return support.write((folder or support.folder()) .. "/" .. (name or "small.lua"), support.SMALL)
end

return support
