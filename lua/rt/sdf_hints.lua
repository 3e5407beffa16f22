-- What a message about an old scene definition file says beside the fault: limits in words, and the likely meaning of a slip.
-- The slips are those of print and recognition that the paper's own figure shows: a decimal point read as a comma or lost, a number read twice.

local words = require "rt.words"

local hints = {}

local WORDS = { "one number", "two numbers", "three numbers" }

function hints.count(least, most)
  if most == least then
    return WORDS[least]
  elseif most == least + 1 then
    return (WORDS[least]:gsub(" .*", "")) .. " or " .. WORDS[most]
  end
  return (WORDS[least]:gsub(" .*", "")) .. " numbers or more"
end

function hints.list(texts)
  if #texts > 8 then
    return words.quote(table.concat(texts, ",", 1, 8)) .. ",..."
  end
  return words.quote(table.concat(texts, ","))
end

local function number(x)
  return words.number(x, "%g")
end

function hints.range(rule)
  if rule.low and rule.high then
    return "from " .. number(rule.low) .. " to " .. number(rule.high)
  elseif rule.above and rule.below then
    return "more than " .. number(rule.above) .. " and less than " .. number(rule.below)
  elseif rule.above then
    return "more than " .. number(rule.above)
  end
  return number(rule.low) .. " or more"
end

function hints.fits(rule, v)
  return not (rule.low and v < rule.low or rule.high and v > rule.high or rule.above and v <= rule.above or rule.below and v >= rule.below)
end

local function all_fit(rule, texts)
  for _, text in ipairs(texts) do
    local v = tonumber(text)
    if not v or not hints.fits(rule, v) then
      return false
    end
  end
  return #texts == rule.count
end

local function is_whole(text)
  return text ~= nil and text:find "^%d+$" ~= nil
end

-- A whole number whose point was lost: 15 was 1.5, 6 was 0.6. Empty when that does not help.
function hints.lost_point(text, rule)
  if not rule.high or not is_whole(text) or #text > 8 then
    return ""
  end
  local guess = #text == 1 and "0." .. text or text:sub(1, 1) .. "." .. text:sub(2)
  return hints.fits(rule, tonumber(guess)) and ("; was %s meant?"):format(guess) or ""
end

-- 0,0,0,2 was 0.2,0.2,0.2: zeros before the one digit that is left of three equal decimal fractions.
local function equal_fractions(texts, rule)
  local last = texts[#texts]
  if rule.count ~= 3 or #texts ~= 4 or not is_whole(last) or last == "0" then
    return nil
  end
  for i = 1, 3 do
    if texts[i] ~= "0" then
      return nil
    end
  end
  local one = "0." .. last
  return { one, one, one }
end

-- 1,1,1,0.9 was 1,1,0.9: one of the equal neighbours was read twice.
local function read_twice(texts, rule)
  if #texts ~= rule.count + 1 or rule.count == 1 then
    return nil
  end
  for i = 1, #texts - 1 do
    if texts[i] == texts[i + 1] then
      local rest = table.move(texts, 1, #texts, 1, {})
      table.remove(rest, i)
      return rest
    end
  end
  return nil
end

-- 1,5 was 1.5, and 0,2,0,2,0,2 was 0.2,0.2,0.2: commas for points.
local function decimal_commas(texts, rule)
  if #texts ~= 2 * rule.count then
    return nil
  end
  local joined = {}
  for i = 1, #texts, 2 do
    if not texts[i]:find "^[+-]?%d+$" or not is_whole(texts[i + 1]) then
      return nil
    end
    joined[#joined + 1] = texts[i] .. "." .. texts[i + 1]
  end
  return joined
end

-- "; was A meant?" for a list of the wrong length, or nothing.
function hints.counts(texts, rule)
  for _, reading in ipairs { equal_fractions, read_twice, decimal_commas } do
    local guess = reading(texts, rule)
    if guess and all_fit(rule, guess) then
      return "; was " .. table.concat(guess, ",") .. " meant?"
    end
  end
  return ""
end

return hints
