-- The Lua reference: LDoc makes it without a warning, and every function and table of keys of the stub stands in it.
-- usage: lua5.4 docs/check.lua RT.D.LUA LDOC, in the folder with config.ld

local stub, ldoc = ...
local here = arg[0]:match "^(.*)/" or "."

local function quote(text)
  return "'" .. text:gsub("'", "'\\''") .. "'"
end

assert(loadfile(here .. "/ldoc.lua"))(stub, "rt.lua")
local pipe = assert(io.popen("HOME=. " .. quote(ldoc) .. " --fatalwarnings . 2>&1")) -- LDoc fails without a HOME
local said = pipe:read "a"
local ok = pipe:close()
assert(ok and not said:lower():find "warning", said)
local page = assert(io.open "lua/index.html"):read "a"
local missing, count = {}, 0
for line in io.lines(stub) do
  local name = line:match "^function rt%.([%w_]+)" or line:match "^function ([%w_]+:[%w_]+)" or line:match "^%-%-%-@class rt%.([%w_]+_desc)"
  if name then
    count = count + 1
    missing[#missing + 1] = not page:find('<a name = "' .. name .. '">', 1, true) and not page:find('<a name = "rt.' .. name .. '">', 1, true)
      and name or nil
  end
end
assert(#missing == 0, "not in the reference: " .. table.concat(missing, ", "))
print(("the reference has all %d functions and tables"):format(count))
