-- The machine a measurement was made on: what it is, what librt is, what else runs. Unknown facts are left out.

local core = require "rt.core"

local facts = {}

local function read(path)
  local file = io.open(path, "rb")
  local text = file and file:read "a"
  if file then
    file:close()
  end
  return text
end

-- One line of a file, without spaces around it.
local function word(path)
  local text = read(path)
  text = text and text:match "^%s*(.-)%s*$"
  return text ~= "" and text or nil
end

local UNITS = { K = 1024, M = 1024 ^ 2, G = 1024 ^ 3 }

local function bytes_of(text)
  local digits, unit = text:match "^(%d+)([KMG]?)$"
  return digits and math.tointeger(tonumber(digits) * (UNITS[unit] or 1))
end

-- Caches that the first CPU sees: { level, type, bytes, line_bytes, shared_by }.
local function caches()
  local list = {}
  for i = 0, 9 do
    local folder = ("/sys/devices/system/cpu/cpu0/cache/index%d/"):format(i)
    local size = word(folder .. "size")
    if not size then
      break
    end
    list[#list + 1] = {
      level = tonumber(word(folder .. "level")), type = word(folder .. "type"), bytes = bytes_of(size),
      line_bytes = tonumber(word(folder .. "coherency_line_size")), shared_by = word(folder .. "shared_cpu_list"),
    }
  end
  return list
end

-- Name of the CPU, logical CPUs of the machine, cores (pairs of package and core).
local function cpu()
  local text = read "/proc/cpuinfo" or ""
  local name = text:match "model name%s*:%s*([^\n]*)" or text:match "Hardware%s*:%s*([^\n]*)" or text:match "cpu model%s*:%s*([^\n]*)"
  local logical, cores, seen = 0, 0, {}
  for block in (text .. "\n\n"):gmatch "(.-)\n\n" do
    if block:find "processor%s*:" then
      logical = logical + 1
      local package, id = block:match "physical id%s*:%s*(%d+)", block:match "core id%s*:%s*(%d+)"
      local key = (package or "0") .. "/" .. (id or logical)
      if not seen[key] then
        seen[key], cores = true, cores + 1
      end
    end
  end
  return name, logical > 0 and logical or nil, cores > 0 and cores or nil
end

local function total_memory()
  local kilobytes = (read "/proc/meminfo" or ""):match "MemTotal:%s*(%d+)"
  return kilobytes and math.tointeger(tonumber(kilobytes)) * 1024
end

-- What makes times comparable: equal machines have equal fingerprints, whatever they are called.
local function fingerprint(f)
  return core.text_hash(table.concat({ f.cpu or "", f.logical_cpus or 0, f.cpus, f.isa, f.version, f.build }, "\0"))
end

-- Keys in the order in which they are written.
facts.keys = {
  "fingerprint", "cpu", "logical_cpus", "cores", "cpus", "isa", "caches", "memory_bytes", "memory_available_bytes", "host", "system", "kernel",
  "governor", "boost", "load", "version", "build", "compiler", "flags", "lua", "time",
}

-- { cpu, logical_cpus, cores, cpus (that this process may use), caches, memory_bytes, kernel, governor, load, version, build, compiler, flags, time }
function facts.machine()
  local version, build = core.version()
  local cpus, available, isa = core.machine()
  local details = core.build_details()
  local f = {
    cpus = cpus, isa = details.isa .. ", " .. isa, caches = caches(), memory_bytes = total_memory(), memory_available_bytes = available,
    host = word "/proc/sys/kernel/hostname", system = word "/proc/sys/kernel/ostype", kernel = word "/proc/sys/kernel/osrelease",
    governor = word "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", boost = word "/sys/devices/system/cpu/cpufreq/boost",
    version = version, build = build, compiler = details.compiler, flags = details.flags, lua = _VERSION, time = os.date "!%Y-%m-%dT%H:%M:%SZ",
  }
  f.cpu, f.logical_cpus, f.cores = cpu()
  local load = (read "/proc/loadavg" or ""):match "^(%S+)"
  f.load = load and tonumber(load)
  f.fingerprint = fingerprint(f)
  return f
end

-- One line that tells machines apart.
function facts.words(f)
  return ("%s, %d CPUs, librt %s"):format(f.cpu or "unknown CPU", f.cpus or 0, f.version or "?")
end

return facts
