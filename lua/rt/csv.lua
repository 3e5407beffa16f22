-- RFC 4180: fields quoted where needed, rows ended by CR LF.

local json = require "rt.json"

local csv = {}

function csv.field(value)
  if value == nil then
    return ""
  end
  local text = math.type(value) == "float" and (json.number(value) or "") or tostring(value)
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
