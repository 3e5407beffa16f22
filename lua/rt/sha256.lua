-- SHA-256 (FIPS 180-4) of a string, in base64 as a Content-Security-Policy wants it, or as hexadecimal digits.

local sha256 = {}

-- The first 32 bits of the fractions of the cube roots (K) and square roots (H) of the first primes.
local K, H = {}, {}

local function fraction(n, root)
  -- 32 bits of the 49 that a double has behind the point here; none of the 64 lies near enough to a boundary (the test's vectors would tell)
  local x = root == 2 and math.sqrt(n) or n ^ (1 / 3)
  return math.floor((x - math.floor(x)) * 4294967296) & 0xffffffff
end

do
  local count, n = 0, 2
  while count < 64 do
    local prime = true
    for d = 2, math.floor(math.sqrt(n)) do
      if n % d == 0 then
        prime = false
        break
      end
    end
    if prime then
      count = count + 1
      K[count] = fraction(n, 3)
      if count <= 8 then
        H[count] = fraction(n, 2)
      end
    end
    n = n + 1
  end
end

local function turn(x, by)
  return (x >> by | x << (32 - by)) & 0xffffffff
end

local function block(h, message, at)
  local w = { string.unpack(">" .. ("I4"):rep(16), message, at) }
  for i = 17, 64 do
    local a, b = w[i - 15], w[i - 2]
    w[i] = (w[i - 16] + (turn(a, 7) ~ turn(a, 18) ~ a >> 3) + w[i - 7] + (turn(b, 17) ~ turn(b, 19) ~ b >> 10)) & 0xffffffff
  end
  local a, b, c, d, e, f, g, k = table.unpack(h)
  for i = 1, 64 do
    local t = k + (turn(e, 6) ~ turn(e, 11) ~ turn(e, 25)) + (e & f ~ ~e & g) + K[i] + w[i]
    local u = (turn(a, 2) ~ turn(a, 13) ~ turn(a, 22)) + (a & b ~ a & c ~ b & c)
    k, g, f, e, d, c, b, a = g, f, e, (d + t) & 0xffffffff, c, b, a, (t + u) & 0xffffffff
  end
  for i, v in ipairs { a, b, c, d, e, f, g, k } do
    h[i] = (h[i] + v) & 0xffffffff
  end
end

local function digest(s)
  local h = table.move(H, 1, 8, 1, {})
  local message = s .. "\128" .. ("\0"):rep((55 - #s) % 64) .. string.pack(">I8", #s * 8)
  for at = 1, #message, 64 do
    block(h, message, at)
  end
  return string.pack(">" .. ("I4"):rep(8), table.unpack(h))
end

function sha256.hex(s)
  return (digest(s):gsub(".", function(c)
    return ("%02x"):format(c:byte())
  end))
end

local DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"

function sha256.base64(s)
  return (digest(s):gsub("..?.?", function(part)
    local a, b, c = part:byte(1, 3)
    local bits = a << 16 | (b or 0) << 8 | (c or 0)
    local out = {}
    for i = 0, 3 do
      local at = bits >> (18 - 6 * i) & 63
      out[i + 1] = i > #part and "=" or DIGITS:sub(at + 1, at + 1)
    end
    return table.concat(out)
  end))
end

return sha256
