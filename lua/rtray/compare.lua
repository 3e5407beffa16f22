-- rtray compare A B

local cli = require "rtray.cli"
local output = require "rtray.output"
local json = require "rtray.json"
local files = require "rtray.files"
local types = require "rtray.types"

local compare = {}

local function number(x)
  return x == math.huge and "infinite" or ("%.6g"):format(x)
end

local function print_text(a, b, d, equal, pixels)
  if d.differing == 0 then
    output.print("%s and %s are equal in every bit", types.quote(a), types.quote(b))
    return
  end
  output.print("differing pixels   %s of %s (%.3g%%)", output.count(d.differing), output.count(pixels), 100 * d.differing / pixels)
  output.print("first              %d, %d", d.first[1], d.first[2])
  output.print("largest difference %s", number(d.max))
  output.print("mean squared error %s", number(d.mse))
  output.print("PSNR               %s dB", number(d.psnr))
  output.print("SSIM               %s", number(d.ssim))
  output.print("FLIP               %s", number(d.flip))
  if equal then
    output.print("within the tolerance")
  end
end

local function check(command, values)
  if values.map then
    files.check_output(values.map)
  elseif values.scale then
    cli.fault(command, "--scale colours the image of --map; name one")
  end
  if values.metric == "psnr" and values.tolerance then
    cli.fault(command, "--tolerance is a difference of 0 ... 1, PSNR has decibels; take it with flip or ssim, or without --metric")
  elseif values.ppd and values.metric and values.metric ~= "flip" then
    cli.fault(command, "--ppd is for FLIP; %s does not depend on it", values.metric:upper())
  end
end

-- How far it is from equal, for the tolerance.
local function distance(values, d)
  return values.metric == "flip" and d.flip or values.metric == "ssim" and 1 - d.ssim or d.max
end

local function save_map(values, map)
  local scale = values.scale or (values.metric == "flip" or values.metric == "ssim") and "magma" or "none"
  local shown = scale == "none" and map or map:color_map(scale)
  shown:save(values.map)
end

function compare.run(command, values, arguments)
  local rt = require "rt"
  check(command, values)
  local name_a, name_b = arguments[1], arguments[2]
  local a, b = rt.image(name_a), rt.image(name_b)
  local aw, ah = a:size()
  local bw, bh = b:size()
  if aw ~= bw or ah ~= bh then
    if not values.quiet then
      output.print("the sizes differ: %s is %dx%d, %s is %dx%d", types.quote(name_a), aw, ah, types.quote(name_b), bw, bh)
    end
    return 4
  end
  local metric = values.metric
  local d = a:compare(b, {
    map = values.map and (metric ~= "psnr" and metric or "difference") or nil, flip = metric == nil or metric == "flip", ppd = values.ppd,
  })
  local equal = d.differing == 0 or values.tolerance ~= nil and distance(values, d) <= values.tolerance
  if values.map then
    save_map(values, d.map)
  end
  if values.json then
    local first = d.first and { d.first[1], d.first[2] } or nil
    output.print("%s", json.encode(json.object():set("equal", equal):set("pixels", aw * ah):set("differing", d.differing):set("first", first)
      :set("max", d.max):set("mse", d.mse):set("psnr", d.psnr):set("ssim", d.ssim):set("flip", d.flip)))
  elseif metric and not values.quiet then
    output.print("%s", number(d[metric]))
  elseif not values.quiet then
    print_text(name_a, name_b, d, equal, aw * ah)
  end
  return equal and 0 or 4
end

return compare
