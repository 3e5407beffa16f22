-- Renders in progress.

local support = require "support"
local raises = support.raises

-- A render of about a second, in small tiles.
local function long(scene, more)
  local options = { width = 320, height = 240, samples = 256, tile = 16 }
  for key, value in pairs(more or {}) do
    options[key] = value
  end
  return scene:start(options)
end

describe("a checkpoint", function()
  it("is gone on from, to the same image and the same rays", function()
    support.in_folder(function(folder)
      local path = folder .. "/state"
      local function options(more)
        local o = { size = { 64, 48 }, samples = 2048, tile = 8, checkpoint = path, checkpoint_every = 0.01 } -- 48 tiles: one is left at a cancel
        for key, value in pairs(more or {}) do
          o[key] = value
        end
        return o
      end
      local scene = support.ball()
      local want, stats = scene:render { size = { 64, 48 }, samples = 2048 }
      assert.equal(0, stats.checkpoints)
      do
        local job <close> = scene:start(options { workers = 1 })
        while job:stats().tiles_done < 3 do
          job:poll()
        end
        job:cancel()
        assert.equal("cancelled", (job:wait()))
      end
      support.raises(path .. ": this checkpoint is of another render: samples is 2048 there and 65 here; remove it or name another file", function()
        return scene:render(options { samples = 65 }), nil
      end)
      local image, resumed = scene:render(options { workers = 2, checkpoint_keep = true })
      assert.equal(want:hash(), image:hash())
      assert.equal(stats.rays, resumed.rays)
      assert.is_true(resumed.tiles_resumed >= 3 and resumed.checkpoints >= 1)
      image, resumed = scene:render(options()) -- all of it stands in the file, which is removed now
      assert.equal(want:hash(), image:hash())
      assert.equal(resumed.tiles, resumed.tiles_resumed)
      assert.is_nil(io.open(path))
    end)
  end)
end)

describe("a job", function()
  it("is polled, waited for and gives its image", function()
    local job = support.ball():start()
    local state, progress
    repeat
      state, progress = job:poll()
      assert.is_true(progress >= 0 and progress <= 1)
      job:wait(0.01)
    until state ~= "running"
    assert.equal("done", state)
    assert.equal("done", (job:wait()))
    local image = job:image()
    assert.equal(image, job:image())
    assert.equal(support.ball():render():hash(), image:hash())
    assert.equal(2, #job:stats().per_worker)
    assert.equal(job:stats().tiles, job:stats().tiles_done)
  end)

  it("of one worker works while it is waited for, in the background beside the script", function()
    local scene = support.ball()
    local here, away = scene:start { workers = 1 }, { scene:start { workers = 1, background = true }, scene:start { workers = 1, background = true } }
    for _, job in ipairs(away) do
      local stats
      repeat
        stats = job:stats()
      until stats.tiles_done == stats.tiles
    end
    assert.equal(0, here:stats().tiles_done)
    for _, job in ipairs(away) do -- all tiles are done a moment before the job is
      assert.equal("done", (job:wait()))
    end
    assert.equal("done", (here:wait()))
    assert.equal(here:image():hash(), away[1]:image():hash())
    assert.equal(here:image():hash(), away[2]:image():hash())
  end)

  it("gives its tiles as they are done", function()
    local job, area = support.ball():start(), 0
    for tile in job:tiles() do
      assert.is_true(tile.x + tile.width <= 32 and tile.y + tile.height <= 24)
      area = area + tile.width * tile.height
    end
    assert.equal(32 * 24, area)
    assert.equal("done", (job:poll()))
  end)

  it("is cancelled soon", function()
    for workers = 1, 2 do
      local job = long(support.ball(), { workers = workers, samples = 65536 })
      job:wait(0.05)
      local start = os.time()
      job:cancel()
      assert.equal("cancelled", (job:wait()))
      assert.is_true(os.time() - start <= 1)
      assert.same({ 320, 240 }, { job:image():size() })
    end
  end)

  it("shows what is finished when asked to", function()
    local job = long(support.ball(), { preview = true, samples = 4096 })
    for _ in job:tiles() do
      local image = job:image()
      if job:poll() == "running" then
        local _, _, _, first = image:pixel(0, 0)
        assert.is_true(first == 0 or first == 1)
        break
      end
    end
    job:release()
    local plain <close> = long(support.ball(), { samples = 4096 })
    assert.is_nil(plain:image())
  end)

  it("can be released twice, while it runs", function()
    local job = long(support.ball(), { samples = 65536 })
    job:release()
    job:release()
    raises("the job has been released", function() return job:poll(), nil end)
    assert.equal("rt.job (released)", tostring(job))
  end)

  it("may be forgotten while it runs", function()
    long(support.ball(), { samples = 65536 })
    collectgarbage()
    collectgarbage()
  end)

  it("ends at Ctrl-C, builds of trees too", function()
    -- The script says "go", gets the signal and must end of itself: `wait` gives its status, 1 from lua5.4 after an error.
    local function interrupted(script)
      local folder
      support.in_folder(function(f)
        folder = f
        support.write(f .. "/s.lua", 'local rt = require "rt"\n' .. script)
        local pipe = io.popen(([[
          lua5.4 %s/s.lua > %s/out 2>&1 & p=$!
          while kill -0 $p 2>/dev/null && ! grep -q go %s/out; do sleep 0.02; done
          sleep 0.2; kill -INT $p; wait $p; echo status $?; cat %s/out]]):format(folder, folder, folder, folder))
        local text = pipe:read "a"
        pipe:close()
        assert.is_truthy(text:find "status 1\n" and text:find "interrupted!", text)
      end)
    end
    interrupted [[
      local scene = rt.scene { rt.sphere { center = {0, 0, 0}, radius = 1 } }
      io.stdout:write "go\n"; io.stdout:flush()
      scene:render { width = 4000, height = 4000, samples = 65536 }]]
    interrupted [[
      local n = 1000000
      local centers = rt.buffer("f32", 3 * n)
      for i = 1, 3 * n do centers[i] = rt.random(i) end
      io.stdout:write "go\n"; io.stdout:flush()
      while true do -- one build may be done before the signal is here
        local scene = rt.scene { rt.spheres { centers = centers, radius = 0.2 } }
        coroutine.wrap(function() scene:commit() end)()
        rt.drop_kept()
      end]]
  end)

  it("passes through what an interrupt raises, in a coroutine too", function()
    -- Stock lua5.4's handler of Ctrl-C sets such a hook on the main state.
    local function interrupted(f)
      local scene = support.ball()
      local count = 0
      local function hook()
        count = count + 1
        if count > 3 then
          debug.sethook()
          error("interrupted!", 0)
        end
      end
      local ok, message = pcall(f, scene, hook)
      debug.sethook()
      assert.is_false(ok)
      assert.is_truthy(tostring(message):find "interrupted!")
    end
    interrupted(function(scene, hook)
      local job <close> = long(scene, { samples = 65536 })
      debug.sethook(hook, "c")
      job:wait()
    end)
    interrupted(function(scene, hook)
      local main = coroutine.running()
      local co = coroutine.create(function()
        local job <close> = long(scene, { samples = 65536 })
        debug.sethook(main, hook, "c")
        job:wait()
      end)
      local ok, message = coroutine.resume(co)
      coroutine.close(co)
      assert(ok, message)
    end)
  end)
end)
