-- RFC 4180: fields quoted where needed, rows ended by CR LF. Texts that a spreadsheet would take for a formula ("=1+1", "@SUM(A1)", "-x") get an
-- apostrophe in front, as spreadsheets mark texts; numbers, also written as texts ("-1", "+2.5e3"), stay as they are.

local json = require "rt.json"

local csv = {}

function csv.field(value)
  if value == nil then
    return ""
  end
  local text = math.type(value) == "float" and (json.number(value) or "") or tostring(value)
  if text:find "^[=+%-@\t\r]" and not tonumber(text) then
    text = "'" .. text
  end
  return text:find '[,"\r\n]' and '"' .. text:gsub('"', '""') .. '"' or text
end

-- A row; row.n says how many fields, for there may be holes.
function csv.row(row)
  local fields = {}
  for i = 1, row.n or #row do
    fields[i] = csv.field(row[i])
  end
  return table.concat(fields, ",") .. "\r\n"
end

return csv
