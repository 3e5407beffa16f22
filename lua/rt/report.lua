-- The report of a sweep: index.html, contact sheets and plots, all made from DIR/results.json and the images beside it. Made again, it is the same.
-- Of a sweep that is running or was killed, results.json is made from its journal first.

local check = require "rt.check"
local core = require "rt.core"
local data = require "rt.report_data"
local gnuplot = require "rt.report_gnuplot"
local page = require "rt.report_page"
local sheet = require "rt.report_sheet"
local words = require "rt.words"

local report = {}

local function fail(path, why)
  error(("'%s' cannot be written: %s"):format(words.quote(path, 4096), tostring(why):gsub("^.*: ", "")), 0)
end

-- Beside the target first: who looks sees the old file or the new one.
local function replace(path, content)
  local part = path .. ".part"
  local file, why = io.open(part, "wb")
  if not file then
    fail(path, why)
  end
  local ok
  ok, why = file:write(content)
  local closed, reason = file:close()
  if ok and closed then
    ok, why = core.put_in_place(part, path)
  else
    ok, why = nil, why or reason
  end
  if not ok then
    os.remove(part)
    fail(path, why)
  end
end

local KNOWN = { "results.csv", "runs.csv", "results.json", "machine.json" }

-- Writes the report into the folder. options: { plots = false } leaves gnuplot out, { sheets = false } the contact sheets. Gives
-- { page = path, files = {names in the folder}, notes = {sentences about what could not be done} }. Raises when the folder has no readable
-- results.json or cannot be written to. results: what the sweep has just written there, so that it need not be read again.
function report.write(folder, options, results)
  options = options or {}
  local study
  if results then
    study = data.of(results)
  else
    require("rt.sweep_again").refresh(folder) -- a sweep that was killed had no time to
    study = data.read(folder .. "/results.json")
  end
  local files, sheets, notes = {}, {}, {}
  local function write(name, content)
    replace(folder .. "/" .. name, content)
  end
  local can, why = core.can_create(folder) -- told at once, not after the plots
  if not can then
    fail(folder .. "/index.html", why)
  end
  if options.sheets ~= false then
    local note
    sheets, note = sheet.write(study, folder)
    notes[#notes + 1] = note
  end
  local plots = {}
  if options.plots ~= false then
    local note
    plots, note = gnuplot.run(study, folder, write)
    notes[#notes + 1] = note
  end
  for _, list in ipairs { KNOWN, sheets, plots } do
    for _, name in ipairs(list) do
      if core.file_stat(folder .. "/" .. name) == "file" then
        files[#files + 1] = name
      end
    end
  end
  write("index.html", page.html(study, { notes = notes, sheets = sheets, files = files }))
  table.insert(files, 1, "index.html")
  return { page = folder .. "/index.html", files = files, notes = notes }
end

local fields = { plots = check.boolean, sheets = check.boolean }

-- rt.report(folder, options): what report.write gives, with checked arguments.
function report.make(folder, options)
  local path = check.string(folder, "rt.report", "the folder")
  return report.write(path, check.fields(options or {}, fields, "rt.report"))
end

return report
