-- docs/tutorial.md: every script is written, every command run, in the order of the page.

local support = require "support"

-- The blocks of the page: { "lua", name, text } and { "sh", command }.
local function blocks()
  local list = {}
  for kind, name, text in support.read(support.source .. "/docs/tutorial.md"):gmatch "```(%a+) ?(%S*)\n(.-)```" do
    if kind == "lua" then
      list[#list + 1] = { "lua", name, text }
    else
      for command in text:gmatch "[^\n]+" do
        list[#list + 1] = { "sh", command }
      end
    end
  end
  return list
end

describe("the tutorial", function()
  it("works as it is written", function()
    local folder = support.folder()
    local ffmpeg = support.shell("command -v ffmpeg").status == 0
    local commands = 0
    for _, block in ipairs(blocks()) do
      if block[1] == "lua" then
        support.write(folder .. "/" .. block[2], block[3])
      elseif ffmpeg or not block[2]:find("mp4", 1, true) then
        local args = {}
        for word in block[2]:gmatch "%S+" do
          args[#args + 1] = word
        end
        assert.equal("rtray", table.remove(args, 1))
        args.cwd = folder
        local r = support.rtray(args)
        assert.equal(0, r.status, block[2] .. "\n" .. r.err)
        commands = commands + 1
      end
    end
    assert.is_true(commands >= 12)
    for _, name in ipairs { "lamp.png", "green.png", "moon.png", "stairs.png", "frame6.png", "frame23.png", "glass/index.html", "glass/results.csv",
      "noise/results.csv", "scaling/results.json", "compare.png" } do
      assert.is_true(support.exists(folder .. "/" .. name), name)
    end
    assert.equal(ffmpeg, support.exists(folder .. "/film.mp4"))
    assert.not_equal(support.read(folder .. "/lamp.png"), support.read(folder .. "/moon.png"))
  end)
end)
