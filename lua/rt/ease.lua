-- Easings: functions from 0 ... 1 to 0 ... 1 that say how a change runs. All are made of + - * / alone: the same bits on every machine.

local check = require "rt.check"
local words = require "rt.words"

local ease = {}

local function bounce_out(x)
  local a = 7.5625
  if x < 1 / 2.75 then
    return a * x * x
  elseif x < 2 / 2.75 then
    x = x - 1.5 / 2.75
    return a * x * x + 0.75
  elseif x < 2.5 / 2.75 then
    x = x - 2.25 / 2.75
    return a * x * x + 0.9375
  end
  x = x - 2.625 / 2.75
  return a * x * x + 0.984375
end

ease.functions = {
  linear = function(x) return x end,
  smooth = function(x) return x * x * (3 - 2 * x) end,                        -- no speed at both ends
  smoother = function(x) return x * x * x * (x * (6 * x - 15) + 10) end,      -- nor acceleration
  ["in"] = function(x) return x * x * x end,                                  -- starts slowly
  out = function(x) return 1 - (1 - x) * (1 - x) * (1 - x) end,               -- ends slowly
  in_out = function(x)
    return x < 0.5 and 4 * x * x * x or 1 - 4 * (1 - x) * (1 - x) * (1 - x)
  end,
  step = function(x) return x < 1 and 0 or 1 end,                             -- stays, then jumps
  overshoot = function(x)                                                     -- goes past the end and comes back
    local y = x - 1
    return 1 + 2.70158 * y * y * y + 1.70158 * y * y
  end,
  bounce = bounce_out,
}

-- The easings' names in the order in which messages list them.
ease.names = { "linear", "smooth", "smoother", "in", "out", "in_out", "step", "overshoot", "bounce" }

-- One coordinate of a cubic Bezier curve from 0 to 1 with the inner control values a and b.
local function bezier(a, b, s)
  local r = 1 - s
  return 3 * r * r * s * a + 3 * r * s * s * b + s * s * s
end

-- CSS's cubic-bezier(x1, y1, x2, y2): the curve's y where its x is the time. x grows with the curve's parameter, so halving finds it.
local function cubic_bezier(x1, y1, x2, y2)
  return function(x)
    if x <= 0 or x >= 1 then
      return x <= 0 and 0 or 1
    end
    local low, high = 0.0, 1.0
    for _ = 1, 52 do
      local middle = (low + high) / 2
      if bezier(x1, x2, middle) < x then
        low = middle
      else
        high = middle
      end
    end
    return bezier(y1, y2, (low + high) / 2)
  end
end

local four = check.numbers(4)

-- The function of what a user writes: a name, {x1, y1, x2, y2} as CSS's cubic-bezier, or a function.
function ease.field(value, who, key)
  if type(value) == "function" then
    return value
  elseif type(value) == "table" then
    local n = four(value, who, key)
    for i = 1, 3, 2 do
      if n[i] < 0 or n[i] > 1 then
        check.fail("%s: %s[%d] must be from 0 to 1, for time does not run backwards; got %s", who, key, i, tostring(n[i]))
      end
    end
    return cubic_bezier(n[1], n[2], n[3], n[4])
  end
  local f = type(value) == "string" and ease.functions[value]
  if not f then
    local near = type(value) == "string" and words.nearest(value, ease.names)
    check.fail("%s: %s must be one of %s, {x1, y1, x2, y2} or a function; got %s%s", who, key, table.concat(ease.names, ", "),
      check.describe(value), near and " (did you mean " .. near .. "?)" or "")
  end
  return f
end

local number = check.number()

-- rt.ease("smooth", x) is the eased x; rt.ease "smooth" the function. x is held in 0 ... 1.
function ease.make(how, x)
  local f = ease.field(how, "rt.ease", "the easing")
  if x == nil then
    return f
  end
  x = number(x, "rt.ease", "x")
  return f(x < 0 and 0.0 or x > 1 and 1.0 or x)
end

return ease
