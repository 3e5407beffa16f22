-- Walking positional items: objects, lists of items to any depth, or false. Lists are walked in ascending order of their integer keys, past holes.

local check = require "rt.check"
local class = require "rt.class"

local items = {}

-- The integer keys of a list in ascending order: their count when they are 1 ... count, else also a sorted list of them.
local function keys_of(list, who, place)
  local count, lowest, highest = 0, 1, 0
  for key in next, list do
    if math.type(key) ~= "integer" then
      check.fail("%s: %s has a key %s; a list of items has numbers only", who, place(), check.describe(key))
    end
    count = count + 1
    lowest = key < lowest and key or lowest
    highest = key > highest and key or highest
  end
  if lowest == 1 and highest == count then
    return count
  end
  local keys = {}
  for key in next, list do
    keys[#keys + 1] = key
  end
  table.sort(keys)
  return count, keys
end

-- "item 3.2": the place of an item in lists within lists.
local function place_words(stack, key)
  local parts = {}
  for i = 2, #stack do
    parts[#parts + 1] = tostring(stack[i].key)
  end
  parts[#parts + 1] = key and tostring(key)
  return #parts == 0 and "the list" or "item " .. table.concat(parts, ".")
end

-- The items of a list or a group, nil for other values.
local function list_of(value)
  if type(value) ~= "table" then
    return nil
  elseif getmetatable(value) == nil then
    return value
  end
  return class.kind(value) == "group" and value.items or nil
end

-- Calls visit(item, place) for every object in `list` and in its lists and groups; place() words where it stands. Nothing is recursive:
-- lists may be nested deeper than C's stack.
function items.walk(list, who, visit)
  local stack, open, key = {}, {}, nil
  local function place()
    return place_words(stack, key)
  end
  local function enter(l)
    if open[l] then
      check.fail("%s: %s is a list that contains itself", who, place())
    end
    open[l] = true
    local count, keys = keys_of(l, who, place)
    stack[#stack + 1] = { list = l, key = key, count = count, keys = keys, at = 0 }
  end
  enter(list)
  while #stack > 0 do
    local top = stack[#stack]
    top.at = top.at + 1
    if top.at > top.count then
      open[top.list] = nil
      stack[#stack] = nil
    else
      key = top.keys and top.keys[top.at] or top.at
      local item = top.list[key]
      local below = list_of(item)
      if below then
        enter(below)
      elseif item ~= false then
        visit(item, place)
      end
    end
  end
end

return items
