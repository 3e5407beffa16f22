-- The machine of a study in words: rows of { name, text }.

local text = require "rt.report_text"

local function number(value)
  return math.type(value) and value == value and math.abs(value) ~= math.huge and value or nil
end

local function word(value)
  return type(value) == "string" and value ~= "" and value or number(value) and text.number(value) or nil
end

local function bytes(value)
  value = number(value)
  if not value then
    return nil
  end
  local by, unit = text.scale("bytes", value)
  return text.number(value / by) .. " " .. unit
end

local function caches(list)
  local parts = {}
  for _, c in ipairs(type(list) == "table" and list or {}) do
    if type(c) == "table" and bytes(c.bytes) then
      local kind = c.type == "Data" and "d" or c.type == "Instruction" and "i" or ""
      parts[#parts + 1] = ("L%s%s %s"):format(word(c.level) or "?", kind, bytes(c.bytes))
    end
  end
  return #parts > 0 and table.concat(parts, ", ") or nil
end

local function joined(...)
  local parts = {}
  for _, value in ipairs { ... } do
    parts[#parts + 1] = value ~= "" and value or nil
  end
  return #parts > 0 and table.concat(parts, " ") or nil
end

local machine = {}

-- The load of others before the sweep began, as the system counts it.
function machine.load(m)
  local load = m.load
  if type(load) == "table" then
    load = load[1]
  elseif type(load) == "string" then
    load = tonumber(load:match "^[%d.]+")
  end
  return number(load)
end

function machine.rows(m)
  local rows = {}
  local function row(name, value)
    if value then
      rows[#rows + 1] = { name, value }
    end
  end
  row("CPU", word(m.cpu))
  local counts = {}
  if number(m.cores) then
    counts[#counts + 1] = text.count(m.cores, "core")
  end
  if number(m.logical_cpus) then
    counts[#counts + 1] = text.count(m.logical_cpus, "logical CPU")
  end
  if number(m.cpus) then
    counts[#counts + 1] = ("%d may be used"):format(m.cpus)
  end
  row("CPUs", #counts > 0 and table.concat(counts, ", ") or nil)
  row("Instruction set", word(m.isa))
  row("Caches", caches(m.caches))
  row("Memory", bytes(m.memory_bytes))
  row("System", joined(word(m.system) or "", word(m.kernel) or ""))
  row("Host", word(m.host))
  row("Frequency governor", word(m.governor))
  row("Boost", m.boost ~= nil and (m.boost == true or m.boost == 1 or m.boost == "1") and "on" or m.boost ~= nil and "off" or nil)
  row("Load when measured", machine.load(m) and text.number(machine.load(m)))
  local version, build = word(m.version), word(m.build)
  row("librt", build and version and build:find(version, 1, true) and build or joined(version or "", build or ""))
  row("Compiler", word(m.compiler))
  row("Flags", word(m.flags))
  row("Lua", word(m.lua))
  row("Time", word(m.time))
  row("Fingerprint", word(m.fingerprint))
  return rows
end

return machine
